#include "render/pixel_store.h"

namespace tintree::render {
namespace {

using codec::PixelFormat;

// Names of extensions that glcorearb.h leaves out.
constexpr GLenum kCompressedSrgbAlphaDxt1 = 0x8C4D;
constexpr GLenum kMaxAnisotropy = 0x84FE;
constexpr GLfloat kAnisotropy = 8;

}  // namespace

GLenum stored_as(PixelFormat format) {
  switch (format) {
    case PixelFormat::kRgba8:
      return GL_SRGB8_ALPHA8;
    case PixelFormat::kBc1:
      return kCompressedSrgbAlphaDxt1;
    case PixelFormat::kBc5Snorm:
      return GL_COMPRESSED_SIGNED_RG_RGTC2;
    case PixelFormat::kBc4Snorm:
      return GL_COMPRESSED_SIGNED_RED_RGTC1;
  }
  return GL_SRGB8_ALPHA8;
}

void set_filter(const GlFunctions& gl, GLenum target, bool steep) {
  gl.TexParameteri(target, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  gl.TexParameteri(target, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  gl.TexParameteri(target, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  gl.TexParameteri(target, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  gl.TexParameteri(target, GL_TEXTURE_MAX_LEVEL, 0);
  if (gl.anisotropic && steep) gl.TexParameterf(target, kMaxAnisotropy, kAnisotropy);
}

}  // namespace tintree::render
