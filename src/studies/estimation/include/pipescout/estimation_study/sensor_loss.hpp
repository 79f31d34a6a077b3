// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "pipescout/estimation_study/vehicle_run.hpp"

/// What an overloaded computer or a bad link does to the data of one sensor.
namespace pipescout::estimation_study {

struct SensorLoss {
  Sensor sensor = Sensor::kImu;
  double share = 0;          ///< [0, 0.9] of its readings are lost
  double longest_burst = 0;  ///< s, [0, 60]; lost in bursts of at most this; 0: each by itself
  double lag = 0;            ///< s, [0, 60]; the others arrive so much later than they would

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

/// The sensor whose reading it is; nothing for a given pose.
[[nodiscard]] std::optional<Sensor> sensor_of(const Reading& reading);

/// The run with such losses from `from` (s) on. The same seed gives the same losses. Throws as
/// SensorLoss::validate.
[[nodiscard]] VehicleRun with_loss(VehicleRun run, const SensorLoss& loss, double from,
                                   std::uint64_t seed);

/// s, the longest time between readings of a sensor, and from its last one to the end; 0 without
/// readings.
[[nodiscard]] double longest_gap(const VehicleRun& run, Sensor sensor);

}  // namespace pipescout::estimation_study
