#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "codec/error.h"
#include "render/gl_functions.h"

namespace tintree::render {

/// 8-bit RGB pixels, row-major, the upper row first.
struct Picture {
  int width_px = 0;
  int height_px = 0;
  std::vector<std::uint8_t> rgb;

  std::array<std::uint8_t, 3> at(int x_px, int y_px) const {
    const std::size_t i =
        3 * (static_cast<std::size_t>(y_px) * static_cast<std::size_t>(width_px) + static_cast<std::size_t>(x_px));
    return {rgb[i], rgb[i + 1], rgb[i + 2]};
  }
};

/// A frame to draw into: sRGB-encoded 8-bit colour, a float depth buffer (which a window's frame lacks), and
/// several samples a pixel. Lives and dies while its context is current; not thread-safe.
/// Memory: 8 bytes a sample and 8 a pixel.
class OffscreenTarget {
 public:
  /// `samples`: 1 for none of the smoothing; more than the driver has is cut to that. Fails with kIo when
  /// the driver cannot make a frame of this size. `gl` must outlive it.
  static Expected<OffscreenTarget> create(const GlFunctions& gl, int width_px, int height_px, int samples);

  OffscreenTarget(OffscreenTarget&& other) noexcept;
  OffscreenTarget& operator=(OffscreenTarget&& other) noexcept;
  ~OffscreenTarget();

  int width_px() const { return width_px_; }
  int height_px() const { return height_px_; }

  /// Makes it what is drawn into.
  void bind() const;
  Picture read_picture() const;
  /// What the depth buffer holds at a pixel (from the left and the top): near_m / depth, 0 where nothing was
  /// drawn. Waits for the drawing to end.
  float read_depth(int x_px, int y_px) const;
  /// The same of all pixels, row-major, the upper row first.
  std::vector<float> read_depths() const;
  /// Copies the colours to the lower left of the window's frame, which is of the same size.
  void show_in_window() const;

 private:
  struct Frame {
    GLuint framebuffer = 0;
    GLuint color = 0;
    GLuint depth = 0;
  };

  explicit OffscreenTarget(const GlFunctions& gl) : gl_(&gl) {}
  bool make(Frame& frame, int samples) const;
  void destroy(Frame& frame) const;
  void resolve(GLbitfield what) const;

  const GlFunctions* gl_;
  int width_px_ = 0;
  int height_px_ = 0;
  Frame drawn_;     ///< With all its samples.
  Frame resolved_;  ///< One sample a pixel, to read from.
};

}  // namespace tintree::render
