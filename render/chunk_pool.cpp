#include "render/chunk_pool.h"

#include <algorithm>

namespace tintree::render {

std::optional<std::size_t> ChunkPool::take(std::uint64_t owner, std::size_t size, std::uint64_t frame,
                                           std::vector<std::uint64_t>& put_out) {
  std::size_t fitting = smallest_;
  while (fitting < size) fitting *= 2;
  if (fitting > budget_) return std::nullopt;
  std::optional<std::size_t> found = smallest_empty(size);
  const bool tight = found && chunks_[*found].size == fitting;
  if (!tight && bytes_ + fitting <= budget_) found = make(fitting);
  if (!found) found = least_missed(size, frame);
  while (!found && give_up_oldest(frame, put_out)) {
    if (bytes_ + fitting <= budget_) found = make(fitting);
  }
  if (!found) return std::nullopt;
  Chunk& chunk = chunks_[*found];
  if (chunk.owner) put_out.push_back(*chunk.owner);
  chunk.owner = owner;
  chunk.used = frame;
  return found;
}

std::optional<std::size_t> ChunkPool::smallest_empty(std::size_t size) const {
  std::optional<std::size_t> best;
  for (std::size_t i = 0; i < chunks_.size(); ++i) {
    const Chunk& c = chunks_[i];
    if (!c.owner && c.size >= size && (!best || c.size < chunks_[*best].size)) best = i;
  }
  return best;
}

std::optional<std::size_t> ChunkPool::least_missed(std::size_t size, std::uint64_t frame) const {
  std::optional<std::size_t> best;
  double best_score = 0;
  for (std::size_t i = 0; i < chunks_.size(); ++i) {
    const Chunk& c = chunks_[i];
    if (c.size < size || c.used >= frame) continue;
    const double score = static_cast<double>(frame - c.used) * static_cast<double>(size) / static_cast<double>(c.size);
    if (score > best_score) {
      best = i;
      best_score = score;
    }
  }
  return best;
}

bool ChunkPool::give_up_oldest(std::uint64_t frame, std::vector<std::uint64_t>& put_out) {
  Chunk* oldest = nullptr;
  for (Chunk& c : chunks_) {
    if (c.size > 0 && (!c.owner || c.used < frame) && (oldest == nullptr || c.used < oldest->used)) oldest = &c;
  }
  if (oldest == nullptr) return false;
  if (oldest->owner) put_out.push_back(*oldest->owner);
  bytes_ -= oldest->size;
  *oldest = {};
  return true;
}

std::size_t ChunkPool::make(std::size_t size) {
  bytes_ += size;
  const auto free = std::ranges::find(chunks_, std::size_t{0}, &Chunk::size);
  const auto number = static_cast<std::size_t>(free - chunks_.begin());
  if (free == chunks_.end()) chunks_.emplace_back();
  chunks_[number] = {size, std::nullopt, 0};
  return number;
}

}  // namespace tintree::render
