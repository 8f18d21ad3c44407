#include "render/gl_context.h"

// GL/osmesa.h would pull in GL/gl.h, which does not go with glcorearb.h.
#define __gl_h_ 1
#define GLAPIENTRY APIENTRY
#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GL/osmesa.h>
#include <dlfcn.h>

#include <array>
#include <cstring>
#include <string>
#include <vector>

namespace tintree::render {
namespace {

constexpr std::array<std::array<int, 2>, 2> kVersions{{{4, 5}, {3, 3}}};

/// A library opened while running. Never closed: drivers do not survive that.
void* open_library(const char* name) { return dlopen(name, RTLD_NOW | RTLD_LOCAL); }

template <typename Function>
bool find(void* library, const char* name, Function& out) {
  out = reinterpret_cast<Function>(dlsym(library, name));
  return out != nullptr;
}

class OsMesaContext final : public HeadlessContext {
 public:
  static Expected<std::unique_ptr<HeadlessContext>> create() {
    std::unique_ptr<OsMesaContext> out(new OsMesaContext);
    void* library = open_library("libOSMesa.so.8");
    if (library == nullptr) library = open_library("libOSMesa.so");
    if (library == nullptr || !find(library, "OSMesaCreateContextAttribs", out->create_) ||
        !find(library, "OSMesaMakeCurrent", out->make_current_) ||
        !find(library, "OSMesaDestroyContext", out->destroy_) || !find(library, "OSMesaGetProcAddress", out->get_)) {
      return fail(ErrorCode::kIo,
                  "the library OSMesa is not there; install the package libosmesa6, or use --headless egl");
    }
    for (const auto& [major, minor] : kVersions) {
      const std::array<int, 9> attributes{OSMESA_FORMAT,
                                          OSMESA_RGBA,
                                          OSMESA_PROFILE,
                                          OSMESA_CORE_PROFILE,
                                          OSMESA_CONTEXT_MAJOR_VERSION,
                                          major,
                                          OSMESA_CONTEXT_MINOR_VERSION,
                                          minor,
                                          0};
      out->context_ = out->create_(attributes.data(), nullptr);
      if (out->context_ != nullptr) break;
    }
    if (out->context_ == nullptr ||
        out->make_current_(out->context_, out->pixels_.data(), GL_UNSIGNED_BYTE, kSide, kSide) == 0) {
      return fail(ErrorCode::kIo, "OSMesa offers no OpenGL 3.3; install a newer Mesa");
    }
    return out;
  }

  ~OsMesaContext() override {
    if (context_ != nullptr) destroy_(context_);
  }

  GetGlFunction get_function() const override {
    return [get = get_](const char* name) { return reinterpret_cast<void*>(get(name)); };
  }

 private:
  static constexpr int kSide = 4;  ///< Of the frame that OSMesa demands and nobody looks at.

  decltype(&OSMesaCreateContextAttribs) create_ = nullptr;
  decltype(&OSMesaMakeCurrent) make_current_ = nullptr;
  decltype(&OSMesaDestroyContext) destroy_ = nullptr;
  decltype(&OSMesaGetProcAddress) get_ = nullptr;
  OSMesaContext context_ = nullptr;
  std::array<unsigned char, std::size_t{4} * kSide * kSide> pixels_{};
};

class EglContext final : public HeadlessContext {
 public:
  static Expected<std::unique_ptr<HeadlessContext>> create() {
    std::unique_ptr<EglContext> out(new EglContext);
    void* library = open_library("libEGL.so.1");
    if (library == nullptr || !find(library, "eglGetProcAddress", out->get_)) {
      return fail(ErrorCode::kIo,
                  "the library EGL is not there; install the package libegl1, or use --headless osmesa");
    }
    for (const EGLDisplay display : out->displays()) {
      if (out->open(display)) return out;
    }
    return fail(ErrorCode::kIo, "EGL offers no OpenGL 3.3 without a window; use --headless osmesa");
  }

  ~EglContext() override {
    if (display_ == EGL_NO_DISPLAY) return;
    call<PFNEGLMAKECURRENTPROC>("eglMakeCurrent")(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    call<PFNEGLDESTROYCONTEXTPROC>("eglDestroyContext")(display_, context_);
    call<PFNEGLTERMINATEPROC>("eglTerminate")(display_);
  }

  GetGlFunction get_function() const override {
    return [get = get_](const char* name) { return reinterpret_cast<void*>(get(name)); };
  }

 private:
  template <typename Function>
  Function call(const char* name) const {
    return reinterpret_cast<Function>(get_(name));
  }

  /// Graphics cards first, then Mesa without any.
  std::vector<EGLDisplay> displays() const {
    std::vector<EGLDisplay> out;
    const auto get_display = call<PFNEGLGETPLATFORMDISPLAYEXTPROC>("eglGetPlatformDisplayEXT");
    const auto query_devices = call<PFNEGLQUERYDEVICESEXTPROC>("eglQueryDevicesEXT");
    const auto query_string = call<PFNEGLQUERYDEVICESTRINGEXTPROC>("eglQueryDeviceStringEXT");
    if (get_display == nullptr) return out;
    std::array<EGLDeviceEXT, 16> devices{};
    EGLint count = 0;
    if (query_devices != nullptr && query_string != nullptr) query_devices(16, devices.data(), &count);
    for (EGLint i = 0; i < count; ++i) {
      EGLDeviceEXT device = devices[static_cast<std::size_t>(i)];
      const char* extensions = query_string(device, EGL_EXTENSIONS);
      const bool software = extensions != nullptr && std::strstr(extensions, "EGL_MESA_device_software") != nullptr;
      if (!software) out.push_back(get_display(EGL_PLATFORM_DEVICE_EXT, device, nullptr));
    }
    out.push_back(get_display(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr));
    return out;
  }

  bool open(EGLDisplay display) {
    const auto initialize = call<PFNEGLINITIALIZEPROC>("eglInitialize");
    const auto terminate = call<PFNEGLTERMINATEPROC>("eglTerminate");
    const auto make_current = call<PFNEGLMAKECURRENTPROC>("eglMakeCurrent");
    if (display == EGL_NO_DISPLAY || initialize(display, nullptr, nullptr) == EGL_FALSE) return false;
    context_ = make_context(display);
    if (context_ == EGL_NO_CONTEXT || make_current(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context_) == EGL_FALSE) {
      terminate(display);
      return false;
    }
    display_ = display;
    return true;
  }

  EGLContext make_context(EGLDisplay display) const {
    const auto bind_api = call<PFNEGLBINDAPIPROC>("eglBindAPI");
    const auto choose = call<PFNEGLCHOOSECONFIGPROC>("eglChooseConfig");
    const auto create = call<PFNEGLCREATECONTEXTPROC>("eglCreateContext");
    if (bind_api(EGL_OPENGL_API) == EGL_FALSE) return EGL_NO_CONTEXT;
    const std::array<EGLint, 5> wanted{EGL_SURFACE_TYPE, EGL_DONT_CARE, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_NONE};
    EGLConfig config = nullptr;
    EGLint count = 0;
    choose(display, wanted.data(), &config, 1, &count);
    for (const auto& [major, minor] : kVersions) {
      const std::array<EGLint, 7> attributes{EGL_CONTEXT_MAJOR_VERSION,
                                             major,
                                             EGL_CONTEXT_MINOR_VERSION,
                                             minor,
                                             EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                             EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                             EGL_NONE};
      EGLContext context = create(display, count > 0 ? config : nullptr, EGL_NO_CONTEXT, attributes.data());
      if (context != EGL_NO_CONTEXT) return context;
    }
    return EGL_NO_CONTEXT;
  }

  decltype(&eglGetProcAddress) get_ = nullptr;
  EGLDisplay display_ = EGL_NO_DISPLAY;
  EGLContext context_ = EGL_NO_CONTEXT;
};

}  // namespace

Expected<std::unique_ptr<HeadlessContext>> HeadlessContext::create(Headless kind) {
  return kind == Headless::kEgl ? EglContext::create() : OsMesaContext::create();
}

}  // namespace tintree::render
