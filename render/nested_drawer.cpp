#include "render/nested_drawer.h"

#include <cmath>
#include <cstddef>
#include <span>
#include <string>
#include <utility>

#include <glm/gtc/type_ptr.hpp>
#include <glm/mat4x4.hpp>

#include "render/nested_chunks.h"
#include "render/nested_stitch.h"

namespace tintree::render {
namespace {

using cache::NestedShape;

/// West, north, east, south.
constexpr std::array<std::array<int, 2>, 4> kSteps{{{-1, 0}, {0, -1}, {1, 0}, {0, 1}}};
constexpr std::array<std::uint16_t, 4> kSkirtSides{cache::kSkirtWest, cache::kSkirtNorth, cache::kSkirtEast,
                                                   cache::kSkirtSouth};

}  // namespace

Expected<NestedDrawer> NestedDrawer::create(const GlFunctions& gl) {
  auto program = make_ground_program(gl, "nested.vert.glsl");
  if (!program) return tl::unexpected(program.error());
  return NestedDrawer(gl, std::move(*program));
}

NestedDrawer::NestedDrawer(const GlFunctions& gl, ShaderProgram program) : gl_(&gl), program_(std::move(program)) {
  for (std::size_t i = 0; i < at_.size(); ++i) {
    const auto uniform = [&](const char* name) {
      return program_.uniform((name + std::string(i == 0 ? "[0]" : "[1]")).c_str());
    };
    at_[i] = {uniform("address_to_eye"), uniform("coarse_units"), uniform("fine_units"), uniform("detail")};
  }
  gl_->GenVertexArrays(1, &stitch_array_);
  gl_->BindVertexArray(stitch_array_);
  gl_->GenBuffers(1, &stitch_buffer_);
  gl_->BindBuffer(GL_ARRAY_BUFFER, stitch_buffer_);
  constexpr GLsizei kStride = sizeof(StitchVertex);
  describe_nested_vertex(*gl_, kStride);
  gl_->VertexAttribIPointer(5, 2, GL_UNSIGNED_SHORT, kStride,
                            reinterpret_cast<const void*>(offsetof(StitchVertex, second)));
  gl_->EnableVertexAttribArray(5);
  gl_->BindVertexArray(0);
}

NestedDrawer::NestedDrawer(NestedDrawer&& other) noexcept
    : gl_(other.gl_),
      program_(std::move(other.program_)),
      at_(other.at_),
      stitch_buffer_(std::exchange(other.stitch_buffer_, 0)),
      stitch_array_(std::exchange(other.stitch_array_, 0)) {}

NestedDrawer::~NestedDrawer() {
  if (stitch_array_ == 0) return;
  gl_->DeleteVertexArrays(1, &stitch_array_);
  gl_->DeleteBuffers(1, &stitch_buffer_);
}

std::vector<NestedDrawer::Placed> NestedDrawer::place(Trees trees, const LodCut& cut, GpuTilePool& pool) const {
  std::vector<Placed> out;
  for (const DrawTile& d : cut.draws) {
    const codec::TileId& id = trees[d.tree]->nodes()[d.node].id;
    const GpuTile* tile = pool.use({id, d.tree});
    if (tile == nullptr) continue;
    if (auto shape = tile->nested.lock()) out.push_back({&d, id, tile, std::move(shape)});
  }
  return out;
}

void NestedDrawer::set_tile(const Camera& camera, Trees trees, const LodCut& cut, const Placed& tile,
                            std::size_t which) const {
  const NestedShape& shape = *tile.shape;
  const Places& at = at_[which];
  const glm::mat4 matrix(glm::make_mat4(shape.frame.matrix({camera.eye.x, camera.eye.y, camera.eye.z}).data()));
  gl_->UniformMatrix4fv(at.address_to_eye, 1, GL_FALSE, glm::value_ptr(matrix));
  const auto& units = shape.units;
  gl_->Uniform4f(at.coarse_units, units[0], units[1], units[2], units[3]);
  gl_->Uniform4f(at.fine_units, units[4], units[5], units[6], units[7]);
  const auto level = static_cast<float>(tile.draw->nested_level);
  const double bound_m = trees[tile.draw->tree]->layout().bound_m(tile.id.level);
  const double allowed = cut.options.pixel_error / (camera.focal_px() * bound_m);
  gl_->Uniform4f(at.detail, cut.options.morph ? 0 : level, level, static_cast<float>(allowed), 0);
}

std::vector<NestedDrawer::Line> NestedDrawer::border(const Placed& tile, std::size_t side) const {
  std::vector<Line> out;
  const std::size_t vertices = tile.shape->level_vertices(tile.draw->nested_level);
  bool joined = false;
  for (const cache::BorderVertex& b : tile.shape->borders[side]) {
    if (b.vertex >= vertices) continue;
    if (!joined) out.emplace_back();
    out.back().push_back(b);
    joined = (b.joined_levels >> tile.draw->nested_level & 1) != 0;
  }
  return out;
}

std::vector<NestedDrawer::StitchVertex> NestedDrawer::stitches(const Placed& tile, const Placed& neighbour,
                                                               std::size_t side) const {
  std::vector<StitchVertex> out;
  const std::vector<Line> others = border(neighbour, (side + 2) % 4);
  for (const Line& line : border(tile, side)) {
    for (const Line& other : others) {
      for (const auto& triangle : stitch(line, other)) {
        for (const StitchCorner& c : triangle) {
          const auto second = static_cast<std::uint16_t>(c.other ? 1 : 0);
          out.push_back({(c.other ? neighbour : tile).shape->vertices[c.vertex], second, 0});
        }
      }
    }
  }
  return out;
}

std::vector<NestedDrawer::StitchVertex> NestedDrawer::skirt(const Placed& tile, std::size_t side) const {
  std::vector<StitchVertex> out;
  const std::uint16_t foot = kSkirtSides[side];
  for (const Line& line : border(tile, side)) {
    for (std::size_t i = 0; i + 1 < line.size(); ++i) {
      const cache::NestedVertex& a = tile.shape->vertices[line[i].vertex];
      const cache::NestedVertex& b = tile.shape->vertices[line[i + 1].vertex];
      out.insert(out.end(), {{a, 0, 0}, {b, 0, 0}, {a, 0, foot}, {a, 0, foot}, {b, 0, 0}, {b, 0, foot}});
    }
  }
  return out;
}

void NestedDrawer::draw_side(const std::vector<StitchVertex>& vertices) const {
  const std::span<const StitchVertex> all(vertices);
  gl_->BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(all.size_bytes()), all.data(), GL_STREAM_DRAW);
  gl_->DrawArrays(GL_TRIANGLES, 0, static_cast<GLsizei>(all.size()));
}

void NestedDrawer::draw(const Camera& camera, Trees trees, const LodCut& cut, std::span<const DrawTile> part,
                        GpuTilePool& pool, const Style& style, DrawStats& stats) const {
  const std::vector<Placed> tiles = place(trees, cut, pool);
  if (tiles.empty()) return;
  gl_->Enable(GL_PRIMITIVE_RESTART);
  gl_->PrimitiveRestartIndex(codec::NestedFans::kRestart);
  const auto in_part = [&](const Placed& t) { return t.draw >= part.data() && t.draw < part.data() + part.size(); };
  Neighbours drawn;
  for (const Placed& t : tiles) {
    drawn[{t.id, t.draw->tree}] = &t;
    if (!in_part(t)) continue;
    set_tile(camera, trees, cut, t, 0);
    set_tile_look(*gl_, program_, pool, *t.tile, trees, *t.draw, style);
    pool.nested().send(*t.tile->chunk, *t.shape, t.draw->nested_level);
    pool.nested().draw(*t.tile->chunk, *t.shape);
    stats.add_tile(t.shape->fans.level_triangles[static_cast<std::size_t>(t.draw->nested_level)]);
  }
  gl_->Disable(GL_PRIMITIVE_RESTART);
  if (!style.skirts && !style.stitches) return;
  gl_->BindVertexArray(stitch_array_);
  gl_->BindBuffer(GL_ARRAY_BUFFER, stitch_buffer_);
  for (const Placed& t : tiles) {
    if (in_part(t)) draw_sides(camera, trees, cut, pool, style, t, drawn);
  }
}

/// Every side is stitched once: by the smaller of the two tiles, and between equal ones by the eastern or southern.
void NestedDrawer::draw_sides(const Camera& camera, Trees trees, const LodCut& cut, const GpuTilePool& pool,
                              const Style& style, const Placed& tile, const Neighbours& drawn) const {
  set_tile(camera, trees, cut, tile, 0);
  set_tile_look(*gl_, program_, pool, *tile.tile, trees, *tile.draw, style);
  for (std::size_t side = 0; side < kSteps.size(); ++side) {
    if ((tile.shape->skirt_sides & kSkirtSides[side]) == 0) continue;
    const auto [dx, dy] = kSteps[side];
    codec::TileId next{tile.id.level, tile.id.x + static_cast<std::uint32_t>(dx),
                       tile.id.y + static_cast<std::uint32_t>(dy)};
    auto at = drawn.find({next, tile.draw->tree});
    if (at != drawn.end() && side >= 2) continue;
    while (at == drawn.end() && next.level > 0) {
      next = trees[tile.draw->tree]->layout().parent(next);
      at = drawn.find({next, tile.draw->tree});
    }
    if (at == drawn.end()) {
      if (style.skirts) draw_side(skirt(tile, side));
      continue;
    }
    if (!style.stitches) continue;
    const Placed& other = *at->second;
    set_tile(camera, trees, cut, other, 1);
    const codec::GridFrame& from = other.shape->frame;
    const codec::GridFrame& to = tile.shape->frame;
    const auto steps = [&to](std::int64_t cells) {
      return static_cast<float>(std::ldexp(static_cast<double>(cells), -to.xy_shift));
    };
    gl_->Uniform3f(program_.uniform("second_to_first"), std::ldexp(1.0F, from.xy_shift - to.xy_shift),
                   steps(from.column0 - to.column0), steps(from.row0 - to.row0));
    draw_side(stitches(tile, other, side));
  }
}

}  // namespace tintree::render
