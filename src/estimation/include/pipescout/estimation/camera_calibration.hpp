// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "pipescout/estimation/fixed_lag_smoother.hpp"

namespace pipescout::estimation {

/// In words, what is known of the mounting of the camera, relative to where it was taken to be, and
/// of the delay of its poses, with twice their standard deviations; and what the motion so far does
/// not determine, so that it is as uncertain as it was beforehand. `mounting` as
/// VisualPoseMeasurement, `clock` as PoseMeasurement has it; negative: the delay is that of visual
/// poses. Empty where nothing of it is estimated, and before the start. `parameters` are those of
/// the smoother.
[[nodiscard]] std::string camera_calibration_text(const FixedLagSmoother& smoother,
                                                  const FixedLagSmootherParameters& parameters,
                                                  int mounting, int clock = -1);

}  // namespace pipescout::estimation
