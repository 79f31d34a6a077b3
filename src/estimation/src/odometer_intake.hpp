// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <limits>
#include <optional>
#include <vector>

#include "pipescout/estimation/state_estimator.hpp"

namespace pipescout::estimation {

/// The readings of the odometer of the last seconds, and distances between any two times in them.
///
/// A counter that was misread for once jumps there and back. A reading that more of its neighbours
/// contradict than bear out, two to either side, is left out, and after a reset until there are
/// others that bear it out.
class OdometerIntake {
 public:
  /// Not checked.
  explicit OdometerIntake(const OdometerUse& use);

  Outcome add(const OdometerReading& reading) noexcept;
  void forget() noexcept {
    readings_.clear();
    forgotten_ = -std::numeric_limits<double>::infinity();
  }
  /// How many are later.
  [[nodiscard]] std::size_t after(double time) const noexcept;
  /// Whether one more makes it forget a reading of after this time.
  [[nodiscard]] bool is_full_after(double time) const noexcept;

  struct Increment {
    double distance = 0;       // m
    double deviation = 0;      // m
    std::size_t left_out = 0;  // readings that others contradict
  };
  /// Nothing where a reading is missing, the counter was reset or there is no data.
  [[nodiscard]] std::optional<Increment> between(double from, double to) const noexcept;
  /// m/s and m/s^2 over the last `window` seconds before `end`; nothing as above.
  struct Motion {
    double speed = 0;
    double acceleration = 0;
  };
  [[nodiscard]] std::optional<Motion> motion(double end, double window) const noexcept;
  /// Of the newest that is not left out; NaN before the first.
  [[nodiscard]] double newest() const noexcept;

 private:
  using Place = std::vector<OdometerReading>::const_iterator;
  [[nodiscard]] bool usable(const OdometerReading& r) const noexcept;
  /// Whether a counter may go from one to the other, by largest speed and gap.
  [[nodiscard]] bool agree(const OdometerReading& a, const OdometerReading& b) const noexcept;
  [[nodiscard]] bool left_out(Place reading) const noexcept;
  /// Whether the distance between a reading and the next is to be used.
  [[nodiscard]] bool joined(const OdometerReading& a, const OdometerReading& b) const noexcept;

  OdometerUse use_;
  std::vector<OdometerReading> readings_{};                      // oldest first
  double forgotten_ = -std::numeric_limits<double>::infinity();  // s, the newest that is not kept
};

}  // namespace pipescout::estimation
