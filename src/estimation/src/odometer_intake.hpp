// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "pipescout/estimation/state_estimator.hpp"

namespace pipescout::estimation {

/// The readings of the odometer of the last seconds, and distances between any two times in them.
class OdometerIntake {
 public:
  /// Not checked.
  explicit OdometerIntake(const OdometerUse& use);

  Outcome add(const OdometerReading& reading) noexcept;
  void forget() noexcept { readings_.clear(); }

  struct Increment {
    double distance = 0;   // m
    double deviation = 0;  // m
  };
  /// Nothing where a reading is missing, the counter was reset or there is no data.
  [[nodiscard]] std::optional<Increment> between(double from, double to) const noexcept;
  /// m/s and m/s^2 over the last `window` seconds; nothing as above.
  struct Motion {
    double speed = 0;
    double acceleration = 0;
  };
  [[nodiscard]] std::optional<Motion> motion(double window) const noexcept;
  /// NaN before the first.
  [[nodiscard]] double newest() const noexcept;

 private:
  /// Whether the distance between a reading and the next is to be used.
  [[nodiscard]] bool joined(const OdometerReading& a, const OdometerReading& b) const noexcept;

  OdometerUse use_;
  std::vector<OdometerReading> readings_{};  // oldest first
};

}  // namespace pipescout::estimation
