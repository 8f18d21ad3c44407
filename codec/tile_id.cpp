#include "codec/tile_id.h"

namespace tintree::codec {
namespace {

constexpr int kLevelShift = 58;

std::uint64_t spread_bits(std::uint64_t v) {
  v &= 0xffffffffULL;
  v = (v | (v << 16)) & 0x0000ffff0000ffffULL;
  v = (v | (v << 8)) & 0x00ff00ff00ff00ffULL;
  v = (v | (v << 4)) & 0x0f0f0f0f0f0f0f0fULL;
  v = (v | (v << 2)) & 0x3333333333333333ULL;
  return (v | (v << 1)) & 0x5555555555555555ULL;
}

std::uint32_t gather_bits(std::uint64_t v) {
  v &= 0x5555555555555555ULL;
  v = (v | (v >> 1)) & 0x3333333333333333ULL;
  v = (v | (v >> 2)) & 0x0f0f0f0f0f0f0f0fULL;
  v = (v | (v >> 4)) & 0x00ff00ff00ff00ffULL;
  v = (v | (v >> 8)) & 0x0000ffff0000ffffULL;
  return static_cast<std::uint32_t>(v | (v >> 16));
}

}  // namespace

std::uint64_t TileId::morton() const { return spread_bits(x) | (spread_bits(y) << 1); }

std::int64_t TileId::key() const {
  return static_cast<std::int64_t>((static_cast<std::uint64_t>(level) << kLevelShift) | morton());
}

TileId TileId::from_key(std::int64_t key) {
  const auto bits = static_cast<std::uint64_t>(key);
  const std::uint64_t position = bits & ((1ULL << kLevelShift) - 1);
  return {static_cast<int>(bits >> kLevelShift), gather_bits(position), gather_bits(position >> 1)};
}

std::string TileId::text() const { return std::to_string(level) + "/" + std::to_string(x) + "/" + std::to_string(y); }

}  // namespace tintree::codec
