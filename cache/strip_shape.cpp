#include "cache/strip_shape.h"

#include <utility>

#include "cache/drawable_tile.h"
#include "cache/occluder.h"

namespace tintree::cache {

StripShape::StripShape(std::vector<std::byte> packed, codec::StripPayload strip, codec::StripBorders borders)
    : packed_(std::move(packed)), strip_(strip), borders_(borders) {
  skirt_words_ = static_cast<std::uint32_t>(codec::strip_skirts(strip_, words(), borders_).size());
}

std::vector<std::uint32_t> StripShape::words() const {
  std::vector<std::uint32_t> out(triangle_words());
  codec::expand_sub_strips(strip_, out);
  return out;
}

std::unique_ptr<DrawableTile> make_drawable_strip(const codec::TreeLayout& layout, const codec::TileId& id,
                                                  std::vector<std::byte> packed, const codec::TileMesh& mesh,
                                                  std::uint16_t joined_sides) {
  const auto strip = codec::open_strip(packed);
  if (!strip || !codec::unpacks_on_card(*strip)) return nullptr;
  const int step_shift = mesh.xy_shift - strip->fine;
  const TileOutline outline = tile_outline(layout, id, step_shift, joined_sides);
  const auto border = [&](SkirtSide side, std::int64_t at) {
    return (outline.sides & side) != 0 ? static_cast<std::int32_t>(at) : -1;
  };
  const codec::StripBorders borders{border(kSkirtWest, 0), border(kSkirtNorth, 0), border(kSkirtEast, outline.east),
                                    border(kSkirtSouth, outline.south)};
  auto tile = std::make_unique<DrawableTile>();
  tile->id = id;
  tile->frame = codec::GridFrame(layout, id, mesh);
  tile->frame.xy_shift = step_shift;
  tile->surface_triangles = static_cast<std::uint32_t>(mesh.triangles.size());
  tile->occluder = std::make_shared<const Occluder>(make_occluder(layout, id, mesh));
  tile->native.strip = std::make_shared<const StripShape>(std::move(packed), *strip, borders);
  return tile;
}

}  // namespace tintree::cache
