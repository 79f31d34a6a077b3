// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <termios.h>

#include <functional>
#include <thread>

namespace pipescout::bag_command {

enum class Key { kSpace, kRight, kUp, kDown };

/// Keys that are pressed in a terminal, one by one and unseen. The terminal is as before when this
/// object goes.
class Keyboard {
 public:
  /// `pressed` is called on a thread of its own. Throws std::system_error. `terminal`: a file
  /// descriptor for which isatty holds.
  Keyboard(int terminal, std::function<void(Key)> pressed);
  Keyboard(const Keyboard&) = delete;
  Keyboard& operator=(const Keyboard&) = delete;
  ~Keyboard();

 private:
  void run();

  const int terminal_;
  const std::function<void(Key)> pressed_;
  int stop_ = -1;
  termios before_{};
  std::thread thread_;
};

}  // namespace pipescout::bag_command
