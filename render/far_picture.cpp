#include "render/far_picture.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <glm/geometric.hpp>

namespace tintree::render {
namespace {

/// Skirts reach over the picture's inner rim by more than ground before it and in it can be apart: a pixel and a half
/// of the levels, half a pixel of the picture; a half of them goes across the rim.
constexpr double kSkirtPx = 4;

const std::vector<cache::TileRef> kNothing;

constexpr std::size_t kTexelBytes = 8;  ///< RGBA8, and a depth as a float.

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

FarPicture::FarPicture(const GlFunctions& gl, ShaderProgram program) : gl_(&gl), program_(std::move(program)) {
  gl_->GenVertexArrays(1, &no_vertices_);
  gl_->GenFramebuffers(1, &framebuffer_);
  gl_->GenTextures(1, &colors_);
  gl_->GenTextures(1, &depths_);
}

FarPicture::~FarPicture() {
  gl_->DeleteVertexArrays(1, &no_vertices_);
  gl_->DeleteFramebuffers(1, &framebuffer_);
  gl_->DeleteTextures(1, &colors_);
  gl_->DeleteTextures(1, &depths_);
}

void FarPicture::forget() {
  // Where pictures do not last, a turning view or a rising speed, there is a rest before the next.
  rest_ = held_ < impostor::kFrames / 2 ? 2 * impostor::kFrames : 0;
  held_ = 0;
  made_.reset();
  tiles_.clear();
}

std::size_t FarPicture::bytes() const {
  return kTexelBytes * static_cast<std::size_t>(width_px_) * static_cast<std::size_t>(height_px_);
}

bool FarPicture::fit(const Camera& picture, GpuTilePool& pool) {
  if (width_px_ == picture.width_px && height_px_ == picture.height_px) return true;
  const auto texels = static_cast<std::size_t>(picture.width_px) * static_cast<std::size_t>(picture.height_px);
  return pool.set_aside(kTexelBytes * texels) && allocate(picture.width_px, picture.height_px);
}

bool FarPicture::allocate(int width_px, int height_px) {
  gl_->BindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  const auto allocate = [&](GLuint texture, GLint internal, GLenum format, GLenum type, GLint filter, GLenum point) {
    gl_->BindTexture(GL_TEXTURE_2D, texture);
    gl_->TexImage2D(GL_TEXTURE_2D, 0, internal, width_px, height_px, 0, format, type, nullptr);
    for (const GLenum name : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
      gl_->TexParameteri(GL_TEXTURE_2D, name, filter);
    for (const GLenum name : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T})
      gl_->TexParameteri(GL_TEXTURE_2D, name, GL_CLAMP_TO_EDGE);
    gl_->FramebufferTexture2D(GL_FRAMEBUFFER, point, GL_TEXTURE_2D, texture, 0);
  };
  while (gl_->GetError() != GL_NO_ERROR) {
  }
  gl_->ActiveTexture(GL_TEXTURE0);
  allocate(colors_, GL_RGBA8, GL_RGBA, GL_UNSIGNED_BYTE, GL_LINEAR, GL_COLOR_ATTACHMENT0);
  allocate(depths_, GL_DEPTH_COMPONENT32F, GL_DEPTH_COMPONENT, GL_FLOAT, GL_NEAREST, GL_DEPTH_ATTACHMENT);
  gl_->BindTexture(GL_TEXTURE_2D, 0);
  const bool whole =
      gl_->CheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE && gl_->GetError() == GL_NO_ERROR;
  width_px_ = whole ? width_px : 0;
  height_px_ = whole ? height_px : 0;
  return whole;
}

std::optional<std::vector<cache::TileRef>> FarPicture::plan(const Camera& camera, Trees trees, GpuTilePool& pool,
                                                            const CutOptions& options, const ChooseCut& choose) {
  const bool moved = last_ && (camera.eye != last_->eye || camera.target != last_->target);
  // A view that stands still needs no picture, unless one has been begun.
  if (!moved && !wanted_) {
    last_ = camera;
    return kNothing;
  }
  if (moved) step_m_ = std::max(glm::length(camera.eye - last_->eye), 0.5 * step_m_);
  last_ = camera;
  if (made_ && !impostor_holds(*made_, camera)) forget();
  if (made_ && moved) ++held_;
  if (moved) rest_ = std::max(rest_ - 1, 0);
  wanted_.reset();
  const double left_px = options.pixel_error - impostor::kParallaxPx - impostor::kResamplePx;
  const double begin_m = std::max(impostor_distance_m(step_m_, camera), 1e-3);
  const bool far_enough = std::ranges::any_of(trees, [&](const cache::TileBounds* tree) {
    return !tree->nodes().empty() && farthest_m(tree->box(tree->nodes().front()), camera.eye) >= begin_m;
  });
  if (made_ || rest_ > 0 || left_px <= 0 || options.morph || !far_enough) return kNothing;
  next_ = {impostor_camera(camera), std::numeric_limits<double>::infinity(), 0};
  if (!fit(next_.camera, pool)) return std::nullopt;
  CutOptions finer = options;
  finer.pixel_error = left_px * impostor::kTexelsPerPx;
  finer.texel_px = options.texel_px * impostor::kTexelsPerPx;
  wanted_ = choose(next_.camera, finer, begin_m);
  std::erase_if(wanted_->draws, [&](const DrawTile& d) {
    const cache::Box box = trees[d.tree]->box(trees[d.tree]->nodes()[d.node]);
    const double near_by_m = nearest_m(box, camera.eye);
    if (near_by_m < begin_m) return true;
    next_.nearest_m = std::min(next_.nearest_m, near_by_m);
    next_.farthest_m = std::max(next_.farthest_m, farthest_m(box, camera.eye));
    return false;
  });
  if (!wanted_->draws.empty() || !wanted_->complete) return wanted_->requests;
  wanted_.reset();
  return kNothing;
}

DrawStats FarPicture::refresh(const Renderer& renderer, Trees trees, GpuTilePool& pool, const Style& style,
                              double haze_begin_m) {
  if (made_ && !alike(style, style_)) forget();
  if (!wanted_ || !wanted_->complete || style.wireframe) return {};
  if (style.tint != Tint::kHeight) return {};
  LodCut cut = std::move(*wanted_);
  wanted_.reset();
  cut.max_error_px = kSkirtPx * impostor::kTexelsPerPx;
  cut.nearest_m = haze_begin_m;
  gl_->BindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  gl_->Viewport(0, 0, width_px_, height_px_);
  gl_->DepthMask(GL_TRUE);
  gl_->ClearColor(0, 0, 0, 0);
  gl_->ClearDepth(0);
  gl_->Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  const DrawStats drawn = renderer.draw_ground(next_.camera, trees, cut, pool, style);
  made_ = next_;
  made_near_m_ = renderer.near_m(cut);
  style_ = style;
  for (const DrawTile& d : cut.draws) tiles_.insert({trees[d.tree]->nodes()[d.node].id, d.tree});
  return drawn;
}

std::uint32_t FarPicture::take_from(LodCut& cut, Trees trees, const Camera& camera) const {
  if (!made_ || !impostor_holds(*made_, camera)) return 0;
  return static_cast<std::uint32_t>(
      std::erase_if(cut.draws, [&](const DrawTile& d) { return covered(tiles_, trees, d.tree, d.node); }));
}

void FarPicture::draw(const Camera& camera, double near_m) const {
  const auto set = [&](const char* name, const glm::dvec3& v) {
    gl_->Uniform3f(program_.uniform(name), static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z));
  };
  const auto set_number = [&](const char* name, double v) {
    gl_->Uniform1f(program_.uniform(name), static_cast<float>(v));
  };
  const CameraAxes axes = camera.axes();
  const CameraAxes then = made_->camera.axes();
  program_.use();
  set("right", axes.right * camera.tan_half_x());
  set("up", axes.up * camera.tan_half_y());
  set("forward", axes.forward);
  set("view", axes.forward);
  set("moved", camera.eye - made_->camera.eye);
  set("picture_right", then.right / made_->camera.tan_half_x());
  set("picture_up", then.up / made_->camera.tan_half_y());
  set("picture_forward", then.forward);
  set_number("radius", made_->radius_m());
  set_number("picture_near", made_near_m_);
  set_number("near", near_m);
  gl_->Uniform1i(program_.uniform("colors"), 0);
  gl_->Uniform1i(program_.uniform("depths"), 1);
  gl_->ActiveTexture(GL_TEXTURE1);
  gl_->BindTexture(GL_TEXTURE_2D, depths_);
  gl_->ActiveTexture(GL_TEXTURE0);
  gl_->BindTexture(GL_TEXTURE_2D, colors_);
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
