// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <geometry_msgs/msg/pose_with_covariance_stamped.hpp>
#include <memory>
#include <nav_msgs/msg/odometry.hpp>
#include <optional>
#include <pipescout_msgs/msg/rack_state.hpp>
#include <sensor_msgs/msg/camera_info.hpp>
#include <sensor_msgs/msg/image.hpp>
#include <string>
#include <vector>

#include "pipescout/geometry/camera.hpp"
#include "pipescout/geometry/se3.hpp"
#include "pipescout/message_conversions/camera_mount.hpp"
#include "pipescout/message_conversions/grey_image.hpp"
#include "pipescout/message_conversions/odometry_history.hpp"
#include "pipescout/rack_vision/rack_localization.hpp"
#include "pipescout/runtime/awaited_subscribers.hpp"
#include "pipescout/runtime/component.hpp"
#include "pipescout/runtime/silence_watch.hpp"
#include "pipescout/runtime/stamp_limits.hpp"

namespace pipescout {

/// Pose of the camera over a rack of pipes: `camera/image_raw` and `camera/camera_info` in,
/// `rack/pose` and `rack/state` out. `odometry/filtered`, if available, predicts its motion, and
/// `rack/pose_hint` gives an initial pose.
///
/// Parameters and faults: docs/components/rack_localizer.md. Parameters take effect when it is
/// configured.
class RackLocalizer final : public Component {
 public:
  explicit RackLocalizer(ComponentOptions options);
  ~RackLocalizer() override;

 protected:
  CallbackReturn on_configure() override;
  CallbackReturn on_cleanup() override;

 private:
  using Image = sensor_msgs::msg::Image;
  using CameraInfo = sensor_msgs::msg::CameraInfo;
  using Odometry = nav_msgs::msg::Odometry;
  using Pose = geometry_msgs::msg::PoseWithCovarianceStamped;
  using State = pipescout_msgs::msg::RackState;

  void declare_start_parameters();
  void declare_tracker_parameters();
  void declare_message_parameters();
  [[nodiscard]] rack_vision::RackLocalizationParameters localization_parameters() const;
  [[nodiscard]] rack_vision::FirstPoseHint hint() const;

  /// Images are subscribed to when enough subscriptions of the pose are matched.
  void subscribe();
  void on_image(const Image& message);
  void on_camera_info(const CameraInfo& message);
  void on_odometry(const Odometry& message);
  void on_pose_hint(const Pose& message);

  /// Motion of the camera since the previous image, from odometry.
  [[nodiscard]] std::optional<rack_vision::MotionPrediction> motion_until(Time stamp);
  void check_start(bool usable);
  void publish(const Image& image, const rack_vision::RackTrackerResult& result);
  void tell_counts();

  AwaitedSubscribers awaited_{*this, "the component subscribes to images", {"pose", "state"}};
  Parameter<std::string> rack_file_;
  Parameter<std::string> frame_id_;
  Parameter<std::vector<double>> start_position_;
  Parameter<std::vector<double>> start_roll_pitch_yaw_;
  Parameter<double> start_position_deviation_;
  Parameter<double> start_rotation_deviation_;
  Parameter<double> start_drift_;
  Parameter<bool> find_first_pose_;
  Parameter<std::vector<double>> hint_position_;
  Parameter<std::vector<double>> hint_position_deviation_;
  Parameter<std::vector<double>> hint_heading_;
  Parameter<double> retry_period_;
  Parameter<int> samples_per_edge_;
  Parameter<int> points_per_frame_;
  Parameter<int> map_capacity_;
  Parameter<bool> estimate_offsets_;
  Parameter<double> offset_deviation_;
  Parameter<bool> estimate_intrinsics_;
  Parameter<double> focal_length_deviation_;
  Parameter<double> centre_deviation_;
  Parameter<double> row_time_;
  Parameter<double> acceleration_;
  Parameter<double> angular_acceleration_;
  std::optional<CameraMountParameters> mount_parameters_;
  Parameter<double> odometry_drift_;
  Parameter<double> odometry_rotation_drift_;
  Parameter<double> maximum_age_;
  Parameter<double> maximum_lead_;
  Parameter<double> silent_after_;

  // As configured.
  StampLimits stamp_limits_;
  std::string frame_;
  rack_vision::RackModel model_;
  Eigen::Vector3d along_ = Eigen::Vector3d::UnitY();  // main direction of the pipes
  rack_vision::RackLocalizationParameters settings_;
  CameraMount mount_{geometry::SE3()};

  std::optional<rack_vision::RackLocalization> localization_;  // from the first calibration on
  std::optional<CameraInfo> calibration_;
  struct Start {
    geometry::SE3 T_rack_camera;
    geometry::Matrix6d covariance;
  };
  // These wait for the calibration.
  std::optional<Start> start_;
  std::optional<Start> suggestion_;
  GreyImageReader reader_;
  std::optional<OdometryHistory> odometry_;
  std::optional<Time> last_image_;
  std::optional<rack_vision::IntrinsicsBelief> intrinsics_;  ///< when they are estimated
  std::vector<rack_vision::PipeShapeEstimate> shapes_;
  rack_vision::TrackStatus last_status_ = rack_vision::TrackStatus::kNotStarted;
  bool has_tracked_ = false;  // since it was configured

  Publisher<Pose> pose_publisher_;
  Publisher<State> state_publisher_;
  Subscription<Image> image_subscription_;
  Subscription<CameraInfo> camera_info_subscription_;
  Subscription<Odometry> odometry_subscription_;
  Subscription<Pose> hint_subscription_;
  SilenceWatch image_silence_{
      *this, "image.silent",
      [this](std::string_view counter, std::string_view text) { report_fault(counter, text); }};
  std::shared_ptr<Timer> counts_timer_;
};

}  // namespace pipescout
