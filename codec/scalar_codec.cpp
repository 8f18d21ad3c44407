#include "codec/scalar_codec.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <utility>

#include "codec/bit_pack.h"
#include "codec/index_coder.h"
#include "codec/scalar_grid.h"
#include "codec/varint.h"

namespace tintree::codec {
namespace {

constexpr auto kPayloadVersion = std::byte{2};
constexpr auto kWhole = std::byte{0};
constexpr auto kHoled = std::byte{1};
constexpr std::int64_t kMostSteps = std::int64_t{1} << 28;

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

Error damaged() { return {ErrorCode::kBadData, "the payload is no grid of heights", {}}; }

bool is_size(std::int64_t v) { return v >= 1 && v <= kMostSteps; }

/// What decode() demands beside what any grid's bytes fulfil.
bool is_within_limits(const TileMesh& mesh) {
  const BlockTree& blocks = mesh.scalar_shape->blocks;
  return is_size(blocks.width()) && is_size(blocks.height()) && is_size(blocks.stride()) &&
         std::has_single_bit(static_cast<std::uint32_t>(blocks.stride())) && mesh.xy_shift >= kMinXyShift &&
         mesh.xy_shift <= kMaxXyShift && std::abs(mesh.z_offset) <= kMaxHeightOffset &&
         std::ranges::all_of(mesh.vertices, [](const GridVertex& v) { return v.z >= 0 && v.z <= kMaxHeightAddress; });
}

bool take_border(std::span<const std::byte>& bytes, std::size_t border_count, ScalarTile& tile) {
  std::int64_t height = 0;
  for (std::size_t i = 0; i < border_count; ++i) {
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
void for_each_inner(std::size_t border_count, ScalarTile& tile, const Visit& visit) {
  for (std::size_t i = border_count; i < tile.z.size(); ++i) {
    if (!tile.is_missing(i)) visit(tile.z[i]);
  }
}

/// `quantizer` stays empty where no vertex is inside.
bool take_inner(std::span<const std::byte> bytes, std::size_t border_count, ScalarTile& tile,
                std::optional<HeightQuantizer>& quantizer) {
  std::size_t count = 0;
  for_each_inner(border_count, tile, [&](std::int32_t) { ++count; });
  std::vector<std::int32_t> heights(count);
  if (heights.empty()) return bytes.empty();
  quantizer = take_quantized(bytes, heights);
  if (!quantizer) return false;
  std::size_t next = 0;
  for_each_inner(border_count, tile, [&](std::int32_t& z) { z = heights[next++]; });
  return true;
}

/// A bit says whether a block is split, if it can be, and with holes another one whether one that is not is empty.
void put_blocks(BitWriter& bits, const BlockTree& blocks, bool holed) {
  blocks.walk(
      [&](const GridBlock& block) {
        const bool split = blocks.is_split(block.node);
        if (block.stride > 1) bits.put(split ? 1 : 0, 1);
        return split;
      },
      [&](const GridBlock& block) {
        if (holed) bits.put(block.empty ? 1 : 0, 1);
      });
}

bool take_blocks(BitReader& bits, BlockTree& blocks, bool holed) {
  blocks.walk(
      [&](const GridBlock& block) {
        const bool split = block.stride > 1 && bits.take(1) != 0 && bits.ok();
        if (split) blocks.split(block.node);
        return split;
      },
      [&](const GridBlock& block) {
        if (holed && bits.take(1) != 0) blocks.set_empty(block.node);
      });
  return bits.ok();
}

/// Cells with a vertex inside the tile at their north-western corner.
std::uint64_t inner_cells(const BlockTree& blocks) {
  std::uint64_t count = 0;
  blocks.for_each([&](const GridBlock& block) {
    const auto along = [&](std::int32_t from, std::int32_t length) {
      const std::int64_t cells = (std::int64_t{length} - from + block.stride - 1) / block.stride;
      return static_cast<std::uint64_t>(std::min<std::int64_t>(kBlockCells, cells) - (from == 0 ? 1 : 0));
    };
    count += along(block.x, blocks.width()) * along(block.y, blocks.height());
  });
  return count;
}

bool take_shape(std::span<const std::byte>& bytes, bool holed, ScalarShape& shape) {
  const std::uint64_t bits_left = 8 * std::uint64_t{bytes.size()};
  std::uint64_t width = 0;
  std::uint64_t height = 0;
  std::uint64_t stride = 0;
  if (!take_varint(bytes, width) || !take_varint(bytes, height) || !take_varint(bytes, stride)) return false;
  const auto fits = [](std::uint64_t v) { return is_size(static_cast<std::int64_t>(v)); };
  if (!fits(width) || !fits(height) || !fits(stride) || !std::has_single_bit(stride)) return false;
  const auto w = static_cast<std::int32_t>(width);
  const auto h = static_cast<std::int32_t>(height);
  const auto s = static_cast<std::int32_t>(stride);
  // A block takes a bit, or has a vertex of its own, which does.
  const auto roots = static_cast<std::uint64_t>(BlockTree::roots_along(w, s)) *
                     static_cast<std::uint64_t>(BlockTree::roots_along(h, s));
  if (roots > bits_left) return false;
  shape.blocks = BlockTree(w, h, s);
  BitReader bits(bytes);
  for (int side = 0; side < 4; ++side) {
    if (!SidePlaces::take(bits, shape.length(side), shape.sides[static_cast<std::size_t>(side)])) return false;
  }
  if (!take_blocks(bits, shape.blocks, holed)) return false;
  bytes = bits.rest();
  return holed || inner_cells(shape.blocks) <= bits_left;
}

}  // namespace

Expected<std::vector<std::byte>> ScalarCodec::encode(const TileMesh& mesh) const {
  if (mesh.scalar_shape && !is_within_limits(mesh))
    return fail(ErrorCode::kBadData, "the mesh exceeds what a payload of method scalar holds");
  auto found = find_scalar_tile(mesh);
  if (!found) return fail(ErrorCode::kBadData, "the mesh is no grid of method scalar");
  ScalarTile& tile = found->tile;
  const ScalarShape& shape = tile.shape;
  const std::size_t border_count = found->grid.border_count;
  bool holed = !tile.missing.empty();
  shape.blocks.for_each([&](const GridBlock& block) { holed = holed || block.empty; });
  std::vector<std::byte> out{kPayloadVersion, static_cast<std::byte>(static_cast<std::int8_t>(mesh.xy_shift)),
                             holed ? kHoled : kWhole};
  put_signed_varint(out, mesh.z_offset);
  put_varint(out, static_cast<std::uint64_t>(shape.width()));
  put_varint(out, static_cast<std::uint64_t>(shape.height()));
  put_varint(out, static_cast<std::uint64_t>(shape.blocks.stride()));
  BitWriter bits(out);
  for (const auto& places : shape.sides) {
    if (!SidePlaces::put(bits, places))
      return fail(ErrorCode::kBadData, "a side's vertices are not where halving puts them");
  }
  put_blocks(bits, shape.blocks, holed);
  bits.finish();
  if (holed) {
    tile.missing.resize(tile.z.size());
    put_missing(out, tile.missing);
  }
  std::int32_t last = 0;
  for (std::size_t i = 0; i < border_count; ++i) {
    if (tile.is_missing(i)) continue;
    put_signed_varint(out, tile.z[i] - last);
    last = tile.z[i];
  }
  std::vector<std::int32_t> heights;
  for_each_inner(border_count, tile, [&](std::int32_t z) { heights.push_back(z); });
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
  const bool holed = form == kHoled;
  if ((!holed && form != kWhole) || !take_signed_varint(bytes, tile.z_offset) || !take_shape(bytes, holed, tile.shape))
    return tl::unexpected(damaged());
  auto grid = make_scalar_grid(tile.shape);
  if (!grid) return tl::unexpected(damaged());
  if (holed) {
    tile.missing.assign(grid->places.size(), false);
    if (!take_missing(bytes, tile.missing)) return tl::unexpected(damaged());
  }
  tile.z.assign(grid->places.size(), 0);
  std::optional<HeightQuantizer> quantizer;
  if (!take_border(bytes, grid->border_count, tile) || !take_inner(bytes, grid->border_count, tile, quantizer))
    return tl::unexpected(damaged());
  TileMesh mesh = tile.mesh(std::move(*grid));
  mesh.height_quantizer = std::move(quantizer);
  return mesh;
}

}  // namespace tintree::codec
