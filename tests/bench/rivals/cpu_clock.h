#pragma once

#include <algorithm>
#include <ctime>
#include <limits>

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

/// The least processor time of `work`, which is done at least three times and for a quarter of a second.
template <class Work>
double least_seconds(const Work& work) {
  const CpuClock all;
  double least = std::numeric_limits<double>::infinity();
  for (int done = 0; done < 3 || all.seconds() < 0.25; ++done) {
    const CpuClock once;
    work();
    least = std::min(least, once.seconds());
  }
  return least;
}

}  // namespace tintree::bench
