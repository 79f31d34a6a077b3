// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <optional>
#include <pipescout_msgs/msg/pipe_track.hpp>
#include <pipescout_msgs/msg/pipe_track_particles.hpp>
#include <span>

#include "pipescout/thermal_tracker/tracker_settings.hpp"
#include "pipescout/tracking/image_motion.hpp"

namespace pipescout {

/// Tracks a valve or a vessel through thermal images: hot regions, and a tracker of its shape.
/// Pure; not thread-safe.
class BodyTracker {
 public:
  struct Frame {
    double time = 0;  ///< s
    tracking::ImageSize image{};
    std::span<const float> celsius{};
    std::optional<tracking::ImageMotion> motion{};
  };

  BodyTracker() = default;
  BodyTracker(const BodyTracker&) = delete;
  BodyTracker& operator=(const BodyTracker&) = delete;
  virtual ~BodyTracker() = default;

  /// The next image. Throws std::invalid_argument when the number of temperatures is not that of
  /// its pixels.
  virtual void update(const Frame& frame) = 0;
  [[nodiscard]] virtual tracking::TrackState state() const = 0;
  [[nodiscard]] virtual tracking::TrackFault fault() const = 0;
  /// px; nothing without a track in the image.
  [[nodiscard]] virtual std::optional<Eigen::Vector2d> middle() const = 0;
  /// All but header, fault and range.
  [[nodiscard]] virtual pipescout_msgs::msg::PipeTrack message() const = 0;
  /// As `particles_message`.
  [[nodiscard]] virtual pipescout_msgs::msg::PipeTrackParticles particles(
      std::size_t most) const = 0;
};

/// Nothing for a pipe.
[[nodiscard]] std::unique_ptr<BodyTracker> make_body_tracker(const TrackerSettings& settings);

}  // namespace pipescout
