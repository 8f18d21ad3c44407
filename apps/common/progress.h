#pragma once

#include <chrono>
#include <cstdint>
#include <mutex>
#include <string>

namespace tintree::app {

/// A progress line on standard error: what is done, of how much, the share and the time left. The time is judged by
/// what was done since the step's first report: what an earlier run had done does not count. Redraws in place on a
/// terminal, else prints a line per tenth. Thread-safe.
class Progress {
 public:
  explicit Progress(bool quiet) : quiet_(quiet) {}
  ~Progress() { close(); }
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Reports that `done` of `total` units of `step` are complete; a new step name begins a new line.
  void report(const std::string& step, std::uint64_t done, std::uint64_t total);
  /// Ends the current line.
  void close();

 private:
  using Clock = std::chrono::steady_clock;
  void draw(std::uint64_t done, std::uint64_t total, Clock::time_point now);
  void end_line();

  bool quiet_;
  std::mutex turn_;
  std::string step_;
  Clock::time_point begun_{};
  std::uint64_t first_ = 0;  // done when the step was first reported
  Clock::time_point drawn_{};
  std::uint64_t tenth_ = 0;
  bool line_open_ = false;
};

}  // namespace tintree::app
