#include "apps/common/program.h"

#include <atomic>
#include <csignal>
#include <cstdio>
#include <exception>
#include <new>

#include <fmt/core.h>

namespace tintree::app {
namespace {

volatile std::sig_atomic_t g_stop = 0;

void on_signal(int signal) {
  g_stop = 1;
  std::signal(signal, SIG_DFL);
}

int report(const std::string& program, const Error& error) {
  fmt::print(stderr, "{}: {}\n", program, error.text());
  return static_cast<int>(error.code);
}

}  // namespace

int run_program(CLI::App& app, int argc, char** argv, const std::function<Expected<void>()>& run) {
  const std::string program = app.get_name();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() == 0) return app.exit(e);
    return report(program, {ErrorCode::kUsage, std::string(e.what()) + " (see --help)", {}});
  }
  try {
    const Expected<void> done = run();
    return done ? 0 : report(program, done.error());
  } catch (const std::bad_alloc&) {
    return report(program, {ErrorCode::kIo, "out of memory", {}});
  } catch (const std::exception& e) {
    return report(program, {ErrorCode::kIo, std::string("unexpected: ") + e.what(), {}});
  }
}

bool stop_requested() {
  [[maybe_unused]] static const bool installed = [] {
    std::signal(SIGINT, on_signal);
    std::signal(SIGTERM, on_signal);
    return true;
  }();
  return g_stop != 0;
}

}  // namespace tintree::app
