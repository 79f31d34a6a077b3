// SPDX-License-Identifier: Apache-2.0
#include "camera_arm.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace pipescout::arm_study::internal {
namespace {

using Eigen::Vector2d;
using manipulation::ArmModel;
using manipulation::JointVector;

constexpr double kRounding = 1e-9;  // of what is compared with limits
constexpr double kMoving = 1e-6;    // rad/s

ArmModel generic_arm() {
  return {manipulation::camera_arm_urdf(), "base_link", "camera_optical_frame"};
}

simulation::ArmDynamicsParameters dynamics_of(const ArmModel& arm, double delay) {
  simulation::ArmDynamicsParameters parameters{.delay = delay};
  for (const manipulation::ArmJoint& joint : arm.joints()) {
    parameters.lower.push_back(joint.lower);
    parameters.upper.push_back(joint.upper);
    parameters.largest_rate.push_back(joint.velocity);
  }
  return parameters;
}

JointVector zero_errors(std::size_t joints, double deviation, std::uint64_t seed) {
  statistics::Draw draw(seed, 0x73);
  JointVector errors(static_cast<Eigen::Index>(joints));
  for (double& error : errors) {
    error = deviation * draw.normal();
  }
  return errors;
}

}  // namespace

CameraArm::CameraArm(const ArmRule& rule, const DriveSettings& settings,
                     const geometry::Camera& camera, const simulation::StraightPipe& pipe,
                     std::uint64_t seed)
    : fixed_(rule.fixed),
      pipe_(pipe),
      camera_(camera),
      arm_(generic_arm()),
      zero_errors_(zero_errors(arm_.joints().size(), settings.joint_zero_deviation, seed)),
      controller_(generic_arm(), rule.controller),
      dynamics_(dynamics_of(arm_, settings.arm_delay), rule.controller.ready),
      tracker_(settings.track, seed),
      sections_(settings.track.latency),
      shown_(rule.controller.ready),
      last_velocity_(JointVector::Zero(arm_.size())) {
  score_.rule = rule.name;
  score_.least_clearance = std::numeric_limits<double>::infinity();
  controller_.set_camera(camera_);
  for (const manipulation::ArmJoint& joint : arm_.joints()) {
    names_.push_back(joint.name);
  }
}

void CameraArm::observe(const manipulation::VehicleMotion& motion, double now) {
  controller_.observe(motion, now);
}

void CameraArm::move_pipe(const Eigen::Vector3d& by) {
  pipe_.from += by;
  pipe_.to += by;
}

JointVector CameraArm::joints() const {
  const JointVector positions =
      Eigen::Map<const Eigen::VectorXd>(dynamics_.positions().data(), arm_.size());
  return positions + zero_errors_;
}

geometry::SE3 CameraArm::T_body_camera() const {
  return arm_.T_base_camera(joints());
}

geometry::Vector6d CameraArm::camera_velocity() const {
  const JointVector rates =
      Eigen::Map<const Eigen::VectorXd>(dynamics_.rates().data(), arm_.size());
  return arm_.camera_jacobian(joints()) * rates;
}

geometry::SE3 CameraArm::T_body_camera_shown() const {
  std::vector<double> shown(names_.size());
  dynamics_.encoders(shown);
  return arm_.T_base_camera(Eigen::Map<const Eigen::VectorXd>(shown.data(), arm_.size()));
}

std::optional<simulation::PipeView> CameraArm::view(const simulation::BodyMotion& body) const {
  return simulation::view_pipe(pipe_, camera_, body.T_map_body * T_body_camera());
}

void CameraArm::take_image(const simulation::BodyMotion& body, double moved) {
  const auto seen = blind_ ? std::nullopt : view(body);
  sections_.push(body.time, tracker_.measure(seen, camera_.parameters(), body.time, moved));
}

void CameraArm::take_section(const manipulation::PipeSection& section, double now) {
  sections_.push(now, section);
}

void CameraArm::cycle(const simulation::BodyMotion& body, bool counts) {
  const double now = body.time;
  // What the encoders showed a cycle ago: joint states take that long.
  controller_.observe({.time = shown_time_, .names = names_, .positions = shown_}, now);
  dynamics_.encoders(shown_);
  shown_time_ = now;
  while (const auto section = sections_.pop(now)) {
    controller_.observe(*section, now);
  }
  if (!fixed_) {
    const auto command = controller_.step(now, manipulation::ArmRequest::kTrack);
    if (command.commanded) {
      dynamics_.command({command.position.data(), names_.size()},
                        {command.velocity.data(), names_.size()}, controller_.parameters().period);
      check(command);
    }
    command_ = command;
  }
  if (counts) {
    look(body);
  }
}

void CameraArm::check(const manipulation::ArmCommand& command) {
  const auto& parameters = controller_.parameters();
  const auto& joints = arm_.joints();
  bool within = true;
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    const double rate = std::abs(command.velocity[k]) / joints[i].velocity;
    const double acceleration = std::abs(command.velocity[k] - last_velocity_[k]) /
                                (parameters.period * parameters.largest_acceleration);
    score_.largest_rate_share = std::max(score_.largest_rate_share, rate);
    score_.largest_acceleration_share = std::max(score_.largest_acceleration_share, acceleration);
    within = within && rate <= 1 + kRounding && acceleration <= 1 + kRounding &&
             command.position[k] >= joints[i].lower && command.position[k] <= joints[i].upper;
  }
  const auto clearance = arm_.clearance(command.position, parameters.ground);
  const double least = std::min(clearance.self, clearance.plane);
  score_.least_clearance = std::min(score_.least_clearance, least);
  within = within && least >= parameters.least_clearance;
  score_.limit_violations += within ? 0 : 1;
  last_velocity_ = command.velocity;
}

void CameraArm::look(const simulation::BodyMotion& body) {
  ++score_.samples;
  moving_ += command_.commanded && command_.velocity.cwiseAbs().maxCoeff() > kMoving ? 1 : 0;
  score_.moving_percent = 100 * static_cast<double>(moving_) / static_cast<double>(score_.samples);
  const auto seen = view(body);
  if (!seen) {
    // As far off as can be told.
    const double half = camera_.parameters().height / 2.0;
    score_.centre_square += half * half;
    score_.largest_centre = std::max(score_.largest_centre, half);
    return;
  }
  const Vector2d along = seen->to - seen->from;
  const Vector2d middle = (seen->to + seen->from) / 2;
  const double centre = middle.y() - camera_.parameters().centre_v;
  const double angle = std::atan(along.y() / along.x());
  score_.whole += seen->whole_width ? 1 : 0;
  score_.centre_square += centre * centre;
  score_.angle_square += angle * angle;
  score_.largest_centre = std::max(score_.largest_centre, std::abs(centre));
}

}  // namespace pipescout::arm_study::internal
