// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipescout/estimation/fixed_lag_smoother.hpp"

namespace pipescout::estimation::test {

struct TrueState {
  double time = 0;
  NavState state{};
};

/// What stream.csv of the data set fusion_stream holds.
struct FusionStream {
  std::vector<TrueState> truth;
  std::vector<ImuSample> imu;
  std::vector<GpsMeasurement> gps;
  std::vector<VisualPoseMeasurement> vision;
  std::vector<RelativePoseMeasurement> odometry;
};

/// Empty when the file is not there.
[[nodiscard]] FusionStream read_fusion_stream(const std::filesystem::path& file);

/// Of the newest states from 5 s on.
struct StreamScore {
  double position = 0;            // m, root mean square
  double rotation = 0;            // rad
  double velocity = 0;            // m/s
  double nees = 0;                // mean, of 15 dimensions
  std::vector<double> update_ms;  // without the first 50
};

struct StreamSensors {
  bool gps = true;
  bool vision = true;
  bool odometry = true;
};

[[nodiscard]] StreamScore run_fusion_stream(const FusionStream& stream, const StreamSensors& use,
                                            FixedLagSmoother& smoother);

/// Densities of that stream, lag 2 s, no gates.
[[nodiscard]] FixedLagSmootherParameters fusion_stream_parameters();

}  // namespace pipescout::estimation::test
