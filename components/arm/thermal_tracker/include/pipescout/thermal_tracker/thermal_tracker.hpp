// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <nav_msgs/msg/odometry.hpp>
#include <optional>
#include <pipescout_msgs/msg/pipe_track.hpp>
#include <pipescout_msgs/msg/pipe_track_particles.hpp>
#include <sensor_msgs/msg/camera_info.hpp>
#include <sensor_msgs/msg/image.hpp>
#include <span>
#include <vector>

#include "pipescout/geometry/camera.hpp"
#include "pipescout/message_conversions/odometry_history.hpp"
#include "pipescout/message_conversions/thermal_image.hpp"
#include "pipescout/runtime/awaited_subscribers.hpp"
#include "pipescout/runtime/component.hpp"
#include "pipescout/runtime/silence_watch.hpp"
#include "pipescout/thermal/leak_detector.hpp"
#include "pipescout/thermal_tracker/tracker_settings.hpp"
#include "pipescout/tracking/shape_tracker.hpp"

namespace pipescout {

class BodyTracker;

/// Tracks a pipe, a valve or a vessel in thermal images: `thermal/image_raw`,
/// `thermal/camera_info`, and optionally `odometry/filtered` and `/tf` in, `track/pipe` for each
/// image and `track/particles` out.
///
/// Parameters and faults: docs/components/thermal_tracker.md. Parameters take effect when it is
/// configured.
class ThermalTracker final : public Component {
 public:
  explicit ThermalTracker(ComponentOptions options);
  ~ThermalTracker() override;

 protected:
  CallbackReturn on_configure() override;
  CallbackReturn on_cleanup() override;

 private:
  using Image = sensor_msgs::msg::Image;
  using CameraInfo = sensor_msgs::msg::CameraInfo;
  using Odometry = nav_msgs::msg::Odometry;
  using PipeTrack = pipescout_msgs::msg::PipeTrack;
  using Particles = pipescout_msgs::msg::PipeTrackParticles;
  /// Metadata of an image.
  struct Circumstances {
    std::optional<geometry::SE3> T_map_camera;
    std::optional<tracking::ImageMotion> motion;
    std::optional<tracking::TrackHint<tracking::PipeShape>> hint;
    std::optional<double> depth;  // m, of the pipe of the map along the axis of the camera
  };

  /// Images are subscribed to when enough subscriptions of the track are matched.
  void subscribe();
  void on_image(const Image& message);
  void on_camera_info(const CameraInfo& message);
  void on_odometry(const Odometry& message);

  /// Of a valve or a vessel.
  void track_body(const Image& message, Time stamp, const ThermalImageReader::View& picture,
                  std::span<const float> celsius);
  /// px; the middle of the image without a track.
  [[nodiscard]] Eigen::Vector2d followed_place() const;
  [[nodiscard]] Circumstances circumstances(Time stamp, const Image& message);
  /// Fills `regions_`.
  void take_regions(const thermal::Detections& detections);
  /// m along the axis of the camera.
  [[nodiscard]] double depth(const Circumstances& known) const;
  void publish(const Image& picture, const tracking::PipeTrack& track,
               const thermal::Detections& detections, const Circumstances& known);
  void publish_body(const Image& picture, const Circumstances& known);
  void tell_counts();

  TrackerParameters declared_;
  AwaitedSubscribers awaited_{*this, "the component subscribes to images"};

  // As configured.
  std::optional<TrackerSettings> settings_;

  std::optional<thermal::LeakDetector> detector_;
  std::optional<tracking::PipeTracker> tracker_;
  std::unique_ptr<BodyTracker> body_;  // in place of both: a valve or a vessel is tracked
  std::optional<geometry::Camera> camera_;
  std::optional<CameraInfo> calibration_;
  std::optional<OdometryHistory> odometry_;
  ThermalImageReader reader_;
  std::vector<tracking::PipeRegion> regions_;
  std::vector<float> degrees_;  // degC, of the pixels, for a valve or a vessel
  struct CameraPose {
    Time time{};
    geometry::SE3 T_map_camera;
  };
  std::optional<CameraPose> last_pose_;  // of the picture before
  double half_width_ = 0;                // px, of the pipe when it was seen last; 0: never
  double width_ = 0;                     // px, between its edges when it was seen whole last
  std::uint64_t pictures_ = 0;
  std::uint64_t locked_ = 0;

  Publisher<PipeTrack> track_publisher_;
  Publisher<Particles> particles_publisher_;
  Subscription<Image> image_subscription_;
  Subscription<CameraInfo> camera_info_subscription_;
  Subscription<Odometry> odometry_subscription_;
  SilenceWatch image_silence_{
      *this, "image.silent",
      [this](std::string_view counter, std::string_view text) { report_fault(counter, text); }};
  std::shared_ptr<Timer> counts_timer_;
};

}  // namespace pipescout
