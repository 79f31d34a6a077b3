// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <pipescout/odometry/weld_detector.hpp>
#include <pipescout/odometry/weld_positioning.hpp>
#include <pipescout_msgs/msg/bend_detection.hpp>
#include <pipescout_msgs/msg/eddy_current_samples.hpp>
#include <pipescout_msgs/msg/fused_odometer.hpp>
#include <pipescout_msgs/msg/pipe_position.hpp>
#include <pipescout_msgs/msg/weld_detection.hpp>
#include <string>
#include <vector>

#include "pipescout/runtime/awaited_subscribers.hpp"
#include "pipescout/runtime/component.hpp"
#include "pipescout/runtime/silence_watch.hpp"
#include "pipescout/runtime/stamp_limits.hpp"
#include "pipescout/weld_ledger/tally_file.hpp"
#include "pipescout/weld_locator/distance_history.hpp"

namespace pipescout {

/// Detects girth welds in `eddy_current` along the distance of `odometer/fused`, publishes them on
/// `weld`, and publishes the joint of the pipe and the distance into it on `pipe/position`, by the
/// sequence of joint lengths in a tally, and by its bends where the wheels find them (`bend`). All
/// positions are those of the probe.
///
/// Parameters: docs/components/weld_locator.md. They take effect when it is configured.
class WeldLocator final : public Component {
 public:
  explicit WeldLocator(ComponentOptions options);
  ~WeldLocator() override;

 protected:
  CallbackReturn on_configure() override;
  CallbackReturn on_deactivate() override;
  CallbackReturn on_cleanup() override;

 private:
  using Bend = pipescout_msgs::msg::BendDetection;
  using Fused = pipescout_msgs::msg::FusedOdometer;
  using Samples = pipescout_msgs::msg::EddyCurrentSamples;
  using Weld = pipescout_msgs::msg::WeldDetection;
  using Position = pipescout_msgs::msg::PipePosition;

  /// A weld that was recognised, for the distance to the next one.
  struct PassedWeld {
    std::size_t weld = 0;  // index in the tally
    Time time{};
    double standard_deviation = 0.0;  // m, of seeing it
  };

  void declare_detector_parameters();
  void declare_positioning_parameters();
  void declare_message_parameters();
  [[nodiscard]] odometry::WeldDetectorParameters detector_parameters() const;
  [[nodiscard]] odometry::WeldPositioningParameters positioning_parameters() const;
  [[nodiscard]] odometry::WeldPositioningStart start() const;
  void subscribe();

  void on_fused(const Fused& message);
  [[nodiscard]] bool is_acceptable(const Fused& message);
  void on_bend(const Bend& message);
  void on_samples(const std::shared_ptr<const Samples>& message);
  [[nodiscard]] bool is_acceptable(const Samples& message);
  void check_stamp(const char* input, Time stamp);
  void process_waiting();
  void process(const Samples& message);
  void on_weld(const odometry::WeldEvent& event);
  void report_spacing_faults(const odometry::WeldPositionEstimate& estimate, const char* by);
  void identify(const odometry::WeldEvent& event, const DistanceHistory::Point& passage,
                Weld& message);
  void publish_position(Time stamp);
  void tell_counts();
  void write_learnt_tally();

  Parameter<std::string> tally_file_;
  Parameter<std::string> learnt_tally_file_;
  Parameter<double> standard_joint_length_;
  Parameter<double> standard_joint_deviation_;
  Parameter<std::int64_t> start_joint_;
  Parameter<double> start_distance_;
  Parameter<double> start_deviation_;
  Parameter<std::string> start_orientation_;
  Parameter<double> missed_probability_;
  Parameter<double> spurious_probability_;
  Parameter<double> scale_deviation_;
  Parameter<double> scale_drift_;
  Parameter<double> double_slip_probability_;
  Parameter<int> channels_;
  Parameter<double> smallest_width_;
  Parameter<double> largest_width_;
  Parameter<double> false_alarms_per_km_;
  Parameter<double> least_confidence_;
  Parameter<double> phase_;
  Parameter<double> phase_tolerance_;
  Parameter<double> noise_floor_;
  Parameter<double> maximum_age_;
  Parameter<double> maximum_lead_;
  Parameter<double> silent_after_;
  AwaitedSubscribers awaited_{
      *this, "the component subscribes to its inputs", {"weld", "position"}};

  // As configured.
  StampLimits stamp_limits_;
  double confidence_limit_ = 0.0;
  std::string learnt_path_;
  std::optional<Tally> tally_;
  double first_chainage_ = 0.0;  // m

  std::optional<odometry::WeldDetector> detector_;
  std::optional<odometry::WeldPositioning> positioning_;
  std::optional<DistanceHistory> history_;
  std::deque<std::shared_ptr<const Samples>> waiting_;  // for the odometer to reach their time
  std::optional<Time> samples_until_;                   // stamp of the last sample that was taken
  std::optional<PassedWeld> last_weld_;
  double independent_variance_ = 0.0;  // m^2, of the last fused distance
  std::string frame_id_;
  bool was_locked_ = false;

  Publisher<Weld> weld_publisher_;
  Publisher<Position> position_publisher_;
  Subscription<Bend> bend_subscription_;
  Subscription<Fused> fused_subscription_;
  Subscription<Samples> samples_subscription_;
  SilenceWatch fused_silence_{
      *this, "fused.silent",
      [this](std::string_view counter, std::string_view text) { report_fault(counter, text); }};
  SilenceWatch samples_silence_{
      *this, "eddy_current.silent",
      [this](std::string_view counter, std::string_view text) { report_fault(counter, text); }};
  std::shared_ptr<Timer> counts_timer_;
};

}  // namespace pipescout
