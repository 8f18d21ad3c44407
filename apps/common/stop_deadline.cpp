#include "apps/common/stop_deadline.h"

#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <mutex>
#include <stop_token>
#include <utility>

#include <unistd.h>

#include "apps/common/program.h"

namespace tintree::app {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kLook{50};
constexpr milliseconds kPatience{700};

/// Sleeps; false when that was cut short because the deadline's life is over.
bool sleep(const std::stop_token& over, milliseconds time) {
  std::mutex turn;
  std::condition_variable_any wake;
  std::unique_lock lock(turn);
  wake.wait_for(lock, over, time, [] { return false; });
  return !over.stop_requested();
}

}  // namespace

StopDeadline::StopDeadline(std::string program, Error error)
    : watch_([program = std::move(program), error = std::move(error)](const std::stop_token& over) {
        while (!stop_requested()) {
          if (!sleep(over, kLook)) return;
        }
        if (!sleep(over, kPatience)) return;
        if (isatty(STDERR_FILENO) != 0) std::fputc('\n', stderr);  // leaves the progress line
        ::_exit(report_failure(program, error));
      }) {}

}  // namespace tintree::app
