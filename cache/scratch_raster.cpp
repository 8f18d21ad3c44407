#include "cache/scratch_raster.h"

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/statvfs.h>
#include <unistd.h>

namespace tintree::cache {
namespace {

constexpr std::int64_t kSide = 256;

std::int64_t blocks_along(std::int64_t samples) { return (samples + kSide - 1) / kSide; }

/// The part of a window in one block: rows and columns of the raster, ends not included.
struct Piece {
  std::int64_t block_x;
  std::int64_t block_y;
  std::int64_t column0;
  std::int64_t row0;
  std::int64_t column1;
  std::int64_t row1;
};

/// Calls `visit` for the pieces of a window until one fails.
template <typename Visit>
Expected<void> for_each_piece(std::int64_t column, std::int64_t row, std::int64_t width, std::int64_t height,
                              const Visit& visit) {
  for (std::int64_t by = row / kSide; by * kSide < row + height; ++by) {
    for (std::int64_t bx = column / kSide; bx * kSide < column + width; ++bx) {
      const Piece piece{bx,
                        by,
                        std::max(column, bx * kSide),
                        std::max(row, by * kSide),
                        std::min(column + width, (bx + 1) * kSide),
                        std::min(row + height, (by + 1) * kSide)};
      if (auto done = visit(piece); !done) return done;
    }
  }
  return {};
}

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

template <typename Sample>
void encode(const double* from, std::int64_t count, std::byte* to) {
  for (std::int64_t i = 0; i < count; ++i) {
    const auto value = static_cast<Sample>(from[i]);
    std::memcpy(to + i * static_cast<std::int64_t>(sizeof value), &value, sizeof value);
  }
}

template <typename Sample>
void decode(const std::byte* from, std::int64_t count, double* to) {
  for (std::int64_t i = 0; i < count; ++i) {
    Sample value;
    std::memcpy(&value, from + i * static_cast<std::int64_t>(sizeof value), sizeof value);
    to[i] = static_cast<double>(value);
  }
}

}  // namespace

ScratchRaster::ScratchRaster(int file, std::string folder, std::int64_t columns, ScratchSample sample)
    : file_(file), folder_(std::move(folder)), columns_(columns), sample_(sample) {}

ScratchRaster::ScratchRaster(ScratchRaster&& other) noexcept
    : file_(std::exchange(other.file_, -1)),
      folder_(std::move(other.folder_)),
      columns_(other.columns_),
      sample_(other.sample_) {}

ScratchRaster& ScratchRaster::operator=(ScratchRaster&& other) noexcept {
  std::swap(file_, other.file_);
  std::swap(folder_, other.folder_);
  std::swap(columns_, other.columns_);
  std::swap(sample_, other.sample_);
  return *this;
}

ScratchRaster::~ScratchRaster() {
  if (file_ >= 0) ::close(file_);
}

Expected<ScratchRaster> ScratchRaster::create(const std::string& folder, std::int64_t columns, std::int64_t rows,
                                              ScratchSample sample) {
  const std::int64_t bytes =
      blocks_along(columns) * blocks_along(rows) * kSide * kSide * static_cast<std::int64_t>(sample);
  struct statvfs disk {};
  if (::statvfs(folder.c_str(), &disk) == 0) {
    const double free = static_cast<double>(disk.f_bavail) * static_cast<double>(disk.f_frsize);
    if (free < static_cast<double>(bytes)) {
      return fail(ErrorCode::kIo,
                  fmt::format("a temporary copy of the heights needs {:.0f} MiB here, and {:.0f} are free; free some",
                              static_cast<double>(bytes) / (1 << 20), free / (1 << 20)),
                  folder);
    }
  }
  const int file = open_unnamed(folder);
  if (file < 0) {
    return fail(ErrorCode::kIo, std::string("a temporary file cannot be made here: ") + std::strerror(errno), folder);
  }
  return ScratchRaster(file, folder, columns, sample);
}

std::int64_t ScratchRaster::position(std::int64_t block_x, std::int64_t block_y, std::int64_t row) const {
  return (((block_y * blocks_along(columns_) + block_x) * kSide + row) * kSide) * static_cast<std::int64_t>(sample_);
}

Expected<void> ScratchRaster::write(std::int64_t column, std::int64_t row, std::int64_t width, std::int64_t height,
                                    const double* values, std::int64_t stride) {
  const auto bytes_each = static_cast<std::int64_t>(sample_);
  std::vector<std::byte> buffer;
  return for_each_piece(column, row, width, height, [&](const Piece& p) -> Expected<void> {
    const std::int64_t left = p.column0 - p.block_x * kSide;
    const std::int64_t count = p.column1 - p.column0;
    // What lies in a block beyond the raster's east side is never read.
    const bool whole_rows = left == 0 && (count == kSide || p.column1 == columns_);
    const std::int64_t rows_at_once = whole_rows ? p.row1 - p.row0 : 1;
    buffer.assign(static_cast<std::size_t>(rows_at_once * kSide * bytes_each), std::byte{});
    for (std::int64_t r = p.row0; r < p.row1; r += rows_at_once) {
      for (std::int64_t i = 0; i < rows_at_once; ++i) {
        const double* from = values + (r + i - row) * stride + (p.column0 - column);
        std::byte* to = buffer.data() + i * kSide * bytes_each;
        sample_ == ScratchSample::kFloat ? encode<float>(from, count, to) : encode<double>(from, count, to);
      }
      const std::int64_t at = position(p.block_x, p.block_y, r - p.block_y * kSide) + left * bytes_each;
      const std::int64_t bytes = ((rows_at_once - 1) * kSide + count) * bytes_each;
      const bool done = move_all(
          bytes, [&](std::int64_t from, std::size_t n) { return ::pwrite(file_, buffer.data() + from, n, at + from); });
      if (!done) {
        return fail(ErrorCode::kIo,
                    std::string("the temporary copy of the heights cannot be written here: ") + std::strerror(errno),
                    folder_);
      }
    }
    return {};
  });
}

Expected<void> ScratchRaster::read(std::int64_t column, std::int64_t row, std::int64_t width, std::int64_t height,
                                   double* values, std::int64_t stride) const {
  const auto bytes_each = static_cast<std::int64_t>(sample_);
  std::vector<std::byte> buffer(static_cast<std::size_t>(std::min(height, kSide) * kSide * bytes_each));
  return for_each_piece(column, row, width, height, [&](const Piece& p) -> Expected<void> {
    const std::int64_t left = p.column0 - p.block_x * kSide;
    const std::int64_t count = p.column1 - p.column0;
    const std::int64_t at = position(p.block_x, p.block_y, p.row0 - p.block_y * kSide) + left * bytes_each;
    const std::int64_t bytes = ((p.row1 - p.row0 - 1) * kSide + count) * bytes_each;
    const bool done = move_all(
        bytes, [&](std::int64_t from, std::size_t n) { return ::pread(file_, buffer.data() + from, n, at + from); });
    if (!done) {
      return fail(ErrorCode::kIo,
                  std::string("the temporary copy of the heights cannot be read: ") + std::strerror(errno), folder_);
    }
    for (std::int64_t r = p.row0; r < p.row1; ++r) {
      const std::byte* from = buffer.data() + (r - p.row0) * kSide * bytes_each;
      double* to = values + (r - row) * stride + (p.column0 - column);
      sample_ == ScratchSample::kFloat ? decode<float>(from, count, to) : decode<double>(from, count, to);
    }
    return {};
  });
}

}  // namespace tintree::cache
