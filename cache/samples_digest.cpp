#include "cache/samples_digest.h"

#include <fmt/format.h>
#include <xxhash.h>

namespace tintree::cache {

SamplesDigest::SamplesDigest(const HeightBlocks& blocks)
    : blocks_x_(blocks.blocks_x()), hashes_(static_cast<std::size_t>(blocks.blocks_x() * blocks.blocks_y())) {}

void SamplesDigest::add(std::int64_t bx, std::int64_t by, const HeightBlock& block) {
  const auto base = static_cast<std::int64_t>(block.base_m);
  const XXH128_hash_t hash = XXH3_128bits_withSeed(block.heights.data(), block.heights.size() * sizeof(float),
                                                   static_cast<XXH64_hash_t>(base));
  hashes_[static_cast<std::size_t>(by * blocks_x_ + bx)] = {hash.low64, hash.high64};
}

std::string SamplesDigest::text() const {
  const XXH128_hash_t all = XXH3_128bits(hashes_.data(), hashes_.size() * sizeof(Hash));
  return fmt::format("{:016x}{:016x}", all.high64, all.low64);
}

}  // namespace tintree::cache
