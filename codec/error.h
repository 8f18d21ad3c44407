#pragma once

#include <string>
#include <utility>

#include <tl/expected.hpp>

namespace tintree {

/// What went wrong, by what a caller can do about it. The values are the programs' exit codes.
enum class ErrorCode {
  kCheckFailed = 1,  ///< A promise about the data does not hold.
  kUsage = 2,        ///< The request itself makes no sense.
  kBadData = 3,      ///< The input can be read but not used.
  kIo = 4,           ///< The system refused to read or write.
  kStopped = 5,      ///< The user asked for a stop.
};

/// A failure in one clear message: what is wrong and what to do, and the file or place it is about.
struct Error {
  ErrorCode code;
  std::string message;
  std::string where;  ///< File, tile or option; may be empty.

  /// "where: message", as a program prints it.
  std::string text() const { return where.empty() ? message : where + ": " + message; }
};

template <typename T>
using Expected = tl::expected<T, Error>;

inline tl::unexpected<Error> fail(ErrorCode code, std::string message, std::string where = {}) {
  return tl::unexpected<Error>(Error{code, std::move(message), std::move(where)});
}

}  // namespace tintree
