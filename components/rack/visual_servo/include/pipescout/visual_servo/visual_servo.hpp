// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <geometry_msgs/msg/pose_with_covariance_stamped.hpp>
#include <geometry_msgs/msg/twist_stamped.hpp>
#include <memory>
#include <optional>
#include <pipescout/rack_vision/visual_servo.hpp>
#include <pipescout/rack_vision/way_point_mission.hpp>
#include <pipescout_msgs/msg/rack_state.hpp>
#include <string>
#include <vector>

#include "pipescout/message_conversions/camera_mount.hpp"
#include "pipescout/runtime/awaited_subscribers.hpp"
#include "pipescout/runtime/component.hpp"

namespace pipescout {

/// Controls a robot along way-points over a rack of pipes: `rack/pose` and `rack/state` of its
/// camera in, `cmd_vel_stamped` out. Holds, then climbs, while there is no pose.
///
/// Parameters and faults: docs/components/visual_servo.md. Parameters take effect when it is
/// configured.
class VisualServo final : public Component {
 public:
  explicit VisualServo(ComponentOptions options);
  ~VisualServo() override;

 protected:
  CallbackReturn on_configure() override;
  CallbackReturn on_deactivate() override;
  CallbackReturn on_cleanup() override;

 private:
  using Pose = geometry_msgs::msg::PoseWithCovarianceStamped;
  using State = pipescout_msgs::msg::RackState;
  using Twist = geometry_msgs::msg::TwistStamped;
  struct Deviation {
    double position = 0.0;  // m, along the direction known least
    double yaw = 0.0;       // rad
  };

  void declare_mission_parameters();
  void declare_servo_parameters();
  void declare_safety_parameters();
  /// These throw std::invalid_argument naming the parameter or field.
  [[nodiscard]] std::vector<rack_vision::WayPoint> way_points() const;
  [[nodiscard]] rack_vision::WayPointMission new_mission() const;
  [[nodiscard]] rack_vision::VisualServoParameters servo_parameters() const;

  /// The inputs are subscribed to when enough subscriptions of the command are matched.
  void subscribe();
  void on_pose(const Pose& message);
  /// Infinite, and counted, when the covariance is invalid; 0 when it is not given.
  [[nodiscard]] Deviation deviation_of(const Pose& message);
  void on_state(const State& message);
  /// Brings mission and servo to now, or to `measured`, the stamp of the image that it answers,
  /// when that is a little ahead of the clock; publishes the command with that stamp.
  void command(Time measured);
  void publish(const rack_vision::ServoCommand& command, Time stamp);
  void tell(const rack_vision::ServoCommand& command);

  AwaitedSubscribers awaited_{*this, "the component subscribes to its inputs"};
  Parameter<std::vector<double>> way_points_;
  Parameter<double> hold_;
  Parameter<double> path_speed_;
  Parameter<double> path_acceleration_;
  Parameter<double> path_yaw_rate_;
  Parameter<double> path_yaw_acceleration_;
  Parameter<double> position_tolerance_;
  Parameter<double> yaw_tolerance_;
  Parameter<double> reached_for_;
  Parameter<double> deviations_within_;
  Parameter<double> look_around_;
  Parameter<double> patience_;
  Parameter<double> largest_lag_;
  Parameter<double> largest_yaw_lag_;
  Parameter<bool> full_rotation_;
  Parameter<double> position_gain_;
  Parameter<double> rotation_gain_;
  Parameter<double> response_time_;
  Parameter<double> largest_speed_;
  Parameter<double> largest_rotation_rate_;
  Parameter<double> largest_acceleration_;
  Parameter<double> largest_rotation_acceleration_;
  std::optional<CameraMountParameters> mount_parameters_;
  Parameter<std::string> frame_id_;
  Parameter<std::string> command_frame_id_;
  Parameter<double> rate_;
  Parameter<double> maximum_age_;
  Parameter<double> maximum_lead_;
  Parameter<double> smallest_quality_;
  Parameter<double> hold_time_;
  Parameter<double> climb_speed_;
  Parameter<double> climb_height_;

  // As configured.
  std::string frame_;
  std::string command_frame_;
  CameraMount mount_{geometry::SE3()};
  Duration longest_silence_{};                           // between two commands
  std::optional<rack_vision::WayPointMission> planned_;  // before it begins

  std::optional<rack_vision::WayPointMission> mission_;
  std::optional<rack_vision::VisualServo> servo_;
  struct Quality {
    Time stamp;
    double value = 0.0;
    bool tracking = false;
  };
  std::optional<Quality> quality_;  // of the last rack/state
  Deviation deviation_;             // of the last pose that was taken
  std::optional<Time> commanded_at_;
  rack_vision::ServoState told_state_ = rack_vision::ServoState::kIdle;
  std::size_t told_outcomes_ = 0;
  bool told_complete_ = false;
  bool has_flown_ = false;  // by a pose, since it was configured

  Publisher<Twist> publisher_;
  Subscription<Pose> pose_subscription_;
  Subscription<State> state_subscription_;
  std::shared_ptr<Timer> timer_;
};

}  // namespace pipescout
