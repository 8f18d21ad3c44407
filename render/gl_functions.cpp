#include "render/gl_functions.h"

#include <string>

namespace tintree::render {
namespace {

std::string text(const GlFunctions& gl, GLenum what) {
  const GLubyte* s = gl.GetString(what);
  return s == nullptr ? std::string() : reinterpret_cast<const char*>(s);
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
  if (10 * major + minor >= 45) gl.ClipControl = reinterpret_cast<PFNGLCLIPCONTROLPROC>(get("glClipControl"));
  return gl;
}

}  // namespace tintree::render
