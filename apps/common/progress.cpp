#include "apps/common/progress.h"

#include <cstdio>

#include <fmt/core.h>
#include <unistd.h>

namespace tintree::app {
namespace {

std::string clock_text(double seconds) {
  const auto s = static_cast<long>(seconds + 0.5);
  return s >= 3600 ? fmt::format("{}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60)
                   : fmt::format("{}:{:02}", s / 60, s % 60);
}

}  // namespace

void Progress::report(const std::string& step, std::uint64_t done, std::uint64_t total) {
  if (quiet_ || total == 0) return;
  const std::scoped_lock lock(turn_);
  const auto now = Clock::now();
  if (step != step_) {
    end_line();
    step_ = step;
    begun_ = now;
    first_ = done;
    drawn_ = {};
    tenth_ = done * 10 / total;
  }
  static const bool terminal = isatty(STDERR_FILENO) != 0;
  const std::uint64_t tenth = done * 10 / total;
  const bool due = terminal ? now - drawn_ > std::chrono::milliseconds(200) || done == total : tenth > tenth_;
  if (!due) return;
  tenth_ = tenth;
  drawn_ = now;
  draw(done, total, now);
  if (!terminal) end_line();
}

void Progress::draw(std::uint64_t done, std::uint64_t total, Clock::time_point now) {
  const double spent = std::chrono::duration<double>(now - begun_).count();
  const double share = static_cast<double>(done) / static_cast<double>(total);
  std::string rest;
  if (done == total) {
    rest = ", took " + clock_text(spent);
  } else if (done > first_) {
    rest = ", " + clock_text(spent / static_cast<double>(done - first_) * static_cast<double>(total - done)) + " left";
  }
  fmt::print(stderr, "{}{}: {} of {} ({:.0f} %){}", line_open_ ? "\r\033[K" : "", step_, done, total, 100 * share,
             rest);
  std::fflush(stderr);
  line_open_ = true;
}

void Progress::end_line() {
  if (line_open_) fmt::print(stderr, "\n");
  line_open_ = false;
}

void Progress::close() {
  const std::scoped_lock lock(turn_);
  end_line();
  step_.clear();
}

}  // namespace tintree::app
