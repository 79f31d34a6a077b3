// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <geometry_msgs/msg/pose_with_covariance_stamped.hpp>
#include <map>
#include <memory>
#include <nav_msgs/msg/odometry.hpp>
#include <optional>
#include <pipescout_msgs/msg/estimator_state.hpp>
#include <pipescout_msgs/msg/fused_odometer.hpp>
#include <pipescout_msgs/msg/rack_state.hpp>
#include <pipescout_msgs/msg/weld_detection.hpp>
#include <sensor_msgs/msg/imu.hpp>
#include <sensor_msgs/msg/nav_sat_fix.hpp>
#include <string_view>
#include <tf2_msgs/msg/tf_message.hpp>

#include "pipescout/estimation/planar_motion.hpp"
#include "pipescout/estimation/state_estimator.hpp"
#include "pipescout/estimation/wheel_drive.hpp"
#include "pipescout/estimator_sources/source_input.hpp"
#include "pipescout/geometry/geodesy.hpp"
#include "pipescout/runtime/awaited_subscribers.hpp"
#include "pipescout/runtime/component.hpp"
#include "pipescout/runtime/silence_watch.hpp"
#include "pipescout/state_estimator/agreeing_fixes.hpp"
#include "pipescout/state_estimator/estimator_settings.hpp"

namespace pipescout {

/// State estimate of a robot: `imu/data`, `gps/fix`, `odometer/fused`, `rack/pose` and `weld` in,
/// as far as available; `odometry/filtered`, `estimator/state` and `/tf` out. A rack localizer that
/// has lost the rack gets a `rack/pose_hint`.
///
/// Parameters and faults: docs/components/state_estimator.md. Parameters take effect when it is
/// configured.
class StateEstimator final : public Component {
 public:
  explicit StateEstimator(ComponentOptions options);
  ~StateEstimator() override;

 protected:
  CallbackReturn on_configure() override;
  CallbackReturn on_cleanup() override;

 private:
  using Imu = sensor_msgs::msg::Imu;
  using Fix = sensor_msgs::msg::NavSatFix;
  using Odometer = pipescout_msgs::msg::FusedOdometer;
  using Pose = geometry_msgs::msg::PoseWithCovarianceStamped;
  using RackState = pipescout_msgs::msg::RackState;
  using Weld = pipescout_msgs::msg::WeldDetection;
  using Odometry = nav_msgs::msg::Odometry;
  using State = pipescout_msgs::msg::EstimatorState;
  using Transforms = tf2_msgs::msg::TFMessage;

  /// The inputs are subscribed to when enough subscriptions of the outputs are matched.
  void subscribe();
  void on_imu(const Imu& message);
  void take_reading(const estimation::ImuReading& reading);
  void on_fix(const Fix& message);
  void on_odometer(const Odometer& message);
  /// Nothing, and a fault, while the transforms do not tell.
  [[nodiscard]] std::optional<geometry::SE3> camera_at(Time stamp);
  void on_rack_pose(const Pose& message);
  void on_rack_state(const RackState& message);
  void on_weld(const Weld& message);
  void on_initial_pose(const Pose& message);

  /// s since the origin, which is the first stamp of all. Nothing, and the fault is counted, for a
  /// stamp that is refused.
  [[nodiscard]] std::optional<double> time_of(std::string_view input,
                                              const builtin_interfaces::msg::Time& stamp);
  [[nodiscard]] Time stamp_of(double time) const;
  void report_outcome(estimation::Source source, estimation::Outcome outcome);
  void report_outcome(const std::string& source, estimation::Outcome outcome);
  void give_start();

  // state_estimator_sources.cpp
  void subscribe_to_sources();
  template <class Message>
  void subscribe_to_source(std::size_t source);
  template <class Message>
  void on_source(std::size_t source, const Message& message);
  /// Of the body, by the last reading; zero before it.
  [[nodiscard]] Eigen::Vector3d angular_rate() const;
  /// What wheels say stands for an IMU.
  void imply_imu(const estimation::WheelMotion& motion);
  /// Where the sensor is: from parameters, else from tf. Nothing, and the fault is counted, where
  /// tf does not know the frame.
  [[nodiscard]] std::optional<geometry::SE3> place_of(std::size_t source, const std::string& frame);
  void tell_sources();

  /// Whether there is a map in which the fix has a place: its origin comes from fixes that agree.
  [[nodiscard]] bool may_place(const Fix& message);
  void use_fix(const Fix& message, double time);
  void place_map(const geometry::GeodeticPosition& origin);

  void publish_news();
  [[nodiscard]] bool is_due(Time stamp) const;
  void publish_estimate(const estimation::Estimate& estimate);
  void publish_state();
  [[nodiscard]] bool may_hint_place(Time stamp) const;
  void publish_pose_hint();
  void tell_status();
  void tell_correlations();

  /// What was heard of a named source.
  struct NamedInput {
    std::shared_ptr<void> subscription;
    std::map<std::string, geometry::SE3> places;  // T_base_sensor, by frame
    std::optional<SourceInput> input;
  };

  EstimatorParameters declared_;
  AwaitedSubscribers awaited_{
      *this, "the component subscribes to its inputs", {"odometry", "state"}};

  EstimatorSettings settings_;  // as configured
  std::optional<estimation::StateEstimator> estimator_;
  std::optional<geometry::LocalFrame> map_;  // from the datum, or the first fixes that agree, on
  AgreeingFixes first_fixes_;
  bool told_unstated_covariance_ = false;
  std::optional<Time> origin_;
  std::optional<estimation::PlanarMotion> planar_;  // of a robot without an IMU
  std::optional<estimation::ImuReading> last_reading_;
  double imu_interval_ = 0;  // s, between the last two readings
  std::optional<Time> published_;
  std::uint64_t told_updates_ = 0;
  std::optional<Time> hinted_;
  bool rack_is_lost_ = false;
  bool has_run_ = false;  // since it was configured
  bool start_is_given_ = false;
  bool origin_is_due_ = false;          // with the next transforms: where the map is on the Earth
  estimation::EstimatorStatus status_;  // at the newest keyframe; not computed for each reading
  estimation::EstimatorStatus told_;
  std::array<bool, estimation::kSources> correlation_is_told_{};  // that is beyond the stated time

  Publisher<Odometry> odometry_publisher_;
  Publisher<State> state_publisher_;
  Publisher<Transforms> tf_publisher_;
  Publisher<Pose> hint_publisher_;
  Subscription<Imu> imu_subscription_;
  Subscription<Fix> fix_subscription_;
  Subscription<Odometer> odometer_subscription_;
  Subscription<Pose> rack_pose_subscription_;
  Subscription<RackState> rack_state_subscription_;
  Subscription<Weld> weld_subscription_;
  Subscription<Pose> initial_pose_subscription_;
  SilenceWatch imu_silence_{
      *this, "imu.silent",
      [this](std::string_view counter, std::string_view text) { report_fault(counter, text); }};
  std::shared_ptr<Timer> status_timer_;
  std::vector<NamedInput> named_;  // as settings_.sources
};

}  // namespace pipescout
