#pragma once

#include <ctime>

namespace tintree::bench {

/// Processor time of this program since the clock was made; it can stand still meanwhile.
class CpuClock {
 public:
  double seconds() const { return static_cast<double>(std::clock() - start_ - paused_) / CLOCKS_PER_SEC; }

  /// Runs `work` off the clock.
  template <class Work>
  void pause_for(const Work& work) {
    const std::clock_t before = std::clock();
    work();
    paused_ += std::clock() - before;
  }

 private:
  std::clock_t start_ = std::clock();
  std::clock_t paused_ = 0;
};

}  // namespace tintree::bench
