#pragma once

#include <string_view>

namespace tintree::render {

/// The text of a file of render/shaders ("terrain.vert.glsl"), as it was when the library was built;
/// empty for a name that is not there.
std::string_view shader_source(std::string_view name);

}  // namespace tintree::render
