#include "render/nested_drawer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <utility>

#include <glm/geometric.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <glm/mat4x4.hpp>

namespace tintree::render {
namespace {

using codec::NestedTile;

constexpr std::size_t kSmallestChunk = std::size_t{32} << 10;
constexpr std::size_t kVertexBytes = sizeof(NestedVertex);
constexpr std::size_t kIndexBytes = sizeof(std::uint32_t);

/// A vertex between tiles: whose it is comes behind.
struct StitchVertex {
  NestedVertex vertex;
  float other_tile = 0;
};

const void* offset(std::size_t bytes) { return reinterpret_cast<const void*>(bytes); }

/// Locations as in shaders/nested.vert.glsl.
void describe(const GlFunctions& gl, GLsizei stride) {
  gl.VertexAttribIPointer(0, 2, GL_UNSIGNED_INT, stride, offset(0));
  gl.VertexAttribPointer(1, 4, GL_BYTE, GL_FALSE, stride, offset(8));
  gl.VertexAttribPointer(2, 4, GL_BYTE, GL_FALSE, stride, offset(12));
  for (GLuint location = 0; location < 3; ++location) gl.EnableVertexAttribArray(location);
}

NestedVertex pack(const NestedTile& tile, std::size_t v) {
  const codec::GridVertex& p = tile.vertices[v];
  const auto x = static_cast<std::uint32_t>(p.x);
  const auto y = static_cast<std::uint32_t>(p.y);
  return {(x & 0xffffU) | y << 16, static_cast<std::uint32_t>(p.z) | (x >> 16) << 22 | (y >> 16) << 25, tile.morphs[v]};
}

std::size_t most_indices(const NestedTile& tile) {
  std::size_t most = 0;
  for (const auto& fans : tile.fans) most = std::max(most, fans.size());
  return most;
}

std::size_t vertex_room(const NestedTile& tile) { return tile.vertices.size() * kVertexBytes; }

void set(const GlFunctions& gl, GLint location, const glm::dmat4& m) {
  const glm::mat4 f(m);
  gl.UniformMatrix4fv(location, 1, GL_FALSE, glm::value_ptr(f));
}

}  // namespace

std::size_t NestedDrawer::chunk_bytes(const NestedTile& tile) {
  return vertex_room(tile) + most_indices(tile) * kIndexBytes;
}

Expected<NestedDrawer> NestedDrawer::create(const GlFunctions& gl, const codec::TreeLayout& layout,
                                            std::size_t gpu_bytes, std::size_t largest_bytes) {
  auto program = ShaderProgram::create(gl, "nested.vert.glsl", "nested.frag.glsl");
  if (!program) return tl::unexpected(program.error());
  return NestedDrawer(gl, layout, std::move(*program), ChunkPool(gpu_bytes, kSmallestChunk, largest_bytes));
}

NestedDrawer::NestedDrawer(const GlFunctions& gl, const codec::TreeLayout& layout, ShaderProgram program,
                           ChunkPool pool)
    : gl_(&gl), layout_(&layout), program_(std::move(program)), pool_(std::move(pool)) {
  gl_->GenVertexArrays(1, &array_);
  gl_->BindVertexArray(array_);
  gl_->GenBuffers(1, &buffer_);
  gl_->BindBuffer(GL_ARRAY_BUFFER, buffer_);
  gl_->BindBuffer(GL_ELEMENT_ARRAY_BUFFER, buffer_);
  gl_->BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(pool_.bytes()), nullptr, GL_DYNAMIC_DRAW);
  describe(*gl_, kVertexBytes);
  gl_->GenVertexArrays(1, &stitch_array_);
  gl_->BindVertexArray(stitch_array_);
  gl_->GenBuffers(1, &stitch_buffer_);
  gl_->BindBuffer(GL_ARRAY_BUFFER, stitch_buffer_);
  describe(*gl_, sizeof(StitchVertex));
  gl_->VertexAttribPointer(3, 1, GL_FLOAT, GL_FALSE, sizeof(StitchVertex), offset(offsetof(StitchVertex, other_tile)));
  gl_->EnableVertexAttribArray(3);
  gl_->BindVertexArray(0);
}

NestedDrawer::NestedDrawer(NestedDrawer&& other) noexcept
    : gl_(other.gl_),
      layout_(other.layout_),
      program_(std::move(other.program_)),
      pool_(std::move(other.pool_)),
      residents_(std::move(other.residents_)),
      frame_(other.frame_),
      buffer_(std::exchange(other.buffer_, 0)),
      array_(std::exchange(other.array_, 0)),
      stitch_buffer_(std::exchange(other.stitch_buffer_, 0)),
      stitch_array_(std::exchange(other.stitch_array_, 0)) {}

NestedDrawer::~NestedDrawer() {
  if (array_ == 0) return;
  gl_->DeleteVertexArrays(1, &array_);
  gl_->DeleteVertexArrays(1, &stitch_array_);
  gl_->DeleteBuffers(1, &buffer_);
  gl_->DeleteBuffers(1, &stitch_buffer_);
}

NestedDrawer::Placed NestedDrawer::place(const Camera& camera, const NestedView& view, const NestedStyle& style) const {
  const NestedTile& tile = *view.tile;
  Placed out;
  out.view = &view;
  codec::TileMesh address;
  address.xy_shift = tile.xy_shift;
  address.z_offset = tile.z_offset;
  out.frame = codec::GridFrame(*layout_, view.id, address);
  const auto [low, high] = std::ranges::minmax(tile.vertices, {}, &codec::GridVertex::z);
  out.z = {low.z, high.z};
  const double cells = static_cast<double>(layout_->cells_across(view.id.level));
  const auto side = static_cast<std::int32_t>(std::ldexp(cells, -tile.xy_shift));
  std::array<glm::dvec3, 8> corners{};
  for (std::size_t k = 0; k < corners.size(); ++k) {
    const auto [x, y, z] =
        out.frame.world({(k & 1) != 0 ? side : 0, (k & 2) != 0 ? side : 0, out.z[(k & 4) != 0 ? 1 : 0]});
    corners[k] = {x, y, z};
  }
  out.corners = corner_levels(camera, corners, layout_->bound_m(view.id.level), tile.levels, style.pixel_error);
  out.level = mesh_level(out.corners, tile.levels);
  if (!style.morph) out.corners.fill(static_cast<float>(out.level));
  return out;
}

bool NestedDrawer::send(Placed& tile, NestedStats& stats) {
  const NestedTile& mesh = *tile.view->tile;
  const auto key = static_cast<std::uint64_t>(tile.view->id.key());
  auto at = residents_.find(key);
  if (at != residents_.end() && pool_.chunks()[at->second.chunk].owner != key) {
    residents_.erase(at);
    at = residents_.end();
  }
  if (at == residents_.end()) {
    const auto chunk = pool_.take(key, chunk_bytes(mesh), frame_);
    if (!chunk) return false;
    at = residents_.insert_or_assign(key, Resident{*chunk}).first;
  }
  Resident& resident = at->second;
  pool_.use(resident.chunk, frame_);
  tile.chunk = resident.chunk;
  const std::size_t begin = pool_.chunks()[resident.chunk].begin;
  gl_->BindBuffer(GL_ARRAY_BUFFER, buffer_);
  if (resident.levels_sent <= tile.level) {
    const std::size_t first =
        resident.levels_sent == 0 ? 0 : mesh.level_vertices[static_cast<std::size_t>(resident.levels_sent) - 1];
    std::vector<NestedVertex> vertices;
    for (std::size_t v = first; v < mesh.level_vertices[static_cast<std::size_t>(tile.level)]; ++v)
      vertices.push_back(pack(mesh, v));
    gl_->BufferSubData(GL_ARRAY_BUFFER, static_cast<GLintptr>(begin + first * kVertexBytes),
                       static_cast<GLsizeiptr>(vertices.size() * kVertexBytes), vertices.data());
    stats.vertex_bytes += vertices.size() * kVertexBytes;
    resident.levels_sent = tile.level + 1;
  }
  if (std::exchange(resident.indices_of, tile.level) != tile.level) {
    const std::vector<std::uint32_t>& fans = mesh.fans[static_cast<std::size_t>(tile.level)];
    gl_->BufferSubData(GL_ARRAY_BUFFER, static_cast<GLintptr>(begin + vertex_room(mesh)),
                       static_cast<GLsizeiptr>(fans.size() * kIndexBytes), fans.data());
    stats.index_bytes += fans.size() * kIndexBytes;
  }
  return true;
}

void NestedDrawer::set_tile(const Camera& camera, const Placed& tile, int which) const {
  const auto name = [which](const char* uniform) { return std::string(uniform) + (which == 0 ? "[0]" : "[1]"); };
  const auto place_of = [&](const char* uniform) { return program_.uniform(name(uniform).c_str()); };
  const NestedTile& mesh = *tile.view->tile;
  const std::array<double, 16> matrix = tile.frame.matrix({camera.eye.x, camera.eye.y, camera.eye.z});
  set(*gl_, place_of("address_to_eye"), glm::make_mat4(matrix.data()));
  const CornerLevels& c = tile.corners;
  gl_->Uniform4f(place_of("low_levels"), c[0], c[1], c[2], c[3]);
  gl_->Uniform4f(place_of("high_levels"), c[4], c[5], c[6], c[7]);
  const double side = std::ldexp(static_cast<double>(layout_->cells_across(tile.view->id.level)), -mesh.xy_shift);
  const auto floor = static_cast<float>(tile.z[0]);
  const auto height = static_cast<float>(std::max(1, tile.z[1] - tile.z[0]));
  gl_->Uniform4f(place_of("box"), static_cast<float>(1 / side), floor, 1 / height, 0);
  std::array<float, NestedTile::kMostLevels - 1> units{};
  for (std::size_t k = 0; k < units.size(); ++k) units[k] = std::ldexp(1.0F, mesh.morph_exponent[k]);
  gl_->Uniform4f(place_of("coarse_units"), units[0], units[1], units[2], units[3]);
  gl_->Uniform4f(place_of("fine_units"), units[4], units[5], units[6], units[7]);
}

void NestedDrawer::draw_tile(const Placed& tile) const {
  const NestedTile& mesh = *tile.view->tile;
  const std::size_t begin = pool_.chunks()[tile.chunk].begin;
  gl_->DrawElementsBaseVertex(
      GL_TRIANGLE_FAN, static_cast<GLsizei>(mesh.fans[static_cast<std::size_t>(tile.level)].size()), GL_UNSIGNED_INT,
      offset(begin + vertex_room(mesh)), static_cast<GLint>(begin / kVertexBytes));
}

/// Sides: 0 west, 1 north, 2 east, 3 south.
std::vector<BorderVertex> NestedDrawer::border(const Placed& tile, int side) const {
  const NestedTile& mesh = *tile.view->tile;
  const codec::TileId& id = tile.view->id;
  const std::int64_t halves = 2 * layout_->cells_across(id.level);
  const int digits = mesh.xy_shift + 1;
  const bool southward = side % 2 == 0;
  const std::int64_t line = side < 2 ? 0 : halves >> digits;
  const std::int64_t begin = halves * (southward ? id.y : id.x);
  std::vector<BorderVertex> out;
  for (std::uint32_t v = 0; v < mesh.level_vertices[static_cast<std::size_t>(tile.level)]; ++v) {
    const codec::GridVertex& p = mesh.vertices[v];
    if ((southward ? p.x : p.y) == line)
      out.push_back({begin + (static_cast<std::int64_t>(southward ? p.y : p.x) << digits), v});
  }
  std::ranges::sort(out, {}, &BorderVertex::along);
  return out;
}

void NestedDrawer::stitch_pair(const Camera& camera, const Placed& one, const Placed& other, int side,
                               NestedStats& stats) {
  const auto triangles = stitch(border(one, side), border(other, (side + 2) % 4));
  std::vector<StitchVertex> vertices;
  for (const auto& t : triangles) {
    for (const StitchCorner& c : t)
      vertices.push_back({pack(*(c.other ? other : one).view->tile, c.vertex), c.other ? 1.0F : 0.0F});
  }
  set_tile(camera, one, 0);
  set_tile(camera, other, 1);
  gl_->BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(vertices.size() * sizeof(StitchVertex)), vertices.data(),
                  GL_STREAM_DRAW);
  gl_->DrawArrays(GL_TRIANGLES, 0, static_cast<GLsizei>(vertices.size()));
  stats.stitches += triangles.size();
}

/// Every side is stitched once: by the smaller of the two tiles, and between equal ones by the eastern or southern.
void NestedDrawer::stitch_sides(const Camera& camera, std::span<const Placed> tiles, NestedStats& stats) {
  std::map<std::int64_t, const Placed*> by_key;
  for (const Placed& t : tiles) {
    if (t.resident) by_key[t.view->id.key()] = &t;
  }
  constexpr std::array<std::array<int, 2>, 4> kSteps{{{-1, 0}, {0, -1}, {1, 0}, {0, 1}}};
  gl_->BindVertexArray(stitch_array_);
  gl_->BindBuffer(GL_ARRAY_BUFFER, stitch_buffer_);
  for (const Placed& t : tiles) {
    if (!t.resident) continue;
    const codec::TileId& id = t.view->id;
    for (int side = 0; side < 4; ++side) {
      const auto [dx, dy] = kSteps[static_cast<std::size_t>(side)];
      if ((dx < 0 && id.x == 0) || (dy < 0 && id.y == 0)) continue;
      codec::TileId next{id.level, id.x + static_cast<std::uint32_t>(dx), id.y + static_cast<std::uint32_t>(dy)};
      if (next.x >= layout_->tiles_x(id.level) || next.y >= layout_->tiles_y(id.level)) continue;
      auto at = by_key.find(next.key());
      if (at != by_key.end() && side >= 2) continue;
      while (at == by_key.end() && next.level > 0) {
        next = layout_->parent(next);
        at = by_key.find(next.key());
      }
      if (at != by_key.end()) stitch_pair(camera, t, *at->second, side, stats);
    }
  }
}

NestedStats NestedDrawer::draw(const OffscreenTarget& target, const Camera& camera, std::span<const NestedView> tiles,
                               const NestedStyle& style) {
  ++frame_;
  NestedStats stats;
  std::vector<Placed> placed;
  double lowest = std::numeric_limits<double>::infinity();
  double highest = -lowest;
  for (const NestedView& view : tiles) {
    Placed& tile = placed.emplace_back(place(camera, view, style));
    tile.resident = send(tile, stats);
    stats.without_room += tile.resident ? 0U : 1U;
    lowest = std::min(lowest, tile.frame.height_m(tile.z[0]));
    highest = std::max(highest, tile.frame.height_m(tile.z[1]));
  }
  target.bind();
  const bool zero_to_one = gl_->ClipControl != nullptr;
  if (zero_to_one) gl_->ClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
  gl_->DepthMask(GL_TRUE);
  gl_->ClearColor(style.background.r, style.background.g, style.background.b, 1);
  gl_->ClearDepth(0);
  gl_->Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  gl_->Enable(GL_DEPTH_TEST);
  gl_->DepthFunc(GL_GREATER);
  gl_->Enable(GL_PRIMITIVE_RESTART);
  gl_->PrimitiveRestartIndex(NestedTile::kRestart);
  program_.use();
  set(*gl_, program_.uniform("eye_to_clip"), camera.projection(0.1, zero_to_one) * camera.view_rotation());
  gl_->Uniform1f(program_.uniform("eye_rise"), static_cast<float>(camera.eye.z - lowest));
  gl_->Uniform1f(program_.uniform("relief"), static_cast<float>(std::max(highest - lowest, 1e-3)));
  gl_->Uniform3f(program_.uniform("to_sun"), -0.586F, 0.586F, 0.559F);
  gl_->BindVertexArray(array_);
  for (const Placed& tile : placed) {
    if (!tile.resident) continue;
    set_tile(camera, tile, 0);
    draw_tile(tile);
    stats.triangles += tile.view->tile->level_triangles[static_cast<std::size_t>(tile.level)];
  }
  gl_->Disable(GL_PRIMITIVE_RESTART);
  if (style.stitch) stitch_sides(camera, placed, stats);
  gl_->BindVertexArray(0);
  return stats;
}

}  // namespace tintree::render
