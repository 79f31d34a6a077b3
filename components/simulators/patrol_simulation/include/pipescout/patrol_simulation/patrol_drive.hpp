// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <pipescout/manipulation/arm_model.hpp>
#include <pipescout/plant_world/plant_drive.hpp>
#include <pipescout/simulation/arm_dynamics.hpp>
#include <pipescout/simulation/gps_receiver.hpp>
#include <pipescout/simulation/imu_sensor.hpp>
#include <pipescout/simulation/pipe_view.hpp>
#include <pipescout/simulation/thermal_patrol.hpp>
#include <span>
#include <string>
#include <vector>

namespace pipescout {

/// An arm on the robot that carries the camera.
struct PatrolArmParameters {
  std::string urdf{};                            ///< text of its robot description
  std::string base_link{};                       ///< the body of the robot
  std::string camera_link{};                     ///< optical frame of the camera
  std::vector<double> start{};                   ///< rad, one per joint
  simulation::ArmDynamicsParameters dynamics{};  ///< but for the limits, which are the arm's
};

struct PatrolDriveParameters {
  simulation::ThermalPatrolParameters patrol{};
  double standing = 5;  ///< s, [0, 1000]: before it drives, so that an estimator can begin
  /// At the origin of the body, with its axes; its period is rounded to steps of the robot.
  simulation::ImuParameters imu = simulation::ImuParameters::industrial();
  simulation::GpsParameters gps{};
  double odometer_period = 0.02;             ///< s, [0.002, 10]: rounded likewise
  std::optional<PatrolArmParameters> arm{};  ///< none: the camera is fixed to the body
  /// It is driven by twists through this plant, from its start; none: by itself along its row.
  std::optional<simulation::PlantDriveParameters> plant{};
  std::uint64_t seed = 1;  ///< of the sensors

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

/// A robot on patrol, and what its sensors say. Pure; the same parameters give the same bits. Not
/// thread-safe.
class PatrolDrive {
 public:
  /// Throws as PatrolDriveParameters::validate, ArmModel and ArmDynamics.
  explicit PatrolDrive(const PatrolDriveParameters& parameters);

  struct ImuSample {
    double time = 0;
    simulation::ImuReading reading{};
  };
  struct OdometerSample {
    double time = 0;
    std::array<double, simulation::kWheels> distances{};  ///< m
  };

  /// Drives on to a time, s from the start, to the nearest step; nothing for one that has passed.
  void drive_until(double time);
  /// What the sensors have said since the last call: by time; fixes of GPS by their arrival, those
  /// that have arrived.
  [[nodiscard]] std::vector<ImuSample> take_imu_samples();
  [[nodiscard]] std::vector<OdometerSample> take_odometer_samples();
  [[nodiscard]] std::vector<simulation::GpsFix> take_fixes();

  /// The next point of the arm's trajectory, as ArmDynamics::command; nothing without an arm.
  void command_arm(std::span<const double> positions, std::span<const double> rates,
                   double time_from_start);
  /// Null without an arm.
  [[nodiscard]] const manipulation::ArmModel* arm() const noexcept {
    return arm_ ? &*arm_ : nullptr;
  }
  /// Null without an arm.
  [[nodiscard]] const simulation::ArmDynamics* arm_dynamics() const noexcept {
    return arm_dynamics_ ? &*arm_dynamics_ : nullptr;
  }
  /// Null without a plant.
  [[nodiscard]] simulation::PlantDrive* plant() noexcept { return plant_ ? &*plant_ : nullptr; }
  [[nodiscard]] const simulation::PlantDrive* plant() const noexcept {
    return plant_ ? &*plant_ : nullptr;
  }
  /// The robot has the tube of a row on its left, as a camera that inspects it needs.
  [[nodiscard]] bool beside_row() const;
  /// What the camera sees of the tube now; nothing when it is not in view.
  [[nodiscard]] std::optional<simulation::PipeView> tube_in_view() const;

  [[nodiscard]] const simulation::BodyMotion& motion() const noexcept {
    return patrol_.robot().motion();
  }
  /// At the end of its way, after the camera has passed the tube; never in a plant.
  [[nodiscard]] bool arrived() const noexcept { return patrol_.arrived() && !plant_; }
  [[nodiscard]] simulation::ThermalPatrol& patrol() noexcept { return patrol_; }
  [[nodiscard]] const simulation::ThermalPatrol& patrol() const noexcept { return patrol_; }

 private:
  void measure();
  void move_camera();
  void drive_by_twists();

  PatrolDriveParameters parameters_;
  simulation::ThermalPatrol patrol_;
  std::optional<manipulation::ArmModel> arm_;
  std::optional<simulation::ArmDynamics> arm_dynamics_;
  std::optional<simulation::PlantDrive> plant_;
  simulation::ImuSensor imu_;
  simulation::GpsReceiver gps_;
  std::int64_t steps_ = 0;
  std::int64_t steps_per_imu_sample_;
  std::int64_t steps_per_odometer_sample_;
  std::vector<ImuSample> imu_samples_;
  std::vector<OdometerSample> odometer_samples_;
  std::vector<simulation::GpsFix> fixes_;  // on their way
};

}  // namespace pipescout
