// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "pipescout/geometry/geodesy.hpp"
#include "pipescout/patrol_simulation/patrol_drive.hpp"
#include "pipescout/patrol_simulation/plant_parameters.hpp"
#include "pipescout/runtime/parameters.hpp"

namespace pipescout {

/// Parameters of the component that make the patrol; those of the run are its own.
class PatrolParameters {
 public:
  /// Declares them.
  explicit PatrolParameters(Parameters& parameters);

  /// Throws std::invalid_argument naming the parameter.
  [[nodiscard]] PatrolDriveParameters drive() const;
  [[nodiscard]] geometry::GeodeticPosition datum() const;
  [[nodiscard]] double image_rate() const { return image_rate_.get(); }
  /// Whether images are of 8 bits, from `grey_range`; otherwise of counts.
  [[nodiscard]] bool grey() const;
  /// Of joint_states and of the answers to them, Hz.
  [[nodiscard]] double arm_rate() const { return arm_rate_.get(); }
  [[nodiscard]] double standing() const { return standing_.get(); }  ///< s
  [[nodiscard]] const PlantParameters& plant() const { return plant_; }
  /// Degrees Celsius, of black and of white.
  [[nodiscard]] std::vector<double> grey_range() const;

 private:
  void declare_row(Parameters& parameters);
  void declare_robot(Parameters& parameters);
  void declare_camera(Parameters& parameters);
  void declare_arm(Parameters& parameters);
  [[nodiscard]] std::optional<PatrolArmParameters> arm() const;
  void add_decoys(simulation::ThermalSceneParameters& scene) const;
  [[nodiscard]] std::vector<simulation::ThermalLeak> leaks() const;

  PlantParameters plant_;
  Parameter<std::int64_t> seed_;
  Parameter<std::vector<double>> row_position_;
  Parameter<double> row_yaw_;
  Parameter<double> length_;
  Parameter<double> tube_height_;
  Parameter<double> tube_temperature_;
  Parameter<std::vector<double>> leaks_;
  Parameter<std::vector<double>> bright_joints_;
  Parameter<std::vector<double>> reflections_;
  Parameter<std::vector<double>> warm_supports_;
  Parameter<std::vector<double>> sun_glints_;
  Parameter<std::vector<double>> hot_bodies_;
  Parameter<std::string> terrain_;
  Parameter<double> speed_;
  Parameter<double> distance_;
  Parameter<double> standing_;
  Parameter<std::string> imu_;
  Parameter<double> imu_rate_;
  Parameter<double> gps_rate_;
  Parameter<double> gps_deviation_;
  Parameter<std::vector<double>> datum_;
  Parameter<double> image_rate_;
  Parameter<std::string> encoding_;
  Parameter<std::vector<double>> grey_range_;
  Parameter<int> width_;
  Parameter<int> height_;
  Parameter<double> focal_length_;
  Parameter<std::vector<double>> camera_position_;
  Parameter<std::vector<double>> camera_roll_pitch_yaw_;
  Parameter<double> netd_;
  Parameter<double> exposure_;
  Parameter<double> dead_share_;
  Parameter<bool> arm_mounted_;
  Parameter<std::string> arm_urdf_file_;
  Parameter<std::string> arm_camera_frame_;
  Parameter<std::vector<double>> arm_start_;
  Parameter<double> arm_rate_;
  Parameter<double> arm_delay_;
  Parameter<double> arm_acceleration_;
};

}  // namespace pipescout
