// SPDX-License-Identifier: Apache-2.0
#include "pipescout/patrol_simulation/patrol_simulation.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <stdexcept>
#include <string>
#include <utility>

#include "patrol_messages.hpp"
#include "pipescout/catalogue/topics.hpp"
#include "pipescout/message_conversions/camera.hpp"
#include "pipescout/message_conversions/geometry.hpp"
#include "pipescout/message_conversions/motion.hpp"
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
constexpr double kOdometerDeviation = 0.01;  // m, stated of a reading

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
  steps_ = 0;
  images_ = 0;
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
  run_steps_.configure(
      *clock_publisher_.untyped(),
      {image_publisher_.untyped(), camera_info_publisher_.untyped(), imu_publisher_.untyped(),
       fix_publisher_.untyped(), readings_publisher_.untyped(), joint_publisher_.untyped(),
       true_odometry_publisher_.untyped(), true_leaks_publisher_.untyped(),
       true_track_publisher_.untyped()},
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
  command_subscription_ = {};
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
    if (images_ < expected_images_ &&
        images_ * 100 / expected_images_ != (images_ - 1) * 100 / expected_images_) {
      report_progress(images_, expected_images_);
    }
  }
  ++steps_;
  const bool complete = drive_->arrived();
  if (complete) {
    report_complete("the robot has driven " +
                    std::to_string(std::lround(drive_->patrol().robot().distance())) + " m");
  }
  return !complete;
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
                         scene.tube_radius, patrol.place() >= 0 && patrol.place() <= scene.length));
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
  for (auto& leak : true_leak_messages(drive_->patrol().scene())) {
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
