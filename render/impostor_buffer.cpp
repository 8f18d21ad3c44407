#include "render/impostor_buffer.h"

namespace tintree::render {

ImpostorBuffer::ImpostorBuffer(const GlFunctions& gl) : gl_(&gl) {
  gl_->GenFramebuffers(1, &framebuffer_);
  gl_->GenTextures(1, &colors_);
  gl_->GenTextures(1, &depths_);
}

ImpostorBuffer::~ImpostorBuffer() {
  gl_->DeleteFramebuffers(1, &framebuffer_);
  gl_->DeleteTextures(1, &colors_);
  gl_->DeleteTextures(1, &depths_);
}

std::size_t ImpostorBuffer::bytes_of(int width_px, int height_px) {
  return kTexelBytes * static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px);
}

bool ImpostorBuffer::resize(int width_px, int height_px) {
  if (width_px_ == width_px && height_px_ == height_px) return true;
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

void ImpostorBuffer::bind() const {
  gl_->BindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  gl_->Viewport(0, 0, width_px_, height_px_);
}

void ImpostorBuffer::clear() const {
  gl_->DepthMask(GL_TRUE);
  gl_->ClearColor(0, 0, 0, 0);
  gl_->ClearDepth(0);
  gl_->Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
}

void ImpostorBuffer::bind_textures() const {
  gl_->ActiveTexture(GL_TEXTURE1);
  gl_->BindTexture(GL_TEXTURE_2D, depths_);
  gl_->ActiveTexture(GL_TEXTURE0);
  gl_->BindTexture(GL_TEXTURE_2D, colors_);
}

}  // namespace tintree::render
