// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <nav_msgs/msg/odometry.hpp>
#include <optional>
#include <pipescout/geometry/geodesy.hpp>
#include <pipescout_msgs/msg/leak_event.hpp>
#include <pipescout_msgs/msg/odometer_readings.hpp>
#include <rosgraph_msgs/msg/clock.hpp>
#include <sensor_msgs/msg/camera_info.hpp>
#include <sensor_msgs/msg/image.hpp>
#include <sensor_msgs/msg/imu.hpp>
#include <sensor_msgs/msg/nav_sat_fix.hpp>
#include <vector>

#include "pipescout/interfaces/component.hpp"
#include "pipescout/patrol_simulation/patrol_drive.hpp"
#include "pipescout/patrol_simulation/patrol_parameters.hpp"

namespace pipescout {

/// Stands in for a ground robot that patrols along a row of collectors at night, and for its
/// drivers: publishes `thermal/image_raw`, `thermal/camera_info`, `imu/data`, `gps/fix`,
/// `odometer/readings`, the truth on `ground_truth/odometry`, `ground_truth/leaks`, and the time of
/// all that on `/clock`, for nodes with `use_sim_time`.
///
/// Parameters: docs/components/patrol_simulation.md. They take effect when it is configured.
class PatrolSimulation final : public Component {
 public:
  explicit PatrolSimulation(ComponentOptions options);
  ~PatrolSimulation() override;

 protected:
  CallbackReturn on_configure() override;
  CallbackReturn on_activate() override;
  CallbackReturn on_deactivate() override;
  CallbackReturn on_cleanup() override;

 private:
  using Image = sensor_msgs::msg::Image;
  using CameraInfo = sensor_msgs::msg::CameraInfo;
  using Imu = sensor_msgs::msg::Imu;
  using Fix = sensor_msgs::msg::NavSatFix;
  using Odometry = nav_msgs::msg::Odometry;
  using Readings = pipescout_msgs::msg::OdometerReadings;
  using Clock = rosgraph_msgs::msg::Clock;

  void start_if_heard();
  void schedule();
  /// Drives on to the next image and publishes it, with what the other sensors have said.
  void next_image();
  void publish_imu();
  void publish_odometers();
  void publish_fixes();
  void publish_true_leaks();
  void publish_true_odometry(Time stamp);
  void publish_image(Time stamp);

  PatrolParameters patrol_parameters_;
  Parameter<double> rate_;
  Parameter<int> wait_for_subscribers_;

  // As configured.
  double image_period_ = 0;  // s, simulated
  Duration real_period_{};
  std::size_t wanted_subscribers_ = 0;
  bool grey_ = false;
  std::uint64_t expected_images_ = 1;

  std::optional<PatrolDrive> drive_;
  std::optional<simulation::ThermalGreys> greys_;
  std::optional<geometry::LocalFrame> frame_;
  std::vector<std::uint16_t> counts_;
  std::uint64_t images_ = 0;
  bool active_ = false;
  bool complete_ = false;
  SteadyTime next_image_not_before_{};  // of real time

  Publisher<Image> image_publisher_;
  Publisher<CameraInfo> camera_info_publisher_;
  Publisher<Imu> imu_publisher_;
  Publisher<Fix> fix_publisher_;
  Publisher<Readings> readings_publisher_;
  Publisher<pipescout_msgs::msg::LeakEvent> true_leaks_publisher_;
  Publisher<Odometry> true_odometry_publisher_;
  Publisher<Clock> clock_publisher_;
  std::shared_ptr<Timer> timer_;  // for one event
};

}  // namespace pipescout
