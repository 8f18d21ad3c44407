#pragma once

#include "render/gl_functions.h"

namespace tintree::render {

/// One layout of texels.
struct Texels {
  GLenum stored_as;
  GLenum channels;
  GLenum type;
  GLint filter;
};
/// East and north of unit normals.
inline constexpr Texels kNormalTexels{GL_RG16F, GL_RG, GL_HALF_FLOAT, GL_LINEAR};

/// A square texture without mip-maps, clamped to its outer texels; it is left bound to the active unit. `values`: rows
/// without gaps, or null for none yet.
GLuint make_square_texture(const GlFunctions& gl, const Texels& texels, int size, const void* values);

}  // namespace tintree::render
