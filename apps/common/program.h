#pragma once

#include <functional>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include "codec/error.h"

namespace tintree::app {

/// Parses the command line into what `app` was given and calls `run`. Help and version exit 0, a usage
/// error prints one line and exits 2, a failure of `run` prints its message and exits with its code
/// (DESIGN of the command lines: docs/guide.md). Returns the process's exit code.
int run_program(CLI::App& app, int argc, char** argv, const std::function<Expected<void>()>& run);

/// True once the user has asked for a stop (Ctrl-C or SIGTERM). The first call installs the handler; a
/// second signal ends the process at once.
bool stop_requested();

}  // namespace tintree::app
