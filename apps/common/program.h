#pragma once

#include <functional>
#include <string>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include "codec/error.h"
#include "codec/stop_flag.h"

namespace tintree::app {

/// Parses the command line into what `app` was given and calls `run`. --help and --version exit 0, a usage
/// error prints one line and exits 2, a failure of `run` prints its message and exits with its code
/// (DESIGN of the command lines: docs/guide.md). A write beyond the limit on file sizes fails, in place of the signal
/// SIGXFSZ. Returns the process's exit code.
int run_program(CLI::App& app, int argc, char** argv, const std::function<Expected<void>()>& run);

/// Set once the user has asked for a stop (Ctrl-C or SIGTERM). The first call installs the handler; a second signal
/// ends the process at once.
const StopFlag* stop_flag();
inline bool stop_requested() { return is_set(stop_flag()); }

/// Prints "program: message" to standard error; returns the exit code of the failure.
int report_failure(const std::string& program, const Error& error);

}  // namespace tintree::app
