#include "apps/common/program.h"

#include <csignal>
#include <cstdio>
#include <exception>
#include <new>

#include <fmt/core.h>

namespace tintree::app {
namespace {

StopFlag g_stop = false;

void on_signal(int signal) {
  g_stop = true;
  std::signal(signal, SIG_DFL);
}

}  // namespace

int report_failure(const std::string& program, const Error& error) {
  fmt::print(stderr, "{}: {}\n", program, error.text());
  return static_cast<int>(error.code);
}

int run_program(CLI::App& app, int argc, char** argv, const std::function<Expected<void>()>& run) {
  // A file that grows beyond the user's limit (ulimit -f) is a failed write like another, with a message.
  std::signal(SIGXFSZ, SIG_IGN);
  const std::string program = app.get_name();
  app.set_version_flag("--version", program + " " + TINTREE_VERSION);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() == 0) return app.exit(e);
    return report_failure(program, {ErrorCode::kUsage, std::string(e.what()) + " (see --help)", {}});
  }
  try {
    const Expected<void> done = run();
    return done ? 0 : report_failure(program, done.error());
  } catch (const std::bad_alloc&) {
    return report_failure(program, {ErrorCode::kIo, "out of memory", {}});
  } catch (const std::exception& e) {
    return report_failure(program, {ErrorCode::kIo, std::string("unexpected: ") + e.what(), {}});
  }
}

const StopFlag* stop_flag() {
  [[maybe_unused]] static const bool installed = [] {
    std::signal(SIGINT, on_signal);
    std::signal(SIGTERM, on_signal);
    return true;
  }();
  return &g_stop;
}

}  // namespace tintree::app
