// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "pipescout/simulation/ground_robot.hpp"
#include "pipescout/simulation/terrain.hpp"
#include "pipescout/simulation/thermal_camera.hpp"

/// A ground robot that drives along rows of collectors over rough ground and views them with a
/// thermal camera: Ibarguren and others (2013), section 7. Frames as in thermal_scene.hpp; `body`
/// is that of ground_robot.hpp.
namespace pipescout::simulation {

/// Of a camera that looks to the left of a robot, `elevation` rad above its plane. The upper border
/// of the image is up, columns go forward.
[[nodiscard]] geometry::SE3 T_body_side_camera(const Eigen::Vector3d& position, double elevation);

struct ThermalPatrolParameters {
  ThermalSceneParameters scene{};
  /// Other rows. An image shows one: the nearest that the camera looks towards.
  std::vector<ThermalSceneParameters> further_rows{};
  ThermalCameraParameters camera = ThermalCameraParameters::qvga();
  GroundRobotParameters robot{.wheel_base = 1.6, .track = 1.2};
  TerrainParameters terrain{};
  double speed = 5.5;    ///< m/s, [0.1, 20]
  double distance = 10;  ///< m, [1, 100]: horizontal distance of the robot's path from the tube
  double begin = -14;    ///< m, [-1000, 1000]: start along the row, at rest
  double end = 165;      ///< m, (begin, 10000]: end along the row
  /// m, m, rad, in the map: where it stands at first; nothing: at `begin`
  std::optional<Eigen::Vector3d> start{};
  geometry::SE3 T_body_camera = T_body_side_camera({0.2, 0.2, 1.2}, 0.145);
  std::uint64_t seed = 1;  ///< of the ground and the wheels

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

/// The same parameters give the same bits. Not thread-safe.
class ThermalPatrol {
 public:
  /// Throws as the `validate` of its parameters.
  explicit ThermalPatrol(const ThermalPatrolParameters& parameters);

  /// Steers towards the end of its path; a step of `GroundRobot::kStep`.
  void step();
  /// The same, but it does as it is told.
  void step(const GroundRobotCommand& command);
  /// The same, but it stands or comes to a stop.
  void stand();
  /// To the nearest step; nothing for a time that has passed. Seconds.
  void drive_until(double time);
  [[nodiscard]] bool arrived() const noexcept { return course_.arrived(); }
  /// For a camera that moves on the body: its current pose, and its velocity relative to the body
  /// in the camera frame, [linear m/s; angular rad/s].
  void move_camera(const geometry::SE3& T_body_camera, const geometry::Vector6d& velocity);

  [[nodiscard]] const GroundRobot& robot() const noexcept { return robot_; }
  /// The current view of the camera.
  [[nodiscard]] ThermalView view(std::uint64_t frame) const;
  /// m, along the first row.
  [[nodiscard]] double place() const;
  /// Throws as ThermalRenderer::render.
  void render(std::uint64_t frame, std::span<std::uint16_t> counts) {
    renderers_[row_in_view()].render(view(frame), counts);
  }
  /// Of the first row; camera and radiometry are those of all.
  [[nodiscard]] const ThermalRenderer& renderer() const noexcept { return renderers_.front(); }
  [[nodiscard]] const ThermalScene& scene() const noexcept { return scenes_.front(); }
  /// The first and the further ones.
  [[nodiscard]] const std::vector<ThermalScene>& rows() const noexcept { return scenes_; }
  /// Which of them is in the image.
  [[nodiscard]] std::size_t row_in_view() const;

 private:
  ThermalPatrolParameters parameters_;
  std::vector<ThermalScene> scenes_;
  std::vector<ThermalRenderer> renderers_;
  GroundRobot robot_;
  CourseController course_;
  geometry::Vector6d camera_velocity_ = geometry::Vector6d::Zero();
  std::uint64_t steps_ = 0;
};

}  // namespace pipescout::simulation
