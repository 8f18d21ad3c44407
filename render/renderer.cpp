#include "render/renderer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <glm/geometric.hpp>
#include <glm/gtc/type_ptr.hpp>

#include "render/screen_error.h"

namespace tintree::render {
namespace {

constexpr double kMostSkirtPx = 16;
/// Share of the background's colour a diagonal of the scene behind the nearest ground: 1 - exp(-kHaze).
constexpr double kHaze = 0.25;
constexpr double kFog = 3;  // exp(-3) is 0.05.

void set(const GlFunctions& gl, GLint location, const glm::dvec3& v) {
  gl.Uniform3f(location, static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z));
}

void set(const GlFunctions& gl, GLint location, const glm::dmat4& m) {
  const glm::mat4 f(m);
  gl.UniformMatrix4fv(location, 1, GL_FALSE, glm::value_ptr(f));
}

void set(const GlFunctions& gl, GLint location, double v) { gl.Uniform1f(location, static_cast<float>(v)); }

/// Round all trees.
cache::Box whole_box(Trees trees) {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  cache::Box whole{{kFar, kFar, kFar}, {-kFar, -kFar, -kFar}};
  for (const cache::TileBounds* tree : trees) {
    if (tree->nodes().empty()) continue;
    const cache::Box box = tree->box(tree->nodes().front());
    for (std::size_t axis = 0; axis < 3; ++axis) {
      whole.min[axis] = std::min(whole.min[axis], box.min[axis]);
      whole.max[axis] = std::max(whole.max[axis], box.max[axis]);
    }
  }
  return whole;
}

double diagonal_m(const cache::Box& box) {
  return std::hypot(box.max[0] - box.min[0], box.max[1] - box.min[1], box.max[2] - box.min[2]);
}

}  // namespace

Expected<Renderer> Renderer::create(const GlFunctions& gl) {
  auto terrain = make_ground_program(gl, "terrain.vert.glsl");
  if (!terrain) return tl::unexpected(terrain.error());
  auto nested = NestedDrawer::create(gl);
  if (!nested) return tl::unexpected(nested.error());
  auto strips = StripDrawer::create(gl);
  if (!strips) return tl::unexpected(strips.error());
  auto scalars = ScalarDrawer::create(gl);
  if (!scalars) return tl::unexpected(scalars.error());
  auto sky = ShaderProgram::create(gl, "sky.vert.glsl", "sky.frag.glsl");
  if (!sky) return tl::unexpected(sky.error());
  return Renderer(gl, std::move(*terrain), std::move(*nested), std::move(*strips), std::move(*scalars),
                  std::move(*sky));
}

Renderer::Renderer(const GlFunctions& gl, ShaderProgram terrain, NestedDrawer nested, StripDrawer strips,
                   ScalarDrawer scalars, ShaderProgram sky)
    : gl_(&gl),
      terrain_(std::move(terrain)),
      nested_(std::move(nested)),
      strips_(std::move(strips)),
      scalars_(std::move(scalars)),
      sky_(std::move(sky)) {
  gl_->GenVertexArrays(1, &no_vertices_);
}

Renderer::Renderer(Renderer&& other) noexcept
    : gl_(other.gl_),
      terrain_(std::move(other.terrain_)),
      nested_(std::move(other.nested_)),
      strips_(std::move(other.strips_)),
      scalars_(std::move(other.scalars_)),
      sky_(std::move(other.sky_)),
      no_vertices_(std::exchange(other.no_vertices_, 0)) {}

Renderer::~Renderer() {
  if (no_vertices_ != 0) gl_->DeleteVertexArrays(1, &no_vertices_);
}

double Renderer::near_m(const LodCut& cut) const {
  // A reversed float depth has precision to spare; without clip control it has that of 24 bits.
  const double least = gl_->ClipControl != nullptr ? 0.01 : 1e-4 * cut.farthest_m;
  return std::max({0.5 * cut.nearest_m, least, 1e-3});
}

double Renderer::gap_slope(const Camera& camera, const LodCut& cut) {
  return std::clamp(cut.max_error_px, 1.0, kMostSkirtPx) / camera.focal_px();
}

void Renderer::draw_background(const OffscreenTarget& target, const Camera& camera, const Style& style) const {
  target.bind();
  gl_->PolygonMode(GL_FRONT_AND_BACK, GL_FILL);
  const glm::vec3 plain = style.background.value_or(glm::vec3(0));
  gl_->DepthMask(GL_TRUE);
  gl_->ClearColor(plain.r, plain.g, plain.b, 1);
  gl_->ClearDepth(0);
  gl_->Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  if (style.background) return;
  const CameraAxes axes = camera.axes();
  gl_->Disable(GL_DEPTH_TEST);
  sky_.use();
  set(*gl_, sky_.uniform("right"), axes.right * camera.tan_half_x());
  set(*gl_, sky_.uniform("up"), axes.up * camera.tan_half_y());
  set(*gl_, sky_.uniform("forward"), axes.forward);
  gl_->BindVertexArray(no_vertices_);
  gl_->DrawArrays(GL_TRIANGLES, 0, 3);
}

void Renderer::begin(const ShaderProgram& program, const Camera& camera, Trees trees, const LodCut& cut,
                     const Style& style) const {
  const bool zero_to_one = gl_->ClipControl != nullptr;
  const cache::Box box = whole_box(trees);
  const double level = std::cos(style.sun_elevation_rad);
  program.use();
  set(*gl_, program.uniform("eye_to_clip"), camera.projection(near_m(cut), zero_to_one) * camera.view_rotation());
  set(*gl_, program.uniform("gap_slope"), gap_slope(camera, cut));
  set(*gl_, program.uniform("ahead"), camera.axes().forward);
  set(*gl_, program.uniform("least_gain"), ScreenError::kLeastGain);
  set(*gl_, program.uniform("eye_rise"), camera.eye.z - box.min[2]);
  set(*gl_, program.uniform("relief"), std::max(box.max[2] - box.min[2], 1e-3));
  const double haze = style.fog_m > 0 ? kFog / style.fog_m : kHaze / std::max(diagonal_m(box), 1e-3);
  set(*gl_, program.uniform("haze_per_metre"), style.background ? 0.0 : haze);
  set(*gl_, program.uniform("haze_begin"), style.fog_m > 0 ? 0.0 : cut.nearest_m);
  gl_->Uniform1i(program.uniform("photo"), 0);
  gl_->Uniform1i(program.uniform("normal_directions"), 1);
  gl_->Uniform1i(program.uniform("normal_lengths"), 2);
  FineTextures::begin(*gl_, program);
  set(*gl_, program.uniform("to_sun"),
      glm::dvec3(std::sin(style.sun_azimuth_rad) * level, std::cos(style.sun_azimuth_rad) * level,
                 std::sin(style.sun_elevation_rad)));
}

DrawStats Renderer::draw(const OffscreenTarget& target, const Camera& camera, Trees trees, const LodCut& cut,
                         GpuTilePool& pool, const Style& style) const {
  draw_background(target, camera, style);
  return draw_ground(camera, trees, cut, pool, style);
}

DrawStats Renderer::draw_ground(const Camera& camera, Trees trees, const LodCut& cut, GpuTilePool& pool,
                                const Style& style) const {
  return draw_ground(camera, trees, cut, cut.draws, pool, style);
}

DrawStats Renderer::draw_ground(const Camera& camera, Trees trees, const LodCut& cut, std::span<const DrawTile> part,
                                GpuTilePool& pool, const Style& style) const {
  if (gl_->ClipControl != nullptr) gl_->ClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
  DrawStats stats;
  if (part.empty()) return stats;
  gl_->Enable(GL_DEPTH_TEST);
  gl_->DepthFunc(GL_GREATER);
  if (style.wireframe) gl_->PolygonMode(GL_FRONT_AND_BACK, GL_LINE);
  pool.fine_textures().prepare(trees, cut);
  begin(terrain_, camera, trees, cut, style);
  draw_meshes(camera, trees, part, pool, style, stats);
  if (pool.nested().reserved_bytes() > 0) {
    begin(nested_.program(), camera, trees, cut, style);
    nested_.draw(camera, trees, cut, part, pool, style, stats);
  }
  if (pool.has_strips()) {
    begin(strips_.program(), camera, trees, cut, style);
    strips_.draw(camera, trees, part, pool, style, stats);
  }
  if (pool.has_scalars()) {
    begin(scalars_.program(), camera, trees, cut, style);
    scalars_.draw(camera, trees, part, pool, style, stats);
  }
  gl_->PolygonMode(GL_FRONT_AND_BACK, GL_FILL);
  gl_->BindVertexArray(0);
  return stats;
}

void Renderer::draw_meshes(const Camera& camera, Trees trees, std::span<const DrawTile> draws, GpuTilePool& pool,
                           const Style& style, DrawStats& stats) const {
  const GLint address_to_eye = terrain_.uniform("address_to_eye");
  const GLint morph = terrain_.uniform("morph");
  GLuint bound = 0;
  for (const DrawTile& d : draws) {
    const GpuTile* tile = pool.use({trees[d.tree]->nodes()[d.node].id, d.tree});
    if (tile == nullptr || !tile->is_mesh()) continue;
    const std::array<double, 16> matrix = tile->frame.matrix({camera.eye.x, camera.eye.y, camera.eye.z});
    set(*gl_, address_to_eye, glm::make_mat4(matrix.data()));
    set_tile_look(*gl_, terrain_, pool, *tile, trees, d, style);
    const bool morphs = d.morph > 0 && tile->morph.vertex_array != 0;
    const GpuMesh& mesh = morphs ? tile->morph : tile->mesh;
    if (std::exchange(bound, mesh.vertex_array) != mesh.vertex_array) gl_->BindVertexArray(mesh.vertex_array);
    set(*gl_, morph, morphs ? d.morph : 0);
    draw_mesh(*gl_, mesh, style, stats);
  }
}

}  // namespace tintree::render
