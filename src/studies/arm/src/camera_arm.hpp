// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "drive_sensors.hpp"
#include "pipescout/arm_study/arm_drive.hpp"

namespace pipescout::arm_study::internal {

/// One arm on the robot, its camera, its tracker and its controller.
class CameraArm {
 public:
  CameraArm(const ArmRule& rule, const DriveSettings& settings, const geometry::Camera& camera,
            const simulation::StraightPipe& pipe, std::uint64_t seed);

  void observe(const manipulation::VehicleMotion& motion, double now);
  void take_image(const simulation::BodyMotion& body, double moved);
  /// What another tracker says, just now.
  void take_section(const manipulation::PipeSection& section, double now);
  /// A cycle of the controller. `counts`: for the score.
  void cycle(const simulation::BodyMotion& body, bool counts);
  void step() { dynamics_.step(); }
  [[nodiscard]] const DriveScore& score() const { return score_; }

  /// From now on the tracker sees no pipe.
  void blind() { blind_ = true; }
  /// The pipe is somewhere else.
  void move_pipe(const Eigen::Vector3d& by);
  /// The true place of the camera on the body, and its velocity against it in its own axes.
  [[nodiscard]] geometry::SE3 T_body_camera() const;
  [[nodiscard]] geometry::Vector6d camera_velocity() const;
  /// Where encoders show it to be.
  [[nodiscard]] geometry::SE3 T_body_camera_shown() const;
  /// Of the last cycle.
  [[nodiscard]] const manipulation::ArmCommand& command() const { return command_; }

 private:
  [[nodiscard]] manipulation::JointVector joints() const;  ///< the true ones
  [[nodiscard]] std::optional<simulation::PipeView> view(const simulation::BodyMotion& body) const;
  void check(const manipulation::ArmCommand& command);
  void look(const simulation::BodyMotion& body);

  bool fixed_;
  bool blind_ = false;
  simulation::StraightPipe pipe_;
  geometry::Camera camera_;
  manipulation::ArmModel arm_;  ///< the true one
  manipulation::JointVector zero_errors_;
  manipulation::ArmController controller_;
  simulation::ArmDynamics dynamics_;
  TrackSensor tracker_;
  Delayed<manipulation::PipeSection> sections_;
  std::vector<std::string> names_;
  std::vector<double> shown_;
  double shown_time_ = 0;
  manipulation::JointVector last_velocity_;
  std::size_t moving_ = 0;
  manipulation::ArmCommand command_;
  DriveScore score_;
};

}  // namespace pipescout::arm_study::internal
