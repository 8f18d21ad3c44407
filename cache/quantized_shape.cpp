#include "cache/quantized_shape.h"

#include <algorithm>
#include <bit>
#include <cstdlib>
#include <limits>
#include <utility>

#include "cache/drawable_tile.h"
#include "cache/skirt.h"

namespace tintree::cache {
namespace {

/// Finds a height's index in a quantiser that has it.
class IndexFinder {
 public:
  explicit IndexFinder(const codec::HeightQuantizer& quantizer) : quantizer_(&quantizer) {
    const std::vector<std::int32_t>& table = quantizer.table;
    if (table.empty()) return;
    indices_.resize(static_cast<std::size_t>(table.back() - table.front()) + 1);
    for (std::size_t i = 0; i < table.size(); ++i)
      indices_[static_cast<std::size_t>(table[i] - table.front())] = static_cast<std::int32_t>(i);
  }

  std::int32_t index(std::int32_t height) const {
    return indices_.empty() ? (height - quantizer_->low) / quantizer_->step
                            : indices_[static_cast<std::size_t>(height - quantizer_->table.front())];
  }

 private:
  const codec::HeightQuantizer* quantizer_;
  std::vector<std::int32_t> indices_;  // of heights from the table's lowest on
};

/// Lowest height on the sides; 0 where no vertex lies there.
std::int32_t lowest_on_sides(const QuantizedFormat& format, const codec::TileMesh& mesh) {
  std::int32_t low = std::numeric_limits<std::int32_t>::max();
  for (const codec::GridVertex& v : mesh.vertices) {
    if (format.on_side(v.x, v.y)) low = std::min(low, v.z);
  }
  return low == std::numeric_limits<std::int32_t>::max() ? 0 : low;
}

QuantizedFormat format_of(const codec::TileMesh& mesh, const codec::HeightQuantizer& quantizer,
                          const TileOutline& outline) {
  const auto border = [&](SkirtSide side, std::int64_t at) {
    return (outline.sides & side) != 0 ? static_cast<std::int32_t>(at) : -1;
  };
  QuantizedFormat out;
  out.width = mesh.scalar_shape->width();
  out.height = mesh.scalar_shape->height();
  out.x_bits = std::bit_width(static_cast<std::uint32_t>(out.width));
  out.y_bits = std::bit_width(static_cast<std::uint32_t>(out.height));
  out.low = quantizer.low;
  out.step = quantizer.step;
  out.side_low = lowest_on_sides(out, mesh);
  out.borders = {border(kSkirtWest, 0), border(kSkirtNorth, 0), border(kSkirtEast, outline.east),
                 border(kSkirtSouth, outline.south)};
  return out;
}

/// False when an index has too many bits.
bool put_words(const codec::TileMesh& mesh, const codec::HeightQuantizer& quantizer, QuantizedShape& shape) {
  const QuantizedFormat& format = shape.format;
  const IndexFinder inside(quantizer);
  const int place_bits = format.x_bits + format.y_bits;
  const std::int32_t too_many = 1 << (31 - place_bits);
  shape.words.reserve(mesh.vertices.size() + mesh.vertices.size() / 8);
  for (const codec::GridVertex& v : mesh.vertices) {
    const std::int32_t index = format.on_side(v.x, v.y) ? v.z - format.side_low : inside.index(v.z);
    if (index >= too_many) return false;
    shape.words.push_back(static_cast<std::uint32_t>(v.x) | static_cast<std::uint32_t>(v.y) << format.x_bits |
                          static_cast<std::uint32_t>(index) << place_bits);
  }
  return true;
}

/// Whether places on a side fit into texels, and samples and height steps from any eye into 32 bits.
bool is_near(const codec::GridFrame& frame, const codec::ScalarShape& shape) {
  constexpr std::int64_t kFarthest = QuantizedShape::kFarthest;
  const std::int64_t steps = std::max(shape.width(), shape.height());
  return steps <= QuantizedShape::kMostSteps && frame.xy_shift >= 0 && steps << frame.xy_shift <= kFarthest &&
         std::max(frame.column0, frame.row0) <= kFarthest && std::abs(frame.z_offset) <= kFarthest;
}

}  // namespace

codec::GridVertex QuantizedShape::vertex(std::uint32_t word) const {
  const std::int32_t x = format.x(word);
  const std::int32_t y = format.y(word);
  const std::int32_t index = format.index(word);
  if (format.on_side(x, y)) return {x, y, format.side_low + index};
  return {x, y, table.empty() ? format.low + format.step * index : table[static_cast<std::size_t>(index)]};
}

std::unique_ptr<DrawableTile> make_drawable_quantized(const codec::TreeLayout& layout, const codec::TileId& id,
                                                      const codec::TileMesh& mesh, std::uint16_t joined_sides) {
  const codec::GridFrame frame(layout, id, mesh);
  if (!mesh.scalar_shape || !is_near(frame, *mesh.scalar_shape)) return nullptr;
  const codec::HeightQuantizer quantizer = mesh.height_quantizer.value_or(codec::HeightQuantizer{});
  if (quantizer.table.size() > QuantizedShape::kMostLevels) return nullptr;
  const TileOutline outline = tile_outline(layout, id, mesh.xy_shift, joined_sides);
  auto shape = std::make_shared<QuantizedShape>();
  shape->format = format_of(mesh, quantizer, outline);
  if (!put_words(mesh, quantizer, *shape)) return nullptr;
  shape->table = quantizer.table;
  auto tile = std::make_unique<DrawableTile>();
  tile->id = id;
  tile->frame = frame;
  tile->surface_triangles = static_cast<std::uint32_t>(mesh.triangles.size());
  std::vector<std::uint32_t> indices;
  indices.reserve(3 * mesh.triangles.size() + 3 * mesh.triangles.size() / 8);
  for (const codec::Triangle& t : mesh.triangles) indices.insert(indices.end(), t.begin(), t.end());
  const auto lower = [&](std::uint32_t i, std::uint16_t) {
    shape->words.push_back(shape->words[i] | QuantizedFormat::kFoot);
    return static_cast<std::uint32_t>(shape->words.size() - 1);
  };
  add_skirts(mesh, outline, lower, indices);
  tile->set_indices(std::move(indices), shape->words.size());
  tile->occluder = std::make_shared<const Occluder>(make_occluder(layout, id, mesh));
  tile->native.scalar = std::move(shape);
  return tile;
}

}  // namespace tintree::cache
