#include "apps/view/glfw_window.h"

#include <utility>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <fmt/core.h>

namespace tintree::view {
namespace {

constexpr const char* kRemedy = "use --headless osmesa --screenshot FILE.png";

std::string last_reason() {
  const char* reason = nullptr;
  glfwGetError(&reason);
  return reason == nullptr ? "no reason given" : reason;
}

}  // namespace

Expected<std::unique_ptr<GlfwWindow>> GlfwWindow::create(int width, int height, const std::string& title,
                                                         bool visible) {
  if (glfwInit() == GLFW_FALSE) {
    return fail(ErrorCode::kIo,
                fmt::format("there is no display to open a window on ({}); {}", last_reason(), kRemedy));
  }
  std::unique_ptr<GlfwWindow> out(new GlfwWindow);
  for (const auto& [major, minor] : {std::pair(4, 5), std::pair(3, 3)}) {
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, major);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, minor);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, GLFW_TRUE);
    glfwWindowHint(GLFW_SCALE_TO_MONITOR, GLFW_TRUE);
    glfwWindowHint(GLFW_VISIBLE, visible ? GLFW_TRUE : GLFW_FALSE);
    out->handle_ = glfwCreateWindow(width, height, title.c_str(), nullptr, nullptr);
    if (out->handle_ != nullptr) break;
  }
  if (out->handle_ == nullptr) {
    return fail(ErrorCode::kIo,
                fmt::format("the display has no OpenGL 3.3, which a window needs ({}); {}", last_reason(), kRemedy));
  }
  glfwMakeContextCurrent(out->handle_);
  glfwSwapInterval(1);
  return out;
}

GlfwWindow::~GlfwWindow() {
  if (handle_ != nullptr) glfwDestroyWindow(handle_);
  glfwTerminate();
}

render::GetGlFunction GlfwWindow::get_function() {
  return [](const char* name) { return reinterpret_cast<void*>(glfwGetProcAddress(name)); };
}

}  // namespace tintree::view
