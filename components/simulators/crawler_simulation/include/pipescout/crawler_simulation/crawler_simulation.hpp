// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <nav_msgs/msg/odometry.hpp>
#include <optional>
#include <pipescout_msgs/msg/eddy_current_samples.hpp>
#include <pipescout_msgs/msg/odometer_readings.hpp>
#include <pipescout_msgs/msg/pipe_position.hpp>
#include <rosgraph_msgs/msg/clock.hpp>
#include <sensor_msgs/msg/imu.hpp>
#include <string>
#include <vector>

#include "pipescout/crawler_simulation/simulated_run.hpp"
#include "pipescout/runtime/component.hpp"
#include "pipescout/runtime/simulation_run.hpp"

namespace pipescout {

/// Simulates a crawler and replaces its drivers: publishes `odometer/readings` of its wheels,
/// `eddy_current` of its probe, `imu/data`, the truth on `ground_truth/pipe_position` and
/// `ground_truth/odometry`, and the time of all that on `/clock`, for nodes with `use_sim_time`.
/// Says that it is complete at the end of the pipe.
///
/// Parameters: docs/components/crawler_simulation.md. They take effect when it is configured.
class CrawlerSimulation final : public Component {
 public:
  explicit CrawlerSimulation(ComponentOptions options);
  ~CrawlerSimulation() override;

 protected:
  CallbackReturn on_configure() override;
  CallbackReturn on_activate() override;
  CallbackReturn on_deactivate() override;
  CallbackReturn on_cleanup() override;

 private:
  using Readings = pipescout_msgs::msg::OdometerReadings;
  using Samples = pipescout_msgs::msg::EddyCurrentSamples;
  using Position = pipescout_msgs::msg::PipePosition;
  using Imu = sensor_msgs::msg::Imu;
  using Odometry = nav_msgs::msg::Odometry;
  using Clock = rosgraph_msgs::msg::Clock;

  void declare_wheel_parameters();
  void declare_drive_parameters();
  void declare_imu_parameters();
  void declare_signal_parameters();
  [[nodiscard]] SimulatedRunParameters run_parameters() const;
  /// False: it was the last.
  bool step();
  void publish_readings(double until);
  void publish_samples(double until);
  void publish_truth(double time);
  void publish_imu(double until);

  Parameter<std::string> tally_;
  Parameter<std::int64_t> seed_;
  Parameter<std::vector<std::string>> wheels_;
  Parameter<std::vector<std::string>> kinds_;
  Parameter<std::vector<double>> periods_;
  Parameter<std::vector<double>> scale_errors_;
  Parameter<std::vector<double>> wear_;
  Parameter<std::vector<double>> clocks_;
  Parameter<double> pipe_radius_;
  Parameter<double> resolution_;
  Parameter<double> noise_;
  Parameter<double> dropped_share_;
  Parameter<double> nan_share_;
  Parameter<double> slip_spacing_;
  Parameter<double> slip_most_;
  Parameter<double> slip_together_;
  Parameter<double> stick_spacing_;
  Parameter<double> gravity_slip_;
  Parameter<std::int64_t> start_joint_;
  Parameter<double> length_;
  Parameter<double> speed_;
  Parameter<double> stop_spacing_;
  Parameter<double> reverse_share_;
  Parameter<double> joint_error_;
  Parameter<std::string> route_;
  Parameter<std::string> imu_;
  Parameter<double> imu_rate_;
  Parameter<double> standing_;
  Parameter<double> sample_rate_;
  Parameter<double> peak_snr_;
  Parameter<double> valves_;
  Parameter<double> bends_;
  Parameter<double> dents_;

  // As configured.
  std::vector<std::string> names_;

  std::optional<SimulatedRun> run_;
  std::uint64_t steps_ = 0;           // made
  std::uint64_t standing_steps_ = 0;  // before it starts
  std::uint64_t total_steps_ = 0;

  Publisher<Readings> readings_publisher_;
  Publisher<Samples> samples_publisher_;
  Publisher<Position> truth_publisher_;
  Publisher<Odometry> true_odometry_publisher_;
  Publisher<Imu> imu_publisher_;
  Publisher<Clock> clock_publisher_;
  // Last: its steps end before their publishers.
  SimulationRun run_steps_{*this,
                           {"readings", "eddy_current", "imu", "true_position", "true_odometry"}};
};

}  // namespace pipescout
