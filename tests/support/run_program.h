#pragma once

#include <string>
#include <vector>

namespace tintree::test {

/// How a program ended.
struct ProgramResult {
  int exit_code = -1;  ///< 128 + signal when a signal ended it.
  std::string out;
  std::string err;

  std::string all() const { return out + err; }
};

/// Runs `program` with `arguments`, waits for its end and captures what it printed.
ProgramResult run_program(const std::string& program, const std::vector<std::string>& arguments);

}  // namespace tintree::test
