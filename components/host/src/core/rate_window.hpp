// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <deque>
#include <optional>
#include <string>

#include "pipescout/runtime/time.hpp"

namespace pipescout::host {

/// The rate at which messages arrive, over the last `window` intervals between them.
class RateWindow {
 public:
  struct Statistics {
    double rate = 0.0;                ///< Hz
    double min = 0.0;                 ///< s, shortest interval
    double max = 0.0;                 ///< s, longest interval
    double standard_deviation = 0.0;  ///< s, of the intervals
    std::size_t window = 0;           ///< intervals
  };

  /// Throws std::invalid_argument when `window` is 0.
  explicit RateWindow(std::size_t window);

  void arrived(SteadyTime now);
  /// Nothing before the second message.
  [[nodiscard]] std::optional<Statistics> statistics() const;

 private:
  std::size_t window_;
  std::optional<SteadyTime> last_;
  std::deque<double> intervals_;
};

/// As `ros2 topic hz` prints it.
[[nodiscard]] std::string to_string(const RateWindow::Statistics& statistics);

}  // namespace pipescout::host
