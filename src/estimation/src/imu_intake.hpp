// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <optional>

#include "clock_watch.hpp"
#include "pipescout/estimation/state_estimator.hpp"

namespace pipescout::estimation {

/// From instantaneous readings of an IMU to mean values over intervals, in the body. What differs
/// much from the reading before waits for the next one to bear it out.
class ImuIntake {
 public:
  /// Not checked.
  explicit ImuIntake(const StateEstimatorParameters& parameters);

  struct Taken {
    Outcome outcome = Outcome::kWaiting;  // kGated: a spike, the reading before this one, or this
    bool jumped = false;                  // of time, to this reading; there are no samples
    double gap = 0;                       // s, before this reading, if too long to be joined
    std::size_t count = 0;
    std::array<ImuSample, 2> samples{};  // `count` of them
  };
  /// `others`: the newest time of other sensors, whose clocks have not jumped since the last
  /// reading; NaN: none. A long step of time that they have gone along with is a gap, see is_gap.
  Taken add(const ImuReading& reading,
            double others = std::numeric_limits<double>::quiet_NaN()) noexcept;
  /// Whether a step from one reading to another is one of readings that are missing, not of the
  /// clock: other sensors have gone on meanwhile.
  [[nodiscard]] static bool is_gap(double from, double to, double others) noexcept;

  /// Time goes on from the next reading.
  void forget() noexcept;
  /// NaN before the first.
  [[nodiscard]] double newest() const noexcept { return clock_.newest(); }

 private:
  [[nodiscard]] bool near(const ImuReading& a, const ImuReading& b) const noexcept;
  void join(const ImuReading& to, Taken& taken) noexcept;
  [[nodiscard]] bool is_dead(const ImuReading& reading) noexcept;
  /// The first reading may be wrong: what is joined begins with one that the next bears out.
  void begin(const ImuReading& now, Taken& taken) noexcept;

  geometry::SO3 R_body_imu_;
  double scale_;
  double largest_rate_;
  double largest_force_;
  double spike_rate_;
  double spike_force_;
  double rate_step_;  // from reading to reading, on the mean
  double force_step_;
  double largest_gap_;
  ClockWatch clock_;
  std::optional<ImuReading> last_{};  // in the body
  std::optional<ImuReading> held_{};
  std::size_t dropped_ = 0;                                  // running
  Eigen::Vector3d repeated_rate_ = Eigen::Vector3d::Zero();  // of the newest readings, since:
  double repeated_since_ = 0;                                // s
  std::size_t repeats_ = 0;
};

}  // namespace pipescout::estimation
