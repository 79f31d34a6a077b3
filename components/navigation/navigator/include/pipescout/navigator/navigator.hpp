// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <geometry_msgs/msg/pose_stamped.hpp>
#include <geometry_msgs/msg/twist.hpp>
#include <memory>
#include <nav2_msgs/action/navigate_to_pose.hpp>
#include <nav_msgs/msg/occupancy_grid.hpp>
#include <nav_msgs/msg/odometry.hpp>
#include <nav_msgs/msg/path.hpp>
#include <optional>
#include <pipescout_msgs/action/follow_route.hpp>
#include <pipescout_msgs/action/inspect_tour.hpp>
#include <pipescout_msgs/msg/leak_event.hpp>
#include <pipescout_msgs/msg/navigator_state.hpp>
#include <pipescout_msgs/msg/pipe_coverage.hpp>
#include <pipescout_msgs/msg/pipe_track.hpp>
#include <sensor_msgs/msg/laser_scan.hpp>
#include <set>
#include <std_srvs/srv/set_bool.hpp>
#include <string>
#include <variant>
#include <vector>

#include "pipescout/navigator/navigator_parameters.hpp"
#include "pipescout/runtime/component.hpp"
#include "pipescout/runtime/executor_thread.hpp"

namespace pipescout {

/// Drives a robot with Ackermann steering: actions `navigate_to_pose`, `follow_route` and
/// `inspect_tour` and the topic `goal_pose`; `odometry/filtered`, `scan`, `local_costmap`,
/// `track/pipe` and `leak/events` in; `cmd_vel` and `navigator/state` in each cycle while active,
/// `plan`, `navigator/costmap` and `navigator/coverage`. Service `~/pause`. Plans on a thread of
/// its own, so that commands go on.
///
/// Parameters, reasons and faults: docs/components/navigator.md. Parameters but `closed_edges` take
/// effect when it is configured.
class Navigator final : public Component {
 public:
  explicit Navigator(ComponentOptions options);
  ~Navigator() override;

 protected:
  CallbackReturn on_configure() override;
  CallbackReturn on_activate() override;
  CallbackReturn on_cleanup() override;

 private:
  using NavigateToPose = nav2_msgs::action::NavigateToPose;
  using FollowRoute = pipescout_msgs::action::FollowRoute;
  using InspectTour = pipescout_msgs::action::InspectTour;
  using LaserScan = sensor_msgs::msg::LaserScan;
  using LeakEvent = pipescout_msgs::msg::LeakEvent;
  using OccupancyGrid = nav_msgs::msg::OccupancyGrid;
  using Odometry = nav_msgs::msg::Odometry;
  using NavigatorState = pipescout_msgs::msg::NavigatorState;
  using PipeCoverage = pipescout_msgs::msg::PipeCoverage;
  using PathMessage = nav_msgs::msg::Path;
  using PipeTrack = pipescout_msgs::msg::PipeTrack;
  using PoseStamped = geometry_msgs::msg::PoseStamped;
  using SetBool = std_srvs::srv::SetBool;
  using Twist = geometry_msgs::msg::Twist;
  /// Whose goal it is; nobody's: that of the topic.
  using Client = std::variant<std::monostate, ServerGoal<NavigateToPose>, ServerGoal<FollowRoute>,
                              ServerGoal<InspectTour>>;

  void create_actions();
  void create_inputs();
  void on_odometry(const Odometry& message);
  void on_scan(const LaserScan& message);
  void on_costmap(const OccupancyGrid& message);
  void on_track(const PipeTrack& message);
  void on_leak(const LeakEvent& message);
  void on_goal_pose(const PoseStamped& message);
  /// Nothing, and the reason is counted, for one that is not in the map's frame or not a pose.
  /// Throws std::invalid_argument.
  [[nodiscard]] navigation::Pose2d goal_pose(const PoseStamped& message) const;
  [[nodiscard]] std::vector<std::int64_t> rows_with_pipes() const;

  void begin(const navigation::NavigationGoal& goal, Client client);
  void end(navigation::NavigationFailure why);
  void cycle();
  void plan(const navigation::PlanRequest& request);
  void take_plan(const navigation::NavigationPlan& plan);
  void close_edges();
  void stop_planner();
  void publish_map_data(Time stamp);
  void publish_state(const navigation::MoveStatus& status, Time stamp);
  void give_feedback(const navigation::MoveStatus& status);
  void tell(const navigation::MoveStatus& status);
  void count(const char* input, navigation::DriveInput verdict);

  NavigatorParameters declared_;
  std::optional<NavigatorSettings> settings_;
  std::optional<navigation::MoveBase> base_;
  navigation::MoveStatus status_;  ///< of the last cycle
  bool under_way_ = false;         ///< there is a goal
  Client client_;
  Time begun_{};
  std::uint64_t cycles_ = 0;
  std::vector<std::int64_t> rows_;                       ///< of the tour
  std::optional<navigation::NavigationPlan> tour_plan_;  ///< the first of it
  std::set<std::uint64_t> doubtful_;                     ///< findings that were passed again
  std::string told_;                                     ///< status on /diagnostics
  bool plans_ = false;                                   ///< the planner is at work
  std::optional<navigation::PlanRequest> next_request_;

  // Touched by the planner's thread alone, but for the last.
  std::unique_ptr<navigation::GlobalPlanner> planner_;
  std::vector<std::int64_t> closed_;
  std::atomic<bool> planner_stops_ = false;

  Publisher<Twist> command_publisher_;
  Publisher<PathMessage> plan_publisher_;
  Publisher<NavigatorState> state_publisher_;
  Publisher<OccupancyGrid> costmap_publisher_;
  Publisher<PipeCoverage> coverage_publisher_;
  Subscription<Odometry> odometry_subscription_;
  Subscription<LaserScan> scan_subscription_;
  Subscription<OccupancyGrid> costmap_subscription_;
  Subscription<PipeTrack> track_subscription_;
  Subscription<LeakEvent> leak_subscription_;
  Subscription<PoseStamped> goal_subscription_;
  ActionServer<NavigateToPose> navigate_server_;
  ActionServer<FollowRoute> route_server_;
  ActionServer<InspectTour> tour_server_;
  Service<SetBool> pause_service_;
  std::shared_ptr<Timer> timer_;
  ParameterCallbackHandle closed_edges_changed_;

  // Last: its thread ends before what it plans with.
  Executor planner_executor_;
  std::shared_ptr<CallbackGroup> planner_group_;
  std::unique_ptr<ExecutorThread> planner_thread_;
};

}  // namespace pipescout
