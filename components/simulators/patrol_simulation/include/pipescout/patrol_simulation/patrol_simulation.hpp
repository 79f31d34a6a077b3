// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <geometry_msgs/msg/twist.hpp>
#include <memory>
#include <nav_msgs/msg/odometry.hpp>
#include <optional>
#include <pipescout/geometry/geodesy.hpp>
#include <pipescout_msgs/action/inspect_tour.hpp>
#include <pipescout_msgs/msg/leak_event.hpp>
#include <pipescout_msgs/msg/odometer_readings.hpp>
#include <pipescout_msgs/msg/pipe_track.hpp>
#include <rosgraph_msgs/msg/clock.hpp>
#include <sensor_msgs/msg/camera_info.hpp>
#include <sensor_msgs/msg/image.hpp>
#include <sensor_msgs/msg/imu.hpp>
#include <sensor_msgs/msg/joint_state.hpp>
#include <sensor_msgs/msg/laser_scan.hpp>
#include <sensor_msgs/msg/nav_sat_fix.hpp>
#include <string>
#include <trajectory_msgs/msg/joint_trajectory.hpp>
#include <vector>

#include "pipescout/patrol_simulation/patrol_drive.hpp"
#include "pipescout/patrol_simulation/patrol_parameters.hpp"
#include "pipescout/runtime/component.hpp"
#include "pipescout/runtime/simulation_run.hpp"

namespace pipescout {

/// Simulates a ground robot that patrols along rows of collectors at night, and replaces its
/// drivers: publishes `thermal/image_raw`, `thermal/camera_info`, `imu/data`, `gps/fix`,
/// `odometer/readings`, the truth on `ground_truth/odometry`, `ground_truth/leaks` and
/// `ground_truth/pipe_track`, and the time of all that on `/clock`, for nodes with `use_sim_time`.
/// With an arm that carries the camera `joint_states` too, and it does what `arm/command` says.
/// In a plant `scan` too: it drives as `cmd_vel` says, writes the plant's map, and asks as its
/// operator for a tour with the action `inspect_tour`, with whose end the patrol is over.
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
  using JointState = sensor_msgs::msg::JointState;
  using JointTrajectory = trajectory_msgs::msg::JointTrajectory;
  using PipeTrack = pipescout_msgs::msg::PipeTrack;
  using InspectTour = pipescout_msgs::action::InspectTour;
  using LaserScan = sensor_msgs::msg::LaserScan;
  using Twist = geometry_msgs::msg::Twist;

  /// Drives on to the next step and publishes what the sensors have said, and an image when it is
  /// due. False: it was the last.
  bool next_step();
  void on_command(const JointTrajectory& message);
  void publish_imu();
  void publish_odometers();
  void publish_fixes();
  void publish_true_leaks();
  void publish_true_odometry(Time stamp);
  void publish_image(Time stamp);
  void publish_joints(Time stamp);
  void publish_true_track(Time stamp);
  void publish_scan(Time stamp);
  void write_map() const;
  void report_driven();
  void ask_for_tour();
  void on_tour(const GoalOutcome<InspectTour>& outcome);
  /// Asks for the tour, and ends the patrol where its time is over.
  void operate(double time);
  /// The patrol is over, and well done unless the robot has touched something.
  void end_well(const std::string& what);

  PatrolParameters patrol_parameters_;

  // As configured.
  std::int64_t robot_steps_per_step_ = 1;
  std::uint64_t steps_per_image_ = 1;
  double step_period_ = 0;  // s, simulated
  std::string camera_frame_;
  bool grey_ = false;
  std::uint64_t expected_images_ = 1;

  std::optional<PatrolDrive> drive_;
  std::optional<simulation::ThermalGreys> greys_;
  std::optional<geometry::LocalFrame> frame_;
  std::vector<std::uint16_t> counts_;
  std::uint64_t steps_ = 0;
  std::uint64_t images_ = 0;
  std::uint64_t steps_per_scan_ = 1;
  bool with_tour_ = false;  ///< of its own, which has not been preempted
  bool asked_ = false;      ///< for the tour
  bool over_ = false;

  Publisher<Image> image_publisher_;
  Publisher<CameraInfo> camera_info_publisher_;
  Publisher<Imu> imu_publisher_;
  Publisher<Fix> fix_publisher_;
  Publisher<Readings> readings_publisher_;
  Publisher<pipescout_msgs::msg::LeakEvent> true_leaks_publisher_;
  Publisher<Odometry> true_odometry_publisher_;
  Publisher<Clock> clock_publisher_;
  Publisher<PipeTrack> true_track_publisher_;
  Publisher<JointState> joint_publisher_;
  Publisher<LaserScan> scan_publisher_;
  Subscription<JointTrajectory> command_subscription_;
  Subscription<Twist> twist_subscription_;
  ActionClient<InspectTour> tour_client_;
  // Last: its steps end before their publishers.
  SimulationRun run_steps_{*this,
                           {"image", "camera_info", "imu", "fix", "readings", "joint_states",
                            "true_odometry", "true_leaks", "true_track", "scan"}};
};

}  // namespace pipescout
