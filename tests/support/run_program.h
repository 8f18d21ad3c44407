#pragma once

#include <string>
#include <vector>

#include <sys/types.h>

#include "tests/support/temp_dir.h"

namespace tintree::test {

/// How a program ended.
struct ProgramResult {
  int exit_code = -1;  ///< 128 + signal when a signal ended it.
  std::string out;
  std::string err;

  std::string all() const { return out + err; }
};

/// A program that runs beside the test; destroyed, it is killed.
class RunningProgram {
 public:
  RunningProgram(const std::string& program, const std::vector<std::string>& arguments);
  ~RunningProgram();
  RunningProgram(const RunningProgram&) = delete;
  RunningProgram& operator=(const RunningProgram&) = delete;

  /// False once it has ended.
  bool running();
  void send(int signal) const;
  /// Whether it has a handler for the signal by now.
  bool handles(int signal) const;
  /// Waits for its end; how that was, and what it printed.
  ProgramResult wait();

 private:
  TempDir dir_;
  pid_t child_;
  bool ended_ = false;
  int status_ = 0;
};

/// Runs `program` with `arguments`, waits for its end and captures what it printed.
ProgramResult run_program(const std::string& program, const std::vector<std::string>& arguments);

}  // namespace tintree::test
