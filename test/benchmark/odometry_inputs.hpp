// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "pipescout/odometry/odometer_stream.hpp"
#include "pipescout/odometry/weld_alignment.hpp"
#include "pipescout/odometry/weld_detector.hpp"

/// What the cases of the odometry benchmark work on: simulated, the same in each run.
namespace pipescout::benchmarks {

struct WheelInput {
  odometry::OdometerStreamParameters parameters;
  std::vector<odometry::OdometerSample> samples;  ///< in the order of time
};
/// 60 m at 0.3 m/s, 50 samples a second of each wheel; the wheels slip. The stream fuses as often:
/// after each round of samples.
[[nodiscard]] WheelInput wheel_input(std::size_t wheels);

struct SignalSample {
  double distance = 0.0;  ///< m
  odometry::Impedance value;
};
/// 300 m at 0.3 m/s, 200 samples a second, 12 dB, all features and disturbances.
[[nodiscard]] std::vector<SignalSample> signal_input();

struct WeldLists {
  std::vector<odometry::WeldPosition> then;
  std::vector<odometry::WeldPosition> later;
};
/// Two runs over 1,600 joints with odometers of their own, each of which misses one weld in fifty.
[[nodiscard]] WeldLists weld_lists();

}  // namespace pipescout::benchmarks
