// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <deque>
#include <optional>
#include <string>

#include "pipescout/runtime/time.hpp"

namespace pipescout::host {

/// The bytes of a topic, over the last `window` messages.
class SizeWindow {
 public:
  struct Statistics {
    double bytes_per_second = 0.0;
    double mean = 0.0;  ///< bytes of a message, as the next two
    std::size_t min = 0;
    std::size_t max = 0;
    std::size_t window = 0;  ///< messages
  };

  /// Throws std::invalid_argument when `window` is 0.
  explicit SizeWindow(std::size_t window);

  void arrived(SteadyTime now, std::size_t bytes);
  /// From the first message of the window to `now`; nothing before the second message.
  [[nodiscard]] std::optional<Statistics> statistics(SteadyTime now) const;

 private:
  struct Message {
    SteadyTime time;
    std::size_t bytes;
  };
  std::size_t window_;
  std::deque<Message> messages_;
};

/// As `ros2 topic bw` prints it.
[[nodiscard]] std::string to_string(const SizeWindow::Statistics& statistics);

/// How much later than stamped the messages of a topic arrive, over the last `window` of them.
class DelayWindow {
 public:
  struct Statistics {
    double mean = 0.0;  ///< s, as the next three
    double min = 0.0;
    double max = 0.0;
    double standard_deviation = 0.0;
    std::size_t window = 0;  ///< messages
  };

  /// Throws std::invalid_argument when `window` is 0.
  explicit DelayWindow(std::size_t window);

  void arrived(Duration delay);
  [[nodiscard]] std::optional<Statistics> statistics() const;

 private:
  std::size_t window_;
  std::deque<double> delays_;
};

/// As `ros2 topic delay` prints it.
[[nodiscard]] std::string to_string(const DelayWindow::Statistics& statistics);

}  // namespace pipescout::host
