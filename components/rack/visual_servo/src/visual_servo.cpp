// SPDX-License-Identifier: Apache-2.0
#include "pipescout/visual_servo/visual_servo.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "pipescout/catalogue/topics.hpp"
#include "pipescout/message_conversions/geometry.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "pipescout/runtime/register_component.hpp"
#include "pipescout/validation/number_text.hpp"

namespace pipescout {

namespace {

using pipescout_msgs::msg::RackState;
using rack_vision::CameraPose;
using rack_vision::PoseVerdict;
using rack_vision::ServoCommand;
using rack_vision::ServoState;
using rack_vision::VisualServoParameters;
using rack_vision::WayPoint;
using rack_vision::WayPointMissionParameters;
using rack_vision::WayPointOutcome;
using rack_vision::WayPointPath;
using rack_vision::WayPointPathParameters;

constexpr std::size_t kValuesPerWayPoint = 4;
/// The clock was set back by more: a simulation that begins again.
constexpr Duration kNewBeginning = std::chrono::seconds(1);

double seconds(Time time) {
  return to_seconds(time.time_since_epoch());
}

CameraPose to_camera_pose(const geometry_msgs::msg::Pose& pose, double time, double quality) {
  const auto& p = pose.position;
  const auto& q = pose.orientation;
  return {.time = time,
          .position = {p.x, p.y, p.z},
          .orientation = {q.w, q.x, q.y, q.z},
          .quality = quality};
}

/// What a pose that is not taken counts as.
const char* counter(PoseVerdict verdict) {
  switch (verdict) {
    case PoseVerdict::kNotANumber:
      return "pose.not_a_number";
    case PoseVerdict::kNoRotation:
      return "pose.no_rotation";
    case PoseVerdict::kFromTheFuture:
      return "pose.header.stamp.in_future";
    case PoseVerdict::kStale:
      return "pose.header.stamp.stale";
    case PoseVerdict::kOutOfOrder:
      return "pose.header.stamp.not_increasing";
    case PoseVerdict::kTaken:
    case PoseVerdict::kLowQuality:
      break;
  }
  return "pose.low_quality";
}

}  // namespace

VisualServo::VisualServo(ComponentOptions options) : Component(std::move(options)) {
  declare_mission_parameters();
  declare_servo_parameters();
  declare_safety_parameters();
}

VisualServo::~VisualServo() = default;

void VisualServo::declare_mission_parameters() {
  const WayPoint way_point;
  const WayPointPathParameters path;
  const WayPointMissionParameters mission;
  const auto number = [this](const char* name, double value, const char* description) {
    return parameters().declare<double>(name, value, {.description = description});
  };
  way_points_ = parameters().declare<std::vector<double>>(
      "way_points", {},
      {.description =
           "x y z yaw of base_link in the rack frame for each way-point in turn: m and rad"});
  hold_ = number("hold", way_point.hold, "s, [0, 3600]: shortest stay at each way-point");
  path_speed_ =
      number("path.largest_speed", path.largest_speed,
             "m/s, (0, 20]: of the path; below largest_speed, so that the robot can catch up");
  path_acceleration_ =
      number("path.largest_acceleration", path.largest_acceleration, "m/s^2, (0, 20]");
  path_yaw_rate_ = number("path.largest_yaw_rate", path.largest_yaw_rate, "rad/s, (0, 6]");
  path_yaw_acceleration_ =
      number("path.largest_yaw_acceleration", path.largest_yaw_acceleration, "rad/s^2, (0, 20]");
  position_tolerance_ = number("tolerance.position", mission.tolerance.position,
                               "m, (0, 10]: largest error at a way-point that is reached");
  yaw_tolerance_ = number("tolerance.yaw", mission.tolerance.yaw, "rad, (0, pi]: the same");
  reached_for_ = number("reached_for", mission.reached_for,
                        "s, [0, 60]: time within the tolerance after which a way-point is reached");
  deviations_within_ = number("deviations_within", mission.deviations_within,
                              "[0, 10]: this many standard deviations of the pose must be within "
                              "the tolerance too; 0: the covariance is not used");
  look_around_ = number("look_around", mission.look_around,
                        "m, [0, 2]: radius of a circle flown at a way-point while the pose is too "
                        "uncertain; 0: none");
  patience_ =
      number("patience", mission.patience, "s, [0, 3600]: time after which a way-point is missed");
  largest_lag_ = number("largest_lag", mission.largest_lag,
                        "m, (0, 100]: the path waits while the robot is farther from it");
  largest_yaw_lag_ = number("largest_yaw_lag", mission.largest_yaw_lag, "rad, (0, pi]: the same");
}

void VisualServo::declare_servo_parameters() {
  const VisualServoParameters servo;
  const auto number = [this](const char* name, double value, const char* description) {
    return parameters().declare<double>(name, value, {.description = description});
  };
  full_rotation_ = parameters().declare<bool>(
      "full_rotation", false,
      {.description =
           "the robot can rotate in place about every axis; else only its yaw is commanded"});
  position_gain_ = number("position_gain", servo.position_gain, "1/s, (0, 20]");
  rotation_gain_ = number("rotation_gain", servo.rotation_gain, "1/s, (0, 20]");
  response_time_ = number("response_time", servo.response_time,
                          "s, [0, 5]: time constant of the robot's velocity response");
  largest_speed_ = number("largest_speed", servo.largest_speed, "m/s, (0, 20]: commanded");
  largest_rotation_rate_ =
      number("largest_rotation_rate", servo.largest_rotation_rate, "rad/s, (0, 6]: commanded");
  largest_acceleration_ =
      number("largest_acceleration", servo.largest_acceleration, "m/s^2, (0, 50]: of the command");
  largest_rotation_acceleration_ =
      number("largest_rotation_acceleration", servo.largest_rotation_acceleration,
             "rad/s^2, (0, 50]: of the command");
  mount_parameters_.emplace(parameters());
  frame_id_ = parameters().declare<std::string>(
      "frame_id", "rack", {.description = "frame of the poses and way-points"});
  command_frame_id_ = parameters().declare<std::string>(
      "command_frame_id", "",
      {.description = "frame of the commands; empty: base_stabilized (base_link without roll and "
                      "pitch), or base_link with full_rotation"});
  rate_ = parameters().declare<double>(
      "rate", 10.0,
      {.description = "Hz, lowest rate of commands; there is one for each pose as well",
       .floating_point_range = FloatingPointRange{1.0, 1000.0}});
}

void VisualServo::declare_safety_parameters() {
  const VisualServoParameters servo;
  const auto number = [this](const char* name, double value, const char* description) {
    return parameters().declare<double>(name, value, {.description = description});
  };
  maximum_age_ = number("maximum_age", servo.stale_after,
                        "s, (0, 10]: a pose of this age is not used: the robot holds");
  maximum_lead_ = number("maximum_lead", servo.future_tolerance,
                         "s, [0, 1]: how far a stamp may be ahead of the clock");
  smallest_quality_ = number("smallest_quality", servo.smallest_quality,
                             "[0, 1]: poses are not used while the quality in rack/state is lower");
  hold_time_ =
      number("hold_time", servo.hold_time,
             "s, [0, 3600]: time without a pose before the climb; unlimited before the first pose");
  climb_speed_ =
      number("climb.speed", servo.climb_speed, "m/s, [0, largest_speed]; 0: holds without limit");
  climb_height_ = number("climb.height", servo.climb_height,
                         "m, [0, 1000]: height of the climb, then holds again");
}

std::vector<WayPoint> VisualServo::way_points() const {
  const auto values = way_points_.share();
  if (values->empty() || values->size() % kValuesPerWayPoint != 0) {
    throw std::invalid_argument("parameter 'way_points' has " + std::to_string(values->size()) +
                                " values: must be x y z yaw of one way-point or more");
  }
  std::vector<WayPoint> result;
  for (std::size_t i = 0; i < values->size(); i += kValuesPerWayPoint) {
    const double* value = values->data() + i;
    result.push_back(
        {.position = {value[0], value[1], value[2]}, .yaw = value[3], .hold = hold_.get()});
  }
  return result;
}

rack_vision::WayPointMission VisualServo::new_mission() const {
  const WayPointPathParameters path{.largest_speed = path_speed_.get(),
                                    .largest_acceleration = path_acceleration_.get(),
                                    .largest_yaw_rate = path_yaw_rate_.get(),
                                    .largest_yaw_acceleration = path_yaw_acceleration_.get()};
  const WayPointMissionParameters mission{
      .tolerance = {.position = position_tolerance_.get(), .yaw = yaw_tolerance_.get()},
      .reached_for = reached_for_.get(),
      .deviations_within = deviations_within_.get(),
      .look_around = look_around_.get(),
      .look_around_speed = path_speed_.get(),
      .patience = patience_.get(),
      .largest_lag = largest_lag_.get(),
      .largest_yaw_lag = largest_yaw_lag_.get()};
  return {WayPointPath(way_points(), path), mission};
}

VisualServoParameters VisualServo::servo_parameters() const {
  VisualServoParameters result;
  result.T_base_camera = mount_parameters_->T_base_camera();
  result.rotation = full_rotation_.get() ? rack_vision::RotationControl::kFull
                                         : rack_vision::RotationControl::kYawOnly;
  result.position_gain = position_gain_.get();
  result.rotation_gain = rotation_gain_.get();
  result.response_time = response_time_.get();
  result.largest_speed = largest_speed_.get();
  result.largest_rotation_rate = largest_rotation_rate_.get();
  result.largest_acceleration = largest_acceleration_.get();
  result.largest_rotation_acceleration = largest_rotation_acceleration_.get();
  result.stale_after = maximum_age_.get();
  result.future_tolerance = maximum_lead_.get();
  result.smallest_quality = smallest_quality_.get();
  result.hold_time = hold_time_.get();
  result.climb_speed = climb_speed_.get();
  result.climb_height = climb_height_.get();
  return result;
}

CallbackReturn VisualServo::on_configure() {
  planned_.emplace(new_mission());
  mission_ = planned_;
  servo_.emplace(servo_parameters());
  mount_ = mount_parameters_->read(*this);
  frame_ = frame_id_.get();
  command_frame_ = command_frame_id_.get();
  if (command_frame_.empty()) {
    command_frame_ = full_rotation_.get() ? "base_link" : "base_stabilized";
  }
  longest_silence_ = from_seconds(1.0 / rate_.get());
  quality_.reset();
  commanded_at_.reset();
  deviation_ = {};
  told_state_ = ServoState::kIdle;
  told_outcomes_ = 0;
  told_complete_ = false;
  has_flown_ = false;
  // Its last command, zero, is said after the managed endpoints have been disabled.
  publisher_ = create_publisher(topics::kVelocityCommand,
                                {.events = {.matched = awaited_.on_matched()}, .managed = false});
  awaited_.watch({publisher_.untyped()}, [this] { subscribe(); });
  timer_ = create_timer(longest_silence_, [this] {
    // Only what poses and states did not make it say.
    if (!commanded_at_ || now() < *commanded_at_ || now() - *commanded_at_ >= longest_silence_) {
      command(now());
    }
  });
  return CallbackReturn::kSuccess;
}

void VisualServo::subscribe() {
  pose_subscription_ =
      create_subscription(topics::kRackPose, [this](const Pose& message) { on_pose(message); });
  state_subscription_ =
      create_subscription(topics::kRackState, [this](const State& message) { on_state(message); });
}

CallbackReturn VisualServo::on_deactivate() {
  servo_->reset();
  publish(ServoCommand{}, now());
  return CallbackReturn::kSuccess;
}

CallbackReturn VisualServo::on_cleanup() {
  awaited_.stop();
  timer_.reset();
  pose_subscription_ = {};
  state_subscription_ = {};
  publisher_ = {};
  servo_.reset();
  mission_.reset();
  planned_.reset();
  return CallbackReturn::kSuccess;
}

void VisualServo::on_pose(const Pose& message) {
  if (!message.header.frame_id.empty() && message.header.frame_id != frame_) {
    report_fault("pose.header.frame_id",
                 "a pose is in frame '" + message.header.frame_id + "', not in '" + frame_ + "'");
    return;
  }
  const Time stamp = from_message(message.header.stamp);
  std::string missing;
  const auto T_base_camera = mount_.T_base_camera(stamp, &missing);
  if (!T_base_camera) {
    report_fault("tf.missing",
                 "a pose is not used: where the camera is on the robot is not known: " + missing);
    return;
  }
  servo_->set_T_base_camera(*T_base_camera);
  // The state of this image may still be on its way: that of the one before does as well, unless it
  // says that the rack was lost, since a pose says that it was found again.
  const bool judged =
      quality_ && (quality_->tracking || quality_->stamp >= stamp) &&
      std::abs(to_seconds(stamp - quality_->stamp)) <= servo_->parameters().stale_after;
  const PoseVerdict verdict = servo_->observe(
      to_camera_pose(message.pose.pose, seconds(stamp), judged ? quality_->value : 1.0),
      seconds(now()));
  if (verdict != PoseVerdict::kTaken) {
    report_fault(counter(verdict), std::string("a pose is not used: ") + to_string(verdict));
    if (verdict != PoseVerdict::kLowQuality) {
      return;
    }
  } else {
    deviation_ = deviation_of(message);
  }
  command(stamp);
}

VisualServo::Deviation VisualServo::deviation_of(const Pose& message) {
  const auto& entries = message.pose.covariance;
  if (std::ranges::all_of(entries, [](double entry) { return entry == 0; })) {
    return {};  // not stated: the pose is taken at its word
  }
  try {
    const geometry::Matrix6d covariance = covariance_from_message(entries);
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> position(covariance.topLeftCorner<3, 3>(),
                                                                  Eigen::EigenvaluesOnly);
    return {.position = std::sqrt(position.eigenvalues()(2)), .yaw = std::sqrt(covariance(5, 5))};
  } catch (const std::invalid_argument& error) {
    report_fault("pose.covariance",
                 std::string("a pose that cannot confirm a way-point: ") + error.what());
    constexpr double kUnknown = std::numeric_limits<double>::infinity();
    return {.position = kUnknown, .yaw = kUnknown};
  }
}

void VisualServo::on_state(const State& message) {
  const double quality = message.quality;
  const bool tracking = message.status == RackState::STATUS_TRACKING;
  const bool sound = std::isfinite(quality) && quality >= 0 && quality <= 1;
  if (!sound) {
    report_fault("state.quality", "a quality of " + validation::number_text(quality) +
                                      " is outside [0, 1]: treated as 0");
  }
  quality_ = {.stamp = from_message(message.header.stamp),
              .value = tracking && sound ? quality : 0.0,
              .tracking = tracking};
  if (!tracking) {
    // No pose comes of this image that would be answered by a command.
    command(quality_->stamp);
  }
}

void VisualServo::command(Time measured) {
  const Time clock = now();
  if (commanded_at_ && *commanded_at_ - clock > kNewBeginning) {
    mission_ = planned_;
    told_outcomes_ = 0;
    told_complete_ = false;
  }
  // The image may be ahead of the clock by as much as is allowed; then its time is the later one.
  const bool ahead =
      measured > clock && to_seconds(measured - clock) <= servo_->parameters().future_tolerance;
  const Time stamp = ahead ? measured : clock;
  const double at = seconds(stamp);
  std::optional<rack_vision::LevelPose> pose;
  if (const auto T_rack_base = servo_->T_rack_base(at)) {
    pose = {.time = *servo_->pose_time(),
            .position = T_rack_base->translation(),
            .yaw = T_rack_base->rotation().roll_pitch_yaw().z(),
            .position_deviation = deviation_.position,
            .yaw_deviation = deviation_.yaw};
  }
  mission_->advance(at, pose);
  const ServoCommand result = servo_->step(at, mission_->target(servo_->pose_time().value_or(at)));
  commanded_at_ = clock;
  publish(result, stamp);
  tell(result);
}

void VisualServo::publish(const ServoCommand& command, Time stamp) {
  auto message = std::make_unique<Twist>();
  message->header.stamp = to_message(stamp);
  message->header.frame_id = command_frame_;
  message->twist.linear.x = command.linear.x();
  message->twist.linear.y = command.linear.y();
  message->twist.linear.z = command.linear.z();
  message->twist.angular.x = command.angular.x();
  message->twist.angular.y = command.angular.y();
  message->twist.angular.z = command.angular.z();
  publisher_.publish(std::move(message));
}

void VisualServo::tell(const ServoCommand& command) {
  if (command.state != told_state_) {
    told_state_ = command.state;
    const bool flies = command.state == ServoState::kServoing;
    diagnostics().set_value("state", to_string(command.state));
    has_flown_ = has_flown_ || flies;
    // Before the first pose its source has not begun.
    diagnostics().set_status(flies        ? DiagnosticLevel::kOk
                             : has_flown_ ? DiagnosticLevel::kWarn
                                          : DiagnosticLevel::kStale,
                             flies ? "" : std::string("no pose: ") + to_string(command.state));
    logger().info(std::string("now ") + to_string(command.state));
  }
  const std::size_t reached = mission_->count(WayPointOutcome::kReached);
  const std::size_t missed = mission_->count(WayPointOutcome::kMissed);
  const bool new_outcome = reached + missed != told_outcomes_;
  // Later than the last way-point is reached while it is to hold there.
  const bool completes = mission_->complete() && !told_complete_;
  if (!new_outcome && !completes) {
    return;
  }
  const std::size_t total = mission_->outcomes().size();
  const std::string text = std::to_string(reached) + " of " + std::to_string(total) +
                           " way-points reached, " + std::to_string(missed) + " missed";
  if (new_outcome) {
    told_outcomes_ = reached + missed;
    diagnostics().set_value("way_points", text);
    if (mission_->outcomes()[told_outcomes_ - 1] == WayPointOutcome::kMissed) {
      report_fault("way_point.missed",
                   "way-point " + std::to_string(told_outcomes_ - 1) + " was not reached");
    }
    report_progress(told_outcomes_, total, text);
  }
  if (completes) {
    told_complete_ = true;
    report_complete(text);
  }
}

}  // namespace pipescout

PIPESCOUT_REGISTER_COMPONENT(pipescout::VisualServo)
