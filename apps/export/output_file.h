#pragma once

#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <string_view>

#include "codec/error.h"

namespace tintree::exporter {

/// A file being written beside its goal; it takes its place with commit() and disappears without. Not
/// thread-safe.
class OutputFile {
 public:
  /// Creates `path` + `suffix`.
  static Expected<OutputFile> create(const std::string& path, const std::string& suffix = ".tmp");

  OutputFile(OutputFile&&) noexcept = default;
  OutputFile& operator=(OutputFile&&) = delete;
  ~OutputFile();

  /// Failures are kept and come back from commit() or ok().
  void write(std::string_view bytes);
  void write_at(std::uint64_t position, std::string_view bytes);
  /// Appends everything that another file holds.
  void append(OutputFile& other);
  /// kIo once anything could not be written.
  Expected<void> ok() const;
  /// Makes the file survive a crash and moves it to its goal.
  Expected<void> commit();

 private:
  struct Closer {
    void operator()(std::FILE* f) const { std::fclose(f); }
  };
  OutputFile(std::string goal, std::string temporary, std::FILE* file)
      : goal_(std::move(goal)), temporary_(std::move(temporary)), file_(file) {}

  void note_failure();

  std::string goal_;
  std::string temporary_;
  std::unique_ptr<std::FILE, Closer> file_;
  int failure_ = 0;  // errno of the first failure
};

}  // namespace tintree::exporter
