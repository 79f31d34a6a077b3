// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <deque>
#include <optional>

#include "pipescout/arm_study/arm_drive.hpp"
#include "pipescout/simulation/body_motion.hpp"
#include "pipescout/simulation/pipe_view.hpp"
#include "pipescout/statistics/draw.hpp"

namespace pipescout::arm_study::internal {

/// What takes a while to come.
template <class T>
class Delayed {
 public:
  explicit Delayed(double latency) : latency_(latency) {}
  void push(double time, const T& value) { waiting_.push_back({time + latency_, value}); }
  /// The next one that is there at `now`, s.
  std::optional<T> pop(double now) {
    if (waiting_.empty() || waiting_.front().first > now + 1e-9) {
      return std::nullopt;
    }
    const T value = waiting_.front().second;
    waiting_.pop_front();
    return value;
  }

 private:
  double latency_;
  std::deque<std::pair<double, T>> waiting_;
};

/// The tracker: the section of the pipe in the image, coasting in gaps and for a second after the
/// pipe has left the image, lost later.
class TrackSensor {
 public:
  TrackSensor(const TrackErrors& errors, std::uint64_t seed);
  /// `moved`: m, since the beginning of the drive.
  [[nodiscard]] manipulation::PipeSection measure(const std::optional<simulation::PipeView>& view,
                                                  const geometry::CameraParameters& camera,
                                                  double time, double moved);

 private:
  void draw_gap(double moved);

  TrackErrors errors_;
  statistics::Draw draw_;
  double range_scale_;
  double gap_begins_ = 0;  // m
  double gap_lasts_ = 0;   // s
  std::optional<double> gap_since_;
  std::optional<double> last_seen_;
};

/// The estimator.
class OdometrySensor {
 public:
  OdometrySensor(const OdometryErrors& errors, std::uint64_t seed);
  [[nodiscard]] manipulation::VehicleMotion measure(const simulation::BodyMotion& truth);

 private:
  OdometryErrors errors_;
  statistics::Draw draw_;
  Eigen::Vector3d tilt_;      // rad
  Eigen::Vector3d velocity_;  // m/s
};

}  // namespace pipescout::arm_study::internal
