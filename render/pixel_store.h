#pragma once

#include "codec/texture_codec.h"
#include "render/gl_functions.h"

namespace tintree::render {

/// OpenGL's internal format for pixels of this kind; colours are sRGB.
GLenum stored_as(codec::PixelFormat format);

/// How tiles' pictures are filtered, of the texture that is bound to `target`: anisotropically if `steep`, where the
/// card can, and without mip-maps, clamped to the outer texels.
void set_filter(const GlFunctions& gl, GLenum target, bool steep);

}  // namespace tintree::render
