// SPDX-License-Identifier: Apache-2.0
#include "pose_noise.hpp"

#include <cmath>
#include <string>

#include "pipescout/validation/check.hpp"

namespace pipescout::leak_study {
namespace {

using Eigen::Vector3d;

}  // namespace

void PoseErrors::validate() const {
  validation::check_within("level_deviation", level_deviation, 0, 10);
  validation::check_within("height_deviation", height_deviation, 0, 10);
  validation::check_within("position_time", position_time, 0.1, 1e5);
  validation::check_within("heading_deviation", heading_deviation, 0, 1);
  validation::check_within("heading_time", heading_time, 0.1, 1e5);
  validation::check_within("tilt_deviation", tilt_deviation, 0, 1);
  validation::check_within("tilt_time", tilt_time, 0.1, 1e5);
  validation::check_within("mounting_deviation", mounting_deviation, 0, 1);
  validation::check_within("mounting_shift_deviation", mounting_shift_deviation, 0, 10);
  validation::check_within("line_deviation", line_deviation, 0, 10);
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
