// SPDX-License-Identifier: Apache-2.0
#include "pipescout/patrol_simulation/patrol_simulation.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>

#include "patrol_messages.hpp"
#include "pipescout/catalogue/topics.hpp"
#include "pipescout/map_files/grid_file.hpp"
#include "pipescout/map_files/route_graph_file.hpp"
#include "pipescout/message_conversions/camera.hpp"
#include "pipescout/message_conversions/geometry.hpp"
#include "pipescout/message_conversions/motion.hpp"
#include "pipescout/plant_world/yard_map.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "pipescout/runtime/register_component.hpp"

namespace pipescout {
namespace {

using simulation::GroundRobot;

/// Of the simulated clock: a stamp of zero means "no time" to some.
constexpr Time kStart{std::chrono::seconds(1000)};
constexpr const char* kMapFrame = "map";
constexpr const char* kBaseFrame = "base_link";
constexpr const char* kCameraFrame = "thermal_optical";
constexpr std::array kWheelNames{"front_left", "front_right", "rear_left", "rear_right"};
constexpr std::uint64_t kScansPerProgress = 100;
constexpr double kMilliseconds = 1e3;
constexpr double kCentimetres = 100;
constexpr double kScanPeriod = 0.1;              // s
constexpr double kLidarNearest = 0.1;            // m
constexpr double kOdometerDeviation = 0.01;      // m, stated of a reading
constexpr const char* kPreempted = "preempted";  // the navigator's word for it

Time at(double seconds) {
  return kStart + from_seconds(seconds);
}

}  // namespace

PatrolSimulation::PatrolSimulation(ComponentOptions options)
    : Component(std::move(options)), patrol_parameters_(parameters()) {}

PatrolSimulation::~PatrolSimulation() = default;

CallbackReturn PatrolSimulation::on_configure() {
  const PatrolDriveParameters parameters = patrol_parameters_.drive();
  grey_ = patrol_parameters_.grey();
  const std::vector<double> range = patrol_parameters_.grey_range();
  frame_.emplace(patrol_parameters_.datum());
  drive_.emplace(parameters);
  greys_.emplace(
      thermal::Radiometry(parameters.patrol.camera.constants, parameters.patrol.scene.object),
      range[0], range[1]);
  const geometry::CameraParameters& camera = parameters.patrol.camera.camera;
  counts_.assign(static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height),
                 0);
  const double image_period =
      std::round(1 / patrol_parameters_.image_rate() / GroundRobot::kStep) * GroundRobot::kStep;
  const bool with_arm = parameters.arm.has_value();
  // Images come with joint states, so their period is a multiple of that of these.
  steps_per_image_ =
      with_arm ? std::max<std::uint64_t>(1, static_cast<std::uint64_t>(std::llround(
                                                image_period * patrol_parameters_.arm_rate())))
               : 1;
  robot_steps_per_step_ = std::max<std::int64_t>(
      1, std::llround(image_period / static_cast<double>(steps_per_image_) / GroundRobot::kStep));
  step_period_ = static_cast<double>(robot_steps_per_step_) * GroundRobot::kStep;
  camera_frame_ = with_arm ? parameters.arm->camera_link : kCameraFrame;
  const double way = parameters.patrol.end - parameters.patrol.begin;
  expected_images_ =
      static_cast<std::uint64_t>(std::ceil((parameters.standing + way / parameters.patrol.speed) /
                                           (static_cast<double>(steps_per_image_) * step_period_)));
  steps_per_scan_ = std::max<std::uint64_t>(
      1, static_cast<std::uint64_t>(std::llround(kScanPeriod / step_period_)));
  steps_ = 0;
  images_ = 0;
  with_tour_ = patrol_parameters_.plant().with_tour();
  asked_ = false;
  over_ = false;
  write_map();
  const auto matched = run_steps_.on_matched();
  clock_publisher_ = create_publisher(topics::kClock);
  true_leaks_publisher_ = create_publisher(topics::kTrueLeaks, {.events = {.matched = matched}});
  true_odometry_publisher_ =
      create_publisher(topics::kTrueOdometry, {.events = {.matched = matched}});
  imu_publisher_ = create_publisher(topics::kImu, {.events = {.matched = matched}});
  fix_publisher_ = create_publisher(topics::kGpsFix, {.events = {.matched = matched}});
  readings_publisher_ =
      create_publisher(topics::kOdometerReadings, {.events = {.matched = matched}});
  camera_info_publisher_ =
      create_publisher(topics::kThermalCameraInfo, {.events = {.matched = matched}});
  image_publisher_ = create_publisher(topics::kThermalImage, {.events = {.matched = matched}});
  true_track_publisher_ =
      create_publisher(topics::kTruePipeTrack, {.events = {.matched = matched}});
  if (with_arm) {
    joint_publisher_ = create_publisher(topics::kJointStates, {.events = {.matched = matched}});
    command_subscription_ = create_subscription(
        topics::kArmCommand, [this](const JointTrajectory& message) { on_command(message); });
  }
  if (drive_->plant() != nullptr) {
    scan_publisher_ = create_publisher(topics::kScan, {.events = {.matched = matched}});
    twist_subscription_ =
        create_subscription(topics::kGroundVelocityCommand, [this](const Twist& message) {
          drive_->plant()->command(message.linear.x, message.angular.z);
        });
    if (with_tour_) {
      tour_client_ = create_action_client<InspectTour>("inspect_tour");
    }
  }
  run_steps_.configure(
      *clock_publisher_.untyped(),
      {image_publisher_.untyped(), camera_info_publisher_.untyped(), imu_publisher_.untyped(),
       fix_publisher_.untyped(), readings_publisher_.untyped(), joint_publisher_.untyped(),
       true_odometry_publisher_.untyped(), true_leaks_publisher_.untyped(),
       true_track_publisher_.untyped(), scan_publisher_.untyped()},
      from_seconds(step_period_), [this] { return next_step(); },
      [this](std::string_view counter, std::string_view text) { report_fault(counter, text); });
  return CallbackReturn::kSuccess;
}

CallbackReturn PatrolSimulation::on_activate() {
  if (!run_steps_.all_there()) {
    report_progress(0, expected_images_,
                    "waiting for the subscriptions of " + run_steps_.missing());
  }
  run_steps_.activate();
  return CallbackReturn::kSuccess;
}

CallbackReturn PatrolSimulation::on_deactivate() {
  run_steps_.deactivate();
  return CallbackReturn::kSuccess;
}

CallbackReturn PatrolSimulation::on_cleanup() {
  run_steps_.clean_up();
  clock_publisher_ = {};
  true_leaks_publisher_ = {};
  true_odometry_publisher_ = {};
  imu_publisher_ = {};
  fix_publisher_ = {};
  readings_publisher_ = {};
  camera_info_publisher_ = {};
  image_publisher_ = {};
  true_track_publisher_ = {};
  joint_publisher_ = {};
  scan_publisher_ = {};
  command_subscription_ = {};
  twist_subscription_ = {};
  tour_client_ = {};
  drive_.reset();
  return CallbackReturn::kSuccess;
}

void PatrolSimulation::on_command(const JointTrajectory& message) {
  const manipulation::ArmModel& arm = *drive_->arm();
  if (message.points.empty()) {
    report_fault("command.points.empty", "a command has no points: ignored");
    return;
  }
  const auto& point = message.points.back();
  std::vector<double> positions;
  std::vector<double> rates;
  for (const manipulation::ArmJoint& joint : arm.joints()) {
    const auto found = std::ranges::find(message.joint_names, joint.name);
    const auto i = static_cast<std::size_t>(found - message.joint_names.begin());
    if (found == message.joint_names.end() || i >= point.positions.size() ||
        i >= point.velocities.size()) {
      report_fault("command.missing_joint",
                   "a command has no position and velocity of '" + joint.name + "'");
      return;
    }
    positions.push_back(point.positions[i]);
    rates.push_back(point.velocities[i]);
  }
  try {
    drive_->command_arm(positions, rates, to_seconds(from_message(point.time_from_start)));
  } catch (const std::invalid_argument& error) {
    report_fault("command.refused", std::string("a command is refused: ") + error.what());
    return;
  }
}

bool PatrolSimulation::next_step() {
  const double time =
      static_cast<double>(static_cast<std::int64_t>(steps_) * robot_steps_per_step_) *
      GroundRobot::kStep;
  drive_->drive_until(time);
  const Time stamp = at(time);
  Clock clock;
  clock.clock = to_message(stamp);
  clock_publisher_.publish(std::move(clock));
  if (steps_ == 0) {
    publish_true_leaks();
  }
  if (drive_->arm() != nullptr) {
    publish_joints(stamp);
  }
  publish_imu();
  publish_odometers();
  publish_fixes();
  publish_true_odometry(stamp);
  if (steps_ % steps_per_image_ == 0) {
    publish_true_track(stamp);
    publish_image(stamp);
    ++images_;
    if (drive_->plant() == nullptr && images_ < expected_images_ &&
        images_ * 100 / expected_images_ != (images_ - 1) * 100 / expected_images_) {
      report_progress(images_, expected_images_);
    }
  }
  if (drive_->plant() != nullptr) {
    if (steps_ % steps_per_scan_ == 0) {
      publish_scan(stamp);
    }
    if (steps_ % (kScansPerProgress * steps_per_scan_) == 0) {
      report_driven();
    }
    operate(time);
    ++steps_;
    return !over_;
  }
  ++steps_;
  const bool complete = drive_->arrived();
  if (complete) {
    report_complete("the robot has driven " +
                    std::to_string(std::lround(drive_->patrol().robot().distance())) + " m");
  }
  return !complete;
}

void PatrolSimulation::write_map() const {
  const std::string folder = patrol_parameters_.plant().map_folder();
  if (drive_->plant() == nullptr || folder.empty()) {
    return;
  }
  const navigation::HybridMap map = simulation::map_of(drive_->plant()->yard());
  const std::filesystem::path path(folder);
  std::filesystem::create_directories(path);
  write_grid(path / "plant.yaml", map.grid);
  write_route_graph(path / "plant.geojson", map.graph);
}

void PatrolSimulation::report_driven() {
  report_progress(static_cast<std::uint64_t>(drive_->plant()->driven()), 0, "m driven");
}

void PatrolSimulation::ask_for_tour() {
  asked_ = true;
  InspectTour::Goal goal;
  goal.rows = patrol_parameters_.plant().tour();
  tour_client_.send_goal(
      std::move(goal),
      {.response =
           [this](const GoalResponse& response) {
             if (!response.accepted) {
               over_ = true;
               report_failed("the tour is refused; the log of the navigator says why");
             }
           },
       .result = [this](const GoalOutcome<InspectTour>& outcome) { on_tour(outcome); }});
}

void PatrolSimulation::on_tour(const GoalOutcome<InspectTour>& outcome) {
  if (outcome.result && outcome.result->reason == kPreempted) {
    with_tour_ = false;
    logger().info("the tour ends, since another goal has preempted it; the plant goes on");
    return;
  }
  if (!outcome) {
    over_ = true;
    report_failed("the tour ended early: " +
                  (outcome.result ? outcome.result->reason : std::string(to_string(outcome.end))));
    return;
  }
  end_well(std::to_string(outcome.result->rows_passed) + " rows driven along, " +
           std::to_string(outcome.result->left_out.size()) + " left out, " +
           std::to_string(std::lround(outcome.result->pipe_seen_percent)) +
           " % of their pipes seen sharp, ");
}

void PatrolSimulation::operate(double time) {
  const PlantParameters& plant = patrol_parameters_.plant();
  if (over_) {
    return;
  }
  if (!with_tour_) {
    if (plant.duration() > 0 && time >= plant.duration()) {
      end_well("");
    }
    return;
  }
  if (!asked_ && time >= patrol_parameters_.standing() && tour_client_.is_ready()) {
    ask_for_tour();
  }
  if (time > plant.time_limit()) {
    over_ = true;
    report_failed("the tour takes longer than plant.time_limit");
  }
}

void PatrolSimulation::end_well(const std::string& what) {
  over_ = true;
  const simulation::PlantDrive& plant = *drive_->plant();
  if (plant.contact_time() > 0) {
    report_failed("the robot touched something for " +
                  std::to_string(std::lround(kMilliseconds * plant.contact_time())) + " ms");
    return;
  }
  report_complete(what + std::to_string(std::lround(plant.driven())) + " m in " +
                  std::to_string(std::lround(drive_->motion().time)) + " s, nearest " +
                  std::to_string(std::lround(kCentimetres * plant.least_clearance())) + " cm");
}

void PatrolSimulation::publish_scan(Time stamp) {
  const simulation::LidarParameters& lidar = drive_->plant()->parameters().lidar;
  auto message = std::make_unique<LaserScan>();
  message->header.stamp = to_message(stamp);
  message->header.frame_id = "lidar";
  message->angle_min = static_cast<float>(-std::numbers::pi);
  message->angle_increment = static_cast<float>(2 * std::numbers::pi / lidar.beams);
  message->angle_max =
      message->angle_min + static_cast<float>(lidar.beams - 1) * message->angle_increment;
  message->scan_time = static_cast<float>(kScanPeriod);
  message->range_min = static_cast<float>(kLidarNearest);
  message->range_max = static_cast<float>(lidar.largest_range);
  drive_->plant()->scan(message->ranges);
  scan_publisher_.publish(std::move(message));
}

void PatrolSimulation::publish_joints(Time stamp) {
  const simulation::ArmDynamics& arm = *drive_->arm_dynamics();
  auto message = std::make_unique<JointState>();
  message->header.stamp = to_message(stamp);
  for (const manipulation::ArmJoint& joint : drive_->arm()->joints()) {
    message->name.push_back(joint.name);
  }
  message->position.resize(message->name.size());
  arm.encoders(message->position);
  message->velocity = arm.rates();
  joint_publisher_.publish(std::move(message));
}

void PatrolSimulation::publish_true_track(Time stamp) {
  const simulation::ThermalPatrol& patrol = drive_->patrol();
  const simulation::ThermalSceneParameters& scene = patrol.scene().parameters();
  auto message = std::make_unique<PipeTrack>(
      true_track_message(drive_->tube_in_view(), patrol.renderer().camera().parameters(),
                         scene.tube_radius, drive_->beside_row()));
  message->header.stamp = to_message(stamp);
  message->header.frame_id = camera_frame_;
  true_track_publisher_.publish(std::move(message));
}

void PatrolSimulation::publish_imu() {
  for (const PatrolDrive::ImuSample& sample : drive_->take_imu_samples()) {
    auto message = std::make_unique<Imu>(
        imu_message(sample.reading.angular_rate, sample.reading.specific_force));
    message->header.stamp = to_message(at(sample.time));
    message->header.frame_id = kBaseFrame;
    imu_publisher_.publish(std::move(message));
  }
}

void PatrolSimulation::publish_odometers() {
  for (const PatrolDrive::OdometerSample& sample : drive_->take_odometer_samples()) {
    auto message = std::make_unique<Readings>();
    message->header.stamp = to_message(at(sample.time));
    message->header.frame_id = kBaseFrame;
    message->name.assign(kWheelNames.begin(), kWheelNames.end());
    message->distance.assign(sample.distances.begin(), sample.distances.end());
    message->standard_deviation.assign(kWheelNames.size(), kOdometerDeviation);
    message->valid.assign(kWheelNames.size(), true);
    readings_publisher_.publish(std::move(message));
  }
}

void PatrolSimulation::publish_fixes() {
  for (const simulation::GpsFix& fix : drive_->take_fixes()) {
    auto message = std::make_unique<Fix>(fix_message(fix, *frame_));
    message->header.stamp = to_message(at(fix.time));
    message->header.frame_id = kBaseFrame;
    fix_publisher_.publish(std::move(message));
  }
}

void PatrolSimulation::publish_true_leaks() {
  for (auto& leak : true_leak_messages(drive_->patrol().rows())) {
    leak.header.stamp = to_message(kStart);
    leak.header.frame_id = kMapFrame;
    true_leaks_publisher_.publish(
        std::make_unique<pipescout_msgs::msg::LeakEvent>(std::move(leak)));
  }
}

void PatrolSimulation::publish_true_odometry(Time stamp) {
  const simulation::BodyMotion& motion = drive_->motion();
  const Eigen::Vector3d velocity = motion.T_map_body.rotation().inverse() * motion.velocity;
  auto message = std::make_unique<Odometry>();
  message->header.stamp = to_message(stamp);
  message->header.frame_id = kMapFrame;
  message->child_frame_id = kBaseFrame;
  message->pose.pose = to_message(motion.T_map_body);
  message->twist.twist = twist_message(velocity, motion.angular_rate);
  true_odometry_publisher_.publish(std::move(message));
}

void PatrolSimulation::publish_image(Time stamp) {
  const geometry::CameraParameters& camera = drive_->patrol().renderer().camera().parameters();
  auto info = std::make_unique<CameraInfo>(to_message(camera));
  info->header.stamp = to_message(stamp);
  info->header.frame_id = camera_frame_;
  camera_info_publisher_.publish(std::move(info));

  drive_->patrol().render(images_, counts_);
  auto image = std::make_unique<Image>();
  image->header.stamp = to_message(stamp);
  image->header.frame_id = camera_frame_;
  image->width = static_cast<std::uint32_t>(camera.width);
  image->height = static_cast<std::uint32_t>(camera.height);
  image->encoding = grey_ ? "mono8" : "mono16";
  image->is_bigendian = std::endian::native == std::endian::big ? 1 : 0;
  const std::size_t pixel = grey_ ? 1 : sizeof(std::uint16_t);
  image->step = static_cast<std::uint32_t>(pixel * static_cast<std::size_t>(camera.width));
  image->data.resize(pixel * counts_.size());
  if (grey_) {
    greys_->convert(counts_, image->data);
  } else {
    std::memcpy(image->data.data(), counts_.data(), image->data.size());
  }
  image_publisher_.publish(std::move(image));
}

}  // namespace pipescout

PIPESCOUT_REGISTER_COMPONENT(pipescout::PatrolSimulation)
