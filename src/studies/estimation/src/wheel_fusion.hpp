// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pipescout/odometry/odometer_stream.hpp"
#include "recorder.hpp"

namespace pipescout::estimation_study::internal {

/// Pushes a sample of a wheel, and hands on what that has fused. It arrives `latency` s after the
/// sample.
void push_wheel(odometry::OdometerStream& stream, const odometry::OdometerSample& sample,
                double latency, Recorder& recorder);

}  // namespace pipescout::estimation_study::internal
