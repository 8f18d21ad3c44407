#pragma once

#include <memory>
#include <string>

#include "codec/error.h"
#include "render/gl_functions.h"

struct GLFWwindow;

namespace tintree::view {

/// GLFW itself and one window with its OpenGL context, which is current from create() to the end. For the main thread.
class GlfwWindow {
 public:
  /// A core context of OpenGL 4.5, or 3.3 where that is all there is. Fails with kIo when there is no display, or no
  /// such OpenGL; the message says what to do instead.
  static Expected<std::unique_ptr<GlfwWindow>> create(int width, int height, const std::string& title, bool visible);

  ~GlfwWindow();
  GlfwWindow(const GlfwWindow&) = delete;
  GlfwWindow& operator=(const GlfwWindow&) = delete;

  GLFWwindow* handle() const { return handle_; }
  static render::GetGlFunction get_function();

 private:
  GlfwWindow() = default;
  GLFWwindow* handle_ = nullptr;
};

}  // namespace tintree::view
