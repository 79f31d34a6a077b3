// SPDX-License-Identifier: Apache-2.0
#include "motion_prediction.hpp"

#include <algorithm>
#include <cmath>

namespace pipescout::navigation {
namespace {

constexpr double kStep = 0.25;            ///< m, of a prediction; far less than a robot's length
constexpr double kMovesNoCloser = 0.02;   ///< m
constexpr double kSteeringAhead = 0.3;    ///< s, half of what the wheels need for a usual turn
constexpr double kLargestApproach = 0.5;  ///< sine of the heading in which it returns to the path
constexpr double kTaperEnd = 0.7;         ///< m before the end of a segment an offset is gone,
constexpr double kTaper = 3;              ///< m, and over which it goes
constexpr double kNothingLeft = 0.005;    ///< m
constexpr double kDriftAhead = 3;         ///< s before the end, from when on the drift is led

}  // namespace

BodyBox::BodyBox(const Footprint& footprint) {
  for (const Point2d& corner : footprint.corners()) {
    front = std::max(front, corner.x);
    rear = std::max(rear, -corner.x);
    left = std::max(left, corner.y);
    right = std::max(right, -corner.y);
  }
}

MotionPrediction::MotionPrediction(const DrivingParameters& parameters, const Footprint& footprint)
    : parameters_(parameters), margin_(parameters.margin), body_(footprint) {
  cells_.reserve(parameters.most_obstacle_cells);
  obstacles_.reserve(2 * parameters.most_obstacle_cells);
}

double MotionPrediction::curvature(const PathTrack& track, const Stretch& stretch,
                                   const TrackPoint& point, const Pose2d& pose,
                                   double speed) const {
  const auto& p = parameters_;
  const double ahead = (stretch.back ? -1 : 1) * std::abs(speed) * kSteeringAhead;
  const double along = track.at(stretch.segment, point, point.arc + ahead).curvature;
  const double offset =
      stretch.offset *
          std::clamp((track.end(stretch.segment) - point.arc - kTaperEnd) / kTaper, 0.0, 1.0) -
      // Braked gently to a stop, it takes so long to the end, and drifts onto it meanwhile.
      stretch.drift *
          std::min(kDriftAhead,
                   std::sqrt(2 * std::max(0.0, stretch.remaining(point.arc)) / p.gentle_braking));
  const double dx = pose.x - point.pose.x;
  const double dy = pose.y - point.pose.y;
  const double convergence = std::max(p.convergence_length, p.convergence_time * std::abs(speed));
  const double reach = 2 * p.damping * kLargestApproach * convergence;
  const double lateral =
      std::clamp(-std::sin(point.pose.heading) * dx + std::cos(point.pose.heading) * dy - offset,
                 -reach, reach);
  const double heading = wrap_angle(pose.heading - point.pose.heading);
  const double rate = 1 / convergence;
  const double parallel = along / std::max(0.2, 1 - along * offset);
  const double wanted =
      parallel - rate * rate * lateral - 2 * p.damping * rate * stretch.sign() * std::sin(heading);
  const double largest = std::tan(p.largest_steering) / p.wheel_base;
  return std::clamp(wanted, -largest, largest);
}

bool MotionPrediction::set_obstacles(const LocalCostmap& costmap, std::span<const Point2d> told,
                                     std::span<const MovingObstacle> moving, const Pose2d& pose,
                                     double now) {
  cells_.clear();
  obstacles_.clear();
  const double half_cell = 0.5 * costmap.parameters().resolution;
  const double radius = parameters_.horizon + body_.front;
  bool all = costmap.occupied_near(pose.position(), radius, now, cells_);
  for (const Point2d& cell : told) {
    if (distance(cell, pose.position()) > radius) {
      continue;
    }
    if (cells_.size() == cells_.capacity()) {
      all = false;
      break;
    }
    cells_.push_back(cell);
  }
  for (const Point2d& cell : cells_) {
    obstacles_.push_back({.x = cell.x, .y = cell.y, .radius = half_cell});
  }
  for (const MovingObstacle& each : moving) {
    const double age = std::max(0.0, now - each.seen);
    obstacles_.push_back({.x = each.centre.x + each.vx * age,
                          .y = each.centre.y + each.vy * age,
                          .vx = each.vx,
                          .vy = each.vy,
                          .radius = each.radius,
                          .growth = parameters_.growth});
  }
  const double cosine = std::cos(pose.heading);
  const double sine = std::sin(pose.heading);
  for (ObstaclePoint& point : obstacles_) {
    const double dx = point.x - pose.x;
    const double dy = point.y - pose.y;
    const double x = cosine * dx + sine * dy;
    const double y = -sine * dx + cosine * dy;
    point.clearance =
        std::max({x - body_.front, -body_.rear - x, y - body_.left, -body_.right - y});
  }
  return all;
}

const ObstaclePoint* MotionPrediction::contact(const Pose2d& pose, double time,
                                               double extra) const {
  const double cosine = std::cos(pose.heading);
  const double sine = std::sin(pose.heading);
  for (const ObstaclePoint& point : obstacles_) {
    const bool moves = point.growth > 0;
    if (moves && time > parameters_.foresight) {
      continue;
    }
    const double dx = point.x + point.vx * time - pose.x;
    const double dy = point.y + point.vy * time - pose.y;
    const double x = cosine * dx + sine * dy;
    const double y = -sine * dx + cosine * dy;
    const double margin = std::max(0.0, std::min(point.radius + point.growth * time +
                                                     (moves ? parameters_.margin : margin_) + extra,
                                                 point.clearance - kMovesNoCloser));
    if (x < body_.front + margin && x > -body_.rear - margin && y < body_.left + margin &&
        y > -body_.right - margin) {
      return &point;
    }
  }
  return nullptr;
}

MotionPrediction::Outcome MotionPrediction::drive(const PathTrack& track, const Stretch& stretch,
                                                  const TrackPoint& start,
                                                  const VehicleState& vehicle, double speed,
                                                  double extra, double horizon) const {
  const auto& p = parameters_;
  Pose2d pose = vehicle.pose;
  double steering = vehicle.steering;
  TrackPoint point = start;
  Outcome outcome;
  double time = 0;
  while (outcome.free < horizon) {
    const double step = std::min(kStep, stretch.remaining(point.arc));
    if (step <= kNothingLeft) {
      return outcome;
    }
    const double wanted = std::atan(p.wheel_base * curvature(track, stretch, point, pose, speed));
    const double turn = p.steering_rate * step / speed;
    steering += std::clamp(wanted - steering, -turn, turn);
    pose = drive_arc(pose, std::tan(steering) / p.wheel_base, stretch.sign() * step);
    time += step / speed;
    if (const ObstaclePoint* obstacle = contact(pose, time, extra)) {
      outcome.hit = true;
      outcome.moving = obstacle->growth > 0;
      return outcome;
    }
    outcome.free += step;
    point = track.nearest(stretch.segment, point, 4 * kStep, pose.position());
  }
  return outcome;
}

}  // namespace pipescout::navigation
