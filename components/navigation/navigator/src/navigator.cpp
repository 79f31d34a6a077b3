// SPDX-License-Identifier: Apache-2.0
#include "pipescout/navigator/navigator.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

#include "navigator_messages.hpp"
#include "pipescout/catalogue/topics.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "pipescout/runtime/goal_rejected.hpp"
#include "pipescout/runtime/register_component.hpp"

namespace pipescout {
namespace {

using navigation::DriveInput;
using navigation::DriveState;
using navigation::MoveState;
using navigation::MoveStatus;
using navigation::NavigationFailure;
using navigation::NavigationPlan;
using navigation::PipeSide;
using navigation::PlanRequest;

/// Percent, from which on a cell of a costmap is occupied: what map_server takes for it.
constexpr int kOccupied = 65;
/// Of a finding that is driven past again: it may be a leak, and is not certain.
constexpr double kDoubtfulFrom = 0.3;
constexpr double kDoubtfulTo = 0.8;
/// Findings of this age are where the robot is.
constexpr Duration kFreshFinding = std::chrono::seconds(5);
constexpr std::uint64_t kCyclesPerFeedback = 10;
constexpr std::uint64_t kCyclesPerMap = 40;  ///< 2 s: it is for display
/// Of the largest speed: what routes with curves are driven with, for the time that is left.
constexpr double kUsualShare = 0.5;

double steady_seconds() {
  return to_seconds(steady_now().time_since_epoch());
}

const char* counter_of(DriveInput verdict) {
  switch (verdict) {
    case DriveInput::kTaken:
      return "taken";
    case DriveInput::kNotFinite:
      return "not_a_number";
    case DriveInput::kOutOfOrder:
      return "header.stamp.not_increasing";
    case DriveInput::kBadGeometry:
      return "bad_geometry";
  }
  return "unknown";
}

}  // namespace

Navigator::Navigator(ComponentOptions options)
    : Component(std::move(options)), declared_(parameters()) {}

Navigator::~Navigator() {
  stop_planner();
}

CallbackReturn Navigator::on_configure() {
  settings_ = declared_.read();
  for (const std::string& remark : settings_->map_remarks) {
    logger().warn(remark);
  }
  base_.emplace(settings_->base, settings_->footprint);
  planner_ = std::make_unique<navigation::GlobalPlanner>(settings_->map, settings_->footprint,
                                                         settings_->planner);
  closed_.clear();
  planner_stops_ = false;
  planner_group_ = planner_executor_.create_callback_group();
  planner_group_->join(context().activity(), node_name().fully_qualified());
  planner_thread_ =
      std::make_unique<ExecutorThread>(planner_executor_, ExecutorThread::Callbacks{});

  command_publisher_ = create_publisher(topics::kGroundVelocityCommand);
  plan_publisher_ = create_publisher(topics::kPlan);
  state_publisher_ = create_publisher(topics::kNavigatorState);
  costmap_publisher_ = create_publisher(topics::kNavigatorCostmap);
  coverage_publisher_ = create_publisher(topics::kPipeCoverage);
  create_inputs();
  create_actions();
  pause_service_ = create_service<SetBool>(
      "~/pause", [this](const SetBool::Request& request, SetBool::Response& response) {
        response.success = state() == LifecycleState::kActive;
        if (response.success) {
          base_->pause(request.data);
        } else {
          response.message =
              "the component is " + std::string(to_string(state())) + "; activate it first";
        }
      });
  closed_edges_changed_ =
      parameters().on_changed([this](const std::vector<NamedParameter>& changed) {
        const bool ours = std::any_of(changed.begin(), changed.end(), [&](const auto& parameter) {
          return parameter.name == declared_.closed_edges_name();
        });
        if (ours) {
          default_group()->post([this] { close_edges(); });
        }
      });
  timer_ = create_timer(from_seconds(settings_->base.driving.period), [this] { cycle(); });
  return CallbackReturn::kSuccess;
}

CallbackReturn Navigator::on_activate() {
  // What was seen and wanted before it was inactive is not what is now.
  base_.emplace(settings_->base, settings_->footprint);
  client_ = {};
  under_way_ = false;
  plans_ = false;
  next_request_.reset();
  told_.clear();
  cycles_ = 0;
  close_edges();
  return CallbackReturn::kSuccess;
}

CallbackReturn Navigator::on_cleanup() {
  timer_.reset();
  closed_edges_changed_.reset();
  stop_planner();
  pause_service_ = {};
  navigate_server_ = {};
  route_server_ = {};
  tour_server_ = {};
  odometry_subscription_ = {};
  scan_subscription_ = {};
  costmap_subscription_ = {};
  track_subscription_ = {};
  leak_subscription_ = {};
  goal_subscription_ = {};
  command_publisher_ = {};
  plan_publisher_ = {};
  state_publisher_ = {};
  costmap_publisher_ = {};
  coverage_publisher_ = {};
  client_ = {};
  base_.reset();
  planner_.reset();
  return CallbackReturn::kSuccess;
}

void Navigator::stop_planner() {
  planner_stops_ = true;
  if (planner_group_) {
    planner_group_->close();
  }
  planner_thread_.reset();
  planner_group_.reset();
}

void Navigator::create_inputs() {
  odometry_subscription_ = create_subscription(
      topics::kOdometryFiltered, [this](const Odometry& message) { on_odometry(message); });
  scan_subscription_ =
      create_subscription(topics::kScan, [this](const LaserScan& message) { on_scan(message); });
  costmap_subscription_ = create_subscription(
      topics::kLocalCostmap, [this](const OccupancyGrid& message) { on_costmap(message); });
  track_subscription_ = create_subscription(
      topics::kPipeTrack, [this](const PipeTrack& message) { on_track(message); });
  leak_subscription_ = create_subscription(topics::kLeakEvents,
                                           [this](const LeakEvent& message) { on_leak(message); });
  goal_subscription_ = create_subscription(
      topics::kGoalPose, [this](const PoseStamped& message) { on_goal_pose(message); });
}

void Navigator::create_actions() {
  const auto over = [this](const auto&) { end(NavigationFailure::kPreempted); };
  const auto cancel = [this](const auto&) { end(NavigationFailure::kCanceled); };
  navigate_server_ = create_action_server<NavigateToPose>(
      "navigate_to_pose",
      {.decide =
           [this](const GoalId&, const auto& goal) {
             try {
               (void)goal_pose(goal->pose);
             } catch (const std::invalid_argument& error) {
               diagnostics().count("goal.refused");
               throw GoalRejected(error.what());
             }
             return GoalDecision::kAccept;
           },
       .accepted =
           [this](ServerGoal<NavigateToPose> goal) {
             const auto pose = goal_pose(goal.goal().pose);
             begin(navigation::PoseGoal{pose}, std::move(goal));
           },
       .canceling = cancel,
       .preempted = over},
      {.preempts = true});
  route_server_ =
      create_action_server<FollowRoute>("follow_route",
                                        {.accepted =
                                             [this](ServerGoal<FollowRoute> goal) {
                                               const navigation::RouteGoal route{goal.goal().nodes};
                                               begin(route, std::move(goal));
                                             },
                                         .canceling = cancel,
                                         .preempted = over},
                                        {.preempts = true});
  tour_server_ = create_action_server<InspectTour>("inspect_tour",
                                                   {.accepted =
                                                        [this](ServerGoal<InspectTour> goal) {
                                                          navigation::TourGoal tour{
                                                              .rows = goal.goal().rows,
                                                              .both_sides = goal.goal().both_sides,
                                                              .as_given = settings_->one_sided};
                                                          if (tour.rows.empty()) {
                                                            tour.rows = rows_with_pipes();
                                                          }
                                                          begin(tour, std::move(goal));
                                                        },
                                                    .canceling = cancel,
                                                    .preempted = over},
                                                   {.preempts = true});
}

std::vector<std::int64_t> Navigator::rows_with_pipes() const {
  const navigation::RouteGraph& graph = settings_->map.graph;
  std::vector<std::int64_t> rows;
  for (std::uint32_t edge = 0; edge < graph.edges().size(); ++edge) {
    const auto opposite = graph.opposite(edge);
    const bool twice = opposite && *opposite < edge && !settings_->one_sided;
    if (graph.edges()[edge].pipe_side != PipeSide::kNone && !twice) {
      rows.push_back(graph.edges()[edge].id);
    }
  }
  return rows;
}

void Navigator::count(const char* input, DriveInput verdict) {
  if (verdict != DriveInput::kTaken) {
    report_fault(std::string(input) + "." + counter_of(verdict),
                 std::string(input) + " is not used: " + navigation::to_string(verdict));
  }
}

void Navigator::on_odometry(const Odometry& message) {
  if (message.header.frame_id != settings_->map_frame ||
      message.child_frame_id != settings_->base_frame) {
    report_fault("odometry.header.frame_id", "odometry is in frame '" + message.child_frame_id +
                                                 "' in '" + message.header.frame_id +
                                                 "', not of '" + settings_->base_frame + "' in '" +
                                                 settings_->map_frame + "'");
    return;
  }
  try {
    count("odometry", base_->add(localisation(message)));
  } catch (const std::invalid_argument& error) {
    report_fault("odometry.refused", std::string("odometry is not used: ") + error.what());
  }
}

void Navigator::on_scan(const LaserScan& message) {
  count("scan", base_->add({.time = seconds(from_message(message.header.stamp)),
                            .angle_min = static_cast<double>(message.angle_min),
                            .angle_increment = static_cast<double>(message.angle_increment),
                            .range_min = static_cast<double>(message.range_min),
                            .range_max = static_cast<double>(message.range_max),
                            .ranges = message.ranges},
                           settings_->T_base_lidar));
}

void Navigator::on_costmap(const OccupancyGrid& message) {
  if (message.header.frame_id != settings_->map_frame) {
    report_fault("local_costmap.header.frame_id", "local_costmap is in frame '" +
                                                      message.header.frame_id + "', not in '" +
                                                      settings_->map_frame + "'");
    return;
  }
  try {
    base_->set_obstacles(occupied_cells(message, kOccupied),
                         seconds(from_message(message.header.stamp)));
  } catch (const std::invalid_argument& error) {
    report_fault("local_costmap.refused",
                 std::string("local_costmap is not used: ") + error.what());
  }
}

void Navigator::on_track(const PipeTrack& message) {
  const bool taken =
      base_->add({.time = seconds(from_message(message.header.stamp)),
                  .tracked = message.state == PipeTrack::STATE_LOCKED && message.fault.empty(),
                  .confidence = message.confidence,
                  .range = message.range});
  if (!taken) {
    report_fault("track.header.stamp.not_increasing", "a track is not later than the last one");
  }
}

void Navigator::on_leak(const LeakEvent& message) {
  const auto& finding = message.finding;
  const bool fresh = now() - from_message(message.header.stamp) < kFreshFinding;
  if (fresh && message.kind != LeakEvent::CLEARED && finding.probability >= kDoubtfulFrom &&
      finding.probability < kDoubtfulTo && doubtful_.insert(finding.id).second) {
    base_->doubtful_finding();
  }
}

navigation::Pose2d Navigator::goal_pose(const PoseStamped& message) const {
  if (message.header.frame_id != settings_->map_frame) {
    throw std::invalid_argument("the goal is in frame '" + message.header.frame_id + "', not in '" +
                                settings_->map_frame + "'");
  }
  return plane_pose(message.pose);
}

void Navigator::on_goal_pose(const PoseStamped& message) {
  navigation::PoseGoal goal;
  try {
    goal.pose = goal_pose(message);
  } catch (const std::invalid_argument& error) {
    report_fault("goal.refused", std::string("a goal on goal_pose is refused: ") + error.what());
    return;
  }
  begin(goal, {});
}

void Navigator::begin(const navigation::NavigationGoal& goal, Client client) {
  end(NavigationFailure::kPreempted);
  client_ = std::move(client);
  under_way_ = true;
  begun_ = now();
  tour_plan_.reset();
  const auto* tour = std::get_if<navigation::TourGoal>(&goal);
  rows_ = tour != nullptr ? tour->rows : std::vector<std::int64_t>();
  base_->start(goal);
}

/// Nothing if there is no goal.
void Navigator::end(NavigationFailure why) {
  if (!under_way_) {
    return;
  }
  under_way_ = false;
  const std::string reason = why == NavigationFailure::kNone ? ""
                             : why == status_.failure && !status_.text.empty()
                                 ? navigation::to_string(why) + (": " + status_.text)
                                 : navigation::to_string(why);
  base_->stop(why);
  const Client client = std::exchange(client_, {});
  const auto finish = [&](const auto& goal, auto result) {
    if (why == NavigationFailure::kNone) {
      goal.succeed(std::move(result));
    } else if (why == NavigationFailure::kCanceled && goal.is_canceling()) {
      goal.canceled(std::move(result));
    } else {
      goal.abort(std::move(result));
    }
  };
  if (const auto* pose = std::get_if<ServerGoal<NavigateToPose>>(&client)) {
    finish(*pose, NavigateToPose::Result());
  } else if (const auto* route = std::get_if<ServerGoal<FollowRoute>>(&client)) {
    FollowRoute::Result result;
    result.reason = reason;
    result.nodes_passed = static_cast<std::uint32_t>(status_.passed);
    finish(*route, std::move(result));
  } else if (const auto* tour = std::get_if<ServerGoal<InspectTour>>(&client)) {
    InspectTour::Result result;
    result.reason = reason;
    result.rows_passed = static_cast<std::uint32_t>(status_.passed);
    double length = 0;
    double seen = 0;
    const navigation::RouteGraph& graph = settings_->map.graph;
    for (const std::int64_t row : rows_) {
      if (const auto edge = graph.edge_of_id(row)) {
        length += graph.length(*edge);
        seen += graph.length(*edge) * base_->coverage().sharp_percent(row, 0, graph.length(*edge));
      }
    }
    result.pipe_seen_percent = length > 0 ? seen / length : 0;
    if (tour_plan_) {
      result.left_out = tour_plan_->left_out;
      result.cost = tour_plan_->cost;
      result.lower_bound = tour_plan_->lower_bound;
    }
    finish(*tour, std::move(result));
  }
  if (why == NavigationFailure::kNone) {
    logger().info("the goal is reached");
  } else if (why == NavigationFailure::kPreempted || why == NavigationFailure::kCanceled) {
    logger().info("the goal is given up: " + reason);
  } else {
    logger().warn("the goal is not reached: " + reason);
  }
}

void Navigator::cycle() {
  const Time stamp = now();
  status_ = base_->cycle(seconds(stamp));
  const navigation::DriveCommand& command = status_.command;
  auto twist = std::make_unique<Twist>();
  const bool turns_wheels = command.state == DriveState::kSteering && command.speed == 0;
  twist->linear.x = turns_wheels ? settings_->steering_speed : command.speed;
  twist->angular.z = twist->linear.x * command.curvature;
  command_publisher_.publish(std::move(twist));
  if (auto request = base_->take_request()) {
    if (plans_) {
      next_request_ = std::move(request);
    } else {
      plan(*request);
    }
  }
  publish_state(status_, stamp);
  if (++cycles_ % kCyclesPerMap == 0) {
    publish_map_data(stamp);
  }
  tell(status_);
  if (under_way_) {
    if (status_.state == MoveState::kSucceeded || status_.state == MoveState::kFailed) {
      end(status_.failure);
    } else if (cycles_ % kCyclesPerFeedback == 0) {
      give_feedback(status_);
    }
  }
}

void Navigator::plan(const PlanRequest& request) {
  plans_ = true;
  planner_group_->post([this, request] {
    double readings = 0;
    const double step = settings_->planning_readings > 0
                            ? 1 / static_cast<double>(settings_->planning_readings)
                            : 0;
    const auto clock = [&] {
      if (planner_stops_) {
        return std::numeric_limits<double>::infinity();
      }
      return step > 0 ? readings += step : steady_seconds();
    };
    NavigationPlan plan{.number = request.number, .failure = NavigationFailure::kNoPath};
    try {
      plan = planner_->plan(request, clock);
    } catch (const std::exception& error) {
      plan.text = error.what();
    }
    default_group()->post([this, plan = std::move(plan)] { take_plan(plan); });
  });
}

void Navigator::take_plan(const NavigationPlan& plan) {
  plans_ = false;
  if (!base_ || state() != LifecycleState::kActive) {
    return;
  }
  if (next_request_) {
    this->plan(*std::exchange(next_request_, std::nullopt));
  }
  base_->give(plan);
  const NavigationPlan& taken = base_->plan();
  if (taken.number != plan.number || taken.path.empty()) {
    return;
  }
  if (!tour_plan_) {
    tour_plan_ = taken;
  }
  auto message = std::make_unique<PathMessage>(path_message(taken.path));
  message->header.stamp = to_message(now());
  message->header.frame_id = settings_->map_frame;
  for (auto& pose : message->poses) {
    pose.header = message->header;
  }
  plan_publisher_.publish(std::move(message));
}

void Navigator::close_edges() {
  if (!planner_group_) {
    return;
  }
  planner_group_->post([this, ids = declared_.closed_edges()] {
    planner_->open_edges(closed_);
    closed_ = ids;
    planner_->close_edges(closed_);
  });
  if (under_way_) {
    base_->plan_again();
  }
}

void Navigator::publish_map_data(Time stamp) {
  if (auto costmap = costmap_message(base_->local_planner().costmap())) {
    costmap->header.stamp = to_message(stamp);
    costmap->header.frame_id = settings_->map_frame;
    costmap_publisher_.publish(std::make_unique<OccupancyGrid>(std::move(*costmap)));
  }
  if (status_.mark) {
    const auto found = base_->coverage().pipes().find(*status_.mark);
    if (found != base_->coverage().pipes().end()) {
      auto coverage = std::make_unique<PipeCoverage>(
          coverage_message(found->first, found->second, base_->coverage().cell()));
      coverage->header.stamp = to_message(stamp);
      coverage->header.frame_id = settings_->map_frame;
      coverage_publisher_.publish(std::move(coverage));
    }
  }
}

void Navigator::publish_state(const MoveStatus& status, Time stamp) {
  auto message = std::make_unique<NavigatorState>(state_message(status));
  message->header.stamp = to_message(stamp);
  message->header.frame_id = settings_->map_frame;
  state_publisher_.publish(std::move(message));
}

void Navigator::give_feedback(const MoveStatus& status) {
  const Time stamp = now();
  const auto fill = [&](auto& feedback) {
    feedback.navigation_time = to_message(stamp - begun_);
    feedback.distance_remaining = static_cast<float>(status.remaining);
    feedback.number_of_recoveries = static_cast<std::int16_t>(
        std::min<int>(status.replans, std::numeric_limits<std::int16_t>::max()));
  };
  if (const auto* pose = std::get_if<ServerGoal<NavigateToPose>>(&client_)) {
    NavigateToPose::Feedback feedback;
    fill(feedback);
    feedback.current_pose.header.stamp = to_message(stamp);
    feedback.current_pose.header.frame_id = settings_->map_frame;
    if (const auto robot = base_->local_planner().localisation(seconds(stamp))) {
      feedback.current_pose.pose = pose_message(robot->pose);
    }
    feedback.estimated_time_remaining = to_message(
        from_seconds(status.remaining / (kUsualShare * settings_->base.driving.largest_speed)));
    pose->publish_feedback(std::move(feedback));
  } else if (const auto* route = std::get_if<ServerGoal<FollowRoute>>(&client_)) {
    FollowRoute::Feedback feedback;
    fill(feedback);
    feedback.nodes_passed = static_cast<std::uint32_t>(status.passed);
    route->publish_feedback(std::move(feedback));
  } else if (const auto* tour = std::get_if<ServerGoal<InspectTour>>(&client_)) {
    InspectTour::Feedback feedback;
    fill(feedback);
    feedback.rows_passed = static_cast<std::uint32_t>(status.passed);
    feedback.inspection = status.inspection == navigation::InspectionReason::kNone
                              ? ""
                              : navigation::to_string(status.inspection);
    tour->publish_feedback(std::move(feedback));
  }
}

void Navigator::tell(const MoveStatus& status) {
  const std::string state = navigation::to_string(status.state);
  const std::string reason = reason_of(status);
  std::string text = reason.empty() ? state : state + ": " + reason;
  if (text == told_) {
    return;
  }
  using navigation::DriveReason;
  const bool blind = status.waits_for != DriveReason::kNone;
  // None has come yet: its source has not begun.
  const bool waits = status.waits_for == DriveReason::kLocalisationMissing ||
                     status.waits_for == DriveReason::kScanMissing;
  diagnostics().set_value("state", state);
  diagnostics().set_value("reason", reason);
  diagnostics().set_status(waits                                ? DiagnosticLevel::kStale
                           : blind                              ? DiagnosticLevel::kError
                           : status.state == MoveState::kFailed ? DiagnosticLevel::kWarn
                                                                : DiagnosticLevel::kOk,
                           text);
  told_ = std::move(text);
}

}  // namespace pipescout

PIPESCOUT_REGISTER_COMPONENT(pipescout::Navigator)
