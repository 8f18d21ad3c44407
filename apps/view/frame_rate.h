#pragma once

#include <deque>

namespace tintree::view {

/// Frames a second, of frames that are drawn only while something changes. Times are seconds of the caller's clock,
/// which never goes back. For one thread.
class FrameRate {
 public:
  void note_frame(double begun_s);
  /// Nothing has been drawn for a while, and that is no frame's time.
  void rest() { begun_s_.clear(); }
  /// Over the last frames drawn without a rest; 0 at rest, and of the first frame after one.
  double per_second() const;

 private:
  std::deque<double> begun_s_;
};

}  // namespace tintree::view
