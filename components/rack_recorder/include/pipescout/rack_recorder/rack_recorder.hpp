// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <geometry_msgs/msg/pose_stamped.hpp>
#include <geometry_msgs/msg/pose_with_covariance_stamped.hpp>
#include <geometry_msgs/msg/twist_stamped.hpp>
#include <memory>
#include <optional>
#include <pipescout_msgs/msg/mission_status.hpp>
#include <pipescout_msgs/msg/rack_state.hpp>
#include <sensor_msgs/msg/camera_info.hpp>
#include <sensor_msgs/msg/image.hpp>
#include <string>

#include "pipescout/interfaces/mission_recorder.hpp"
#include "pipescout/interfaces/whole_file.hpp"
#include "pipescout/message_conversions/grey_image.hpp"
#include "pipescout/rack_recorder/rack_report.hpp"

namespace pipescout {

/// Writes a flight over a pipe rack into the mission folder, line by line as it arrives:
/// `rack/pose`, `rack/state`, `cmd_vel_stamped`, from a simulation `ground_truth/rack_pose`, now
/// and then an image, the calibration and the rack file; and its errors and losses into the
/// mission's summary. Complete a while after its source, whose progress counts way-points; failed
/// when nothing arrives any more before the source is complete.
///
/// Parameters: docs/components/rack_recorder.md. They take effect when it is configured.
class RackRecorder final : public MissionRecorder {
 public:
  explicit RackRecorder(ComponentOptions options);
  ~RackRecorder() override;

 protected:
  CallbackReturn on_configure() override;
  CallbackReturn on_deactivate() override;
  [[nodiscard]] MissionSection section(const std::string& figure_prefix) const override;
  [[nodiscard]] std::string counts() const override;
  void on_source(const pipescout_msgs::msg::MissionStatus& status) override;
  void stop_timers() override;
  void sync_files() override;
  void close_files() override;

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
  /// Each message is a part of the section; a file that cannot be written fails the mission, and a
  /// message that says nonsense (std::invalid_argument) is counted as `<counter>.malformed`.
  template <class T>
  [[nodiscard]] Subscription<T> record(const Topic<T>& topic, const char* counter,
                                       void (RackRecorder::*write)(const T&));
  /// The file, with this header when it is new.
  [[nodiscard]] LineFile& file(std::unique_ptr<LineFile>& file, const char* name,
                               const std::string& header);
  void copy_rack_file();
  void on_progress(const pipescout_msgs::msg::MissionStatus& status);
  /// Ends a recording whose source is dead. Before the first message a flight has not begun.
  void look_for_silence();

  Parameter<double> settle_time_;
  Parameter<double> silent_after_;
  Parameter<double> image_period_;
  Parameter<std::int64_t> maximum_images_;
  Parameter<std::string> rack_;

  // As configured.
  Duration settle_{};
  Duration silence_{};  // zero: may last for ever
  Duration period_{};
  std::uint64_t most_images_ = 0;

  std::optional<RackReport> report_;
  GreyImageReader reader_;
  std::optional<Time> last_image_;
  std::uint64_t images_ = 0;
  std::string calibration_;  // as written
  std::optional<std::uint32_t> way_points_done_;
  std::optional<SteadyTime> heard_at_;
  std::unique_ptr<LineFile> pose_file_;
  std::unique_ptr<LineFile> truth_file_;
  std::unique_ptr<LineFile> state_file_;
  std::unique_ptr<LineFile> offsets_file_;
  std::unique_ptr<LineFile> command_file_;
  std::unique_ptr<LineFile> way_points_file_;
  std::unique_ptr<LineFile> images_file_;

  Subscription<Pose> pose_subscription_;
  Subscription<TruePose> truth_subscription_;
  Subscription<State> state_subscription_;
  Subscription<Command> command_subscription_;
  Subscription<Image> image_subscription_;
  Subscription<CameraInfo> camera_info_subscription_;
  std::shared_ptr<Timer> settle_timer_;
  std::shared_ptr<Timer> silence_timer_;
};

}  // namespace pipescout
