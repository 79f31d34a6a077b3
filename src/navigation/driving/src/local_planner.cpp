// SPDX-License-Identifier: Apache-2.0
#include "pipescout/driving/local_planner.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "drive_inputs.hpp"
#include "motion_prediction.hpp"

namespace pipescout::navigation {
namespace {

constexpr double kStanding = 0.03;       ///< m/s
constexpr double kAtEnd = 0.01;          ///< m
constexpr double kAligned = 0.06;        ///< rad, of the wheels, to drive off
constexpr double kReserve = 0.7;         ///< of the braking that is planned with
constexpr double kLeastSpeed = 0.1;      ///< m/s, below which it waits before an obstacle
constexpr double kPredictedSpeed = 0.3;  ///< m/s, least one of predictions
constexpr double kOffsetStep = 0.3;      ///< m
constexpr double kOffsetHeld = 2;        ///< s, that it keeps to a side before it returns
constexpr double kReturn = 0.3;          ///< m per m, in which it may come back to the path
constexpr double kSlowLength = 2.5;      ///< m, of the slow zone
constexpr double kBackStuck = 2;         ///< s, before backing up is given up
constexpr double kForgetBacking = 3;     ///< m of progress after which it may back up again
constexpr double kTightWay = 3;          ///< m that it drives with the tight margin
constexpr double kTightFree = 1.5;       ///< m that this must free to be worth it
constexpr double kGoalRun = 4;           ///< m, of another approach to the goal
constexpr double kSearch = 1.5;          ///< m of arc length
constexpr double kTangential = 1;        ///< m before the end, where its tangent counts
constexpr double kNewBeginning = 1;      ///< s: the clock was set back by more
/// 1 + twice as many offsets as the largest allowed needs.
constexpr std::size_t kMostOffsets = 2 * 34 + 1;

}  // namespace

class LocalPlanner::Implementation {
 public:
  Implementation(const DrivingParameters& parameters, const LocalCostmapParameters& costmap,
                 const Footprint& footprint)
      : parameters_(parameters), inputs_(parameters, costmap), prediction_(parameters, footprint) {
    parameters_.validate();
    const auto cycles =
        static_cast<std::size_t>(std::lround(parameters_.delay / parameters_.period));
    sent_.assign(std::max<std::size_t>(cycles, 1), {});
  }

  void set_path(const Path& path) {
    track_ = PathTrack(path, parameters_);
    begin_segment(0);
    end_ = DriveState::kDriving;
    attempts_ = 0;
    backs_ = 0;
    backed_at_ = 0;
    offset_ = preferred_;
    strayed_ = 0;
    blocked_ = 0;
    backing_ = false;
  }

  void clear_path() {
    track_ = {};
    backing_ = false;
    end_ = DriveState::kDriving;
  }

  std::optional<double> go_back_to(double arc) {
    if (track_.empty() || end_ != DriveState::kDriving || !(arc <= here_.arc)) {
      return std::nullopt;
    }
    backing_ = true;
    back_arc_ = std::max(arc, track_.begin(segment()));
    return back_arc_;
  }

  DriveCommand cycle(double now);

  DriveInputs& inputs() { return inputs_; }
  [[nodiscard]] const DriveInputs& inputs() const { return inputs_; }
  bool paused_ = false;
  double limit_ = std::numeric_limits<double>::infinity();
  double preferred_ = 0;
  [[nodiscard]] const DrivingParameters& parameters() const { return parameters_; }

 private:
  struct Sent {
    double speed = 0;
    double steering = 0;
  };

  [[nodiscard]] const PathTrack::Segment& segment() const { return track_.segments()[segment_]; }
  void begin_segment(std::size_t index) {
    segment_ = index;
    here_ = {.index = segment().first, .arc = track_.begin(segment())};
  }
  [[nodiscard]] Stretch stretch(double offset) const {
    return {segment(), backing_, backing_ ? back_arc_ : track_.end(segment()), offset,
            inputs_.drift()};
  }

  /// By `braking` m/s^2.
  DriveCommand halt(DriveCommand command, DriveState state, DriveReason reason, double braking);
  DriveCommand halt(const DriveCommand& command, DriveState state, DriveReason reason) {
    return halt(command, state, reason, parameters_.braking);
  }
  DriveCommand send(DriveCommand command, double speed, double steering, double braking);
  [[nodiscard]] double braking_before(double free) const;
  [[nodiscard]] VehicleState predicted(const Pose2d& pose) const;
  [[nodiscard]] double remaining(const TrackPoint& point, const Pose2d& pose) const;
  DriveCommand at_end(DriveCommand command, const Pose2d& pose);
  MotionPrediction::Outcome choose_offset(const TrackPoint& start, const VehicleState& vehicle,
                                          double speed);
  DriveCommand blocked(DriveCommand command, const MotionPrediction::Outcome& outcome,
                       const TrackPoint& start, const VehicleState& vehicle, double braking);
  void set_tight(double way) {
    tight_way_ = way;
    prediction_.set_margin(way > 0 ? std::min(parameters_.tight_margin, parameters_.margin)
                                   : parameters_.margin);
  }
  void start_backing(double length) {
    backing_ = true;
    back_arc_ = std::max(track_.begin(segment()), here_.arc - length);
    blocked_ = 0;
  }

  DrivingParameters parameters_;
  DriveInputs inputs_;
  MotionPrediction prediction_;
  PathTrack track_;
  std::size_t segment_ = 0;
  TrackPoint here_;
  DriveState end_ = DriveState::kDriving;  ///< or that of the end that was met
  int attempts_ = 0;
  bool backing_ = false;
  double back_arc_ = 0;
  int backs_ = 0;
  double backed_at_ = 0;  ///< m, arc length where it last backed up
  double tight_way_ = 0;  ///< m that it still drives with the tight margin
  double blocked_ = 0;    ///< s, how long it has been standing before something
  double offset_ = 0;
  double side_ = 0;         ///< of the preferred offset on which it passes: -1 right, 1 left
  double side_age_ = 0;     ///< s, since then
  double strayed_ = 0;      ///< m, how far from the path an offset has led it
  std::vector<Sent> sent_;  ///< commands that do not act yet, a ring, and the next place in it
  std::size_t next_ = 0;
  double steering_ = 0;  ///< rad, of the wheels, by the model
  Sent last_;
  std::optional<double> last_cycle_;  ///< s
};

DriveCommand LocalPlanner::Implementation::send(DriveCommand command, double speed, double steering,
                                                double braking) {
  const auto& p = parameters_;
  const bool slower = std::abs(speed) < std::abs(last_.speed) || speed * last_.speed < 0;
  const double change = (slower ? braking : p.acceleration) * p.period;
  // Through zero, never past it: the direction changes at standstill.
  double limited = last_.speed + std::clamp(speed - last_.speed, -change, change);
  if (limited * last_.speed < 0) {
    limited = 0;
  }
  const double turn = p.steering_rate * p.period;
  steering_ += std::clamp(sent_[next_].steering - steering_, -turn, turn);
  last_ = {limited, steering};
  sent_[next_] = last_;
  next_ = (next_ + 1) % sent_.size();
  command.speed = limited;
  command.curvature = std::tan(steering) / p.wheel_base;
  return command;
}

DriveCommand LocalPlanner::Implementation::halt(DriveCommand command, DriveState state,
                                                DriveReason reason, double braking) {
  command.state = state;
  command.reason = reason;
  return send(command, 0, last_.steering, braking);
}

/// m/s^2: what may be counted on, and more only where that would end in a contact.
double LocalPlanner::Implementation::braking_before(double free) const {
  const auto& p = parameters_;
  const double speed = std::abs(last_.speed);
  const double room = free - speed * (p.delay + p.period);
  return speed * speed < 2 * p.braking * room ? p.braking : p.hardest_braking;
}

/// When the next command will act.
VehicleState LocalPlanner::Implementation::predicted(const Pose2d& pose) const {
  const auto& p = parameters_;
  VehicleState state{pose, inputs_.speed(), steering_};
  const auto cycles = static_cast<std::size_t>(std::lround(p.delay / p.period));
  for (std::size_t i = 0; i < cycles; ++i) {
    const Sent& sent = sent_[(next_ + i) % sent_.size()];
    const double turn = p.steering_rate * p.period;
    const double change = p.hardest_braking * p.period;
    state.steering += std::clamp(sent.steering - state.steering, -turn, turn);
    state.speed += std::clamp(sent.speed - state.speed, -change, change);
    state.pose =
        drive_arc(state.pose, std::tan(state.steering) / p.wheel_base, state.speed * p.period);
  }
  return state;
}

double LocalPlanner::Implementation::remaining(const TrackPoint& point, const Pose2d& pose) const {
  if (backing_) {
    return point.arc - back_arc_;
  }
  const double left = track_.end(segment()) - point.arc;
  if (left > kTangential) {
    return left;
  }
  const Pose2d& end = track_.end_pose(segment());
  return segment().sign *
         ((end.x - pose.x) * std::cos(end.heading) + (end.y - pose.y) * std::sin(end.heading));
}

DriveCommand LocalPlanner::Implementation::at_end(DriveCommand command, const Pose2d& pose) {
  if (std::abs(inputs_.speed()) > kStanding || std::abs(last_.speed) > 0) {
    command.state = backing_ ? DriveState::kBackingUp : DriveState::kDriving;
    return send(command, 0, last_.steering, parameters_.braking);
  }
  if (backing_) {
    backing_ = false;
    return halt(command, DriveState::kDriving, DriveReason::kNone);
  }
  if (segment_ + 1 < track_.segments().size()) {
    begin_segment(segment_ + 1);
    offset_ = 0;
    return halt(command, DriveState::kSteering, DriveReason::kNone);
  }
  const Pose2d& goal = track_.end_pose(segment());
  if (distance(goal, pose) <= parameters_.goal_distance &&
      std::abs(wrap_angle(goal.heading - pose.heading)) <= parameters_.goal_heading) {
    end_ = DriveState::kReached;
    return halt(command, end_, DriveReason::kNone);
  }
  if (++attempts_ >= parameters_.goal_attempts) {
    end_ = DriveState::kFailed;
    return halt(command, end_, DriveReason::kGoalMissed);
  }
  start_backing(kGoalRun);
  return halt(command, DriveState::kBackingUp, DriveReason::kGoalMissed);
}

MotionPrediction::Outcome LocalPlanner::Implementation::choose_offset(const TrackPoint& start,
                                                                      const VehicleState& vehicle,
                                                                      double speed) {
  const auto& p = parameters_;
  const auto drive = [&](double offset, double extra) {
    return prediction_.drive(track_, stretch(offset), start, vehicle, speed, extra, p.horizon);
  };
  side_age_ += p.period;
  if (backing_) {
    return drive(offset_, 0);
  }
  const bool at_preferred = offset_ == preferred_;
  const MotionPrediction::Outcome current = drive(offset_, 0);
  if (at_preferred && !current.hit) {
    return current;
  }
  std::array<double, kMostOffsets> offsets{};
  std::size_t count = 0;
  const auto most = static_cast<int>(p.largest_offset / kOffsetStep);
  for (int i = -most; i <= most; ++i) {
    offsets[count++] = i * kOffsetStep;
  }
  if (std::abs(preferred_) > 0) {
    offsets[count++] = preferred_;
  }
  const auto cost = [&](double offset) {
    return std::abs(offset - preferred_) + 0.5 * std::abs(offset - offset_);
  };
  std::sort(offsets.begin(), offsets.begin() + static_cast<std::ptrdiff_t>(count),
            [&](double a, double b) { return cost(a) != cost(b) ? cost(a) < cost(b) : a < b; });
  const auto gives_way = [&](double offset) {
    return (offset - preferred_) * side_ < (offset_ - preferred_) * side_;
  };
  for (std::size_t i = 0; i < count; ++i) {
    if (!current.hit && cost(offsets[i]) >= cost(offset_)) {
      break;
    }
    if (offsets[i] == offset_ || (side_age_ < kOffsetHeld && gives_way(offsets[i]))) {
      continue;
    }
    const MotionPrediction::Outcome outcome = drive(offsets[i], p.hysteresis);
    if (!outcome.hit) {
      offset_ = offsets[i];
      if (offset_ != preferred_) {
        side_ = offset_ < preferred_ ? -1 : 1;
        side_age_ = 0;
      }
      return outcome;
    }
  }
  return current;
}

DriveCommand LocalPlanner::Implementation::blocked(DriveCommand command,
                                                   const MotionPrediction::Outcome& outcome,
                                                   const TrackPoint& start,
                                                   const VehicleState& vehicle, double braking) {
  const auto& p = parameters_;
  command.reason = outcome.moving ? DriveReason::kMovingObstacle : DriveReason::kPathBlocked;
  blocked_ += p.period;
  if (backing_ && blocked_ > kBackStuck) {
    backing_ = false;
    blocked_ = p.wait_time;
  }
  if (!backing_ && blocked_ > p.wait_time && !outcome.moving && tight_way_ <= 0) {
    set_tight(kTightWay);
    const MotionPrediction::Outcome tight =
        prediction_.drive(track_, stretch(offset_), start, vehicle, kPredictedSpeed, 0, p.horizon);
    if (!tight.hit || tight.free > outcome.free + kTightFree) {
      blocked_ = 0;
      return halt(command, DriveState::kWaiting, command.reason, braking);
    }
    set_tight(0);
  }
  if (!backing_ && blocked_ > p.wait_time) {
    const bool room = here_.arc - track_.begin(segment()) > kAtEnd && p.back_up_length > 0;
    if (backs_ == 0 && room) {
      ++backs_;
      backed_at_ = here_.arc;
      start_backing(p.back_up_length);
    } else {
      command.replan = true;
    }
  }
  return halt(command, DriveState::kWaiting, command.reason, braking);
}

DriveCommand LocalPlanner::Implementation::cycle(double now) {
  const auto& p = parameters_;
  DriveCommand command;
  if (last_cycle_ && now < *last_cycle_ - kNewBeginning) {
    inputs_.forget();
  }
  last_cycle_ = now;
  if (track_.empty()) {
    return halt(command, DriveState::kIdle, DriveReason::kNone);
  }
  command.offset = offset_;
  if (const DriveReason fault = inputs_.fault(now); fault != DriveReason::kNone) {
    return halt(command, end_ == DriveState::kDriving ? DriveState::kWaiting : end_, fault);
  }
  const Pose2d pose = inputs_.pose_at(now);
  here_ = track_.nearest(segment(), here_, kSearch, pose.position());
  const Pose2d error = relative(here_.pose, pose);
  command.travelled = here_.arc;
  command.remaining = track_.length() - here_.arc;
  command.lateral_error = error.y;
  command.heading_error = error.heading;
  if (end_ != DriveState::kDriving) {
    return halt(command, end_,
                end_ == DriveState::kFailed ? DriveReason::kGoalMissed : DriveReason::kNone);
  }
  if (paused_ && last_.speed == 0) {
    return halt(command, DriveState::kWaiting, DriveReason::kPaused);
  }
  // What it left the path for may be gone sooner than it is back.
  strayed_ = std::max(std::abs(offset_), strayed_ - kReturn * std::abs(inputs_.speed()) * p.period);
  if (distance(here_.pose, pose) > p.largest_error + strayed_) {
    command.replan = true;
    return halt(command, DriveState::kWaiting, DriveReason::kOffPath);
  }
  if (here_.arc > backed_at_ + kForgetBacking || here_.arc < backed_at_ - 2 * p.back_up_length) {
    backs_ = 0;
  }

  const VehicleState vehicle = predicted(pose);
  const TrackPoint start = track_.nearest(segment(), here_, kSearch, vehicle.pose.position());
  const double left = remaining(start, vehicle.pose);
  if (left <= kAtEnd) {
    return at_end(command, pose);
  }
  if (!inputs_.has_room() || !prediction_.set_obstacles(inputs_.costmap(), inputs_.told_cells(now),
                                                        inputs_.obstacles().moving(), pose, now)) {
    return halt(command, DriveState::kWaiting, DriveReason::kTooManyObstacles);
  }
  const double speed = std::max(std::abs(vehicle.speed), kPredictedSpeed);
  const MotionPrediction::Outcome outcome = choose_offset(start, vehicle, speed);
  const Stretch way = stretch(offset_);
  command.offset = offset_;
  command.free_distance = outcome.free;
  const double wanted = std::atan(
      p.wheel_base * prediction_.curvature(track_, way, start, vehicle.pose, vehicle.speed));

  command.state = backing_ ? DriveState::kBackingUp : DriveState::kDriving;
  double allowed = backing_
                       ? std::min(p.reverse_speed, std::sqrt(2 * p.gentle_braking * left))
                       : std::max(p.creep_speed, std::min(track_.allowed_speed(start),
                                                          std::sqrt(2 * p.gentle_braking * left)));
  allowed = std::max(allowed, p.creep_speed);
  if (tight_way_ > 0) {
    allowed = std::min(allowed, p.tight_speed);
    command.reason = DriveReason::kObstacleNear;
    set_tight(tight_way_ - std::abs(inputs_.speed()) * p.period);
  }
  double braking = p.braking;
  if (const double limit = paused_ ? 0 : limit_; limit < allowed) {
    // Nobody is in a hurry, unless the path or an obstacle asks for less too.
    braking = allowed < std::abs(last_.speed) ? p.braking : p.gentle_braking;
    allowed = limit;
    command.reason = paused_ ? DriveReason::kPaused : DriveReason::kSpeedLimit;
  }
  if (allowed > p.slow_speed && p.slow_zone > p.margin &&
      prediction_.drive(track_, way, start, vehicle, speed, p.slow_zone - p.margin, kSlowLength)
          .hit) {
    allowed = p.slow_speed;
    command.reason = DriveReason::kObstacleNear;
  }
  if (outcome.hit) {
    // v t + v^2 / 2 b = distance: t until the brakes act.
    const double planned = kReserve * p.braking;
    const double dead = planned * (p.delay + p.period);
    const double room = std::max(0.0, outcome.free - p.stop_gap);
    const double safe = std::sqrt(dead * dead + 2 * planned * room) - dead;
    if (safe < std::abs(last_.speed)) {
      braking = braking_before(outcome.free);
    }
    if (safe < kLeastSpeed) {
      return blocked(command, outcome, start, vehicle, braking);
    }
    if (safe < allowed) {
      allowed = safe;
      command.reason = outcome.moving ? DriveReason::kMovingObstacle : DriveReason::kPathBlocked;
    }
  }
  blocked_ = 0;
  if (std::abs(inputs_.speed()) < kStanding && std::abs(last_.speed) < kStanding &&
      std::abs(wanted - vehicle.steering) > kAligned) {
    command.state = DriveState::kSteering;
    return send(command, 0, wanted, braking);
  }
  return send(command, way.sign() * allowed, wanted, braking);
}

LocalPlanner::LocalPlanner(const DrivingParameters& parameters,
                           const LocalCostmapParameters& costmap, const Footprint& footprint) {
  parameters.validate();
  implementation_ = std::make_unique<Implementation>(parameters, costmap, footprint);
}
LocalPlanner::~LocalPlanner() = default;
LocalPlanner::LocalPlanner(LocalPlanner&&) noexcept = default;
LocalPlanner& LocalPlanner::operator=(LocalPlanner&&) noexcept = default;

void LocalPlanner::set_path(const Path& path) {
  implementation_->set_path(path);
}
void LocalPlanner::clear_path() {
  implementation_->clear_path();
}
void LocalPlanner::pause(bool paused) {
  implementation_->paused_ = paused;
}
void LocalPlanner::limit_speed(double speed) {
  implementation_->limit_ = speed >= 0 ? speed : 0;
}
void LocalPlanner::prefer_offset(double offset) {
  const double most = implementation_->parameters().largest_offset;
  implementation_->preferred_ = std::isfinite(offset) ? std::clamp(offset, -most, most) : 0;
}
std::optional<double> LocalPlanner::go_back_to(double arc_length) {
  return implementation_->go_back_to(arc_length);
}
DriveInput LocalPlanner::add(const Localisation& localisation) {
  return implementation_->inputs().add(localisation);
}
DriveInput LocalPlanner::add(const ScanView& scan, const Pose2d& T_robot_lidar) {
  return implementation_->inputs().add(scan, T_robot_lidar);
}
void LocalPlanner::set_obstacles(std::span<const Point2d> cells, double time) {
  implementation_->inputs().set_obstacles(cells, time);
}
DriveCommand LocalPlanner::cycle(double now) {
  return implementation_->cycle(now);
}
DriveReason LocalPlanner::fault(double now) const {
  return implementation_->inputs().fault(now);
}
std::optional<Localisation> LocalPlanner::localisation(double now) const {
  return implementation_->inputs().localisation(now);
}
const LocalCostmap& LocalPlanner::costmap() const {
  return implementation_->inputs().costmap();
}

}  // namespace pipescout::navigation
