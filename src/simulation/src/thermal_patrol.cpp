// SPDX-License-Identifier: Apache-2.0
#include "pipescout/simulation/thermal_patrol.hpp"

#include <cmath>

#include "pipescout/validation/check.hpp"

namespace pipescout::simulation {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

const ThermalPatrolParameters& checked(const ThermalPatrolParameters& parameters) {
  parameters.validate();
  return parameters;
}

Vector2d on_way(const ThermalPatrolParameters& p, double place) {
  return (p.scene.T_map_row * Vector3d(place, -p.distance, 0)).head<2>();
}

double heading(const ThermalPatrolParameters& p) {
  const Vector3d along = p.scene.T_map_row.rotation() * Vector3d::UnitX();
  return std::atan2(along.y(), along.x());
}

}  // namespace

geometry::SE3 T_body_side_camera(const Vector3d& position, double elevation) {
  Eigen::Matrix3d level;  // columns: the camera's axes, right, down and forward
  level << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  return {geometry::SO3::from_matrix(level) * geometry::SO3::exp(Vector3d(elevation, 0, 0)),
          position};
}

void ThermalPatrolParameters::validate() const {
  scene.validate();
  camera.validate();
  robot.validate();
  terrain.validate();
  validation::check_within("speed", speed, 0.1, 20);
  validation::check_within("distance", distance, 1, 100);
  validation::check_within("begin", begin, -1000, 1000);
  validation::check_above("end", end, begin, 10000);
}

ThermalPatrol::ThermalPatrol(const ThermalPatrolParameters& parameters)
    : parameters_(checked(parameters)),
      scene_(parameters.scene),
      renderer_(scene_, parameters.camera),
      robot_(parameters.robot, Terrain(parameters.terrain, parameters.seed),
             on_way(parameters, parameters.begin), heading(parameters), parameters.seed),
      course_({.speed = parameters.speed, .slowest = std::min(1.0, parameters.speed)},
              {on_way(parameters, parameters.end)}) {}

void ThermalPatrol::step() {
  robot_.command(course_.steer(robot_));
  robot_.step();
  ++steps_;
}

void ThermalPatrol::stand() {
  robot_.command({});
  robot_.step();
  ++steps_;
}

void ThermalPatrol::drive_until(double time) {
  const auto wanted = std::llround(time / GroundRobot::kStep);
  while (static_cast<long long>(steps_) < wanted) {
    step();
  }
}

void ThermalPatrol::move_camera(const geometry::SE3& T_body_camera,
                                const geometry::Vector6d& velocity) {
  parameters_.T_body_camera = T_body_camera;
  camera_velocity_ = velocity;
}

ThermalView ThermalPatrol::view(std::uint64_t frame) const {
  const BodyMotion camera = robot_.motion().of(parameters_.T_body_camera);
  ThermalView result;
  result.T_map_camera = camera.T_map_body;
  result.velocity << camera.T_map_body.rotation().inverse() * camera.velocity, camera.angular_rate;
  result.velocity += camera_velocity_;
  result.frame = frame;
  return result;
}

double ThermalPatrol::place() const {
  return (parameters_.scene.T_map_row.inverse() * robot_.motion().T_map_body.translation()).x();
}

}  // namespace pipescout::simulation
