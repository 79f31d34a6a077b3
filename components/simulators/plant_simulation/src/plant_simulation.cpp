// SPDX-License-Identifier: Apache-2.0
#include "pipescout/plant_simulation/plant_simulation.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "pipescout/catalogue/topics.hpp"
#include "pipescout/map_files/grid_file.hpp"
#include "pipescout/map_files/route_graph_file.hpp"
#include "pipescout/plant_world/yard_map.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "pipescout/runtime/register_component.hpp"

namespace pipescout {
namespace {

/// Of the simulated clock: a stamp of zero means "no time" to some.
constexpr Time kStart{std::chrono::seconds(1000)};
constexpr int kStepMilliseconds = 50;
constexpr double kStepSeconds = kStepMilliseconds * 1e-3;
constexpr std::uint64_t kStepsPerScan = 2;
constexpr std::uint64_t kStepsPerTrack = 2;
constexpr std::uint64_t kStepsPerProgress = 200;
constexpr double kConfidence = 0.9;
constexpr double kOtherVariance = 1e-4;  ///< of height, roll and pitch, which are not simulated
constexpr double kLidarNearest = 0.1;    ///< m
const char* const kMapFrame = "map";
const char* const kBaseFrame = "base_link";

Time at(double seconds) {
  return kStart + from_seconds(seconds);
}

void fill(nav_msgs::msg::Odometry& message, const simulation::AckermannState& state) {
  message.header.frame_id = kMapFrame;
  message.child_frame_id = kBaseFrame;
  message.pose.pose.position.x = state.x;
  message.pose.pose.position.y = state.y;
  message.pose.pose.orientation.w = std::cos(state.heading / 2);
  message.pose.pose.orientation.z = std::sin(state.heading / 2);
  message.twist.twist.linear.x = state.speed;
  message.twist.twist.angular.z = state.yaw_rate;
}

}  // namespace

PlantSimulation::PlantSimulation(ComponentOptions options)
    : Component(std::move(options)), declared_(parameters(), PlantDriveParameters{}) {
  const IntegerRange any_seed{0, 1'000'000'000};
  seed_ = parameters().declare<std::int64_t>(
      "seed", 1, {.description = "of all random numbers", .integer_range = any_seed});
  declared_.integer(
      "rows", [](auto& p) -> int& { return p.yard.rows; }, {2, 20}, "of collectors");
  declared_.real(
      "row_length", [](auto& p) -> double& { return p.yard.row_length; }, {10, 200}, "m");
  declared_.real(
      "row_width", [](auto& p) -> double& { return p.yard.row_width; }, {0.5, 10}, "m");
  declared_.real(
      "aisle", [](auto& p) -> double& { return p.yard.aisle; }, {2.5, 20},
      "m, free width between two rows");
  declared_.real(
      "road", [](auto& p) -> double& { return p.yard.road; }, {4, 20},
      "m, width at the ends of the rows");
  declared_.integer(
      "people", [](auto& p) -> int& { return p.yard.people; }, {0, 50}, "that walk about");
  declared_.integer(
      "vehicles", [](auto& p) -> int& { return p.yard.vehicles; }, {0, 20}, "that drive about");
  declared_.integer(
      "unmapped", [](auto& p) -> int& { return p.yard.unmapped; }, {0, 50},
      "boxes at drawn places in aisles that the map does not show");
  obstacles_ = parameters().declare<std::vector<double>>(
      "obstacles", {},
      {.description = "further such boxes: x, y, half length, half width, m, of each in turn"});
  start_ = parameters().declare<std::vector<double>>(
      "start", {-3.5, 3.25, 0.0},
      {.description = "m, m, rad: pose of the rear axle at the beginning"});
  declared_.real(
      "localisation.position_sigma",
      [](auto& p) -> double& { return p.localisation.position_sigma; }, {0, 10},
      "m, of odometry/filtered, correlated over 20 s");
  declared_.real(
      "localisation.heading_sigma", [](auto& p) -> double& { return p.localisation.heading_sigma; },
      {0, 1}, "rad, likewise");
  declared_.real(
      "slope", [](auto& p) -> double& { return p.vehicle.slope; }, {0, 0.3}, "rad, of the ground");
  declared_.real(
      "uphill", [](auto& p) -> double& { return p.vehicle.uphill; }, {-7, 7},
      "rad, heading in which it rises");
  map_folder_ = parameters().declare<std::string>(
      "map_folder", "",
      {.description = "where plant.yaml, plant.pgm and plant.geojson are written when it is "
                      "configured; empty: nowhere"});
  rows_ = parameters().declare<std::vector<std::int64_t>>(
      "operator.rows", {},
      {.description =
           "edges of the graph of which the operator asks for a tour; empty: all aisles"});
  standing_ = parameters().declare<double>("standing", 1.0,
                                           {.description = "s, before the operator asks",
                                            .floating_point_range = FloatingPointRange{0, 1000}});
  time_limit_ = parameters().declare<double>(
      "time_limit", 1800.0,
      {.description = "s, simulated, after which the operator gives up",
       .floating_point_range = FloatingPointRange{1, 1e6}});
}

PlantSimulation::~PlantSimulation() = default;

PlantDriveParameters PlantSimulation::drive_parameters() const {
  PlantDriveParameters result = declared_.read();
  result.seed = static_cast<std::uint64_t>(seed_.get());
  const std::vector<double> boxes = obstacles_.get();
  constexpr std::size_t kValues = 4;
  if (boxes.size() % kValues != 0) {
    throw std::invalid_argument("parameter 'obstacles': " + std::to_string(boxes.size()) +
                                " values are no multiple of 4");
  }
  for (std::size_t i = 0; i < boxes.size(); i += kValues) {
    result.obstacles.push_back({.centre = {boxes[i], boxes[i + 1]},
                                .half_length = boxes[i + 2],
                                .half_width = boxes[i + 3]});
  }
  const std::vector<double> start = start_.get();
  if (start.size() != 3) {
    throw std::invalid_argument("parameter 'start': " + std::to_string(start.size()) +
                                " values, not x, y and heading");
  }
  result.start = {.x = start[0], .y = start[1], .heading = start[2]};
  return result;
}

CallbackReturn PlantSimulation::on_configure() {
  drive_.emplace(drive_parameters());
  steps_ = 0;
  asked_ = false;
  over_ = false;
  if (const std::string folder = map_folder_.get(); !folder.empty()) {
    const navigation::HybridMap map = simulation::map_of(drive_->yard());
    const std::filesystem::path path(folder);
    std::filesystem::create_directories(path);
    write_grid(path / "plant.yaml", map.grid);
    write_route_graph(path / "plant.geojson", map.graph);
  }
  const auto matched = run_steps_.on_matched();
  clock_publisher_ = create_publisher(topics::kClock);
  scan_publisher_ = create_publisher(topics::kScan, {.events = {.matched = matched}});
  odometry_publisher_ =
      create_publisher(topics::kOdometryFiltered, {.events = {.matched = matched}});
  track_publisher_ = create_publisher(topics::kPipeTrack, {.events = {.matched = matched}});
  true_odometry_publisher_ =
      create_publisher(topics::kTrueOdometry, {.events = {.matched = matched}});
  command_subscription_ = create_subscription(
      topics::kGroundVelocityCommand,
      [this](const Twist& message) { drive_->command(message.linear.x, message.angular.z); });
  client_ = create_action_client<InspectTour>("inspect_tour");
  run_steps_.configure(
      *clock_publisher_.untyped(),
      {scan_publisher_.untyped(), odometry_publisher_.untyped(), track_publisher_.untyped(),
       true_odometry_publisher_.untyped()},
      from_seconds(kStepSeconds), [this] { return next_step(); },
      [this](std::string_view counter, std::string_view text) { report_fault(counter, text); });
  return CallbackReturn::kSuccess;
}

CallbackReturn PlantSimulation::on_activate() {
  if (!run_steps_.all_there()) {
    report_progress(0, 0, "waiting for the subscriptions of " + run_steps_.missing());
  }
  run_steps_.activate();
  return CallbackReturn::kSuccess;
}

CallbackReturn PlantSimulation::on_deactivate() {
  run_steps_.deactivate();
  return CallbackReturn::kSuccess;
}

CallbackReturn PlantSimulation::on_cleanup() {
  run_steps_.clean_up();
  client_ = {};
  clock_publisher_ = {};
  scan_publisher_ = {};
  odometry_publisher_ = {};
  track_publisher_ = {};
  true_odometry_publisher_ = {};
  command_subscription_ = {};
  drive_.reset();
  return CallbackReturn::kSuccess;
}

bool PlantSimulation::next_step() {
  if (steps_ > 0) {
    drive_->drive(kStepMilliseconds);
  }
  const Time stamp = at(drive_->time());
  Clock clock;
  clock.clock = to_message(stamp);
  clock_publisher_.publish(std::move(clock));
  publish_odometry(stamp);
  if (steps_ % kStepsPerScan == 0) {
    publish_scan(stamp);
  }
  if (steps_ % kStepsPerTrack == 0) {
    publish_track(stamp);
  }
  if (++steps_ % kStepsPerProgress == 0) {
    report_progress(static_cast<std::uint64_t>(drive_->driven()), 0, "m driven");
  }
  if (!asked_ && drive_->time() >= standing_.get() && client_.is_ready()) {
    send_goal();
  }
  if (!over_ && drive_->time() > time_limit_.get()) {
    over_ = true;
    report_failed("the tour takes longer than time_limit");
  }
  return !over_;
}

void PlantSimulation::send_goal() {
  asked_ = true;
  InspectTour::Goal goal;
  goal.rows = rows_.get();
  client_.send_goal(
      std::move(goal),
      {.response =
           [this](const GoalResponse& response) {
             if (!response.accepted) {
               over_ = true;
               report_failed("the tour is refused");
             }
           },
       .result = [this](const GoalOutcome<InspectTour>& outcome) { on_result(outcome); }});
}

void PlantSimulation::on_result(const GoalOutcome<InspectTour>& outcome) {
  over_ = true;
  const std::string reason = outcome.result ? outcome.result->reason : to_string(outcome.end);
  if (!outcome) {
    report_failed("the tour ended early: " + reason);
    return;
  }
  if (drive_->collisions() > 0) {
    report_failed("the robot touched something for " + std::to_string(drive_->collisions()) +
                  " ms");
    return;
  }
  const std::string told = std::to_string(outcome.result->rows_passed) + " rows driven along, " +
                           std::to_string(outcome.result->left_out.size()) + " left out, " +
                           std::to_string(std::lround(outcome.result->pipe_seen_percent)) +
                           " % of their pipes seen sharp, " +
                           std::to_string(std::lround(drive_->driven())) + " m in " +
                           std::to_string(std::lround(drive_->time())) + " s, nearest " +
                           std::to_string(std::lround(100 * drive_->least_clearance())) + " cm";
  logger().info(told);
  report_complete(told);
}

void PlantSimulation::publish_odometry(Time stamp) {
  const auto& errors = drive_->parameters().localisation;
  auto measured = std::make_unique<Odometry>();
  fill(*measured, drive_->measured(kStepSeconds));
  measured->header.stamp = to_message(stamp);
  constexpr std::size_t kSize = 6;
  for (std::size_t i = 0; i < kSize; ++i) {
    measured->pose.covariance[i * (kSize + 1)] = kOtherVariance;
  }
  const double position = std::max(errors.position_sigma * errors.position_sigma, kOtherVariance);
  measured->pose.covariance[0] = position;
  measured->pose.covariance[kSize + 1] = position;
  measured->pose.covariance[kSize * kSize - 1] =
      std::max(errors.heading_sigma * errors.heading_sigma, 1e-8);
  odometry_publisher_.publish(std::move(measured));
  auto truth = std::make_unique<Odometry>();
  fill(*truth, drive_->truth());
  truth->header.stamp = to_message(stamp);
  true_odometry_publisher_.publish(std::move(truth));
}

void PlantSimulation::publish_scan(Time stamp) {
  const simulation::LidarParameters& lidar = drive_->parameters().lidar;
  auto message = std::make_unique<LaserScan>();
  message->header.stamp = to_message(stamp);
  message->header.frame_id = "lidar";
  message->angle_min = static_cast<float>(-std::numbers::pi);
  message->angle_increment = static_cast<float>(2 * std::numbers::pi / lidar.beams);
  message->angle_max =
      message->angle_min + static_cast<float>(lidar.beams - 1) * message->angle_increment;
  message->scan_time = static_cast<float>(kStepsPerScan * kStepSeconds);
  message->range_min = static_cast<float>(kLidarNearest);
  message->range_max = static_cast<float>(lidar.largest_range);
  drive_->scan(message->ranges);
  scan_publisher_.publish(std::move(message));
}

void PlantSimulation::publish_track(Time stamp) {
  const auto range = drive_->range_to_pipe();
  auto message = std::make_unique<PipeTrack>();
  message->header.stamp = to_message(stamp);
  message->header.frame_id = "camera_optical_frame";
  message->state = range ? PipeTrack::STATE_LOCKED : PipeTrack::STATE_LOST;
  message->track = range ? 1 : 0;
  message->confidence = range ? kConfidence : 0;
  message->range = range.value_or(std::numeric_limits<double>::quiet_NaN());
  track_publisher_.publish(std::move(message));
}

}  // namespace pipescout

PIPESCOUT_REGISTER_COMPONENT(pipescout::PlantSimulation)
