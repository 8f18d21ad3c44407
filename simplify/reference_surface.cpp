#include "simplify/reference_surface.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>
#include <optional>
#include <set>
#include <utility>

#include <tbb/parallel_for_each.h>
#include <tbb/task_group.h>

#include "cache/samples_digest.h"

namespace tintree::simplify {
namespace {

using cache::HeightBlock;
using cache::kBlockSamples;
using cache::kBlockStride;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

const HeightBlock& missing_block() {
  static const HeightBlock block = [] {
    HeightBlock b;
    b.heights.assign(std::size_t{kBlockStride} * kBlockSamples, kNaN);
    return b;
  }();
  return block;
}

std::array<double, 2> range_of(const HeightBlock& block) {
  double low = kInfinity;
  double high = -kInfinity;
  for (int j = 0; j < kBlockSamples; ++j) {
    const float* line = block.row(j);
    for (int i = 0; i < kBlockSamples; ++i) {
      const double h = static_cast<double>(line[i]);
      low = h < low ? h : low;
      high = h > high ? h : high;
    }
  }
  return {low + block.base_m, high + block.base_m};
}

/// Samples that exist among the first `columns` x `rows` of the block.
std::uint64_t count_valid(const HeightBlock& block, int columns, int rows) {
  std::uint64_t valid = 0;
  for (int j = 0; j < rows; ++j) {
    const float* line = block.row(j);
    for (int i = 0; i < columns; ++i) valid += std::isnan(line[i]) ? 0 : 1;
  }
  return valid;
}

bool holds_triangle(const HeightBlock& block) {
  if (block.all_valid) return true;
  for (int j = 0; j < cache::kBlockCells; ++j) {
    const float* north = block.row(j);
    const float* south = block.row(j + 1);
    for (int i = 0; i < cache::kBlockCells; ++i) {
      const bool diagonal = !std::isnan(north[i]) && !std::isnan(south[i + 1]);
      if (diagonal && !(std::isnan(north[i + 1]) && std::isnan(south[i]))) return true;
    }
  }
  return false;
}

/// Keeps the first failure of several threads.
class FirstError {
 public:
  void note(const Expected<void>& done) {
    if (done) return;
    const std::scoped_lock lock(turn_);
    if (!error_) error_ = done.error();
  }
  std::optional<Error> get() const {
    const std::scoped_lock lock(turn_);
    return error_;
  }

 private:
  mutable std::mutex turn_;
  std::optional<Error> error_;
};

}  // namespace

std::uint64_t ReferenceSurface::pyramid_bytes(std::int64_t columns, std::int64_t rows) {
  return static_cast<std::uint64_t>(cache::HeightBlocks::blocks_along(columns) *
                                    cache::HeightBlocks::blocks_along(rows)) *
         sizeof(BlockPatches);
}

Expected<std::unique_ptr<ReferenceSurface>> ReferenceSurface::scan(
    std::shared_ptr<cache::HeightBlocks> blocks,
    const std::function<bool(std::uint64_t done, std::uint64_t total)>& progress, const Pyramid& pyramid) {
  auto out = std::make_unique<ReferenceSurface>();
  out->blocks_ = std::move(blocks);
  const std::int64_t across = out->blocks_->blocks_x();
  const std::int64_t down = out->blocks_->blocks_y();
  const auto total = static_cast<std::size_t>(across * down);
  auto patches = cache::PagedRecords::create(static_cast<std::int64_t>(total), sizeof(BlockPatches),
                                             pyramid.resident_bytes, pyramid.folder);
  if (!patches) return tl::unexpected(patches.error());
  out->patches_.emplace(std::move(*patches));
  out->ranges_.resize(total);
  cache::SamplesDigest digest(*out->blocks_);
  std::vector<std::uint64_t> valid(total);
  std::vector<char> surface(total);
  std::uint64_t done = 0;
  bool stopped = false;
  FirstError error;
  tbb::task_group tasks;
  auto streamed =
      out->blocks_->stream([&](std::int64_t bx, std::int64_t by, const std::shared_ptr<const HeightBlock>& block) {
        const auto at = static_cast<std::size_t>(by * across + bx);
        // Lets no more than a band of blocks pile up; other threads work them off while the next band is read.
        if (done % 32 == 0) tasks.wait();
        tasks.run([&, at, bx, by, block] {
          const BlockPatches summary = make_patches(*block);
          error.note(out->patches_->write(static_cast<std::int64_t>(at), &summary));
          out->ranges_[at] = range_of(*block);
          // Samples on a shared side count for the next block, if there is one.
          valid[at] = count_valid(*block, bx + 1 < across ? cache::kBlockCells : kBlockSamples,
                                  by + 1 < down ? cache::kBlockCells : kBlockSamples);
          surface[at] = holds_triangle(*block) ? 1 : 0;
          digest.add(bx, by, *block);
        });
        stopped = !progress(++done, total);
        return !stopped && !error.get();
      });
  tasks.wait();
  if (error.get()) return tl::unexpected(*error.get());
  if (!streamed) return tl::unexpected(streamed.error());
  if (stopped) return fail(ErrorCode::kStopped, "stopped");
  for (const std::uint64_t v : valid) out->valid_samples_ += v;
  out->has_surface_ = std::ranges::find(surface, 1) != surface.end();
  out->digest_ = digest.text();
  out->blocks_->expect(digest.take());
  return out;
}

Expected<std::unique_ptr<ReferenceSurface>> ReferenceSurface::scan_windows(std::shared_ptr<cache::HeightBlocks> blocks,
                                                                           const std::vector<codec::CellRect>& windows,
                                                                           const StopFlag* stop) {
  auto out = std::make_unique<ReferenceSurface>();
  out->blocks_ = std::move(blocks);
  const std::int64_t across = out->blocks_->blocks_x();
  const auto total = static_cast<std::size_t>(across * out->blocks_->blocks_y());
  out->ranges_.assign(total, {kInfinity, -kInfinity});
  std::set<std::int64_t> wanted;
  for (const codec::CellRect& w : windows) {
    for (std::int64_t by = w.row0 >> 8; by <= (w.row1 - 1) >> 8; ++by) {
      for (std::int64_t bx = w.column0 >> 8; bx <= (w.column1 - 1) >> 8; ++bx) wanted.insert(by * across + bx);
    }
  }
  auto patches = cache::PagedRecords::create(std::ssize(wanted) + 1, sizeof(BlockPatches), Pyramid{}.resident_bytes,
                                             Pyramid{}.folder);
  if (!patches) return tl::unexpected(patches.error());
  out->patches_.emplace(std::move(*patches));
  // The first record stands for all blocks that are not looked at.
  BlockPatches unknown;
  unknown.whole.low = kNaN;
  unknown.middle.fill(unknown.whole);
  unknown.fine.fill(unknown.whole);
  FirstError error;
  error.note(out->patches_->write(0, &unknown));
  out->places_.assign(total, 0);
  std::int32_t last = 0;
  for (const std::int64_t key : wanted) out->places_[static_cast<std::size_t>(key)] = ++last;
  tbb::parallel_for_each(wanted, [&](std::int64_t key) {
    if (is_set(stop)) return;
    const auto block = out->blocks_->get(key % across, key / across);
    if (!block) return error.note(tl::unexpected(block.error()));
    const auto at = static_cast<std::size_t>(key);
    const BlockPatches summary = make_patches(**block);
    error.note(out->patches_->write(out->places_[at], &summary));
    out->ranges_[at] = range_of(**block);
  });
  if (error.get()) return tl::unexpected(*error.get());
  if (is_set(stop)) return fail(ErrorCode::kStopped, "stopped");
  return out;
}

template <typename Visit>
void ReferenceSurface::for_each_range(const codec::CellRect& cells, const Visit& visit) const {
  if (cells.empty()) return;
  for (std::int64_t by = cells.row0 >> 8; by <= (cells.row1 - 1) >> 8; ++by) {
    for (std::int64_t bx = cells.column0 >> 8; bx <= (cells.column1 - 1) >> 8; ++bx) {
      visit(ranges_[static_cast<std::size_t>(by * blocks_->blocks_x() + bx)]);
    }
  }
}

std::array<double, 2> ReferenceSurface::height_range_m(const codec::CellRect& cells) const {
  std::array<double, 2> range{kInfinity, -kInfinity};
  for_each_range(cells, [&](const std::array<double, 2>& r) {
    range = {std::min(range[0], r[0]), std::max(range[1], r[1])};
  });
  return range;
}

ReferenceSurface::HeightScale ReferenceSurface::height_scale(const codec::CellRect& cells) const {
  HeightScale scale;
  for_each_range(cells, [&](const std::array<double, 2>& r) {
    if (r[0] > r[1]) return;
    scale.relief_m = std::max(scale.relief_m, r[1] - r[0]);
    scale.farthest_m = std::max({scale.farthest_m, std::abs(r[0]), std::abs(r[1])});
  });
  return scale;
}

double SurfaceView::sample(std::int64_t column, std::int64_t row) {
  const cache::HeightBlocks& blocks = surface_->blocks();
  if (column < 0 || row < 0 || column >= blocks.columns() || row >= blocks.rows()) {
    return std::numeric_limits<double>::quiet_NaN();
  }
  // The last column and row belong to the block before them.
  const std::int64_t cell_x = std::min(column, blocks.columns() - 2);
  const std::int64_t cell_y = std::min(row, blocks.rows() - 2);
  const HeightBlock& block = block_of(cell_x, cell_y);
  const auto i = static_cast<int>(column - (cell_x & ~std::int64_t{255}));
  const auto j = static_cast<int>(row - (cell_y & ~std::int64_t{255}));
  return static_cast<double>(block.row(j)[i]) + block.base_m;
}

void SurfaceView::read_exact(const codec::CellRect& window, std::vector<double>& heights_m) {
  const std::int64_t width = window.column1 - window.column0 + 1;
  const std::int64_t height = window.row1 - window.row0 + 1;
  heights_m.assign(static_cast<std::size_t>(width * height), std::numeric_limits<double>::quiet_NaN());
  if (error_) return;
  auto read = surface_->blocks().source().read(window.column0, window.row0, width, height, heights_m.data());
  if (!read) error_ = read.error();
}

const HeightBlock& SurfaceView::fetch(std::int64_t bx, std::int64_t by) {
  cache::HeightBlocks& blocks = surface_->blocks();
  if (error_ || bx < 0 || by < 0 || bx >= blocks.blocks_x() || by >= blocks.blocks_y()) return missing_block();
  const std::int64_t key = by * blocks.blocks_x() + bx;
  Pin& pin = pins_[static_cast<std::size_t>((bx & 7) + 8 * (by & 7))];
  if (pin.key != key) {
    auto block = blocks.get(bx, by);
    if (!block) {
      error_ = block.error();
      return missing_block();
    }
    pin = {key, std::move(*block)};
  }
  last_ = pin.block.get();
  last_bx_ = bx;
  last_by_ = by;
  return *last_;
}

}  // namespace tintree::simplify
