#include "cache/samples_digest.h"

#include <fmt/format.h>
#include <xxhash.h>

namespace tintree::cache {

SamplesDigest::SamplesDigest(const HeightBlocks& blocks)
    : blocks_x_(blocks.blocks_x()), digests_(static_cast<std::size_t>(blocks.blocks_x() * blocks.blocks_y())) {}

void SamplesDigest::add(std::int64_t bx, std::int64_t by, const HeightBlock& block) {
  digests_[static_cast<std::size_t>(by * blocks_x_ + bx)] = digest_of(block);
}

std::string SamplesDigest::text() const {
  const XXH128_hash_t all = XXH3_128bits(digests_.data(), digests_.size() * sizeof(BlockDigest));
  return fmt::format("{:016x}{:016x}", all.high64, all.low64);
}

}  // namespace tintree::cache
