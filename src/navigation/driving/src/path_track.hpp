// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "pipescout/driving/driving_parameters.hpp"
#include "pipescout/navigation_maps/path.hpp"

namespace pipescout::navigation {

/// Where on a segment of the path something is.
struct TrackPoint {
  std::size_t index = 0;  ///< of the pose before it
  double arc = 0;         ///< m
  Pose2d pose;            ///< on the path
  double curvature = 0;   ///< 1/m
};

/// A path in segments between cusps, with the speed that curves and cusps allow.
class PathTrack {
 public:
  struct Segment {
    std::size_t first = 0;
    std::size_t last = 0;  ///< a pose of its own at the end
    double sign = 1;       ///< -1: in reverse
  };

  PathTrack() = default;
  /// Throws std::invalid_argument as LocalPlanner::set_path does.
  PathTrack(const Path& path, const DrivingParameters& parameters);

  [[nodiscard]] bool empty() const { return segments_.empty(); }
  [[nodiscard]] const std::vector<Segment>& segments() const { return segments_; }
  [[nodiscard]] double begin(const Segment& segment) const {
    return poses_[segment.first].arc_length;
  }
  [[nodiscard]] double end(const Segment& segment) const { return poses_[segment.last].arc_length; }
  [[nodiscard]] const Pose2d& end_pose(const Segment& segment) const {
    return poses_[segment.last].pose;
  }
  [[nodiscard]] double length() const { return poses_.empty() ? 0 : poses_.back().arc_length; }

  /// The nearest point of the segment within `reach` m of arc length around `near`.
  [[nodiscard]] TrackPoint nearest(const Segment& segment, const TrackPoint& near, double reach,
                                   const Point2d& position) const;
  /// At an arc length, held within the segment; searched from `near` on.
  [[nodiscard]] TrackPoint at(const Segment& segment, const TrackPoint& near, double arc) const;
  /// m/s, at a point: 0 at the end of a segment.
  [[nodiscard]] double allowed_speed(const TrackPoint& point) const;

 private:
  void find_speeds(const DrivingParameters& parameters);

  std::vector<PathPose> poses_;
  std::vector<Segment> segments_;
  std::vector<double> speeds_;  ///< m/s, one for each pose
  double braking_ = 0;
};

}  // namespace pipescout::navigation
