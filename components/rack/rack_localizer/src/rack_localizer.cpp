// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_localizer/rack_localizer.hpp"

#include <array>
#include <cmath>
#include <iomanip>
#include <locale>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "pipescout/catalogue/topics.hpp"
#include "pipescout/message_conversions/camera.hpp"
#include "pipescout/message_conversions/geometry.hpp"
#include "pipescout/message_conversions/mounting_parameters.hpp"
#include "pipescout/rack_file/rack_file.hpp"
#include "pipescout/rack_vision/visual_servo.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "pipescout/runtime/register_component.hpp"
#include "pipescout/validation/number_text.hpp"

namespace pipescout {

namespace {

using geometry::Matrix6d;
using geometry::SE3;
using pipescout_msgs::msg::RackState;
using rack_vision::MotionPrediction;
using rack_vision::RackTrackerResult;
using rack_vision::TrackStatus;

constexpr FloatingPointRange kPositive{1e-9, 1e6};
constexpr std::size_t kOdometryHistory = 2000;
/// s over which odometry is interpolated, and moved on beyond its last message.
constexpr double kOdometryReach = 0.2;

std::uint8_t to_message(TrackStatus status) {
  switch (status) {
    case TrackStatus::kNotStarted:
      return RackState::STATUS_NOT_STARTED;
    case TrackStatus::kTracking:
      return RackState::STATUS_TRACKING;
    case TrackStatus::kLost:
      return RackState::STATUS_LOST;
    case TrackStatus::kCoasting:
    case TrackStatus::kBadImage:
    case TrackStatus::kBadStamp:
      return RackState::STATUS_BAD_IMAGE;
  }
  return RackState::STATUS_LOST;
}

Matrix6d diagonal(double position_deviation, double rotation_deviation) {
  geometry::Vector6d variances;
  variances << Eigen::Vector3d::Constant(position_deviation * position_deviation),
      Eigen::Vector3d::Constant(rotation_deviation * rotation_deviation);
  return variances.asDiagonal();
}

bool knows_place_better(const Matrix6d& covariance, const Matrix6d& other) {
  return covariance.diagonal().head<3>().sum() < other.diagonal().head<3>().sum();
}

}  // namespace

RackLocalizer::RackLocalizer(ComponentOptions options) : Component(std::move(options)) {
  rack_file_ = parameters().declare<std::string>(
      "rack", "", {.description = "YAML file with the pipes, see docs/rack_file.md"});
  frame_id_ = parameters().declare<std::string>("frame_id", "rack",
                                                {.description = "frame of the published poses"});
  declare_start_parameters();
  declare_tracker_parameters();
  declare_message_parameters();
}

RackLocalizer::~RackLocalizer() = default;

void RackLocalizer::declare_start_parameters() {
  start_position_ = parameters().declare<std::vector<double>>(
      "start.position", {},
      {.description = "m, initial position x y z of the camera in the rack frame; empty: from "
                      "rack/pose_hint or the image"});
  start_roll_pitch_yaw_ = parameters().declare<std::vector<double>>(
      "start.roll_pitch_yaw", {},
      {.description = "rad, of the camera's optical frame; empty: looks straight down, the upper "
                      "border of the image ahead along the flow"});
  start_position_deviation_ =
      parameters().declare<double>("start.position_deviation", 0.05,
                                   {.description = "m, standard deviation of each coordinate",
                                    .floating_point_range = kPositive});
  start_rotation_deviation_ =
      parameters().declare<double>("start.rotation_deviation", 0.05,
                                   {.description = "rad, standard deviation about each axis",
                                    .floating_point_range = kPositive});
  start_drift_ = parameters().declare<double>(
      "start.drift", rack_vision::RackLocalizationParameters{}.hover_drift_speed,
      {.description = "m/s, speed at which the camera may drift from start.position before the "
                      "first pose is found",
       .floating_point_range = kPositive});
  find_first_pose_ = parameters().declare<bool>(
      "find_first_pose", true,
      {.description = "initialise from the image alone when there is no pose"});
  hint_position_ = parameters().declare<std::vector<double>>(
      "hint.position", {},
      {.description = "m, prior x y z of the initialisation from the image alone; empty: unknown. "
                      "The position along the pipes is unobservable from contours"});
  hint_position_deviation_ = parameters().declare<std::vector<double>>(
      "hint.position_deviation", {},
      {.description = "m, standard deviation of each coordinate; empty: 1, 1, 1"});
  hint_heading_ = parameters().declare<std::vector<double>>(
      "hint.heading", {},
      {.description = "rad, angle about rack z from rack x to the camera's x axis, and its "
                      "standard deviation; empty: unknown"});
  retry_period_ =
      parameters().declare<double>("retry_period", settings_.retry_period,
                                   {.description = "s between two attempts to initialise",
                                    .floating_point_range = FloatingPointRange{0.0, 3600.0}});
}

void RackLocalizer::declare_tracker_parameters() {
  const rack_vision::RackTrackerParameters defaults;
  samples_per_edge_ =
      parameters().declare<int>("samples_per_edge", defaults.samples_per_edge,
                                {.description = "sample points along each visible edge",
                                 .integer_range = IntegerRange{2, 100}});
  points_per_frame_ =
      parameters().declare<int>("points_per_frame", defaults.points_per_frame,
                                {.description = "texture points matched in one image",
                                 .integer_range = IntegerRange{0, 200}});
  map_capacity_ = parameters().declare<int>(
      "map_capacity", defaults.map_capacity,
      {.description = "texture points in the map", .integer_range = IntegerRange{0, 20000}});
  estimate_offsets_ =
      parameters().declare<bool>("estimate_offsets", defaults.estimate_offsets,
                                 {.description = "estimate the lateral offsets of the pipes"});
  offset_deviation_ = parameters().declare<double>(
      "offset_deviation", defaults.offset_sigma,
      {.description = "m, prior standard deviation of the offset of a pipe",
       .floating_point_range = kPositive});
  estimate_intrinsics_ = parameters().declare<bool>(
      "estimate_intrinsics", defaults.estimate_intrinsics,
      {.description = "estimate the focal length and the centre of the camera on line"});
  focal_length_deviation_ = parameters().declare<double>(
      "focal_length_deviation", defaults.focal_sigma,
      {.description = "px, standard deviation of the calibrated focal length",
       .floating_point_range = kPositive});
  centre_deviation_ = parameters().declare<double>(
      "centre_deviation", defaults.centre_sigma,
      {.description = "px, standard deviation of each coordinate of the calibrated centre",
       .floating_point_range = kPositive});
  row_time_ = parameters().declare<double>(
      "row_time", defaults.row_time,
      {.description = "s from the exposure of one row of the image to that of the next (rolling "
                      "shutter); 0: global shutter",
       .floating_point_range = FloatingPointRange{0.0, 1e-3}});
  acceleration_ = parameters().declare<double>(
      "acceleration", defaults.acceleration_sigma,
      {.description = "m/s^2, process noise of the constant-velocity model",
       .floating_point_range = kPositive});
  angular_acceleration_ = parameters().declare<double>(
      "angular_acceleration", defaults.angular_acceleration_sigma,
      {.description = "rad/s^2, the same for its rotation", .floating_point_range = kPositive});
}

void RackLocalizer::declare_message_parameters() {
  mount_parameters_.emplace(parameters());
  odometry_drift_ = parameters().declare<double>(
      "odometry.drift", 0.02,
      {.description = "m per root of a second, error of the odometry between images",
       .floating_point_range = kPositive});
  odometry_rotation_drift_ = parameters().declare<double>(
      "odometry.rotation_drift", 0.01,
      {.description = "rad per root of a second, the same for rotation",
       .floating_point_range = kPositive});
  maximum_age_ = parameters().declare<double>(
      "maximum_age", 2.0,
      {.description = "s, messages with an older stamp are counted as stale, and images refused; "
                      "0: any age is accepted",
       .floating_point_range = FloatingPointRange{0.0, 86400.0}});
  maximum_lead_ = parameters().declare<double>(
      "maximum_lead", 0.1,
      {.description = "s, messages with a stamp further ahead of the clock are refused",
       .floating_point_range = FloatingPointRange{0.0, 86400.0}});
  silent_after_ = parameters().declare<double>(
      "silent_after", 2.0,
      {.description = "s without an image after which image.silent is counted",
       .floating_point_range = kPositive});
}

rack_vision::RackLocalizationParameters RackLocalizer::localization_parameters() const {
  rack_vision::RackLocalizationParameters result;
  result.tracker.samples_per_edge = samples_per_edge_.get();
  result.tracker.points_per_frame = points_per_frame_.get();
  result.tracker.map_capacity = map_capacity_.get();
  result.tracker.estimate_offsets = estimate_offsets_.get();
  result.tracker.offset_sigma = offset_deviation_.get();
  result.tracker.estimate_intrinsics = estimate_intrinsics_.get();
  result.tracker.focal_sigma = focal_length_deviation_.get();
  result.tracker.centre_sigma = centre_deviation_.get();
  result.tracker.row_time = row_time_.get();
  result.tracker.acceleration_sigma = acceleration_.get();
  result.tracker.angular_acceleration_sigma = angular_acceleration_.get();
  result.find_first_pose = find_first_pose_.get();
  result.retry_period = retry_period_.get();
  result.hover_drift_speed = start_drift_.get();
  result.validate();
  return result;
}

rack_vision::FirstPoseHint RackLocalizer::hint() const {
  rack_vision::FirstPoseHint result;
  if (const auto position = three(hint_position_)) {
    const Eigen::Vector3d deviation =
        three(hint_position_deviation_).value_or(Eigen::Vector3d::Ones());
    result.x = {position->x(), deviation.x()};
    result.y = {position->y(), deviation.y()};
    result.z = {position->z(), deviation.z()};
  }
  if (const auto& values = hint_heading_.get(); !values.empty()) {
    if (values.size() != 2) {
      throw std::invalid_argument(
          "parameter 'hint.heading' must be empty or two numbers: angle and standard deviation");
    }
    result.heading = {values[0], values[1]};
  }
  result.validate();
  return result;
}

CallbackReturn RackLocalizer::on_configure() {
  const std::string file = rack_file_.get();
  if (file.empty()) {
    throw std::invalid_argument("parameter 'rack' is empty: it must name the rack's YAML file");
  }
  model_ = read_rack(file);
  logger().info(std::to_string(model_.pipes.size()) + " pipes and " +
                std::to_string(model_.supports.size()) + " supports in " + file);
  along_ = rack_vision::main_direction(model_);
  settings_ = localization_parameters();
  // What does not fit together is told now, not with the first calibration.
  rack_vision::RackLocalization(model_, geometry::Camera(), settings_).set_hint(hint());
  mount_ = mount_parameters_->read(*this);
  frame_ = frame_id_.get();
  stamp_limits_ = {.maximum_age = maximum_age_.get(), .maximum_lead = maximum_lead_.get()};
  localization_.reset();
  calibration_.reset();
  intrinsics_.reset();
  shapes_.clear();
  start_.reset();
  suggestion_.reset();
  odometry_.emplace(kOdometryHistory, kOdometryReach);
  last_image_.reset();
  last_status_ = TrackStatus::kNotStarted;
  has_tracked_ = false;
  if (const auto position = three(start_position_)) {
    const auto angles = three(start_roll_pitch_yaw_);
    // A base that faces along the flow, which is rack y.
    const SE3 ahead(geometry::SO3::about_z(M_PI_2), Eigen::Vector3d::Zero());
    const geometry::SO3 rotation = angles ? geometry::SO3::from_roll_pitch_yaw(*angles)
                                          : (ahead * rack_vision::downward_camera()).rotation();
    start_ = Start{SE3(rotation, *position),
                   diagonal(start_position_deviation_.get(), start_rotation_deviation_.get())};
  }

  pose_publisher_ =
      create_publisher(topics::kRackPose, {.events = {.matched = awaited_.on_matched()}});
  state_publisher_ =
      create_publisher(topics::kRackState, {.events = {.matched = awaited_.on_matched()}});
  odometry_subscription_ = create_subscription(
      topics::kOdometryFiltered, [this](const Odometry& message) { on_odometry(message); });
  hint_subscription_ = create_subscription(topics::kRackPoseHint,
                                           [this](const Pose& message) { on_pose_hint(message); });
  image_silence_.start("image", silent_after_.get());
  counts_timer_ = create_timer(std::chrono::seconds(1), [this] { tell_counts(); });
  awaited_.watch({pose_publisher_.untyped(), state_publisher_.untyped()}, [this] { subscribe(); });
  return CallbackReturn::kSuccess;
}

void RackLocalizer::subscribe() {
  camera_info_subscription_ = create_subscription(
      topics::kCameraInfo, [this](const CameraInfo& message) { on_camera_info(message); });
  image_subscription_ = create_subscription(topics::kCameraImage,
                                            [this](const Image& message) { on_image(message); });
}

CallbackReturn RackLocalizer::on_cleanup() {
  awaited_.stop();
  image_silence_.stop();
  counts_timer_.reset();
  image_subscription_ = {};
  camera_info_subscription_ = {};
  odometry_subscription_ = {};
  hint_subscription_ = {};
  pose_publisher_ = {};
  state_publisher_ = {};
  localization_.reset();
  odometry_.reset();
  return CallbackReturn::kSuccess;
}

void RackLocalizer::on_camera_info(const CameraInfo& message) {
  if (calibration_ && same_calibration(*calibration_, message)) {
    return;
  }
  try {
    const geometry::Camera camera(from_message(message));
    localization_.emplace(model_, camera, settings_);
    localization_->set_hint(hint());
  } catch (const std::invalid_argument& error) {
    report_fault("camera_info.refused", std::string("calibration refused: ") + error.what());
    return;
  }
  if (calibration_) {
    report_fault("camera_info.changed", "the calibration has changed: tracking starts again");
  }
  calibration_ = message;
  if (start_) {
    check_start(localization_->set_pose(start_->T_rack_camera, start_->covariance));
  }
  if (suggestion_) {
    check_start(localization_->suggest_pose(suggestion_->T_rack_camera, suggestion_->covariance));
  }
}

void RackLocalizer::check_start(bool usable) {
  if (!usable) {
    report_fault("start.refused", "the initial pose is not usable");
  }
}

void RackLocalizer::on_pose_hint(const Pose& message) {
  if (const auto fault =
          stamp_limits_.find_fault("pose_hint", from_message(message.header.stamp), now())) {
    report_fault(fault->counter, fault->text);
    return;
  }
  if (!message.header.frame_id.empty() && message.header.frame_id != frame_) {
    report_fault(
        "pose_hint.header.frame_id",
        "a pose hint is in frame '" + message.header.frame_id + "', not in '" + frame_ + "'");
    return;
  }
  try {
    const Start suggestion{from_message(message.pose.pose),
                           covariance_from_message(message.pose.covariance)};
    if (localization_) {
      check_start(localization_->suggest_pose(suggestion.T_rack_camera, suggestion.covariance));
    } else if (!suggestion_ || knows_place_better(suggestion.covariance, suggestion_->covariance)) {
      suggestion_ = suggestion;
    }
  } catch (const std::invalid_argument& error) {
    report_fault("pose_hint.refused", std::string("pose hint refused: ") + error.what());
  }
}

void RackLocalizer::on_odometry(const Odometry& message) {
  take_odometry(
      *odometry_, message, {.stamps = stamp_limits_}, now(),
      [this](std::string_view counter, std::string_view text) { report_fault(counter, text); });
}

std::optional<MotionPrediction> RackLocalizer::motion_until(Time stamp) {
  if (!last_image_ || stamp <= *last_image_) {
    return std::nullopt;
  }
  const auto before = odometry_->at(*last_image_);
  const auto now_there = odometry_->at(stamp);
  if (!before || !now_there) {
    return std::nullopt;
  }
  std::string missing;
  const auto T_base_camera_before = mount_.T_base_camera(*last_image_, &missing);
  const auto T_base_camera = mount_.T_base_camera(stamp, &missing);
  if (!T_base_camera_before || !T_base_camera) {
    report_fault("tf.missing",
                 "where the camera is on the robot is not known, its motion is not "
                 "predicted: " +
                     missing);
    return std::nullopt;
  }
  const SE3 motion =
      T_base_camera_before->inverse() * before->inverse() * *now_there * *T_base_camera;
  const double root = std::sqrt(to_seconds(stamp - *last_image_));
  return MotionPrediction{
      motion, diagonal(root * odometry_drift_.get(), root * odometry_rotation_drift_.get())};
}

void RackLocalizer::on_image(const Image& message) {
  image_silence_.heard();
  const Time stamp = from_message(message.header.stamp);
  if (const auto fault = stamp_limits_.find_fault("image", stamp, now())) {
    report_fault(fault->counter, fault->text);
    return;
  }
  if (!localization_) {
    report_fault("camera_info.missing", "images without a calibration on camera/camera_info");
    return;
  }
  rack_vision::ImageView view;
  try {
    view = reader_.read(message);
  } catch (const std::invalid_argument& error) {
    report_fault("image.refused", std::string("image refused: ") + error.what());
    return;
  }
  const auto& camera = *calibration_;
  const RackTrackerResult result =
      localization_->track(view, to_seconds(stamp.time_since_epoch()), motion_until(stamp));
  if (result.status == TrackStatus::kBadImage) {
    report_fault("image.unusable", "an image of " + std::to_string(view.width) + " x " +
                                       std::to_string(view.height) +
                                       " (calibrated: " + std::to_string(camera.width) + " x " +
                                       std::to_string(camera.height) +
                                       ") cannot be used: " + std::string(result.reason));
  } else if (result.status == TrackStatus::kBadStamp) {
    report_fault("image.header.stamp.not_increasing",
                 "an image has a stamp that is not later than the previous one");
  } else {
    last_image_ = stamp;
  }
  intrinsics_ = result.intrinsics;
  shapes_.assign(result.shapes.begin(), result.shapes.end());
  publish(message, result);
}

void RackLocalizer::publish(const Image& image, const RackTrackerResult& result) {
  if (result.status != last_status_) {
    if (result.status == TrackStatus::kTracking) {
      has_tracked_ = true;
      logger().info("tracking the rack");
    } else if (result.status == TrackStatus::kLost && has_tracked_) {
      report_fault("track.lost", "the rack is lost: " + std::string(result.reason));
    } else if (result.status == TrackStatus::kLost) {
      logger().info("the rack is not found yet: " + std::string(result.reason));
    }
    last_status_ = result.status;
  }
  if (result.status == TrackStatus::kTracking) {
    auto pose = std::make_unique<Pose>();
    pose->header.stamp = image.header.stamp;
    pose->header.frame_id = frame_;
    pose->pose.pose = pipescout::to_message(result.T_rack_camera);
    pose->pose.covariance = pipescout::to_message(result.covariance);
    pose_publisher_.publish(std::move(pose));
  }
  auto state = std::make_unique<State>();
  state->header.stamp = image.header.stamp;
  state->header.frame_id = frame_;
  state->status = to_message(result.status);
  state->quality = result.status == TrackStatus::kTracking ? result.quality : 0.0;
  state->reason = std::string(result.reason);
  for (std::size_t i = 0; i < model_.pipes.size() && i < result.offsets.size(); ++i) {
    state->pipe.push_back(model_.pipes[i].name);
    state->offset.push_back(result.offsets[i]);
    state->offset_variance.push_back(result.offset_variances[i]);
    state->offset_observed.push_back(result.offset_observed[i] != 0);
  }
  state->inlier_share = result.inlier_share;
  state->edges = static_cast<std::uint32_t>(result.edges);
  state->edge_samples = static_cast<std::uint32_t>(result.edge_samples);
  state->edge_samples_found = static_cast<std::uint32_t>(result.edge_samples_found);
  state->texture_points = static_cast<std::uint32_t>(result.points);
  state->texture_points_matched = static_cast<std::uint32_t>(result.points_matched);
  state->map_points = static_cast<std::uint32_t>(result.map_points);
  const double along = along_.dot(result.covariance.topLeftCorner<3, 3>() * along_);
  state->along_standard_deviation = std::sqrt(std::max(0.0, along));
  state->losses = localization_->tracker().counts().losses;
  state_publisher_.publish(std::move(state));
}

void RackLocalizer::tell_counts() {
  if (!localization_) {
    return;
  }
  const auto tell = [this](const char* key, std::uint64_t value) {
    diagnostics().set_value(key, std::to_string(value));
  };
  const rack_vision::RackTrackerCounts& tracker = localization_->tracker().counts();
  tell("tracker.images", tracker.images);
  tell("tracker.losses", tracker.losses);
  tell("tracker.refused_starts", tracker.refused_starts);
  tell("tracker.bad_predictions", tracker.bad_predictions);
  const rack_vision::RackLocalizationCounts& counts = localization_->counts();
  tell("start.given", counts.given);
  tell("start.suggested", counts.suggested);
  tell("start.from_last_pose", counts.from_last_pose);
  tell("start.from_image", counts.from_image);
  tell("start.image_ambiguous", counts.image_ambiguous);
  tell("start.image_unclear", counts.image_unclear);
  tell("recoveries", counts.recoveries);
  for (const rack_vision::PipeShapeEstimate& each : shapes_) {
    std::ostringstream text;
    text.imbue(std::locale::classic());
    text << std::fixed << std::setprecision(4);
    const auto tell_one = [&text](const char* name, double value, double deviation) {
      text << name << value << " +- " << deviation;
    };
    if (each.found) {
      tell_one("height ", each.shape.height, each.deviation.height);
      tell_one(" m, radius ", each.shape.radius, each.deviation.radius);
      tell_one(" m, turned aside ", each.shape.turn_aside, each.deviation.turn_aside);
      tell_one(" rad, up ", each.shape.turn_up, each.deviation.turn_up);
      text << " rad";
    } else {
      text << "not told by the images";
    }
    diagnostics().set_value("shape." + model_.pipes[each.pipe].name, text.str());
  }
  if (intrinsics_) {
    static constexpr std::array kNames{"camera.focal_length", "camera.centre_u", "camera.centre_v"};
    for (Eigen::Index i = 0; i < 3; ++i) {
      std::ostringstream text;
      text.imbue(std::locale::classic());
      text << std::fixed << std::setprecision(2) << intrinsics_->mean(i) << " +- "
           << std::sqrt(intrinsics_->covariance(i, i)) << " px";
      diagnostics().set_value(kNames[static_cast<std::size_t>(i)], text.str());
    }
  }
}

}  // namespace pipescout

PIPESCOUT_REGISTER_COMPONENT(pipescout::RackLocalizer)
