// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>
#include <vector>

#include "pipescout/estimation/fixed_lag_smoother.hpp"

/// The fixed-lag smoother on the data set fusion_stream: a simulated sensor stream with results of
/// other smoothers, see its SOURCE.txt.
namespace pipescout::estimation_study {

struct TrueState {
  double time = 0;
  estimation::NavState state{};
};

/// Content of stream.csv of the data set fusion_stream.
struct FusionStream {
  std::vector<TrueState> truth;
  std::vector<estimation::ImuSample> imu;
  std::vector<estimation::GpsMeasurement> gps;
  std::vector<estimation::VisualPoseMeasurement> vision;
  std::vector<estimation::RelativePoseMeasurement> odometry;
};

/// Throws std::runtime_error naming the line for an invalid row.
[[nodiscard]] FusionStream parse_fusion_stream(std::string_view text);

/// Of the newest states from 5 s on.
struct StreamScore {
  double position = 0;  ///< m, root mean square
  double rotation = 0;  ///< rad
  double velocity = 0;  ///< m/s
  double nees = 0;      ///< mean, of 15 dimensions
};

struct StreamSensors {
  bool gps = true;
  bool vision = true;
  bool odometry = true;
};

/// A keyframe each 0.1 s. `stream` is not empty.
[[nodiscard]] StreamScore run_fusion_stream(const FusionStream& stream, const StreamSensors& use,
                                            estimation::FixedLagSmoother& smoother);

/// Densities of that stream, lag 2 s, no gates.
[[nodiscard]] estimation::FixedLagSmootherParameters fusion_stream_parameters();

}  // namespace pipescout::estimation_study
