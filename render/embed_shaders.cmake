# Writes OUTPUT, the source behind render/shader_sources.h, from the files of the list SHADERS.

set(table "")
foreach(file ${SHADERS})
  get_filename_component(name ${file} NAME)
  file(READ ${file} text)
  string(APPEND table "  if (name == \"${name}\") return R\"glsl(${text})glsl\";\n")
endforeach()
file(WRITE ${OUTPUT} "// Made from render/shaders by render/embed_shaders.cmake.
#include \"render/shader_sources.h\"

namespace tintree::render {

std::string_view shader_source(std::string_view name) {
${table}  return {};
}

}  // namespace tintree::render
")
