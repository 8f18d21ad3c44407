#include "render/far_picture.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include <glm/geometric.hpp>

namespace tintree::render {
namespace {

/// Skirts reach over the picture's inner rim by more than ground before it and in it can be apart: a pixel and a half
/// of the levels, half a pixel of the picture; a half of them goes across the rim.
constexpr double kSkirtPx = 4;

const std::vector<cache::TileRef> kNothing;

/// What is allowed for the ground on a picture.
double pixel_error_of(const CutOptions& options) {
  return options.pixel_error - impostor::kParallaxPx - impostor::kResamplePx;
}

/// Whether ground drawn with one style can stand beside ground drawn with the other.
bool alike(const Style& a, const Style& b) {
  return a.sun_azimuth_rad == b.sun_azimuth_rad && a.sun_elevation_rad == b.sun_elevation_rad &&
         a.background == b.background && a.fog_m == b.fog_m && a.tint == b.tint && a.wireframe == b.wireframe;
}

}  // namespace

Expected<std::unique_ptr<FarPicture>> FarPicture::create(const GlFunctions& gl) {
  auto program = ShaderProgram::create(gl, "sky.vert.glsl", "far_picture.frag.glsl");
  if (!program) return tl::unexpected(program.error());
  return std::unique_ptr<FarPicture>(new FarPicture(gl, std::move(*program)));
}

FarPicture::FarPicture(const GlFunctions& gl, ShaderProgram program)
    : gl_(&gl), program_(std::move(program)), buffers_{ImpostorBuffer(gl), ImpostorBuffer(gl)} {
  gl_->GenVertexArrays(1, &no_vertices_);
}

FarPicture::~FarPicture() { gl_->DeleteVertexArrays(1, &no_vertices_); }

std::size_t FarPicture::bytes() const { return buffers_[0].bytes() + buffers_[1].bytes(); }

/// Where pictures do not last, a turning view or a rising speed, there is a rest before the next.
void FarPicture::rest() {
  rest_ = 2 * impostor::kFrames;
  begun_.reset();
}

void FarPicture::move_to(const Camera& camera) {
  before_ = std::exchange(any_before_, true) ? now_ : camera;
  now_ = camera;
  if (!moved()) return;
  step_m_ = std::max(glm::length(now_.eye - before_.eye), 0.5 * step_m_);
  rest_ = std::max(rest_ - 1, 0);
}

bool FarPicture::moved() const { return now_.eye != before_.eye || now_.target != before_.target; }

/// Whether it is time to begin with the next picture. A view that stands still needs none.
bool FarPicture::wants_next(Trees trees, const CutOptions& options) const {
  if (!moved() || rest_ > 0 || pixel_error_of(options) <= 0 || options.morph) return false;
  constexpr int kInTime = impostor::kMostDrawing + 2;
  if (shown_ && impostor_frames(shown_->view, before_, now_, kInTime) == kInTime) return false;
  const double beyond_m = impostor_distance_m(step_m_, now_);
  return std::ranges::any_of(trees, [&](const cache::TileBounds* tree) {
    return !tree->nodes().empty() && farthest_m(tree->box(tree->nodes().front()), now_.eye) >= beyond_m;
  });
}

/// False where there is no room for it.
bool FarPicture::begin(GpuTilePool& pool, const CutOptions& options) {
  begun_.emplace();
  begun_->options = options;
  begun_->beyond_m = std::max(impostor_distance_m(step_m_, now_), 1e-3);
  const Camera from = impostor_camera(now_);
  begun_->picture.view.camera = from;
  const std::size_t bytes = ImpostorBuffer::bytes_of(from.width_px, from.height_px);
  return pool.set_aside(buffers_[shown_buffer_].bytes() + bytes) &&
         buffers_[1 - shown_buffer_].resize(from.width_px, from.height_px);
}

/// With all tiles there the cut is the same in every frame: then it is drawn.
void FarPicture::choose_cut(Trees trees, const ChooseCut& choose) {
  ImpostorView& view = begun_->picture.view;
  CutOptions finer = begun_->options;
  finer.pixel_error = pixel_error_of(finer) * impostor::kTexelsPerPx;
  finer.texel_px *= impostor::kTexelsPerPx;
  LodCut& cut = begun_->cut;
  cut = choose(view.camera, finer, begun_->beyond_m);
  view.nearest_m = std::numeric_limits<double>::infinity();
  view.farthest_m = 0;
  std::erase_if(cut.draws, [&](const DrawTile& d) {
    const cache::Box box = trees[d.tree]->box(trees[d.tree]->nodes()[d.node]);
    const double near_by_m = nearest_m(box, view.camera.eye);
    if (near_by_m < begun_->beyond_m) return true;
    view.nearest_m = std::min(view.nearest_m, near_by_m);
    view.farthest_m = std::max(view.farthest_m, farthest_m(box, view.camera.eye));
    return false;
  });
}

std::optional<std::vector<cache::TileRef>> FarPicture::plan(const Camera& camera, Trees trees, GpuTilePool& pool,
                                                            const CutOptions& options, const ChooseCut& choose) {
  move_to(camera);
  if (shown_ && !impostor_holds(shown_->view, now_)) shown_.reset();
  if (begun_ && begun_->frames_left > 0 && !impostor_holds(begun_->picture.view, now_)) rest();
  if (begun_ && begun_->options != options) begun_.reset();
  if (!begun_) {
    if (!wants_next(trees, options)) return kNothing;
    if (!begin(pool, options)) return std::nullopt;
  }
  choose_cut(trees, choose);
  if (!begun_->cut.complete) {
    begun_->frames_left = 0;
    return begun_->cut.requests;
  }
  if (begun_->cut.draws.empty() || !impostor_holds(begun_->picture.view, now_)) begun_.reset();
  return kNothing;
}

/// Over a half of the frames for which the picture will hold; not at all where those are few.
void FarPicture::start_drawing(const Style& style, double haze_begin_m) {
  const int holds = impostor_frames(begun_->picture.view, before_, now_, 2 * impostor::kMostDrawing);
  if (holds < 2 * impostor::kLeastDrawing) return rest();
  begun_->frames_left = holds / 2;
  begun_->drawn = 0;
  begun_->haze_begin_m = haze_begin_m;
  begun_->picture.style = style;
  buffers_[1 - shown_buffer_].clear();
}

DrawStats FarPicture::refresh(const Renderer& renderer, Trees trees, GpuTilePool& pool, const Style& style,
                              double haze_begin_m) {
  if (shown_ && !alike(style, shown_->style)) shown_.reset();
  if (!begun_ || !begun_->cut.complete || style.wireframe || style.tint != Tint::kHeight) return {};
  buffers_[1 - shown_buffer_].bind();
  if (begun_->frames_left == 0 || !alike(style, begun_->picture.style)) {
    start_drawing(style, haze_begin_m);
    if (!begun_) return {};
  }
  LodCut& cut = begun_->cut;
  cut.max_error_px = kSkirtPx * impostor::kTexelsPerPx;
  cut.nearest_m = begun_->haze_begin_m;
  begun_->picture.near_m = renderer.near_m(cut);
  const std::span<const DrawTile> rest = std::span<const DrawTile>(cut.draws).subspan(begun_->drawn);
  const auto frames = static_cast<std::size_t>(begun_->frames_left);
  const std::size_t part = (rest.size() + frames - 1) / frames;
  const DrawStats drawn = renderer.draw_ground(begun_->picture.view.camera, trees, cut, rest.first(part), pool, style);
  begun_->drawn += part;
  --begun_->frames_left;
  if (begun_->drawn == cut.draws.size()) show_begun(trees);
  return drawn;
}

void FarPicture::show_begun(Trees trees) {
  shown_ = std::move(begun_->picture);
  for (const DrawTile& d : begun_->cut.draws) shown_->tiles.insert({trees[d.tree]->nodes()[d.node].id, d.tree});
  shown_buffer_ = 1 - shown_buffer_;
  begun_.reset();
}

std::uint32_t FarPicture::take_from(LodCut& cut, Trees trees, const Camera& camera) const {
  if (!shown_ || !impostor_holds(shown_->view, camera)) return 0;
  return static_cast<std::uint32_t>(
      std::erase_if(cut.draws, [&](const DrawTile& d) { return covered(shown_->tiles, trees, d.tree, d.node); }));
}

void FarPicture::draw(const Camera& camera, double near_m) const {
  const auto set = [&](const char* name, const glm::dvec3& v) {
    gl_->Uniform3f(program_.uniform(name), static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z));
  };
  const auto set_number = [&](const char* name, double v) {
    gl_->Uniform1f(program_.uniform(name), static_cast<float>(v));
  };
  const CameraAxes axes = camera.axes();
  const ImpostorView& made = shown_->view;
  const CameraAxes then = made.camera.axes();
  program_.use();
  set("right", axes.right * camera.tan_half_x());
  set("up", axes.up * camera.tan_half_y());
  set("forward", axes.forward);
  set("view", axes.forward);
  set("moved", camera.eye - made.camera.eye);
  set("picture_right", then.right / made.camera.tan_half_x());
  set("picture_up", then.up / made.camera.tan_half_y());
  set("picture_forward", then.forward);
  set_number("radius", made.radius_m());
  set_number("picture_near", shown_->near_m);
  set_number("near", near_m);
  gl_->Uniform1i(program_.uniform("colors"), 0);
  gl_->Uniform1i(program_.uniform("depths"), 1);
  buffers_[shown_buffer_].bind_textures();
  gl_->Enable(GL_DEPTH_TEST);
  gl_->DepthFunc(GL_GREATER);
  gl_->Enable(GL_BLEND);
  gl_->BlendFunc(GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  gl_->BindVertexArray(no_vertices_);
  gl_->DrawArrays(GL_TRIANGLES, 0, 3);
  gl_->Disable(GL_BLEND);
  gl_->BindVertexArray(0);
  gl_->BindTexture(GL_TEXTURE_2D, 0);
}

}  // namespace tintree::render
