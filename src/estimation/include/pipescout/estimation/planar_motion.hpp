// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "pipescout/estimation/state_estimator.hpp"

namespace pipescout::estimation {

struct PlanarMotionParameters {
  double gravity = 9.80665;  ///< m/s^2
  double step = 0.02;        ///< s, largest time between two readings
  double longest_gap = 1.0;  ///< s: over a longer one nothing is implied
  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

/// For robots without an IMU: the readings that an ideal one would give on level ground, of a base
/// whose speed and yaw rate are known and that does not slip sideways. Between two motions both
/// change evenly.
///
/// What wheels say enters the estimate twice then, as readings and as odometer: the noise of the
/// readings must be that of wheels, see `set_planar`.
class PlanarMotion {
 public:
  explicit PlanarMotion(PlanarMotionParameters parameters = {});

  /// The readings from the motion before to this one, in the frame of the base: x forwards, z up;
  /// the first at the time of the motion before, the last before `time`. Empty for the first
  /// motion, after a gap, and, with nothing changed, for a time that is not after the one before.
  /// Valid until the next call. `speed` m/s, `yaw_rate` rad/s; throws std::invalid_argument unless
  /// all are finite.
  [[nodiscard]] const std::vector<ImuReading>& add(double time, double speed, double yaw_rate);

 private:
  struct Motion {
    double time;
    double speed;
    double yaw_rate;
  };

  PlanarMotionParameters parameters_;
  std::optional<Motion> last_;
  std::vector<ImuReading> readings_;
};

/// Settings of an estimator whose IMU is implied by wheels: their noise, and nothing that only an
/// IMU could tell (mounting of the odometer). IMU at the origin of the base.
void set_planar(StateEstimatorParameters& parameters);

}  // namespace pipescout::estimation
