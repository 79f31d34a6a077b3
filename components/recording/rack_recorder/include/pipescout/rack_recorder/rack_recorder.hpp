// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <geometry_msgs/msg/pose_stamped.hpp>
#include <geometry_msgs/msg/pose_with_covariance_stamped.hpp>
#include <geometry_msgs/msg/twist_stamped.hpp>
#include <optional>
#include <pipescout_msgs/msg/mission_status.hpp>
#include <pipescout_msgs/msg/rack_state.hpp>
#include <sensor_msgs/msg/camera_info.hpp>
#include <sensor_msgs/msg/image.hpp>
#include <string>

#include "pipescout/catalogue/stream_recorder.hpp"
#include "pipescout/message_conversions/grey_image.hpp"
#include "pipescout/mission_tables/thinning.hpp"
#include "pipescout/rack_recorder/rack_report.hpp"

namespace pipescout {

/// Writes a flight over a pipe rack into the mission folder, line by line as it arrives:
/// `rack/pose`, `rack/state`, `cmd_vel_stamped`, from a simulation `ground_truth/rack_pose`, now
/// and then an image, the calibration and the rack file; and its errors and losses into the
/// mission's summary. Complete a while after its source, whose progress counts way-points; failed
/// when nothing arrives any more before the source is complete.
///
/// Parameters: docs/components/rack_recorder.md. They take effect when it is configured.
class RackRecorder final : public StreamRecorder {
 public:
  explicit RackRecorder(ComponentOptions options);
  ~RackRecorder() override;

 protected:
  CallbackReturn on_configure() override;
  [[nodiscard]] MissionSection section(const std::string& figure_prefix) const override;
  [[nodiscard]] std::string counts() const override;
  [[nodiscard]] bool has_data() const override;
  void on_progress(const pipescout_msgs::msg::MissionStatus& status) override;

 private:
  using Pose = geometry_msgs::msg::PoseWithCovarianceStamped;
  using TruePose = geometry_msgs::msg::PoseStamped;
  using State = pipescout_msgs::msg::RackState;
  using Command = geometry_msgs::msg::TwistStamped;
  using Image = sensor_msgs::msg::Image;
  using CameraInfo = sensor_msgs::msg::CameraInfo;

  void on_pose(const Pose& message);
  void on_truth(const TruePose& message);
  void on_state(const State& message);
  void on_command(const Command& message);
  void on_image(const Image& message);
  void on_camera_info(const CameraInfo& message);
  void copy_rack_file();

  Parameter<double> image_period_;
  Parameter<std::int64_t> maximum_images_;
  Parameter<std::string> rack_;

  std::uint64_t most_images_ = 0;  // as configured

  std::optional<RackReport> report_;
  GreyImageReader reader_;
  Thinning image_thinning_;
  std::uint64_t images_ = 0;
  std::string calibration_;  // as written
  std::optional<std::uint32_t> way_points_done_;
};

}  // namespace pipescout
