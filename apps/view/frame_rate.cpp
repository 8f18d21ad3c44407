#include "apps/view/frame_rate.h"

namespace tintree::view {

void FrameRate::note_frame(double begun_s) {
  constexpr std::size_t kMost = 30;
  begun_s_.push_back(begun_s);
  if (begun_s_.size() > kMost) begun_s_.pop_front();
}

double FrameRate::per_second() const {
  if (begun_s_.size() < 2) return 0;
  return static_cast<double>(begun_s_.size() - 1) / (begun_s_.back() - begun_s_.front());
}

}  // namespace tintree::view
