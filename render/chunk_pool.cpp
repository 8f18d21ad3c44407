#include "render/chunk_pool.h"

#include <algorithm>

namespace tintree::render {

ChunkPool::ChunkPool(std::size_t budget, std::size_t smallest, std::size_t largest) {
  std::vector<std::size_t> sizes{smallest};
  while (sizes.back() < largest) sizes.push_back(2 * sizes.back());
  std::size_t begin = 0;
  for (const std::size_t size : sizes) {
    const std::size_t count = std::max<std::size_t>(1, budget / sizes.size() / size);
    for (std::size_t i = 0; i < count; ++i, begin += size) chunks_.push_back({size, begin, std::nullopt, 0});
  }
}

std::optional<std::size_t> ChunkPool::take(std::uint64_t owner, std::size_t size, std::uint64_t frame) {
  std::optional<std::size_t> best;
  double best_score = 0;
  for (std::size_t i = 0; i < chunks_.size(); ++i) {
    const Chunk& c = chunks_[i];
    if (c.size < size) continue;
    if (!c.owner) {
      best = i;
      break;
    }
    const double score = static_cast<double>(frame - c.used) * static_cast<double>(size) / static_cast<double>(c.size);
    if (c.used < frame && score > best_score) {
      best = i;
      best_score = score;
    }
  }
  if (best) {
    chunks_[*best].owner = owner;
    chunks_[*best].used = frame;
  }
  return best;
}

}  // namespace tintree::render
