// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_vision/way_point_mission.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "pipescout/validation/check.hpp"

namespace pipescout::rack_vision {
namespace {

// s: so far does the path run in one call, however long ago the one before was.
constexpr double kLongestStep = 0.2;
// Largest rate of the progress along a round that takes 1 s, see `progress`.
constexpr double kLargestRate = 1.875;

/// From 0 to 1 while u does, at rest at both ends: progress and its first two derivatives.
struct Progress {
  double value;
  double rate;
  double change;
};
Progress progress(double u) noexcept {
  return {u * u * u * (10 - 15 * u + 6 * u * u), 30 * u * u * (1 - u) * (1 - u),
          60 * u * (1 - u) * (1 - 2 * u)};
}

}  // namespace

void WayPointMissionParameters::validate() const {
  tolerance.validate();
  validation::check_within("reached_for", reached_for, 0, 60);
  validation::check_within("deviations_within", deviations_within, 0, 10);
  validation::check_within("look_around", look_around, 0, 2);
  validation::check_above("look_around_speed", look_around_speed, 0, 20);
  validation::check_within("patience", patience, 0, 3600);
  validation::check_above("largest_lag", largest_lag, 0, 100);
  validation::check_above("largest_yaw_lag", largest_yaw_lag, 0, std::numbers::pi);
}

WayPointMission::WayPointMission(WayPointPath path, const WayPointMissionParameters& parameters)
    : path_(std::move(path)),
      parameters_(parameters),
      outcomes_(path_.way_points().size(), WayPointOutcome::kPending) {
  parameters_.validate();
}

void WayPointMission::advance(double now, const std::optional<LevelPose>& pose) {
  if (!std::isfinite(now) || complete_) {
    return;
  }
  const double before = now_.value_or(now);
  const double interval = std::clamp(now - before, 0.0, kLongestStep);
  now_ = std::max(now, before);
  if (!pose || !keeps_up(*pose)) {
    waiting_ = true;
    round_runs_ = false;
    within_since_.reset();
    return;
  }
  const double last_of_this = path_.departure(current_);
  const bool at_its_end = path_time_ >= last_of_this;
  if (waiting_ && !at_its_end) {
    waiting_ = false;
    running_since_ = before;
  }
  path_time_ = std::min(path_time_ + interval, last_of_this);
  judge(interval, *pose);
}

bool WayPointMission::keeps_up(const LevelPose& pose) const noexcept {
  const PathPoint wanted = target(pose.time);
  // Written so that a pose that holds NaN does not.
  return std::isfinite(pose.time) &&
         (pose.position - wanted.position).norm() <= parameters_.largest_lag &&
         std::abs(wrap_angle(pose.yaw - wanted.yaw)) <= parameters_.largest_yaw_lag;
}

bool WayPointMission::knows_well_enough(const LevelPose& pose) const noexcept {
  // Written so that deviations that are NaN do not.
  const double deviations = parameters_.deviations_within;
  return deviations == 0 ||
         (deviations * pose.position_deviation <= parameters_.tolerance.position &&
          deviations * pose.yaw_deviation <= parameters_.tolerance.yaw);
}

bool WayPointMission::is_there(const LevelPose& pose) const noexcept {
  return is_reached(path_.way_points()[current_], pose.position, pose.yaw, parameters_.tolerance);
}

void WayPointMission::judge(double interval, const LevelPose& pose) {
  const bool stays = path_time_ >= path_.arrival(current_) && !round_time_;
  if (stays && knows_well_enough(pose) && is_there(pose)) {
    within_since_ = within_since_.value_or(*now_);
    if (*now_ - *within_since_ >= parameters_.reached_for) {
      outcomes_[current_] = WayPointOutcome::kReached;
    }
  } else {
    within_since_.reset();
  }
  if (path_time_ < path_.departure(current_)) {
    return;
  }
  waited_ += interval;
  if (outcomes_[current_] == WayPointOutcome::kPending) {
    waiting_ = true;
    if (round_time_) {
      round_runs_ = true;
      *round_time_ += interval;
      if (*round_time_ < round_duration()) {
        return;
      }
      round_time_.reset();
      to_the_right_ = !to_the_right_;
    }
    if (waited_ < parameters_.patience) {
      if (parameters_.look_around > 0 && is_there(pose) && !knows_well_enough(pose)) {
        round_time_ = 0;
      }
      return;
    }
    outcomes_[current_] = WayPointOutcome::kMissed;
  }
  complete_ = current_ + 1 == outcomes_.size();
  waiting_ = true;  // until the next call: this one has used up its time
  if (!complete_) {
    ++current_;
    waited_ = 0;
    within_since_.reset();
  }
}

double WayPointMission::round_duration() const noexcept {
  return kLargestRate * 2 * std::numbers::pi * parameters_.look_around /
         parameters_.look_around_speed;
}

void WayPointMission::add_round(double round_time, PathPoint& point) const noexcept {
  const double duration = round_duration();
  const Progress gone = progress(std::clamp(round_time / duration, 0.0, 1.0));
  const double angle = 2 * std::numbers::pi * gone.value;
  const double rate = 2 * std::numbers::pi * gone.rate / duration;
  const double change = 2 * std::numbers::pi * gone.change / (duration * duration);
  const double side = to_the_right_ ? parameters_.look_around : -parameters_.look_around;
  const double up = parameters_.look_around;
  const Eigen::Vector3d along(side * std::cos(angle), 0, up * std::sin(angle));
  const Eigen::Vector3d inwards(-side * std::sin(angle), 0, up * std::cos(angle));
  point.position += Eigen::Vector3d(side * std::sin(angle), 0, up * (1 - std::cos(angle)));
  if (round_runs_) {
    point.velocity = rate * along;
    point.acceleration = change * along + rate * rate * inwards;
  }
}

PathPoint WayPointMission::target(double time) const noexcept {
  if (waiting_ || !now_) {
    PathPoint point = path_.at(path_time_);
    point.velocity.setZero();
    point.acceleration.setZero();
    point.yaw_rate = 0;
    point.yaw_acceleration = 0;
    if (round_time_) {
      const double age = std::clamp(*now_ - time, 0.0, *round_time_);
      add_round(*round_time_ - age, point);
    }
    return point;
  }
  const double age = std::clamp(*now_ - time, 0.0, std::max(0.0, *now_ - running_since_));
  return path_.at(path_time_ - age);
}

std::size_t WayPointMission::count(WayPointOutcome outcome) const noexcept {
  return static_cast<std::size_t>(std::ranges::count(outcomes_, outcome));
}

}  // namespace pipescout::rack_vision
