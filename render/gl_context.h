#pragma once

#include <memory>

#include "codec/error.h"
#include "render/gl_functions.h"

namespace tintree::render {

/// Where a context without a window comes from.
enum class Headless {
  kEgl,     ///< A graphics card where there is one, else Mesa's software renderer.
  kOsMesa,  ///< Mesa's software renderer in memory: works on every machine that has the library.
};

/// An OpenGL context without a window or a frame of its own (draw into an OffscreenTarget). Current on the
/// thread that made it, from create() to its destruction on that same thread. One a process.
class HeadlessContext {
 public:
  /// A core context of version 4.5, or 3.3 where that is all there is. Fails with kIo when the library or
  /// the driver is not there; the message says what to install.
  static Expected<std::unique_ptr<HeadlessContext>> create(Headless kind);

  virtual ~HeadlessContext() = default;
  HeadlessContext(const HeadlessContext&) = delete;
  HeadlessContext& operator=(const HeadlessContext&) = delete;

  virtual GetGlFunction get_function() const = 0;

 protected:
  HeadlessContext() = default;
};

}  // namespace tintree::render
