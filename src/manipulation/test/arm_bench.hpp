// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "pipescout/manipulation/arm_controller.hpp"

namespace pipescout::manipulation::test {

/// A controller with an arm that does what is commanded a period later, on a vehicle that may turn
/// about its x axis, beside an endless level pipe along the map's x at a height.
class ArmBench {
 public:
  explicit ArmBench(const ArmControllerParameters& parameters = {})
      : parameters_(parameters),
        arm_(camera_arm_urdf(), "base_link", "camera_optical_frame"),
        controller_(ArmModel(camera_arm_urdf(), "base_link", "camera_optical_frame"), parameters),
        camera_({.width = 320,
                 .height = 240,
                 .focal_length = 722,
                 .centre_u = 159.5,
                 .centre_v = 119.5}),
        q_(Eigen::Map<const Eigen::VectorXd>(parameters.ready.data(), arm_.size())) {
    controller_.set_camera(camera_);
    for (const ArmJoint& joint : arm_.joints()) {
      names_.push_back(joint.name);
    }
  }

  /// What comes in before a cycle.
  bool joints_come = true;
  bool odometry_comes = true;
  bool track_comes = true;
  TrackState track = TrackState::kLocked;
  double pipe_height = 2.6;  ///< m, above base
  double roll = 0;           ///< rad, of the vehicle
  double roll_rate = 0;      ///< rad/s
  ArmRequest request = ArmRequest::kTrack;

  ArmCommand cycle() {
    now_ += parameters_.period;
    roll += parameters_.period * roll_rate;
    if (joints_come) {
      positions_.assign(q_.begin(), q_.end());
      controller_.observe({.time = now_, .names = names_, .positions = positions_}, now_);
    }
    if (odometry_comes) {
      controller_.observe({.time = now_,
                           .R_map_base = geometry::SO3::about_x(roll).quaternion(),
                           .angular_rate = {roll_rate, 0, 0}},
                          now_);
    }
    if (track_comes && ++cycles_ % 4 == 1) {
      controller_.observe(section(), now_);
    }
    const ArmCommand command = controller_.step(now_, request);
    if (command.commanded) {
      q_ = command.position;
    }
    return command;
  }
  ArmCommand cycles(double time) {
    ArmCommand command;
    for (int i = 0; i < std::lround(time / parameters_.period); ++i) {
      command = cycle();
    }
    return command;
  }

  /// Of the pipe as the camera sees it.
  [[nodiscard]] PipeSection section() {
    const geometry::SE3 T_camera_map =
        (geometry::SE3(geometry::SO3::about_x(roll), Eigen::Vector3d::Zero()) *
         arm_.T_base_camera(q_))
            .inverse();
    const auto pixel = [&](double along) {
      const Eigen::Vector3d p = T_camera_map * Eigen::Vector3d(along, 10, pipe_height);
      return Eigen::Vector2d(camera_.parameters().centre_u + 722 * p.x() / p.z(),
                             camera_.parameters().centre_v + 722 * p.y() / p.z());
    };
    const Eigen::Vector2d from = pixel(-3);
    const Eigen::Vector2d to = pixel(3.5);
    return {.time = now_,
            .state = track,
            .width = 320,
            .height = 240,
            .u = (from.x() + to.x()) / 2,
            .v = (from.y() + to.y()) / 2,
            .length = (to - from).norm(),
            .angle = std::atan2(to.y() - from.y(), to.x() - from.x()),
            .range = 10};
  }

  [[nodiscard]] double now() const { return now_; }
  ArmController& controller() { return controller_; }
  JointVector& posture() { return q_; }

 private:
  ArmControllerParameters parameters_;
  ArmModel arm_;
  ArmController controller_;
  geometry::Camera camera_;
  JointVector q_;
  std::vector<std::string> names_;
  std::vector<double> positions_;
  double now_ = 0;
  int cycles_ = 0;
};

}  // namespace pipescout::manipulation::test
