#pragma once

#include <cstdint>
#include <string>

#include "codec/error.h"

namespace tintree::cache {

/// A temporary file without a name: gone with this object, however the program ends. Reads and writes at places of
/// their own may come from any thread.
class ScratchFile {
 public:
  /// Makes the file in `folder`. kIo when it cannot, or when the disk has no room for `bytes`; `what` names the
  /// contents in messages.
  static Expected<ScratchFile> create(const std::string& folder, std::int64_t bytes, std::string what);

  ScratchFile(ScratchFile&& other) noexcept;
  ScratchFile& operator=(ScratchFile&& other) noexcept;
  ~ScratchFile();

  Expected<void> write(std::int64_t at, const void* from, std::int64_t bytes);
  Expected<void> read(std::int64_t at, void* to, std::int64_t bytes) const;
  int descriptor() const { return file_; }

 private:
  ScratchFile(int file, std::string folder, std::string what);

  int file_ = -1;
  std::string folder_;
  std::string what_;
};

}  // namespace tintree::cache
