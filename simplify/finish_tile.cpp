#include "simplify/finish_tile.h"

#include <algorithm>
#include <bit>
#include <limits>

#include <fmt/format.h>

namespace tintree::simplify {

Expected<codec::TileMesh> finish_tile(codec::TileMesh mesh, std::int64_t span, int sub_bits, const codec::TileId& id) {
  if (mesh.vertices.empty()) return codec::TileMesh{};
  std::int32_t lowest = std::numeric_limits<std::int32_t>::max();
  std::int32_t highest = std::numeric_limits<std::int32_t>::min();
  auto all_bits = static_cast<std::uint32_t>(span);
  for (const codec::GridVertex& v : mesh.vertices) {
    lowest = std::min(lowest, v.z);
    highest = std::max(highest, v.z);
    all_bits |= static_cast<std::uint32_t>(v.x) | static_cast<std::uint32_t>(v.y);
  }
  const std::int64_t relief = std::int64_t{highest} - lowest;
  if (relief > codec::kMaxHeightAddress) {
    return fail(ErrorCode::kBadData,
                fmt::format("its relief spans {} height steps, more than the {} of the format; choose an --error at "
                            "least {:.1f} times as large",
                            relief, codec::kMaxHeightAddress, static_cast<double>(relief) / codec::kMaxHeightAddress),
                "tile " + id.text());
  }
  const int shift = std::countr_zero(all_bits);
  mesh.xy_shift = shift - sub_bits;
  mesh.z_offset += lowest;
  for (codec::GridVertex& v : mesh.vertices) v = {v.x >> shift, v.y >> shift, v.z - lowest};
  return mesh;
}

}  // namespace tintree::simplify
