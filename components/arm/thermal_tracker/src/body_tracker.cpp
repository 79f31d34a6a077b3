// SPDX-License-Identifier: Apache-2.0
#include "body_tracker.hpp"

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "pipescout/message_conversions/tracked_section.hpp"
#include "pipescout/tracking/hot_regions.hpp"
#include "pipescout/tracking/shape_tracker.hpp"
#include "track_messages.hpp"

namespace pipescout {
namespace {

using tracking::HotRegionFinder;
using tracking::ShapeTrackerParameters;
using tracking::TrackState;
using tracking::ValveShape;
using tracking::VesselShape;

std::vector<ValveShape::Region> found(const HotRegionFinder& finder, const ValveShape& /*shape*/) {
  return finder.valves();
}

std::vector<VesselShape::Region> found(const HotRegionFinder& finder,
                                       const VesselShape& /*shape*/) {
  return finder.vessels();
}

/// As given for pipes, but for what is a number of the shape: these are its own.
template <class Shape>
ShapeTrackerParameters<Shape> parameters_of(const tracking::PipeTrackerParameters& given) {
  ShapeTrackerParameters<Shape> result;
  result.filter.particles = given.filter.particles;
  result.filter.resample_share = given.filter.resample_share;
  result.filter.best_particles = given.filter.best_particles;
  result.filter.resampling = given.filter.resampling;
  result.motion_share = given.motion_share;
  result.rate_memory = given.rate_memory;
  result.gate = given.gate;
  result.detection = given.detection;
  result.clutter = given.clutter;
  result.doubt = given.doubt;
  result.confirm = given.confirm;
  result.confidence_time = given.confidence_time;
  result.max_coast = given.max_coast;
  result.max_lost = given.max_lost;
  result.max_back = given.max_back;
  result.max_regions = given.max_regions;
  result.guard_distance = given.guard_distance;
  return result;
}

template <class Shape>
class TrackerOf final : public BodyTracker {
 public:
  explicit TrackerOf(const TrackerSettings& settings)
      : finder_(settings.regions),
        tracker_(Shape{}, parameters_of<Shape>(settings.tracker), settings.seed) {}

  void update(const Frame& frame) override {
    finder_.find(frame.celsius, frame.image);
    regions_ = found(finder_, Shape{});
    tracker_.update(
        {.time = frame.time, .image = frame.image, .regions = regions_, .motion = frame.motion});
  }
  [[nodiscard]] TrackState state() const override { return tracker_.track().state; }
  [[nodiscard]] tracking::TrackFault fault() const override { return tracker_.track().fault; }
  [[nodiscard]] std::optional<Eigen::Vector2d> middle() const override {
    const tracking::Track<Shape>& track = tracker_.track();
    return track.number > 0 && track.in_view
               ? std::optional(Eigen::Vector2d(track.estimate.template head<2>()))
               : std::nullopt;
  }
  [[nodiscard]] pipescout_msgs::msg::PipeTrack message() const override {
    const tracking::Track<Shape>& track = tracker_.track();
    auto message = track_message(track);
    // Predicted for long, a shape that was shrinking has no size left.
    message.estimate.length = std::max(0.0, message.estimate.length);
    message.half_width = std::numeric_limits<double>::quiet_NaN();
    if (middle()) {
      message.half_width = std::max(0.0, half_width_of(track.estimate));
      message.whole_width = whole_width_in_view(from_message(message.estimate), message.half_width,
                                                track.image.width, track.image.height);
    }
    return message;
  }
  [[nodiscard]] pipescout_msgs::msg::PipeTrackParticles particles(std::size_t most) const override {
    return particles_message<Shape>(tracker_.filter(), regions_, most);
  }

 private:
  HotRegionFinder finder_;
  tracking::ShapeTracker<Shape> tracker_;
  std::vector<typename Shape::Region> regions_;
};

}  // namespace

std::unique_ptr<BodyTracker> make_body_tracker(const TrackerSettings& settings) {
  switch (settings.followed) {
    case FollowedShape::kValve:
      return std::make_unique<TrackerOf<ValveShape>>(settings);
    case FollowedShape::kVessel:
      return std::make_unique<TrackerOf<VesselShape>>(settings);
    case FollowedShape::kPipe:
      break;
  }
  return nullptr;
}

}  // namespace pipescout
