#include "render/picture_textures.h"

#include <algorithm>
#include <array>
#include <cstdint>

#include "render/pixel_store.h"

namespace tintree::render {
namespace {

using codec::PixelArray;
using codec::PixelFormat;

template <std::size_t N>
PixelArray one_texel(PixelFormat format, const std::array<std::uint8_t, N>& bytes) {
  const auto raw = std::as_bytes(std::span(bytes));
  return {format, 1, {raw.begin(), raw.end()}};
}

}  // namespace

PictureTextures::PictureTextures(const GlFunctions& gl) : gl_(&gl) {
  plain_.colors = make(one_texel(PixelFormat::kRgba8, std::array<std::uint8_t, 4>{}));
  plain_.directions = make(one_texel(PixelFormat::kBc5Snorm, std::array<std::uint8_t, 16>{}));
  plain_.lengths = make(one_texel(PixelFormat::kBc4Snorm, std::array<std::uint8_t, 8>{127, 127}));
}

PictureTextures::~PictureTextures() {
  for (const GLuint id : {plain_.colors, plain_.directions, plain_.lengths}) gl_->DeleteTextures(1, &id);
  for (const auto& [id, kind] : kinds_) gl_->DeleteTextures(1, &id);
}

GpuPictures PictureTextures::upload(const cache::TilePictures& pictures) {
  GpuPictures out;
  out.colors = take(pictures.colors, out);
  out.directions = take(pictures.directions, out);
  out.lengths = take(pictures.lengths, out);
  return out;
}

void PictureTextures::give_back(const GpuPictures& pictures) {
  for (const GLuint id : {pictures.colors, pictures.directions, pictures.lengths}) {
    if (id != 0) spare_[kinds_.at(id)].push_back(id);
  }
}

GLuint PictureTextures::take(const PixelArray& pixels, GpuPictures& owner) {
  if (pixels.size == 0) return 0;
  owner.bytes += pixels.bytes.size();
  std::vector<GLuint>& spare = spare_[{pixels.format, pixels.size}];
  if (spare.empty()) {
    const GLuint id = make(pixels);
    kinds_[id] = {pixels.format, pixels.size};
    return id;
  }
  const GLuint id = spare.back();
  spare.pop_back();
  gl_->BindTexture(GL_TEXTURE_2D, id);
  fill(pixels, false);
  return id;
}

GLuint PictureTextures::make(const PixelArray& pixels) const {
  GLuint id = 0;
  gl_->GenTextures(1, &id);
  gl_->BindTexture(GL_TEXTURE_2D, id);
  set_filter(*gl_, GL_TEXTURE_2D, pixels.size > 1);
  fill(pixels, true);
  return id;
}

void PictureTextures::fill(const PixelArray& pixels, bool anew) const {
  const GLenum format = stored_as(pixels.format);
  const GLsizei size = pixels.size;
  const auto bytes = static_cast<GLsizei>(pixels.bytes.size());
  gl_->PixelStorei(GL_UNPACK_ALIGNMENT, 1);
  if (pixels.format == PixelFormat::kRgba8) {
    if (anew) {
      gl_->TexImage2D(GL_TEXTURE_2D, 0, static_cast<GLint>(format), size, size, 0, GL_RGBA, GL_UNSIGNED_BYTE,
                      pixels.bytes.data());
    } else {
      gl_->TexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, size, size, GL_RGBA, GL_UNSIGNED_BYTE, pixels.bytes.data());
    }
  } else if (anew) {
    gl_->CompressedTexImage2D(GL_TEXTURE_2D, 0, format, size, size, 0, bytes, pixels.bytes.data());
  } else {
    gl_->CompressedTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, size, size, format, bytes, pixels.bytes.data());
  }
}

void PictureTextures::bind(const GpuPictures& pictures) const {
  const auto bind_unit = [this](GLenum unit, GLuint id, GLuint otherwise) {
    gl_->ActiveTexture(GL_TEXTURE0 + unit);
    gl_->BindTexture(GL_TEXTURE_2D, id != 0 ? id : otherwise);
  };
  bind_unit(0, pictures.colors, plain_.colors);
  bind_unit(1, pictures.directions, plain_.directions);
  bind_unit(2, pictures.lengths, plain_.lengths);
}

}  // namespace tintree::render
