// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <geometry_msgs/msg/pose_stamped.hpp>
#include <geometry_msgs/msg/twist_stamped.hpp>
#include <memory>
#include <nav_msgs/msg/odometry.hpp>
#include <optional>
#include <pipescout_msgs/msg/leak_event.hpp>
#include <rosgraph_msgs/msg/clock.hpp>
#include <sensor_msgs/msg/camera_info.hpp>
#include <sensor_msgs/msg/image.hpp>
#include <sensor_msgs/msg/imu.hpp>
#include <string>
#include <vector>

#include "pipescout/runtime/component.hpp"
#include "pipescout/runtime/simulation_run.hpp"
#include "pipescout/simulation/rack_flight.hpp"

namespace pipescout {

/// Simulates a UAV over a rack of pipes and replaces its drivers: subscribes to `cmd_vel_stamped`,
/// publishes `camera/image_raw`, `camera/camera_info`, `imu/data`, the truth of the camera on
/// `ground_truth/rack_pose` and of the UAV on `ground_truth/odometry`, and the time of all that on
/// `/clock`, for nodes with `use_sim_time`. With a thermal camera also `thermal/image_raw`,
/// `thermal/camera_info`, and the true hot spots on `ground_truth/leaks`.
///
/// Parameters: docs/components/rack_simulation.md. They take effect when it is configured.
class RackSimulation final : public Component {
 public:
  explicit RackSimulation(ComponentOptions options);
  ~RackSimulation() override;

 protected:
  CallbackReturn on_configure() override;
  CallbackReturn on_activate() override;
  CallbackReturn on_deactivate() override;
  CallbackReturn on_cleanup() override;

 private:
  using Image = sensor_msgs::msg::Image;
  using CameraInfo = sensor_msgs::msg::CameraInfo;
  using Imu = sensor_msgs::msg::Imu;
  using Odometry = nav_msgs::msg::Odometry;
  using Pose = geometry_msgs::msg::PoseStamped;
  using Twist = geometry_msgs::msg::TwistStamped;
  using Clock = rosgraph_msgs::msg::Clock;
  using LeakEvent = pipescout_msgs::msg::LeakEvent;

  void declare_run_parameters();
  void declare_flight_parameters();
  void declare_imu_parameters();
  void declare_camera_parameters();
  void declare_thermal_parameters();
  /// Throws std::invalid_argument naming the parameter, YamlError for the rack file.
  [[nodiscard]] simulation::RackFlightParameters flight_parameters() const;
  /// Nothing without a thermal camera. Throws std::invalid_argument naming the parameter.
  [[nodiscard]] std::optional<simulation::RackThermalParameters> thermal_parameters() const;

  /// Flies on to the next image and publishes it. False: it was the last.
  bool next_image();
  void publish_image(Time stamp);
  void publish_imu();
  void publish_true_odometry(Time stamp);
  void publish_thermal_image(Time stamp);
  void publish_true_leaks(Time stamp);
  void on_command(const Twist& message);

  Parameter<std::string> rack_file_;
  Parameter<std::int64_t> seed_;
  Parameter<double> duration_;
  Parameter<double> latency_;
  Parameter<std::string> frame_id_;
  Parameter<std::vector<double>> start_position_;
  Parameter<double> start_yaw_;
  Parameter<std::vector<double>> offsets_;
  Parameter<std::vector<double>> plain_;
  Parameter<double> clutter_share_;
  Parameter<double> wind_speed_;
  Parameter<double> wind_direction_;
  Parameter<double> ground_height_;
  Parameter<double> velocity_error_;
  Parameter<std::string> imu_;
  Parameter<double> imu_rate_;
  Parameter<double> image_rate_;
  Parameter<int> width_;
  Parameter<int> height_;
  Parameter<double> focal_length_;
  Parameter<std::vector<double>> centre_;
  Parameter<std::vector<double>> distortion_;
  Parameter<std::vector<double>> camera_position_;
  Parameter<std::vector<double>> camera_roll_pitch_yaw_;
  Parameter<double> exposure_;
  Parameter<double> read_noise_;
  Parameter<double> thermal_image_rate_;
  Parameter<int> thermal_width_;
  Parameter<int> thermal_height_;
  Parameter<double> thermal_focal_length_;
  Parameter<double> thermal_netd_;
  Parameter<std::vector<double>> thermal_position_;
  Parameter<std::vector<double>> thermal_roll_pitch_yaw_;
  Parameter<std::vector<double>> hot_spots_;
  Parameter<std::vector<double>> warm_ground_;

  // As configured.
  std::string frame_;
  double latency_of_commands_ = 0.0;  // s, simulated
  double image_period_ = 0.0;         // s, simulated
  std::uint64_t total_images_ = 0;
  geometry::CameraParameters camera_;
  std::optional<simulation::RackThermalParameters> thermal_;
  std::uint64_t images_per_thermal_image_ = 1;
  std::vector<Eigen::Vector3d> hot_places_;  // m, rack frame, of the hot spots

  std::optional<simulation::RackFlight> flight_;
  std::uint64_t images_ = 0;
  std::optional<simulation::UavCommand>
      answer_;         // to the last image; takes effect after the latency
  Time last_stamp_{};  // of the last image

  Publisher<Image> image_publisher_;
  Publisher<CameraInfo> camera_info_publisher_;
  Publisher<Pose> truth_publisher_;
  Publisher<Odometry> true_odometry_publisher_;
  Publisher<Imu> imu_publisher_;
  Publisher<Image> thermal_image_publisher_;
  Publisher<CameraInfo> thermal_camera_info_publisher_;
  Publisher<LeakEvent> true_leaks_publisher_;
  Publisher<Clock> clock_publisher_;
  Subscription<Twist> command_subscription_;
  // Last: its steps end before their publishers.
  SimulationRun run_steps_{*this,
                           {"image", "camera_info", "imu", "true_pose", "true_odometry",
                            "thermal_image", "thermal_camera_info", "true_leaks"}};
};

}  // namespace pipescout
