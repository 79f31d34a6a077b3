// SPDX-License-Identifier: Apache-2.0
#include "drive_sensors.hpp"

#include <cmath>
#include <limits>

namespace pipescout::arm_study::internal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using manipulation::TrackState;

constexpr double kCoasts = 1;  // s, before the tracker gives up

}  // namespace

TrackSensor::TrackSensor(const TrackErrors& errors, std::uint64_t seed)
    : errors_(errors),
      draw_(seed, 0x71),
      range_scale_(std::exp(errors.range_deviation * draw_.normal())) {
  draw_gap(0);
}

void TrackSensor::draw_gap(double moved) {
  gap_begins_ = moved + errors_.gap_spacing * draw_.exponential();
  gap_lasts_ = draw_.uniform(0, errors_.gap_time);
  gap_since_.reset();
}

manipulation::PipeSection TrackSensor::measure(const std::optional<simulation::PipeView>& view,
                                               const geometry::CameraParameters& camera,
                                               double time, double moved) {
  manipulation::PipeSection section{.time = time, .width = camera.width, .height = camera.height};
  // Drawn in any case, so that the errors of different arms are alike.
  const double u = draw_.normal();
  const double v = draw_.normal();
  const double turn = draw_.normal();
  if (moved >= gap_begins_) {
    gap_since_ = gap_since_.value_or(time);
    if (time - *gap_since_ >= gap_lasts_) {
      draw_gap(moved);
    }
  }
  if (view && !gap_since_) {
    const Vector2d middle = (view->from + view->to) / 2;
    const Vector2d along = view->to - view->from;
    section.state = TrackState::kLocked;
    section.u = middle.x() + errors_.position_deviation * u;
    section.v = middle.y() + errors_.position_deviation * v;
    section.length = along.norm();
    section.angle = std::atan2(along.y(), along.x()) + errors_.angle_deviation * turn;
    section.range = range_scale_ * view->range;
    last_seen_ = time;
    return section;
  }
  section.state = last_seen_ && time - *last_seen_ < kCoasts ? TrackState::kCoasting
                  : last_seen_                               ? TrackState::kLost
                                                             : TrackState::kNone;
  return section;
}

OdometrySensor::OdometrySensor(const OdometryErrors& errors, std::uint64_t seed)
    : errors_(errors),
      draw_(seed, 0x72),
      tilt_(errors.tilt_deviation * draw_.normals()),
      velocity_(errors.velocity_deviation * draw_.normals()) {}

manipulation::VehicleMotion OdometrySensor::measure(const simulation::BodyMotion& truth) {
  const auto drift = [this](Vector3d& value, double deviation, double time) {
    const double kept = std::exp(-1 / (errors_.rate * time));
    value = kept * value + deviation * std::sqrt(1 - kept * kept) * draw_.normals();
  };
  drift(tilt_, errors_.tilt_deviation, errors_.tilt_time);
  drift(velocity_, errors_.velocity_deviation, errors_.velocity_time);
  const geometry::SO3& R_map_base = truth.T_map_body.rotation();
  return {.time = truth.time,
          .R_map_base = (R_map_base * geometry::SO3::exp(tilt_)).quaternion(),
          .velocity = R_map_base.inverse() * truth.velocity + velocity_,
          .angular_rate = truth.angular_rate + errors_.rate_deviation * draw_.normals()};
}

}  // namespace pipescout::arm_study::internal
