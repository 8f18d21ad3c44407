#include "cache/scratch_file.h"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <utility>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/statvfs.h>
#include <unistd.h>

namespace tintree::cache {
namespace {

/// An open file without a name, or -1 with errno set.
int open_unnamed(const std::string& folder) {
  const int file = ::open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
  if (file >= 0 || (errno != EOPNOTSUPP && errno != EISDIR && errno != EINVAL)) return file;
  std::string name = folder + "/tintree-scratch-XXXXXX";
  const int named = ::mkostemp(name.data(), O_CLOEXEC);
  if (named >= 0) ::unlink(name.c_str());
  return named;
}

/// Moves all bytes or fails with errno set. `move` is pread or pwrite, bound to its buffer.
template <typename Move>
bool move_all(std::int64_t bytes, const Move& move) {
  std::int64_t done = 0;
  while (done < bytes) {
    const ssize_t n = move(done, static_cast<std::size_t>(bytes - done));
    if (n < 0 && errno == EINTR) continue;
    if (n == 0) errno = EIO;
    if (n <= 0) return false;
    done += n;
  }
  return true;
}

}  // namespace

ScratchFile::ScratchFile(int file, std::string folder, std::string what)
    : file_(file), folder_(std::move(folder)), what_(std::move(what)) {}

ScratchFile::ScratchFile(ScratchFile&& other) noexcept
    : file_(std::exchange(other.file_, -1)), folder_(std::move(other.folder_)), what_(std::move(other.what_)) {}

ScratchFile& ScratchFile::operator=(ScratchFile&& other) noexcept {
  std::swap(file_, other.file_);
  std::swap(folder_, other.folder_);
  std::swap(what_, other.what_);
  return *this;
}

ScratchFile::~ScratchFile() {
  if (file_ >= 0) ::close(file_);
}

Expected<ScratchFile> ScratchFile::create(const std::string& folder, std::int64_t bytes, std::string what) {
  struct statvfs disk {};
  if (::statvfs(folder.c_str(), &disk) == 0) {
    const double free = static_cast<double>(disk.f_bavail) * static_cast<double>(disk.f_frsize);
    if (free < static_cast<double>(bytes)) {
      return fail(ErrorCode::kIo,
                  fmt::format("{} needs {:.0f} MiB here, and {:.0f} are free; free some", what,
                              static_cast<double>(bytes) / (1 << 20), free / (1 << 20)),
                  folder);
    }
  }
  const int file = open_unnamed(folder);
  if (file < 0) {
    return fail(ErrorCode::kIo, std::string("a temporary file cannot be made here: ") + std::strerror(errno), folder);
  }
  return ScratchFile(file, folder, std::move(what));
}

Expected<void> ScratchFile::write(std::int64_t at, const void* from, std::int64_t bytes) {
  const auto* source = static_cast<const char*>(from);
  const bool done = move_all(bytes, [&](std::int64_t done_so_far, std::size_t n) {
    return ::pwrite(file_, source + done_so_far, n, at + done_so_far);
  });
  if (done) return {};
  return fail(ErrorCode::kIo, what_ + " cannot be written here: " + std::strerror(errno), folder_);
}

Expected<void> ScratchFile::read(std::int64_t at, void* to, std::int64_t bytes) const {
  auto* target = static_cast<char*>(to);
  const bool done = move_all(bytes, [&](std::int64_t done_so_far, std::size_t n) {
    return ::pread(file_, target + done_so_far, n, at + done_so_far);
  });
  if (done) return {};
  return fail(ErrorCode::kIo, what_ + " cannot be read: " + std::strerror(errno), folder_);
}

}  // namespace tintree::cache
