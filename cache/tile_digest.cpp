#include "cache/tile_digest.h"

#include <array>
#include <new>

#include <fmt/format.h>
#include <xxhash.h>

namespace tintree::cache {
namespace {

/// What checksum and digest cover besides the payload, little-endian.
struct TileHead {
  std::int64_t key;
  std::uint32_t vertices;
  std::uint32_t triangles;
  std::array<double, 5> figures;
};
static_assert(sizeof(TileHead) == 56);

struct PictureHead {
  std::int64_t key;
  std::uint32_t kind;
  std::uint32_t bytes;
};
static_assert(sizeof(PictureHead) == 16);

TileHead head_of(const TileInfo& info) {
  return {info.id.key(),
          info.vertices,
          info.triangles,
          {info.z_min_m, info.z_max_m, info.error_m, info.rms_m, info.border_error_m}};
}

}  // namespace

std::int64_t checksum_of(const StoredTile& tile) {
  const TileHead head = head_of(tile.info);
  const std::uint64_t payload = XXH3_64bits(tile.payload.data(), tile.payload.size());
  return static_cast<std::int64_t>(XXH3_64bits_withSeed(&head, sizeof head, payload));
}

struct TreeDigest::State {
  State() : hash(XXH3_createState()) {
    if (hash == nullptr) throw std::bad_alloc();
    XXH3_128bits_reset(hash);
  }
  ~State() { XXH3_freeState(hash); }
  State(const State&) = delete;
  State& operator=(const State&) = delete;

  XXH3_state_t* hash;
};

TreeDigest::TreeDigest() : state_(std::make_unique<State>()) {}
TreeDigest::~TreeDigest() = default;

void TreeDigest::add(const StoredTile& tile) {
  const TileHead head = head_of(tile.info);
  XXH3_128bits_update(state_->hash, &head, sizeof head);
  XXH3_128bits_update(state_->hash, tile.payload.data(), tile.payload.size());
}

void TreeDigest::add(PictureKind kind, const codec::TileId& id, std::span<const std::byte> payload) {
  const PictureHead head{id.key(), static_cast<std::uint32_t>(kind), static_cast<std::uint32_t>(payload.size())};
  XXH3_128bits_update(state_->hash, &head, sizeof head);
  XXH3_128bits_update(state_->hash, payload.data(), payload.size());
}

std::string TreeDigest::text() const {
  const XXH128_hash_t hash = XXH3_128bits_digest(state_->hash);
  return fmt::format("{:016x}{:016x}", hash.high64, hash.low64);
}

}  // namespace tintree::cache
