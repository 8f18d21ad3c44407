#include "render/offscreen_target.h"

#include <algorithm>
#include <string>
#include <utility>

namespace tintree::render {

Expected<OffscreenTarget> OffscreenTarget::create(const GlFunctions& gl, int width_px, int height_px, int samples) {
  GLint most_samples = 1;
  GLint most_px = 0;
  gl.GetIntegerv(GL_MAX_SAMPLES, &most_samples);
  gl.GetIntegerv(GL_MAX_RENDERBUFFER_SIZE, &most_px);
  const std::string size = std::to_string(width_px) + "x" + std::to_string(height_px);
  if (width_px > most_px || height_px > most_px) {
    return fail(ErrorCode::kIo,
                "a picture of " + size + " pixels is more than the driver's " + std::to_string(most_px) + " a side");
  }
  OffscreenTarget out(gl);
  out.width_px_ = width_px;
  out.height_px_ = height_px;
  if (!out.make(out.drawn_, std::clamp(samples, 1, most_samples)) || !out.make(out.resolved_, 1)) {
    return fail(ErrorCode::kIo, "the driver cannot make a frame of " + size + " pixels; choose a smaller --size");
  }
  return out;
}

OffscreenTarget::OffscreenTarget(OffscreenTarget&& other) noexcept
    : gl_(other.gl_),
      width_px_(other.width_px_),
      height_px_(other.height_px_),
      drawn_(std::exchange(other.drawn_, {})),
      resolved_(std::exchange(other.resolved_, {})) {}

OffscreenTarget& OffscreenTarget::operator=(OffscreenTarget&& other) noexcept {
  std::swap(gl_, other.gl_);
  std::swap(width_px_, other.width_px_);
  std::swap(height_px_, other.height_px_);
  std::swap(drawn_, other.drawn_);
  std::swap(resolved_, other.resolved_);
  return *this;
}

OffscreenTarget::~OffscreenTarget() {
  destroy(drawn_);
  destroy(resolved_);
}

bool OffscreenTarget::make(Frame& frame, int samples) const {
  const GLsizei count = samples > 1 ? samples : 0;
  const auto storage = [&](GLuint& buffer, GLenum format, GLenum attachment) {
    gl_->GenRenderbuffers(1, &buffer);
    gl_->BindRenderbuffer(GL_RENDERBUFFER, buffer);
    gl_->RenderbufferStorageMultisample(GL_RENDERBUFFER, count, format, width_px_, height_px_);
    gl_->FramebufferRenderbuffer(GL_FRAMEBUFFER, attachment, GL_RENDERBUFFER, buffer);
  };
  gl_->GenFramebuffers(1, &frame.framebuffer);
  gl_->BindFramebuffer(GL_FRAMEBUFFER, frame.framebuffer);
  storage(frame.color, GL_RGBA8, GL_COLOR_ATTACHMENT0);
  storage(frame.depth, GL_DEPTH_COMPONENT32F, GL_DEPTH_ATTACHMENT);
  return gl_->CheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE && gl_->GetError() == GL_NO_ERROR;
}

void OffscreenTarget::destroy(Frame& frame) const {
  if (frame.framebuffer == 0) return;
  gl_->DeleteFramebuffers(1, &frame.framebuffer);
  gl_->DeleteRenderbuffers(1, &frame.color);
  gl_->DeleteRenderbuffers(1, &frame.depth);
}

void OffscreenTarget::bind() const {
  gl_->BindFramebuffer(GL_FRAMEBUFFER, drawn_.framebuffer);
  gl_->Viewport(0, 0, width_px_, height_px_);
}

void OffscreenTarget::resolve(GLbitfield what) const {
  gl_->BindFramebuffer(GL_READ_FRAMEBUFFER, drawn_.framebuffer);
  gl_->BindFramebuffer(GL_DRAW_FRAMEBUFFER, resolved_.framebuffer);
  gl_->BlitFramebuffer(0, 0, width_px_, height_px_, 0, 0, width_px_, height_px_, what, GL_NEAREST);
  gl_->BindFramebuffer(GL_READ_FRAMEBUFFER, resolved_.framebuffer);
}

namespace {

/// OpenGL counts rows from below.
template <typename T>
void turn_over(std::vector<T>& values, std::size_t row, std::size_t rows) {
  for (std::size_t y = 0; y < rows / 2; ++y) {
    const auto upper = values.begin() + static_cast<std::ptrdiff_t>(y * row);
    const auto lower = values.begin() + static_cast<std::ptrdiff_t>((rows - 1 - y) * row);
    std::swap_ranges(upper, upper + static_cast<std::ptrdiff_t>(row), lower);
  }
}

}  // namespace

Picture OffscreenTarget::read_picture() const {
  resolve(GL_COLOR_BUFFER_BIT);
  Picture picture{width_px_, height_px_, {}};
  const std::size_t row = 3 * static_cast<std::size_t>(width_px_);
  picture.rgb.resize(row * static_cast<std::size_t>(height_px_));
  gl_->PixelStorei(GL_PACK_ALIGNMENT, 1);
  gl_->ReadPixels(0, 0, width_px_, height_px_, GL_RGB, GL_UNSIGNED_BYTE, picture.rgb.data());
  turn_over(picture.rgb, row, static_cast<std::size_t>(height_px_));
  return picture;
}

float OffscreenTarget::read_depth(int x_px, int y_px) const {
  resolve(GL_DEPTH_BUFFER_BIT);
  float depth = 0;
  const int x = std::clamp(x_px, 0, width_px_ - 1);
  const int y = std::clamp(height_px_ - 1 - y_px, 0, height_px_ - 1);
  gl_->ReadPixels(x, y, 1, 1, GL_DEPTH_COMPONENT, GL_FLOAT, &depth);
  return depth;
}

std::vector<float> OffscreenTarget::read_depths() const {
  resolve(GL_DEPTH_BUFFER_BIT);
  const auto row = static_cast<std::size_t>(width_px_);
  std::vector<float> depths(row * static_cast<std::size_t>(height_px_));
  gl_->ReadPixels(0, 0, width_px_, height_px_, GL_DEPTH_COMPONENT, GL_FLOAT, depths.data());
  turn_over(depths, row, static_cast<std::size_t>(height_px_));
  return depths;
}

void OffscreenTarget::show_in_window() const {
  resolve(GL_COLOR_BUFFER_BIT);
  gl_->BindFramebuffer(GL_DRAW_FRAMEBUFFER, 0);
  gl_->BlitFramebuffer(0, 0, width_px_, height_px_, 0, 0, width_px_, height_px_, GL_COLOR_BUFFER_BIT, GL_NEAREST);
}

}  // namespace tintree::render
