// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <geometry_msgs/msg/twist.hpp>
#include <memory>
#include <nav_msgs/msg/odometry.hpp>
#include <optional>
#include <pipescout_msgs/action/inspect_tour.hpp>
#include <pipescout_msgs/msg/pipe_track.hpp>
#include <rosgraph_msgs/msg/clock.hpp>
#include <sensor_msgs/msg/laser_scan.hpp>
#include <string>
#include <vector>

#include "pipescout/plant_simulation/plant_drive.hpp"
#include "pipescout/runtime/bound_parameters.hpp"
#include "pipescout/runtime/component.hpp"
#include "pipescout/runtime/simulation_run.hpp"

namespace pipescout {

/// Simulates a robot with Ackermann steering in a plant, and its operator: publishes `scan`,
/// `odometry/filtered`, `track/pipe`, the truth on `ground_truth/odometry`, and the time of all
/// that on `/clock`; does what `cmd_vel` says; writes the map of the plant; and asks for a tour
/// with the action `inspect_tour`, with whose end the simulation is over.
///
/// Parameters: docs/components/plant_simulation.md. They take effect when it is configured.
class PlantSimulation final : public Component {
 public:
  explicit PlantSimulation(ComponentOptions options);
  ~PlantSimulation() override;

 protected:
  CallbackReturn on_configure() override;
  CallbackReturn on_activate() override;
  CallbackReturn on_deactivate() override;
  CallbackReturn on_cleanup() override;

 private:
  using Clock = rosgraph_msgs::msg::Clock;
  using InspectTour = pipescout_msgs::action::InspectTour;
  using LaserScan = sensor_msgs::msg::LaserScan;
  using Odometry = nav_msgs::msg::Odometry;
  using PipeTrack = pipescout_msgs::msg::PipeTrack;
  using Twist = geometry_msgs::msg::Twist;

  [[nodiscard]] PlantDriveParameters drive_parameters() const;
  bool next_step();
  void publish_odometry(Time stamp);
  void publish_scan(Time stamp);
  void publish_track(Time stamp);
  void send_goal();
  void on_result(const GoalOutcome<InspectTour>& outcome);

  BoundParameters<PlantDriveParameters> declared_;
  Parameter<std::int64_t> seed_;
  Parameter<std::vector<double>> obstacles_;
  Parameter<std::vector<double>> start_;
  Parameter<std::string> map_folder_;
  Parameter<std::vector<std::int64_t>> rows_;
  Parameter<double> standing_;
  Parameter<double> time_limit_;

  std::optional<PlantDrive> drive_;
  std::uint64_t steps_ = 0;
  bool asked_ = false;
  bool over_ = false;

  Publisher<Clock> clock_publisher_;
  Publisher<Odometry> odometry_publisher_;
  Publisher<Odometry> true_odometry_publisher_;
  Publisher<LaserScan> scan_publisher_;
  Publisher<PipeTrack> track_publisher_;
  Subscription<Twist> command_subscription_;
  ActionClient<InspectTour> client_;
  // Last: its steps end before their publishers.
  SimulationRun run_steps_{*this, {"scan", "odometry", "track", "true_odometry"}};
};

}  // namespace pipescout
