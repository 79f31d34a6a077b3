// SPDX-License-Identifier: Apache-2.0
#include "pipescout/move_base/move_base.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "pipescout/validation/check.hpp"

namespace pipescout::navigation {
namespace {

constexpr double kStands = 0.03;           ///< m/s
constexpr double kStartMissed = 0.5;       ///< m that it may have moved since a path was asked for
constexpr double kMarkReached = 0.2;       ///< m before the end of a mark
constexpr std::size_t kMostSeen = 20'000;  ///< cells that are planned around

bool is_of_localisation(DriveReason reason) {
  return reason == DriveReason::kLocalisationMissing || reason == DriveReason::kLocalisationStale ||
         reason == DriveReason::kLocalisationUncertain;
}

double side_sign(PipeSide side) {
  switch (side) {
    case PipeSide::kLeft:
      return 1;
    case PipeSide::kRight:
      return -1;
    case PipeSide::kNone:
    case PipeSide::kBoth:
      break;
  }
  return 0;
}

}  // namespace

const char* to_string(MoveState state) {
  switch (state) {
    case MoveState::kIdle:
      return "idle";
    case MoveState::kPlanning:
      return "planning";
    case MoveState::kDriving:
      return "driving";
    case MoveState::kSucceeded:
      return "succeeded";
    case MoveState::kFailed:
      return "failed";
  }
  return "unknown";
}

void MoveBaseParameters::validate() const {
  driving.validate();
  costmap.validate();
  inspection.validate();
  validation::check_above("view_angle", view_angle, 0, 3);
  validation::check_above("track_stale_after", track_stale_after, 0, 60);
  validation::check_within("coverage_cell", coverage_cell, 0.01, 10);
  validation::check_within("lost_after", lost_after, 0, 3600);
  validation::check_within("replan_after", replan_after, 0, 600);
  validation::check_within("replans", replans, 0, 1000);
  validation::check_above("progress", progress, 0, 1000);
  validation::check_above("obstacle_radius", obstacle_radius, 0, 100);
}

class MoveBase::Implementation {
 public:
  Implementation(const MoveBaseParameters& parameters, const Footprint& footprint)
      : parameters_(parameters),
        local_(parameters.driving, parameters.costmap, footprint),
        inspection_(parameters.inspection),
        coverage_(parameters.coverage_cell, parameters.inspection.largest_blur) {}

  void start(const NavigationGoal& goal);
  void stop(NavigationFailure why, const std::string& text = {});
  bool add(const PipeObservation& observation);
  void plan_again();
  void doubtful_finding() { inspection_.doubtful_finding(travelled_); }
  std::optional<PlanRequest> take_request() { return std::exchange(request_, std::nullopt); }
  void give(const NavigationPlan& plan);
  MoveStatus cycle(double now);

  LocalPlanner& local() { return local_; }
  [[nodiscard]] const LocalPlanner& local() const { return local_; }
  [[nodiscard]] const NavigationPlan& plan() const { return plan_; }
  [[nodiscard]] const CoverageMap& coverage() const { return coverage_; }

 private:
  void ask(double now, bool with_obstacles);
  void leave_plan();
  void drive(const DriveCommand& command, double now);
  void inspect(const DriveCommand& command, double now, MoveStatus& status);
  bool waits_too_long(double now, DriveReason reason);
  [[nodiscard]] NavigationGoal remaining_goal() const;
  [[nodiscard]] double speed_before_pipe() const;
  [[nodiscard]] bool is_passed(const PlanMark& mark) const {
    return mark.end <= travelled_ + kMarkReached;
  }
  [[nodiscard]] const PlanMark* current_mark() const;

  MoveBaseParameters parameters_;
  LocalPlanner local_;
  InspectionSpeed inspection_;
  CoverageMap coverage_;

  MoveState state_ = MoveState::kIdle;
  NavigationFailure failure_ = NavigationFailure::kNone;
  std::string text_;
  NavigationGoal goal_ = PoseGoal{};  ///< what was left of it when the plan was asked for
  NavigationPlan plan_;
  std::optional<PlanRequest> request_;
  std::uint64_t number_ = 0;     ///< of the last request
  bool asked_ = false;           ///< it has no answer yet
  bool with_obstacles_ = false;  ///< it was asked with what was seen
  std::string no_plan_;          ///< why the last one around what blocks the path was none
  Pose2d asked_from_;
  int replans_ = 0;                    ///< for this goal
  int consecutive_ = 0;                ///< without progress
  double next_plan_ = 0;               ///< s
  double progress_from_ = 0;           ///< m of arc length, where the last plan began
  double travelled_ = 0;               ///< m
  double now_ = 0;                     ///< s
  std::optional<double> waits_since_;  ///< s, for an input
  std::size_t passed_before_ = 0;      ///< marks of earlier plans of the goal
  bool missed_ = false;                ///< it came to the goal, but not near enough
  bool goes_back_ = false;             ///< for the inspection
  std::optional<PipeObservation> observation_;
};

void MoveBase::Implementation::start(const NavigationGoal& goal) {
  local_.clear_path();
  local_.limit_speed(std::numeric_limits<double>::infinity());
  local_.prefer_offset(0);
  inspection_.start();
  goal_ = goal;
  plan_ = {};
  request_.reset();
  asked_ = false;
  replans_ = 0;
  consecutive_ = 0;
  next_plan_ = 0;
  travelled_ = 0;
  passed_before_ = 0;
  missed_ = false;
  goes_back_ = false;
  waits_since_.reset();
  state_ = MoveState::kPlanning;
  failure_ = NavigationFailure::kNone;
  text_.clear();
  no_plan_.clear();
}

void MoveBase::Implementation::stop(NavigationFailure why, const std::string& text) {
  if (state_ != MoveState::kPlanning && state_ != MoveState::kDriving) {
    return;
  }
  local_.clear_path();
  request_.reset();
  asked_ = false;
  state_ = MoveState::kFailed;
  failure_ = why;
  text_ = text;
}

bool MoveBase::Implementation::add(const PipeObservation& observation) {
  const bool later = !observation_ || observation.time > observation_->time;
  if (!std::isfinite(observation.time) || !later) {
    return false;
  }
  observation_ = observation;
  const PlanMark* mark = current_mark();
  const auto robot = local_.localisation(observation.time);
  if (!observation.tracked || mark == nullptr || !robot) {
    return true;
  }
  const auto& camera = parameters_.inspection;
  const double range = std::isfinite(observation.range) && observation.range > 0
                           ? observation.range
                           : camera.usual_range;
  const double half = range * std::tan(parameters_.view_angle / 2);
  const double share = (travelled_ - mark->begin) / (mark->end - mark->begin);
  const double middle = mark->length * (mark->backwards ? 1 - share : share);
  coverage_.add({.pipe = mark->id,
                 .from = std::max(0.0, middle - half),
                 .to = std::max(0.0, middle + half),
                 .time = observation.time,
                 .temperature = observation.temperature,
                 .blur = std::abs(robot->speed) * camera.exposure * camera.focal_length / range});
  return true;
}

const PlanMark* MoveBase::Implementation::current_mark() const {
  if (state_ != MoveState::kDriving || !std::holds_alternative<TourGoal>(goal_)) {
    return nullptr;
  }
  for (const PlanMark& mark : plan_.marks) {
    if (travelled_ >= mark.begin && travelled_ <= mark.end) {
      return &mark;
    }
  }
  return nullptr;
}

NavigationGoal MoveBase::Implementation::remaining_goal() const {
  const auto passed = static_cast<std::ptrdiff_t>(
      std::count_if(plan_.marks.begin(), plan_.marks.end(),
                    [&](const PlanMark& mark) { return is_passed(mark); }));
  if (const auto* route = std::get_if<RouteGoal>(&goal_)) {
    RouteGoal left = *route;
    const auto all = static_cast<std::ptrdiff_t>(left.nodes.size());
    left.nodes.erase(left.nodes.begin(), left.nodes.begin() + std::min(passed, all - 1));
    return left;
  }
  if (const auto* tour = std::get_if<TourGoal>(&goal_)) {
    TourGoal left = *tour;
    std::erase_if(left.rows, [&](std::int64_t id) {
      const bool missed =
          std::find(plan_.left_out.begin(), plan_.left_out.end(), id) != plan_.left_out.end();
      const bool ahead =
          std::any_of(plan_.marks.begin(), plan_.marks.end(),
                      [&](const PlanMark& mark) { return mark.id == id && !is_passed(mark); });
      return missed || !ahead;
    });
    return left.rows.empty() ? *tour : left;
  }
  return goal_;
}

/// What it has passed of the goal is done.
void MoveBase::Implementation::leave_plan() {
  if (plan_.path.empty()) {
    return;
  }
  const auto passed = [&](const PlanMark& mark) { return is_passed(mark); };
  passed_before_ +=
      static_cast<std::size_t>(std::count_if(plan_.marks.begin(), plan_.marks.end(), passed));
  goal_ = remaining_goal();
  std::erase_if(plan_.marks, passed);
}

void MoveBase::Implementation::plan_again() {
  if (state_ == MoveState::kDriving) {
    leave_plan();
    plan_ = {};
    local_.clear_path();
    state_ = MoveState::kPlanning;
    ++replans_;
  }
  asked_ = false;
  request_.reset();
}

void MoveBase::Implementation::ask(double now, bool with_obstacles) {
  const auto robot = local_.localisation(now);
  if (!robot) {
    return;
  }
  leave_plan();
  PlanRequest request{.number = ++number_,
                      .start = robot->pose,
                      .goal = goal_,
                      .time = now,
                      .straight_approach = missed_};
  if (with_obstacles) {
    request.obstacles.reserve(kMostSeen);
    local_.costmap().occupied_near(robot->pose.position(), parameters_.obstacle_radius, now,
                                   request.obstacles);
  }
  asked_from_ = robot->pose;
  with_obstacles_ = !request.obstacles.empty();
  asked_ = true;
  request_ = std::move(request);
}

void MoveBase::Implementation::give(const NavigationPlan& plan) {
  if (!asked_ || plan.number != number_) {
    return;
  }
  asked_ = false;
  const bool has_path = !plan_.path.empty();
  if (plan.failure != NavigationFailure::kNone) {
    if (!has_path && with_obstacles_) {
      // What stands there now may go; what the map says does not.
      ask(now_, false);
    } else if (!has_path) {
      stop(plan.failure, plan.text);
    } else {
      no_plan_ = plan.text;
    }
    return;
  }
  const auto robot = local_.localisation(now_);
  if (!robot || distance(robot->pose, asked_from_) > kStartMissed) {
    return;  // it goes on along the old path, or asks again
  }
  try {
    local_.set_path(plan.path);
  } catch (const std::invalid_argument& error) {
    stop(NavigationFailure::kNoPath, error.what());
    return;
  }
  no_plan_.clear();
  replans_ += has_path ? 1 : 0;
  plan_ = plan;
  travelled_ = 0;
  progress_from_ = 0;
  goes_back_ = false;
  inspection_.start();
  state_ = MoveState::kDriving;
}

bool MoveBase::Implementation::waits_too_long(double now, DriveReason reason) {
  if (reason == DriveReason::kNone) {
    waits_since_.reset();
    return false;
  }
  if (!waits_since_ || now < *waits_since_) {  // or the clock was set back
    waits_since_ = now;
  }
  if (now - *waits_since_ < parameters_.lost_after) {
    return false;
  }
  stop(is_of_localisation(reason) ? NavigationFailure::kLocalisationLost
                                  : NavigationFailure::kScanLost,
       to_string(reason));
  return true;
}

/// m/s: slow enough when the next pipe begins.
double MoveBase::Implementation::speed_before_pipe() const {
  double limit = std::numeric_limits<double>::infinity();
  if (!std::holds_alternative<TourGoal>(goal_)) {
    return limit;
  }
  const auto& camera = parameters_.inspection;
  const double there = camera.speed_share * inspection_.blur_limit(camera.usual_range);
  for (const PlanMark& mark : plan_.marks) {
    if (mark.begin >= travelled_ && mark.pipe_side != PipeSide::kNone) {
      const double way = mark.begin - travelled_;
      limit =
          std::min(limit, std::sqrt(there * there + 2 * parameters_.driving.gentle_braking * way));
    }
  }
  return limit;
}

void MoveBase::Implementation::inspect(const DriveCommand& command, double now,
                                       MoveStatus& status) {
  const PlanMark* mark = current_mark();
  if (mark == nullptr || mark->pipe_side == PipeSide::kNone) {
    local_.limit_speed(speed_before_pipe());
    local_.prefer_offset(0);
    return;
  }
  goes_back_ = goes_back_ && command.state == DriveState::kBackingUp;
  if (goes_back_) {
    status.inspection = InspectionReason::kGoesBack;
    return;
  }
  const bool fresh = observation_ && now - observation_->time <= parameters_.track_stale_after;
  InspectionView view{.time = now, .arc_length = command.travelled};
  if (fresh) {
    view.tracked = observation_->tracked;
    view.confidence = observation_->confidence;
    view.range = observation_->range;
  }
  const InspectionDecision decision = inspection_.decide(view);
  status.inspection = decision.reason;
  local_.limit_speed(decision.speed);
  local_.prefer_offset(decision.nearer ? side_sign(mark->pipe_side) * parameters_.inspection.nearer
                                       : 0);
  if (decision.go_back_to) {
    const double to = std::max(*decision.go_back_to, mark->begin);
    goes_back_ = local_.go_back_to(to).has_value();
    local_.limit_speed(parameters_.inspection.slow_speed);
  }
}

void MoveBase::Implementation::drive(const DriveCommand& command, double now) {
  if (command.state == DriveState::kReached) {
    travelled_ = plan_.path.length();
    state_ = MoveState::kSucceeded;
    return;
  }
  if (travelled_ > progress_from_ + parameters_.progress) {
    progress_from_ = travelled_;
    consecutive_ = 0;
  }
  const bool missed = command.state == DriveState::kFailed;
  if ((!command.replan && !missed) || command.speed != 0 || asked_ || now < next_plan_) {
    return;
  }
  if (missed && std::holds_alternative<TourGoal>(goal_) &&
      std::all_of(plan_.marks.begin(), plan_.marks.end(),
                  [&](const PlanMark& mark) { return is_passed(mark); })) {
    state_ = MoveState::kSucceeded;
    return;
  }
  // A path that is found and does not help counts as well as none.
  if (++consecutive_ > parameters_.replans) {
    stop(missed ? NavigationFailure::kGoalMissed : NavigationFailure::kBlocked,
         no_plan_.empty() ? to_string(command.reason) : no_plan_);
    return;
  }
  next_plan_ = now + parameters_.replan_after;
  missed_ = missed_ || missed;
  ask(now, true);
}

MoveStatus MoveBase::Implementation::cycle(double now) {
  now_ = now;
  MoveStatus status;
  status.command = local_.cycle(now);
  if (state_ == MoveState::kPlanning) {
    const DriveReason fault = local_.fault(now);
    status.waits_for = fault;
    const auto robot = local_.localisation(now);
    const bool stands = robot && status.command.speed == 0 && std::abs(robot->speed) < kStands;
    if (!waits_too_long(now, fault) && fault == DriveReason::kNone && stands && !asked_) {
      ask(now, true);
    }
  } else if (state_ == MoveState::kDriving) {
    travelled_ = status.command.travelled > 0 ? status.command.travelled : travelled_;
    const DriveReason fault = local_.fault(now);
    status.waits_for = fault;
    if (!waits_too_long(now, fault) && fault == DriveReason::kNone) {
      drive(status.command, now);
      inspect(status.command, now, status);
    }
  }
  status.state = state_;
  status.failure = failure_;
  status.text = text_;
  status.replans = replans_;
  status.remaining = state_ == MoveState::kDriving ? status.command.remaining : 0;
  status.passed = passed_before_ + static_cast<std::size_t>(std::count_if(
                                       plan_.marks.begin(), plan_.marks.end(),
                                       [&](const PlanMark& mark) { return is_passed(mark); }));
  if (const PlanMark* mark = current_mark()) {
    status.mark = mark->id;
  }
  return status;
}

MoveBase::MoveBase(const MoveBaseParameters& parameters, const Footprint& footprint) {
  parameters.validate();
  implementation_ = std::make_unique<Implementation>(parameters, footprint);
}
MoveBase::~MoveBase() = default;
MoveBase::MoveBase(MoveBase&&) noexcept = default;
MoveBase& MoveBase::operator=(MoveBase&&) noexcept = default;

void MoveBase::start(const NavigationGoal& goal) {
  implementation_->start(goal);
}
void MoveBase::stop(NavigationFailure why) {
  implementation_->stop(why);
}
void MoveBase::pause(bool paused) {
  implementation_->local().pause(paused);
}
DriveInput MoveBase::add(const Localisation& localisation) {
  return implementation_->local().add(localisation);
}
DriveInput MoveBase::add(const ScanView& scan, const Pose2d& T_robot_lidar) {
  return implementation_->local().add(scan, T_robot_lidar);
}
bool MoveBase::add(const PipeObservation& observation) {
  return implementation_->add(observation);
}
void MoveBase::set_obstacles(std::span<const Point2d> cells, double time) {
  implementation_->local().set_obstacles(cells, time);
}
void MoveBase::plan_again() {
  implementation_->plan_again();
}
void MoveBase::doubtful_finding() {
  implementation_->doubtful_finding();
}
std::optional<PlanRequest> MoveBase::take_request() {
  return implementation_->take_request();
}
void MoveBase::give(const NavigationPlan& plan) {
  implementation_->give(plan);
}
MoveStatus MoveBase::cycle(double now) {
  return implementation_->cycle(now);
}
const NavigationPlan& MoveBase::plan() const {
  return implementation_->plan();
}
const LocalPlanner& MoveBase::local_planner() const {
  return implementation_->local();
}
const CoverageMap& MoveBase::coverage() const {
  return implementation_->coverage();
}

}  // namespace pipescout::navigation
