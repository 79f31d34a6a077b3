// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <nav_msgs/msg/odometry.hpp>
#include <optional>
#include <pipescout_msgs/msg/leak_detections.hpp>
#include <pipescout_msgs/msg/leak_event.hpp>
#include <pipescout_msgs/msg/rack_state.hpp>
#include <sensor_msgs/msg/camera_info.hpp>
#include <sensor_msgs/msg/image.hpp>
#include <span>
#include <vector>

#include "pipescout/geometry/camera.hpp"
#include "pipescout/leak_findings/leak_findings.hpp"
#include "pipescout/leak_inspector/inspector_settings.hpp"
#include "pipescout/message_conversions/odometry_history.hpp"
#include "pipescout/message_conversions/thermal_image.hpp"
#include "pipescout/runtime/awaited_subscribers.hpp"
#include "pipescout/runtime/component.hpp"
#include "pipescout/runtime/silence_watch.hpp"
#include "pipescout/thermal/leak_detector.hpp"

namespace pipescout {

class FindingsArchive;
class PictureRecording;

/// Leaks of pipes: `thermal/image_raw`, `thermal/camera_info` and `odometry/filtered` in, with a
/// rack file `rack/state` too; `leak/detections` for each image and `leak/events` out. Findings are
/// stored in a file over days, a report is written at the end, and images are recorded if
/// requested.
///
/// Parameters and faults: docs/components/leak_inspector.md. Parameters take effect when it is
/// configured.
class LeakInspector final : public Component {
 public:
  explicit LeakInspector(ComponentOptions options);
  ~LeakInspector() override;

 protected:
  CallbackReturn on_configure() override;
  CallbackReturn on_deactivate() override;
  CallbackReturn on_cleanup() override;

 private:
  using Image = sensor_msgs::msg::Image;
  using CameraInfo = sensor_msgs::msg::CameraInfo;
  using Odometry = nav_msgs::msg::Odometry;
  using RackState = pipescout_msgs::msg::RackState;

  /// Images are subscribed to when enough subscriptions of what is found are matched.
  void subscribe();
  void on_image(const Image& message);
  void on_camera_info(const CameraInfo& message);
  void on_odometry(const Odometry& message);
  void on_rack_state(const RackState& message);

  [[nodiscard]] std::optional<leak_findings::FramePose> pose_at(Time stamp) const;
  /// Records images; failures are counted, and the inspection continues.
  void record(const ThermalImageReader::View& picture, const leak_findings::Frame& frame);
  /// Keeps the picture of each finding that none has shown better.
  void keep_evidence(const leak_findings::FrameResult& result, const leak_findings::Frame& frame,
                     const ThermalImageReader::View& picture, std::span<const float> celsius,
                     const thermal::Detections& detections);
  void publish(const leak_findings::Event& event, const Image& picture);
  /// For the archive: failures are counted, and the inspection continues.
  void try_to_keep(const std::function<void()>& action);
  void tell_counts();

  InspectorParameters declared_;
  AwaitedSubscribers awaited_{
      *this, "the component subscribes to images", {"detections", "events"}};

  // As configured.
  std::optional<InspectorSettings> settings_;

  std::optional<thermal::LeakDetector> detector_;
  std::optional<thermal::RadiometryPosterior> posterior_;  // with the contrast rule
  bool levels_ = false;                                    // images of automatic gain came
  std::optional<geometry::Camera> camera_;
  std::optional<CameraInfo> calibration_;
  std::optional<leak_findings::LeakFindings> findings_;  // from the first calibration on
  std::optional<OdometryHistory> odometry_;
  ThermalImageReader reader_;
  std::unique_ptr<FindingsArchive> archive_;
  std::unique_ptr<PictureRecording> recording_;  // nothing where no pictures are kept
  std::vector<Eigen::Vector2d> track_;           // of the robot in the map, m
  std::vector<float> temperatures_;              // of a picture that is evidence, degC
  std::uint64_t frame_ = 0;
  std::uint64_t with_pipe_ = 0;
  std::uint64_t failed_ = 0;

  Publisher<pipescout_msgs::msg::LeakDetections> detections_publisher_;
  Publisher<pipescout_msgs::msg::LeakEvent> event_publisher_;
  Subscription<Image> image_subscription_;
  Subscription<CameraInfo> camera_info_subscription_;
  Subscription<Odometry> odometry_subscription_;
  Subscription<RackState> rack_subscription_;
  SilenceWatch image_silence_{
      *this, "image.silent",
      [this](std::string_view counter, std::string_view text) { report_fault(counter, text); }};
  std::shared_ptr<Timer> counts_timer_;
};

}  // namespace pipescout
