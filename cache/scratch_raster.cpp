#include "cache/scratch_raster.h"

#include <algorithm>
#include <cstring>
#include <utility>
#include <vector>

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

ScratchRaster::ScratchRaster(ScratchFile file, std::int64_t columns, ScratchSample sample)
    : file_(std::move(file)), columns_(columns), sample_(sample) {}

Expected<ScratchRaster> ScratchRaster::create(const std::string& folder, std::int64_t columns, std::int64_t rows,
                                              ScratchSample sample) {
  const std::int64_t bytes =
      blocks_along(columns) * blocks_along(rows) * kSide * kSide * static_cast<std::int64_t>(sample);
  auto file = ScratchFile::create(folder, bytes, "a temporary copy of the heights");
  if (!file) return tl::unexpected(file.error());
  return ScratchRaster(std::move(*file), columns, sample);
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
      if (auto done = file_.write(at, buffer.data(), bytes); !done) return done;
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
    if (auto done = file_.read(at, buffer.data(), bytes); !done) return done;
    for (std::int64_t r = p.row0; r < p.row1; ++r) {
      const std::byte* from = buffer.data() + (r - p.row0) * kSide * bytes_each;
      double* to = values + (r - row) * stride + (p.column0 - column);
      sample_ == ScratchSample::kFloat ? decode<float>(from, count, to) : decode<double>(from, count, to);
    }
    return {};
  });
}

}  // namespace tintree::cache
