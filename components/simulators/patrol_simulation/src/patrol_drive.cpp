// SPDX-License-Identifier: Apache-2.0
#include "pipescout/patrol_simulation/patrol_drive.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "pipescout/validation/check.hpp"

namespace pipescout {
namespace {

using simulation::GroundRobot;

std::int64_t steps_of(double seconds) {
  return std::max<std::int64_t>(1, std::llround(seconds / GroundRobot::kStep));
}

const PatrolDriveParameters& checked(const PatrolDriveParameters& parameters) {
  parameters.validate();
  return parameters;
}

simulation::ImuParameters sampled(const PatrolDriveParameters& parameters) {
  simulation::ImuParameters imu = parameters.imu;
  imu.period = static_cast<double>(steps_of(imu.period)) * GroundRobot::kStep;
  return imu;
}

}  // namespace

void PatrolDriveParameters::validate() const {
  patrol.validate();
  imu.validate();
  gps.validate();
  validation::check_within("standing", standing, 0, 1000);
  if (plant) {
    plant->validate();
  }
  validation::check_within("odometer_period", odometer_period, GroundRobot::kStep, 10);
}

PatrolDrive::PatrolDrive(const PatrolDriveParameters& parameters)
    : parameters_(checked(parameters)),
      patrol_(parameters.patrol),
      imu_(sampled(parameters), parameters.seed),
      gps_(parameters.gps, parameters.seed),
      steps_per_imu_sample_(steps_of(parameters.imu.period)),
      steps_per_odometer_sample_(steps_of(parameters.odometer_period)) {
  static_assert(simulation::ArmDynamics::kStep == GroundRobot::kStep);
  if (parameters_.arm) {
    arm_.emplace(parameters_.arm->urdf, parameters_.arm->base_link, parameters_.arm->camera_link);
    simulation::ArmDynamicsParameters dynamics = parameters_.arm->dynamics;
    for (const manipulation::ArmJoint& joint : arm_->joints()) {
      dynamics.lower.push_back(joint.lower);
      dynamics.upper.push_back(joint.upper);
      dynamics.largest_rate.push_back(joint.velocity);
    }
    arm_dynamics_.emplace(dynamics, parameters_.arm->start);
    move_camera();
  }
  if (parameters_.plant) {
    plant_.emplace(*parameters_.plant);
  }
  measure();
}

void PatrolDrive::move_camera() {
  const auto as_vector = [](const std::vector<double>& values) {
    return manipulation::JointVector(
        Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size())));
  };
  const manipulation::JointVector q = as_vector(arm_dynamics_->positions());
  patrol_.move_camera(arm_->T_base_camera(q),
                      arm_->camera_jacobian(q) * as_vector(arm_dynamics_->rates()));
}

void PatrolDrive::command_arm(std::span<const double> positions, std::span<const double> rates,
                              double time_from_start) {
  if (arm_dynamics_) {
    arm_dynamics_->command(positions, rates, time_from_start);
  }
}

bool PatrolDrive::beside_row() const {
  constexpr double kLeftwards = 0.9;  // cosine of what counts as along the row
  const geometry::SE3& T_map_body = motion().T_map_body;
  const Eigen::Vector3d left = T_map_body.rotation() * Eigen::Vector3d::UnitY();
  for (const simulation::ThermalScene& row : patrol_.rows()) {
    const geometry::SE3 T_row_map = row.parameters().T_map_row.inverse();
    const double place = (T_row_map * T_map_body.translation()).x();
    if (row.faces(T_map_body.translation()) && (T_row_map.rotation() * left).y() > kLeftwards &&
        place >= 0 && place <= row.parameters().length) {
      return true;
    }
  }
  return false;
}

std::optional<simulation::PipeView> PatrolDrive::tube_in_view() const {
  const simulation::ThermalScene& scene = patrol_.rows()[patrol_.row_in_view()];
  if (!scene.faces(patrol_.view(0).T_map_camera.translation())) {
    return std::nullopt;
  }
  return simulation::view_pipe({.from = scene.on_tube(0),
                                .to = scene.on_tube(scene.parameters().length),
                                .radius = scene.parameters().tube_radius},
                               patrol_.renderer().camera(), patrol_.view(0).T_map_camera);
}

void PatrolDrive::drive_until(double time) {
  const std::int64_t wanted = std::llround(time / GroundRobot::kStep);
  while (steps_ < wanted) {
    if (plant_) {
      drive_by_twists();
    } else if (static_cast<double>(steps_) * GroundRobot::kStep < parameters_.standing) {
      patrol_.stand();
    } else {
      patrol_.step();
    }
    if (arm_dynamics_) {
      arm_dynamics_->step();
    }
    ++steps_;
    measure();
  }
  if (arm_dynamics_) {
    move_camera();
  }
}

void PatrolDrive::drive_by_twists() {
  constexpr int kMilliseconds = 2;
  static_assert(GroundRobot::kStep == kMilliseconds * simulation::AckermannVehicle::kStep);
  const simulation::AckermannState& wheels = plant_->drive(kMilliseconds);
  patrol_.step({.speed = wheels.speed, .yaw_rate = wheels.yaw_rate});
  const Eigen::Vector3d& place = motion().T_map_body.translation();
  plant_->move_to({place.x(), place.y(), patrol_.robot().yaw()}, GroundRobot::kStep);
}

void PatrolDrive::measure() {
  const simulation::BodyMotion& body = motion();
  if (steps_ % steps_per_imu_sample_ == 0) {
    imu_samples_.push_back({.time = body.time,
                            .reading = imu_.measure({.angular_rate = body.angular_rate,
                                                     .specific_force = body.specific_force()})});
  }
  if (steps_ % steps_per_odometer_sample_ == 0) {
    odometer_samples_.push_back({.time = body.time, .distances = patrol_.robot().odometers()});
  }
  // A fix is of the step that is nearest to its time.
  while (gps_.due() < body.time + GroundRobot::kStep / 2) {
    if (const auto fix = gps_.measure(body.T_map_body)) {
      fixes_.push_back(*fix);
    }
  }
}

std::vector<PatrolDrive::ImuSample> PatrolDrive::take_imu_samples() {
  return std::exchange(imu_samples_, {});
}

std::vector<PatrolDrive::OdometerSample> PatrolDrive::take_odometer_samples() {
  return std::exchange(odometer_samples_, {});
}

std::vector<simulation::GpsFix> PatrolDrive::take_fixes() {
  const double now = motion().time;
  const auto late =
      std::stable_partition(fixes_.begin(), fixes_.end(),
                            [now](const simulation::GpsFix& fix) { return fix.arrival <= now; });
  std::vector<simulation::GpsFix> arrived(fixes_.begin(), late);
  fixes_.erase(fixes_.begin(), late);
  std::ranges::stable_sort(arrived, {}, &simulation::GpsFix::arrival);
  return arrived;
}

}  // namespace pipescout
