#include "render/gl_functions.h"

#include <string>
#include <string_view>

namespace tintree::render {
namespace {

std::string text(const GlFunctions& gl, GLenum what) {
  const GLubyte* s = gl.GetString(what);
  return s == nullptr ? std::string() : reinterpret_cast<const char*>(s);
}

/// Looks for the extensions that this program can do with or without.
void find_extensions(GlFunctions& gl) {
  bool s3tc = false;
  bool srgb = false;
  GLint count = 0;
  gl.GetIntegerv(GL_NUM_EXTENSIONS, &count);
  for (GLint i = 0; i < count; ++i) {
    const auto* name = reinterpret_cast<const char*>(gl.GetStringi(GL_EXTENSIONS, static_cast<GLuint>(i)));
    const std::string_view extension = name == nullptr ? "" : name;
    s3tc = s3tc || extension == "GL_EXT_texture_compression_s3tc";
    srgb = srgb || extension == "GL_EXT_texture_sRGB" || extension == "GL_EXT_texture_compression_s3tc_srgb";
    gl.anisotropic = gl.anisotropic || extension == "GL_EXT_texture_filter_anisotropic";
  }
  gl.texture_blocks = s3tc && srgb;
}

}  // namespace

Expected<GlFunctions> load_gl(const GetGlFunction& get) {
  GlFunctions gl;
  const char* missing = nullptr;
#define TINTREE_GL_LOAD(type, name)                  \
  gl.name = reinterpret_cast<type>(get("gl" #name)); \
  if (gl.name == nullptr) missing = "gl" #name;
  TINTREE_GL_FUNCTIONS(TINTREE_GL_LOAD)
#undef TINTREE_GL_LOAD
  if (missing != nullptr) {
    return fail(ErrorCode::kIo,
                std::string("OpenGL 3.3 is needed, and the driver has no ") + missing + "; try --headless osmesa");
  }
  GLint major = 0;
  GLint minor = 0;
  gl.GetIntegerv(GL_MAJOR_VERSION, &major);
  gl.GetIntegerv(GL_MINOR_VERSION, &minor);
  gl.renderer = text(gl, GL_RENDERER) + ", OpenGL " + text(gl, GL_VERSION);
  if (10 * major + minor < 33)
    return fail(ErrorCode::kIo, "OpenGL 3.3 is needed, and this is " + gl.renderer + "; try --headless osmesa");
  find_extensions(gl);
  // Mesa's software filters over an ellipse as large as the texture has it: where ground is seen edge-on, for minutes.
  gl.anisotropic = gl.anisotropic && gl.renderer.find("llvmpipe") == std::string::npos;
  if (10 * major + minor >= 45) gl.ClipControl = reinterpret_cast<PFNGLCLIPCONTROLPROC>(get("glClipControl"));
  if (10 * major + minor >= 43) {
    gl.DispatchCompute = reinterpret_cast<PFNGLDISPATCHCOMPUTEPROC>(get("glDispatchCompute"));
    gl.MemoryBarrier = reinterpret_cast<PFNGLMEMORYBARRIERPROC>(get("glMemoryBarrier"));
  }
  return gl;
}

}  // namespace tintree::render
