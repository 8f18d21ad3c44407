#pragma once

#include <cstddef>

#include "render/gl_functions.h"

namespace tintree::render {

/// The texels of an impostor: a colour and a depth each, to be drawn into and then sampled. Lives and dies while its
/// context is current; not thread-safe.
class ImpostorBuffer {
 public:
  static constexpr std::size_t kTexelBytes = 8;  ///< RGBA8, and a depth as a float.

  /// Of no size yet. `gl` must outlive it.
  explicit ImpostorBuffer(const GlFunctions& gl);
  ~ImpostorBuffer();
  ImpostorBuffer(const ImpostorBuffer&) = delete;
  ImpostorBuffer& operator=(const ImpostorBuffer&) = delete;

  /// Makes it so large, unless it is; what it held is lost. False when the driver cannot: then it is of no size.
  bool resize(int width_px, int height_px);
  /// Graphics memory that it holds.
  std::size_t bytes() const { return bytes_of(width_px_, height_px_); }
  static std::size_t bytes_of(int width_px, int height_px);

  /// Makes all of it what is drawn into.
  void bind() const;
  /// Bound, empties it: no colour, no depth.
  void clear() const;
  /// Binds its colours, sampled linearly, to the first texture unit and its depths to the second.
  void bind_textures() const;

 private:
  const GlFunctions* gl_;
  GLuint framebuffer_ = 0;
  GLuint colors_ = 0;
  GLuint depths_ = 0;
  int width_px_ = 0;
  int height_px_ = 0;
};

}  // namespace tintree::render
