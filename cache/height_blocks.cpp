#include "cache/height_blocks.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <iterator>
#include <limits>
#include <list>
#include <mutex>
#include <numeric>
#include <unordered_map>
#include <utility>

#include <fmt/format.h>
#include <xxhash.h>

namespace tintree::cache {
namespace {

/// What a block takes: its heights, and what the cache notes of it.
constexpr std::uint64_t kBlockBytes = PageAllocator<float>::bytes(std::size_t{kBlockStride} * kBlockSamples) + 256;

/// The height that a block's heights are counted from. Counted from there none is more than one and a half times the
/// block's range, so that rounding to float costs a share of the range, however narrow it is.
double base_for(double low_m, double high_m) {
  const double range = high_m - low_m;
  if (range == 0) return low_m;
  const double unit = std::min(1.0, std::scalbn(1.0, std::ilogb(range)));
  return std::floor(std::midpoint(low_m, high_m) / unit) * unit;
}

/// Cuts one block out of a band of samples, `stride` doubles a row, that starts at the block's corner.
std::shared_ptr<const HeightBlock> make_block(std::int64_t column0, std::int64_t row0, const double* band,
                                              std::int64_t stride, std::int64_t columns) {
  auto block = std::make_shared<HeightBlock>();
  block->column0 = column0;
  block->row0 = row0;
  block->heights.assign(std::size_t{kBlockStride} * kBlockSamples, std::numeric_limits<float>::quiet_NaN());
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  std::int64_t valid = 0;
  for (std::int64_t j = 0; j < kBlockSamples; ++j) {
    const double* line = band + j * stride;
    for (std::int64_t i = 0; i < columns; ++i) {
      if (std::isnan(line[i])) continue;
      low = std::min(low, line[i]);
      high = std::max(high, line[i]);
      ++valid;
    }
  }
  if (valid == 0) return block;
  block->base_m = base_for(low, high);
  block->all_valid = valid == std::int64_t{kBlockSamples} * kBlockSamples;
  for (std::int64_t j = 0; j < kBlockSamples; ++j) {
    const double* line = band + j * stride;
    float* out = block->heights.data() + j * kBlockStride;
    for (std::int64_t i = 0; i < columns; ++i) out[i] = static_cast<float>(line[i] - block->base_m);
  }
  return block;
}

}  // namespace

BlockDigest digest_of(const HeightBlock& block) {
  const XXH128_hash_t hash = XXH3_128bits_withSeed(block.heights.data(), block.heights.size() * sizeof(float),
                                                   std::bit_cast<XXH64_hash_t>(block.base_m));
  return {hash.low64, hash.high64};
}

/// Least recently used blocks by bytes.
struct HeightBlocks::Cache {
  struct Entry {
    std::int64_t key;
    std::shared_ptr<const HeightBlock> block;
  };
  explicit Cache(std::uint64_t bytes) : capacity(std::max<std::uint64_t>(bytes / kBlockBytes, 4)) {}

  std::shared_ptr<const HeightBlock> find(std::int64_t key) {
    const std::scoped_lock lock(turn);
    const auto at = places.find(key);
    if (at == places.end()) return nullptr;
    recent.splice(recent.begin(), recent, at->second);
    return at->second->block;
  }

  void insert(std::int64_t key, std::shared_ptr<const HeightBlock> block) {
    const std::scoped_lock lock(turn);
    if (places.contains(key)) return;
    recent.push_front({key, std::move(block)});
    places[key] = recent.begin();
    // What somebody holds takes its memory whether it is dropped or not: it counts as used just now.
    for (std::size_t held = 0; places.size() > capacity && held < places.size();) {
      if (recent.back().block.use_count() > 1) {
        recent.splice(recent.begin(), recent, std::prev(recent.end()));
        ++held;
        continue;
      }
      places.erase(recent.back().key);
      recent.pop_back();
    }
  }

  const std::uint64_t capacity;
  std::mutex turn;
  std::list<Entry> recent;
  std::unordered_map<std::int64_t, std::list<Entry>::iterator> places;
};

HeightBlocks::HeightBlocks(std::shared_ptr<const RasterSource> source, std::uint64_t cache_bytes)
    : source_(std::move(source)),
      columns_(source_->info().columns),
      rows_(source_->info().rows),
      blocks_x_(blocks_along(columns_)),
      blocks_y_(blocks_along(rows_)),
      cache_(std::make_unique<Cache>(cache_bytes)) {}

HeightBlocks::~HeightBlocks() = default;

Expected<std::shared_ptr<const HeightBlock>> HeightBlocks::get(std::int64_t bx, std::int64_t by) {
  const std::int64_t key = by * blocks_x_ + bx;
  if (auto block = cache_->find(key)) return block;
  std::vector<double> window(std::size_t{kBlockSamples} * kBlockSamples);
  if (auto read = source_->read(bx * kBlockCells, by * kBlockCells, kBlockSamples, kBlockSamples, window.data());
      !read) {
    return tl::unexpected(read.error());
  }
  auto block = make_block(bx * kBlockCells, by * kBlockCells, window.data(), kBlockSamples, kBlockSamples);
  if (!expected_.empty() && digest_of(*block) != expected_[static_cast<std::size_t>(key)]) {
    return fail(ErrorCode::kIo,
                fmt::format("rows {} to {} hold other heights than when they were read first: the file was changed "
                            "meanwhile; restore it",
                            block->row0, block->row0 + kBlockCells),
                source_->info().path);
  }
  cache_->insert(key, block);
  return block;
}

std::uint64_t HeightBlocks::cached_bytes() const {
  const std::scoped_lock lock(cache_->turn);
  return cache_->places.size() * kBlockBytes;
}

Expected<void> HeightBlocks::stream(
    const std::function<bool(std::int64_t, std::int64_t, const std::shared_ptr<const HeightBlock>&)>& visit) {
  // A band of at most this many blocks at once keeps the memory independent of the raster's width.
  constexpr std::int64_t kBandBlocks = 32;
  std::vector<double> band;
  for (std::int64_t by = 0; by < blocks_y_; ++by) {
    for (std::int64_t first = 0; first < blocks_x_; first += kBandBlocks) {
      const std::int64_t last = std::min(first + kBandBlocks, blocks_x_);
      const std::int64_t width = (last - first) * kBlockCells + 1;
      band.resize(static_cast<std::size_t>(width * kBlockSamples));
      if (auto read = source_->read(first * kBlockCells, by * kBlockCells, width, kBlockSamples, band.data()); !read) {
        return read;
      }
      for (std::int64_t bx = first; bx < last; ++bx) {
        auto block = make_block(bx * kBlockCells, by * kBlockCells, band.data() + (bx - first) * kBlockCells, width,
                                kBlockSamples);
        cache_->insert(by * blocks_x_ + bx, block);
        if (!visit(bx, by, block)) return {};
      }
    }
  }
  return {};
}

}  // namespace tintree::cache
