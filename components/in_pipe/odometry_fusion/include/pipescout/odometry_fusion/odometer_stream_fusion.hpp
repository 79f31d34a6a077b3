// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <pipescout/odometry/odometer_stream.hpp>
#include <pipescout/odometry/weld_calibration.hpp>
#include <pipescout_msgs/msg/bend_detection.hpp>
#include <pipescout_msgs/msg/fused_odometer.hpp>
#include <pipescout_msgs/msg/odometer_readings.hpp>
#include <pipescout_msgs/msg/weld_detection.hpp>
#include <sensor_msgs/msg/imu.hpp>
#include <string>
#include <vector>

#include "pipescout/runtime/awaited_subscribers.hpp"
#include "pipescout/runtime/component.hpp"
#include "pipescout/runtime/silence_watch.hpp"
#include "pipescout/runtime/stamp_limits.hpp"

namespace pipescout {

/// Streaming fusion of redundant odometers: `odometer/readings` in, of all odometers at once or of
/// some, at any rates; `odometer/fused` out, one for each tick of `odometry::OdometerStream`.
/// With the yaw rates of `imu/data`, turns are taken out of wheels beside each other. Calibrates
/// the scales of the odometers with the welds on `weld` whose distance is known. Bends that wheels
/// around the circumference find are published on `bend`.
///
/// Parameters: docs/components/odometry_fusion.md. They take effect when it is configured.
class OdometerStreamFusion final : public Component {
 public:
  explicit OdometerStreamFusion(ComponentOptions options);
  ~OdometerStreamFusion() override;

 protected:
  CallbackReturn on_configure() override;
  CallbackReturn on_cleanup() override;

 private:
  using Bend = pipescout_msgs::msg::BendDetection;
  using Readings = pipescout_msgs::msg::OdometerReadings;
  using Fused = pipescout_msgs::msg::FusedOdometer;
  using Imu = sensor_msgs::msg::Imu;
  using Weld = pipescout_msgs::msg::WeldDetection;

  /// Parameters at configuration.
  struct Settings {
    std::vector<std::string> names;
    StampLimits stamp_limits;
    double maximum_gap = 0.0;   // s
    double silent_after = 0.0;  // s
    double least_weld_probability = 0.0;
    bool calibrate = false;
  };

  void declare_stream_parameters();
  void declare_calibration_parameters();
  void declare_message_parameters();
  [[nodiscard]] odometry::OdometerStreamParameters stream_parameters() const;
  [[nodiscard]] odometry::WeldCalibrationParameters calibration_parameters() const;
  void subscribe();
  void on_readings(const Readings& message);
  [[nodiscard]] bool follows(Time stamp);
  void report_outcome(odometry::SampleOutcome outcome, const std::string& odometer);
  void publish_state();
  void publish_bend(const odometry::FoundBend& bend, const std_msgs::msg::Header& header);
  void report_health();
  void on_weld(const Weld& message);
  void on_imu(const Imu& message);
  /// Seconds of the stream's time.
  [[nodiscard]] double stream_time(Time stamp) const;

  Parameter<std::vector<std::string>> odometers_;
  Parameter<std::vector<std::string>> kinds_;
  Parameter<std::vector<double>> resolutions_;
  Parameter<std::vector<double>> sigmas_;
  Parameter<std::vector<double>> wraps_;
  Parameter<std::string> rule_;
  Parameter<std::vector<double>> clocks_;
  Parameter<std::vector<double>> laterals_;
  Parameter<double> pipe_radius_;
  Parameter<double> tightest_bend_;
  Parameter<double> clock_sigma_;
  Parameter<double> epsilon_;
  Parameter<bool> estimate_sigmas_;
  Parameter<double> tick_period_;
  Parameter<double> window_distance_;
  Parameter<int> lookback_windows_;
  Parameter<double> maximum_delay_;
  Parameter<double> maximum_gap_;
  Parameter<double> silent_after_;
  Parameter<double> maximum_speed_;
  Parameter<double> common_sigma_;
  Parameter<double> common_scale_sigma_;
  Parameter<double> worn_tolerance_;
  Parameter<bool> calibrate_;
  Parameter<double> calibration_scale_sigma_;
  Parameter<double> calibration_offset_sigma_;
  Parameter<double> calibration_scale_drift_;
  Parameter<double> least_weld_probability_;
  Parameter<double> maximum_age_;
  Parameter<double> maximum_lead_;
  AwaitedSubscribers awaited_{*this, "the component subscribes to the readings"};

  Settings settings_;
  std::optional<odometry::OdometerStream> stream_;
  std::optional<odometry::WeldCalibration> calibration_;
  std::optional<Time> origin_;  // of the stream's time: the first stamp
  std::optional<Time> last_stamp_;
  std::optional<Time> leap_;  // a stamp far from those before, not confirmed yet
  std::string frame_id_;
  std::uint64_t published_tick_ = 0;
  std::uint64_t bends_ = 0;  // told
  std::array<odometry::OdometerHealth, odometry::kMaxOdometers> health_{};

  Publisher<Fused> publisher_;
  Publisher<Bend> bend_publisher_;  // with the rule that finds bends
  Subscription<Readings> readings_subscription_;
  Subscription<Weld> weld_subscription_;
  Subscription<Imu> imu_subscription_;
  SilenceWatch readings_silence_{
      *this, "readings.silent",
      [this](std::string_view counter, std::string_view text) { report_fault(counter, text); }};
};

}  // namespace pipescout
