#include "codec/scalar_codec.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <utility>

#include "codec/bit_pack.h"
#include "codec/index_coder.h"
#include "codec/scalar_grid.h"
#include "codec/varint.h"

namespace tintree::codec {
namespace {

constexpr auto kPayloadVersion = std::byte{1};
constexpr auto kWhole = std::byte{0};
constexpr auto kHoled = std::byte{1};
constexpr std::uint64_t kMostSteps = std::uint64_t{1} << 29;

/// A side's vertices as a binary tree over the least power of two that reaches its end: bit 1 halves a piece. What
/// lies beyond the end is cut off.
class SidePlaces {
 public:
  static bool put(BitWriter& bits, const std::vector<std::int32_t>& places) {
    const auto length = places.back();
    std::size_t next = 0;
    return put_piece(bits, places, next, 0, root(length), length);
  }
  static bool take(BitReader& bits, std::int32_t length, std::vector<std::int32_t>& places) {
    places.assign(1, 0);
    return take_piece(bits, places, 0, root(length), length) && bits.ok();
  }

 private:
  static std::int64_t root(std::int32_t length) {
    return static_cast<std::int64_t>(std::bit_ceil(static_cast<std::uint32_t>(length)));
  }

  /// `next` is the vertex at the piece's start, and then that at its end.
  static bool put_piece(BitWriter& bits, const std::vector<std::int32_t>& places, std::size_t& next, std::int64_t at,
                        std::int64_t piece, std::int32_t length) {
    if (at >= length) return true;
    const bool whole = places[next + 1] == std::min<std::int64_t>(at + piece, length);
    if (whole) ++next;
    if (piece == 1) return whole;
    // A piece with only its first half inside may be halved without a vertex of its own.
    bits.put(whole ? 0 : 1, 1);
    return whole || (put_piece(bits, places, next, at, piece / 2, length) &&
                     put_piece(bits, places, next, at + piece / 2, piece / 2, length));
  }

  static bool take_piece(BitReader& bits, std::vector<std::int32_t>& places, std::int64_t at, std::int64_t piece,
                         std::int32_t length) {
    if (at >= length) return true;
    if (piece > 1 && bits.take(1) != 0) {
      return bits.ok() && take_piece(bits, places, at, piece / 2, length) &&
             take_piece(bits, places, at + piece / 2, piece / 2, length);
    }
    places.push_back(static_cast<std::int32_t>(std::min<std::int64_t>(at + piece, length)));
    return bits.ok();
  }
};

/// Lengths of runs of vertices, there and missing in turn.
void put_missing(std::vector<std::byte>& out, const std::vector<bool>& missing) {
  bool state = false;
  std::uint64_t run = 0;
  for (const bool gone : missing) {
    if (gone != state) {
      put_varint(out, run);
      run = 0;
      state = gone;
    }
    ++run;
  }
  put_varint(out, run);
}

bool take_missing(std::span<const std::byte>& bytes, std::vector<bool>& missing) {
  std::size_t at = 0;
  for (bool state = false; at < missing.size(); state = !state) {
    std::uint64_t run = 0;
    if (!take_varint(bytes, run) || run > missing.size() - at || (run == 0 && at > 0)) return false;
    std::fill_n(missing.begin() + static_cast<std::ptrdiff_t>(at), run, state);
    at += static_cast<std::size_t>(run);
  }
  return true;
}

/// Along a longer edge of a side all vertices of the line next to it have to be there, and its ends.
bool long_edges_whole(const ScalarTile& tile) {
  const ScalarGrid& g = tile.grid;
  std::vector<Triangle> strip = g.strip();
  const std::vector<GridVertex> places = g.places();
  return std::ranges::none_of(strip, [&](const Triangle& t) {
    if (!tile.is_missing(t[0]) && !tile.is_missing(t[1]) && !tile.is_missing(t[2])) return false;
    const auto [x0, x1] = std::minmax({places[t[0]].x, places[t[1]].x, places[t[2]].x});
    const auto [y0, y1] = std::minmax({places[t[0]].y, places[t[1]].y, places[t[2]].y});
    return x1 - x0 > 1 || y1 - y0 > 1;
  });
}

Error damaged() { return {ErrorCode::kBadData, "the payload is no grid of heights", {}}; }

bool take_border(std::span<const std::byte>& bytes, ScalarTile& tile) {
  std::int64_t height = 0;
  for (std::size_t i = 0; i < tile.grid.border_count(); ++i) {
    if (tile.is_missing(i)) continue;
    std::int64_t step = 0;
    if (!take_signed_varint(bytes, step) || step < -kMaxHeightAddress || step > kMaxHeightAddress) return false;
    height += step;
    if (height < 0 || height > kMaxHeightAddress) return false;
    tile.z[i] = static_cast<std::int32_t>(height);
  }
  return true;
}

/// The heights of the inner vertices that are there go through `visit(height)`, in their order.
template <typename Visit>
void for_each_inner(ScalarTile& tile, const Visit& visit) {
  for (std::size_t i = tile.grid.border_count(); i < tile.z.size(); ++i) {
    if (!tile.is_missing(i)) visit(tile.z[i]);
  }
}

bool take_inner(std::span<const std::byte> bytes, ScalarTile& tile) {
  std::size_t count = 0;
  for_each_inner(tile, [&](std::int32_t) { ++count; });
  std::vector<std::int32_t> heights(count);
  if (!take_quantized(bytes, heights)) return false;
  std::size_t next = 0;
  for_each_inner(tile, [&](std::int32_t& z) { z = heights[next++]; });
  return true;
}

bool take_grid(std::span<const std::byte>& bytes, ScalarGrid& grid) {
  std::uint64_t width = 0;
  std::uint64_t height = 0;
  std::uint64_t stride = 0;
  if (!take_varint(bytes, width) || !take_varint(bytes, height) || !take_varint(bytes, stride)) return false;
  const auto is_size = [](std::uint64_t v) { return v >= 1 && v <= kMostSteps; };
  if (!is_size(width) || !is_size(height) || !is_size(stride)) return false;
  if (stride > 1 && (stride >= width || stride >= height)) return false;
  grid.width = static_cast<std::int32_t>(width);
  grid.height = static_cast<std::int32_t>(height);
  grid.stride = static_cast<std::int32_t>(stride);
  // Each inner vertex has a bit at least, or a bit in the list of the missing ones' runs.
  if (grid.columns() > kMaxGridVertices || grid.columns() * grid.rows() > kMaxGridVertices) return false;
  BitReader bits(bytes);
  for (int side = 0; side < 4; ++side) {
    if (!SidePlaces::take(bits, grid.length(side), grid.sides[static_cast<std::size_t>(side)])) return false;
  }
  bytes = bits.rest();
  return grid.is_sound();
}

}  // namespace

Expected<std::vector<std::byte>> ScalarCodec::encode(const TileMesh& mesh) const {
  auto tile = find_scalar_tile(mesh);
  if (!tile) return fail(ErrorCode::kBadData, "the mesh is no grid of method scalar");
  const ScalarGrid& grid = tile->grid;
  const bool holed = !tile->missing.empty();
  std::vector<std::byte> out{kPayloadVersion, static_cast<std::byte>(static_cast<std::int8_t>(mesh.xy_shift)),
                             holed ? kHoled : kWhole};
  put_signed_varint(out, mesh.z_offset);
  put_varint(out, static_cast<std::uint64_t>(grid.width));
  put_varint(out, static_cast<std::uint64_t>(grid.height));
  put_varint(out, static_cast<std::uint64_t>(grid.stride));
  BitWriter bits(out);
  for (const auto& places : grid.sides) {
    if (!SidePlaces::put(bits, places))
      return fail(ErrorCode::kBadData, "a side's vertices are not where halving puts them");
  }
  bits.finish();
  if (holed) put_missing(out, tile->missing);
  std::int32_t last = 0;
  for (std::size_t i = 0; i < grid.border_count(); ++i) {
    if (tile->is_missing(i)) continue;
    put_signed_varint(out, tile->z[i] - last);
    last = tile->z[i];
  }
  std::vector<std::int32_t> heights;
  heights.reserve(grid.inner_count());
  for_each_inner(*tile, [&](std::int32_t z) { heights.push_back(z); });
  put_quantized(out, heights);
  return out;
}

Expected<TileMesh> ScalarCodec::decode(std::span<const std::byte> bytes) const {
  if (bytes.size() < 3 || bytes[0] != kPayloadVersion)
    return fail(ErrorCode::kBadData, "the payload's version is unknown to this program");
  ScalarTile tile;
  tile.xy_shift = static_cast<std::int8_t>(bytes[1]);
  const std::byte form = bytes[2];
  bytes = bytes.subspan(3);
  if (form != kWhole && form != kHoled) return tl::unexpected(damaged());
  if (!take_signed_varint(bytes, tile.z_offset) || !take_grid(bytes, tile.grid)) return tl::unexpected(damaged());
  if (form == kHoled) {
    tile.missing.assign(tile.grid.vertex_count(), false);
    if (tile.grid.stride != 1 || !take_missing(bytes, tile.missing) || !long_edges_whole(tile))
      return tl::unexpected(damaged());
  } else if (tile.grid.inner_count() / 8 > bytes.size()) {
    return tl::unexpected(damaged());
  }
  tile.z.assign(tile.grid.vertex_count(), 0);
  if (!take_border(bytes, tile) || !take_inner(bytes, tile)) return tl::unexpected(damaged());
  return tile.mesh();
}

}  // namespace tintree::codec
