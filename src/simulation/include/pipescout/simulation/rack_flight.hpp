// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>
#include "pipescout/geometry/camera.hpp"
#include "pipescout/geometry/se3.hpp"
#include "pipescout/simulation/dryden_wind.hpp"
#include "pipescout/simulation/imu_sensor.hpp"
#include "pipescout/simulation/rack_image.hpp"
#include "pipescout/simulation/rack_image_light.hpp"
#include "pipescout/simulation/rack_thermal.hpp"
#include "pipescout/simulation/uav.hpp"

namespace pipescout::simulation {

/// A thermal camera beside the other one, and what it has to see.
struct RackThermalParameters {
  geometry::CameraParameters camera{};
  RackThermalSensor sensor{};
  geometry::SE3 T_base_camera{};
  std::vector<HotSpot> hot_spots{};
  std::vector<WarmGround> warm_ground{};
};

struct RackFlightParameters {
  RackScene scene{};  ///< its seed is `seed`
  geometry::CameraParameters camera{};
  ImageSensor sensor{};
  RackLightParameters light{};
  DrydenWindParameters wind{};  ///< its period is ten steps of the UAV
  UavParameters uav{};
  /// At the origin of base_link, with its axes; its period is rounded to steps of the UAV. Nothing:
  /// there is none.
  std::optional<ImuParameters> imu{};
  geometry::SE3 T_base_camera{};
  std::optional<RackThermalParameters> thermal{};  ///< over the model of `scene`; nothing: none
  Eigen::Vector3d start_position = Eigen::Vector3d::Zero();  ///< m, of the UAV in the rack frame
  double start_yaw = 0.0;                                    ///< rad
  std::uint64_t seed = 1;
};

/// A UAV in gusts over a rack, and what its camera sees. Pure; the same parameters and commands
/// give the same bits. Not thread-safe.
class RackFlight {
 public:
  /// Throws std::invalid_argument naming the field when a parameter is out of range.
  explicit RackFlight(const RackFlightParameters& parameters);

  /// From now on.
  void command(const UavCommand& command) { uav_.command(command); }
  /// Flies on to a time, s from the start, to the nearest step of 1 ms; nothing for one that has
  /// passed.
  void fly_until(double time);
  struct ImuSample {
    double time = 0;  ///< s from the start
    ImuReading reading{};
  };
  /// What the IMU has shown since the last call, in the order of time.
  [[nodiscard]] std::vector<ImuSample> take_imu_samples();
  /// The image that is exposed about now, number `frame`: width * height bytes, by rows. Throws
  /// std::invalid_argument when `grey` has another size.
  void render(std::uint64_t frame, std::span<std::uint8_t> grey);
  /// The same of the thermal camera, counts as in rack_thermal.hpp. It must be there.
  void render_thermal(std::uint64_t frame, std::span<std::uint16_t> counts);

  [[nodiscard]] geometry::SE3 T_rack_camera() const;
  /// Of the camera against the rack, in its own frame: [linear m/s; angular rad/s].
  [[nodiscard]] geometry::Vector6d camera_velocity() const;
  [[nodiscard]] const UavState& uav() const noexcept { return uav_.state(); }
  [[nodiscard]] std::size_t bad_commands() const noexcept { return uav_.bad_commands(); }

 private:
  geometry::SE3 T_base_camera_;
  DrydenWind wind_;
  Uav uav_;
  ChangingRackLight light_;
  RackImageRenderer renderer_;
  geometry::SE3 T_base_thermal_;
  std::optional<RackThermalRenderer> thermal_;
  WindSample gust_;
  std::optional<ImuSensor> imu_;
  std::uint64_t steps_per_sample_ = 1;
  std::vector<ImuSample> imu_samples_;
  std::uint64_t steps_ = 0;
};

}  // namespace pipescout::simulation
