// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include "moving_obstacles.hpp"
#include "path_track.hpp"
#include "pipescout/driving/driving_parameters.hpp"
#include "pipescout/navigation_maps/footprint.hpp"

namespace pipescout::navigation {

/// The bounding rectangle of a footprint in the robot's frame, m.
struct BodyBox {
  explicit BodyBox(const Footprint& footprint);

  double front = 0;
  double rear = 0;  ///< behind the origin, usually positive
  double left = 0;
  double right = 0;  ///< to the right of the origin, usually positive
};

/// What must not be touched, and how it moves.
struct ObstaclePoint {
  double x = 0;
  double y = 0;
  double vx = 0;
  double vy = 0;
  double radius = 0;
  double growth = 0;     ///< m/s
  double clearance = 0;  ///< m, now: the margin is never more than this
};

/// Pose and steering of the vehicle at some time.
struct VehicleState {
  Pose2d pose;
  double speed = 0;     ///< m/s
  double steering = 0;  ///< rad
};

/// What of the path is driven: a segment, in its direction or back along it.
struct Stretch {
  PathTrack::Segment segment;
  bool back = false;
  double end = 0;     ///< m of arc length, where it stops
  double offset = 0;  ///< m, to the left
  double drift = 0;   ///< m/s, sideways to the left of the robot

  /// Of the motion: +1 forwards.
  [[nodiscard]] double sign() const { return back ? -segment.sign : segment.sign; }
  [[nodiscard]] double remaining(double arc) const { return back ? arc - end : end - arc; }
};

/// Moves a vehicle as the parameters describe it along a stretch among obstacles.
class MotionPrediction {
 public:
  MotionPrediction(const DrivingParameters& parameters, const Footprint& footprint);

  /// Curvature that brings the robot to the path and along it, 1/m, within the steering's reach.
  [[nodiscard]] double curvature(const PathTrack& track, const Stretch& stretch,
                                 const TrackPoint& point, const Pose2d& pose, double speed) const;

  /// Fills the obstacles from all sources. Allocates nothing.
  /// False when there are more occupied cells than `most_obstacle_cells`.
  [[nodiscard]] bool set_obstacles(const LocalCostmap& costmap, std::span<const Point2d> told,
                                   std::span<const MovingObstacle> moving, const Pose2d& pose,
                                   double now);

  /// m, from now on, around what does not move.
  void set_margin(double margin) { margin_ = margin; }

  struct Outcome {
    double free = 0;      ///< m, without contact
    bool hit = false;     ///< before the end of the stretch or the horizon
    bool moving = false;  ///< by something that moves
  };
  /// With `extra` m more of a margin, at a constant speed, over `horizon` m.
  [[nodiscard]] Outcome drive(const PathTrack& track, const Stretch& stretch,
                              const TrackPoint& start, const VehicleState& vehicle, double speed,
                              double extra, double horizon) const;

 private:
  [[nodiscard]] const ObstaclePoint* contact(const Pose2d& pose, double time, double extra) const;

  DrivingParameters parameters_;
  double margin_;
  BodyBox body_;
  std::vector<Point2d> cells_;
  std::vector<ObstaclePoint> obstacles_;
};

}  // namespace pipescout::navigation
