#pragma once

#include <string>
#include <thread>

#include "codec/error.h"

namespace tintree::app {

/// While it lives, a stop that the program does not come to by itself in good time (it may hang in a slow disk or in
/// a library) ends the process after 0.7 seconds with the message and exit code of `error`. For programs whose files
/// survive a sudden end.
class StopDeadline {
 public:
  StopDeadline(std::string program, Error error);

 private:
  std::jthread watch_;
};

}  // namespace tintree::app
