// SPDX-License-Identifier: Apache-2.0
#include "pipescout/simulation/thermal_patrol.hpp"

#include <cmath>
#include <limits>

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

std::vector<ThermalScene> scenes_of(const ThermalPatrolParameters& p) {
  std::vector<ThermalScene> scenes{ThermalScene(p.scene)};
  for (const ThermalSceneParameters& row : p.further_rows) {
    scenes.emplace_back(row);
  }
  return scenes;
}

std::vector<ThermalRenderer> renderers_of(const std::vector<ThermalScene>& scenes,
                                          const ThermalCameraParameters& camera) {
  std::vector<ThermalRenderer> renderers;
  for (const ThermalScene& scene : scenes) {
    renderers.emplace_back(scene, camera);
  }
  return renderers;
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
  for (const ThermalSceneParameters& row : further_rows) {
    row.validate();
  }
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
      scenes_(scenes_of(parameters)),
      renderers_(renderers_of(scenes_, parameters.camera)),
      robot_(parameters.robot, Terrain(parameters.terrain, parameters.seed),
             parameters.start ? Vector2d(parameters.start->head<2>())
                              : on_way(parameters, parameters.begin),
             parameters.start ? parameters.start->z() : heading(parameters), parameters.seed),
      course_({.speed = parameters.speed, .slowest = std::min(1.0, parameters.speed)},
              {on_way(parameters, parameters.end)}) {}

void ThermalPatrol::step() {
  step(course_.steer(robot_));
}

void ThermalPatrol::step(const GroundRobotCommand& command) {
  robot_.command(command);
  robot_.step();
  ++steps_;
}

void ThermalPatrol::stand() {
  step({});
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

std::size_t ThermalPatrol::row_in_view() const {
  const geometry::SE3 T_map_camera = view(0).T_map_camera;
  const Vector3d forward = T_map_camera.rotation() * Vector3d::UnitZ();
  std::size_t result = 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < scenes_.size(); ++i) {
    const geometry::SE3 T_row_map = scenes_[i].parameters().T_map_row.inverse();
    const double across = (T_row_map * T_map_camera.translation()).y();
    const bool looks = across * (T_row_map.rotation() * forward).y() < 0;
    if (looks && std::abs(across) < least) {
      least = std::abs(across);
      result = i;
    }
  }
  return result;
}

double ThermalPatrol::place() const {
  return (parameters_.scene.T_map_row.inverse() * robot_.motion().T_map_body.translation()).x();
}

}  // namespace pipescout::simulation
