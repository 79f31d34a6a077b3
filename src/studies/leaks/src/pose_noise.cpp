// SPDX-License-Identifier: Apache-2.0
#include "pose_noise.hpp"

#include <cmath>
#include <stdexcept>
#include <string>

namespace pipescout::leak_study {
namespace {

using Eigen::Vector3d;

void check(const char* field, double value, double low, double high) {
  if (!(value >= low && value <= high)) {
    throw std::invalid_argument(std::string(field) + ": " + std::to_string(value) +
                                " is outside [" + std::to_string(low) + ", " +
                                std::to_string(high) + "]");
  }
}

}  // namespace

void PoseErrors::validate() const {
  check("level_deviation", level_deviation, 0, 10);
  check("height_deviation", height_deviation, 0, 10);
  check("position_time", position_time, 0.1, 1e5);
  check("heading_deviation", heading_deviation, 0, 1);
  check("heading_time", heading_time, 0.1, 1e5);
  check("tilt_deviation", tilt_deviation, 0, 1);
  check("tilt_time", tilt_time, 0.1, 1e5);
  check("mounting_deviation", mounting_deviation, 0, 1);
  check("mounting_shift_deviation", mounting_shift_deviation, 0, 10);
  check("line_deviation", line_deviation, 0, 10);
}

namespace internal {

PoseNoise::PoseNoise(const PoseErrors& errors, std::uint64_t seed)
    : errors_(errors), draw_(seed, 0x9e) {}

leak_findings::FramePose PoseNoise::measure(const geometry::SE3& T_map_body, double time) {
  const auto drift = [&](Vector3d& value, const Vector3d& times) {
    const Vector3d normals = draw_.normals();
    const Vector3d kept = started_
                              ? Vector3d((-(time - time_) * times.cwiseInverse()).array().exp())
                              : Vector3d::Zero();
    value = kept.cwiseProduct(value) +
            (1 - kept.array().square()).sqrt().matrix().cwiseProduct(normals);
  };
  drift(position_, Vector3d::Constant(errors_.position_time));
  drift(rotation_, {errors_.tilt_time, errors_.tilt_time, errors_.heading_time});
  started_ = true;
  time_ = time;

  const Vector3d position_deviation(errors_.level_deviation, errors_.level_deviation,
                                    errors_.height_deviation);
  const Vector3d rotation_deviation(errors_.tilt_deviation, errors_.tilt_deviation,
                                    errors_.heading_deviation);
  const Vector3d turn = rotation_.cwiseProduct(rotation_deviation);
  leak_findings::FramePose pose;
  pose.T_map_base = {geometry::SO3::exp(turn) * T_map_body.rotation(),
                     T_map_body.translation() + position_.cwiseProduct(position_deviation)};
  pose.covariance.diagonal() << position_deviation.cwiseAbs2(), rotation_deviation.cwiseAbs2();
  return pose;
}

geometry::SE3 PoseNoise::mounting(const geometry::SE3& T_body_camera) {
  const Vector3d turn = errors_.mounting_deviation * draw_.normals();
  const Vector3d shift = errors_.mounting_shift_deviation * draw_.normals();
  return {geometry::SO3::exp(turn) * T_body_camera.rotation(), T_body_camera.translation() + shift};
}

leak_findings::PipeLine PoseNoise::line(const Vector3d& from, const Vector3d& to) {
  const Vector3d along = (to - from).normalized();
  const Vector3d error = errors_.line_deviation * draw_.normals();
  const Vector3d across = error - error.dot(along) * along;
  return {.from = from + across, .to = to + across};
}

}  // namespace internal
}  // namespace pipescout::leak_study
