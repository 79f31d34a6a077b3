// SPDX-License-Identifier: Apache-2.0
#include "wheel_fusion.hpp"

namespace pipescout::estimation_study::internal {
namespace {

estimation::OdometerStatus status_of(odometry::StreamStatus status) {
  switch (status) {
    case odometry::StreamStatus::kOk:
      return estimation::OdometerStatus::kGood;
    case odometry::StreamStatus::kNoConsensus:
      return estimation::OdometerStatus::kNoConsensus;
    case odometry::StreamStatus::kWaiting:
    case odometry::StreamStatus::kNoData:
      break;
  }
  return estimation::OdometerStatus::kNoData;
}

}  // namespace

void push_wheel(odometry::OdometerStream& stream, const odometry::OdometerSample& sample,
                double latency, Recorder& recorder) {
  if (stream.push(sample).ticks == 0) {
    return;
  }
  const odometry::FusedStream& fused = stream.state();
  recorder.odometer({.time = fused.time,
                     .distance = fused.distance,
                     .variance = fused.random_variance,
                     .status = status_of(fused.status)},
                    sample.time + latency);
}

}  // namespace pipescout::estimation_study::internal
