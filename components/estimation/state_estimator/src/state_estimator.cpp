// SPDX-License-Identifier: Apache-2.0
#include "pipescout/state_estimator/state_estimator.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <pipescout/estimation/camera_calibration.hpp>
#include <stdexcept>
#include <string>
#include <utility>

#include "estimator_messages.hpp"
#include "pipescout/catalogue/topics.hpp"
#include "pipescout/message_conversions/geometry.hpp"
#include "pipescout/message_conversions/map_origin.hpp"
#include "pipescout/message_conversions/motion.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "pipescout/runtime/register_component.hpp"
#include "pipescout/validation/number_text.hpp"
#include "sensor_mounting.hpp"

namespace pipescout {

namespace {

using estimation::Outcome;
using estimation::Phase;
using estimation::Source;
using estimation::SourceState;
using geometry::Matrix6d;
using geometry::SE3;

/// Between two poses to start from for a localizer that is lost.
constexpr Duration kHintPeriod = std::chrono::milliseconds(500);
/// m: a pose that is less certain than this helps no localizer.
constexpr double kUselessHint = 2.0;
/// What is said of a place and of a heading that are not known: m, rad, standard deviations.
constexpr double kAnywhere = 1e4;
constexpr double kAnyHeading = M_PI;
/// rad: a tilt that is less certain than this says nothing to a localizer.
constexpr double kUselessTilt = 0.1;

SensorMounting mounting(const EstimatorSettings& settings, const SE3& T_base_camera = SE3()) {
  return {.imu = settings.imu, .T_base_camera = T_base_camera};
}

/// Of position and rotation.
Matrix6d pose_covariance(const estimation::StateMatrix& covariance) {
  return covariance.topLeftCorner<6, 6>();
}

// Of a pose of the camera in the rack frame, form of geometry_msgs/PoseWithCovariance.

bool tells_place(const Matrix6d& covariance) {
  return covariance.diagonal().head<3>().maxCoeff() < kUselessHint * kUselessHint;
}

bool tells_tilt(const Matrix6d& covariance) {
  return covariance.diagonal().segment<2>(3).maxCoeff() < kUselessTilt * kUselessTilt;
}

/// Of a state that reckons from wherever it began.
void forget_all_but_tilt(Matrix6d& covariance) {
  const Eigen::Matrix2d tilt = covariance.block<2, 2>(3, 3);
  covariance.setZero();
  covariance.diagonal().head<3>().setConstant(kAnywhere * kAnywhere);
  covariance.block<2, 2>(3, 3) = tilt;
  covariance(5, 5) = kAnyHeading * kAnyHeading;
}

std::string seconds(double value) {
  return validation::fixed_text(value, 1) + " s";
}

}  // namespace

StateEstimator::StateEstimator(ComponentOptions options)
    : Component(std::move(options)), declared_(parameters()) {}

StateEstimator::~StateEstimator() = default;

CallbackReturn StateEstimator::on_configure() {
  settings_ = declared_.read(*this);
  estimator_.emplace(settings_.estimator);
  map_.reset();
  if (settings_.datum) {
    place_map(*settings_.datum);
  }
  first_fixes_.clear();
  told_unstated_covariance_ = false;
  origin_.reset();
  planar_.reset();
  last_reading_.reset();
  imu_interval_ = 0;
  published_.reset();
  told_updates_ = 0;
  hinted_.reset();
  rack_is_lost_ = false;
  has_run_ = false;
  start_is_given_ = false;
  origin_is_due_ = false;
  status_ = {};
  told_ = {};
  correlation_is_told_ = {};

  odometry_publisher_ =
      create_publisher(topics::kOdometryFiltered, {.events = {.matched = awaited_.on_matched()}});
  state_publisher_ =
      create_publisher(topics::kEstimatorState, {.events = {.matched = awaited_.on_matched()}});
  hint_publisher_ = create_publisher(topics::kRackPoseHint);
  if (settings_.publish_tf) {
    tf_publisher_ = create_publisher(topics::kTf);
  }
  if (settings_.implied_imu) {
    planar_.emplace(estimation::PlanarMotionParameters{
        .gravity = settings_.estimator.smoother.gravity,
        .longest_gap = settings_.estimator.odometer.largest_gap});
  }
  awaited_.watch({odometry_publisher_.untyped(), state_publisher_.untyped()},
                 [this] { subscribe(); });
  imu_silence_.start(settings_.implied_imu
                         ? "motion of source '" + settings_.sources[*settings_.implied_imu].name +
                               "', which stands for an IMU,"
                         : std::string("reading of the IMU on imu/data"),
                     settings_.silent_after);
  status_timer_ = create_timer(from_seconds(settings_.silent_after), [this] {
    status_ = estimator_->status();
    tell_status();
    tell_correlations();
  });
  return CallbackReturn::kSuccess;
}

void StateEstimator::subscribe() {
  if (!settings_.implied_imu) {
    imu_subscription_ =
        create_subscription(topics::kImu, [this](const Imu& message) { on_imu(message); });
  }
  fix_subscription_ =
      create_subscription(topics::kGpsFix, [this](const Fix& message) { on_fix(message); });
  odometer_subscription_ = create_subscription(
      topics::kOdometerFused, [this](const Odometer& message) { on_odometer(message); });
  rack_pose_subscription_ = create_subscription(
      topics::kRackPose, [this](const Pose& message) { on_rack_pose(message); });
  rack_state_subscription_ = create_subscription(
      topics::kRackState, [this](const RackState& message) { on_rack_state(message); });
  weld_subscription_ =
      create_subscription(topics::kWeld, [this](const Weld& message) { on_weld(message); });
  initial_pose_subscription_ = create_subscription(
      topics::kInitialPose, [this](const Pose& message) { on_initial_pose(message); });
  subscribe_to_sources();
}

CallbackReturn StateEstimator::on_cleanup() {
  awaited_.stop();
  imu_silence_.stop();
  status_timer_.reset();
  imu_subscription_ = {};
  fix_subscription_ = {};
  odometer_subscription_ = {};
  rack_pose_subscription_ = {};
  rack_state_subscription_ = {};
  weld_subscription_ = {};
  initial_pose_subscription_ = {};
  named_.clear();
  odometry_publisher_ = {};
  state_publisher_ = {};
  tf_publisher_ = {};
  hint_publisher_ = {};
  estimator_.reset();
  return CallbackReturn::kSuccess;
}

std::optional<double> StateEstimator::time_of(std::string_view input,
                                              const builtin_interfaces::msg::Time& stamp) {
  const Time time = from_message(stamp);
  if (const auto fault = settings_.stamp_limits.find_fault(input, time, now())) {
    report_fault(fault->counter, fault->text);
    if (fault->in_future) {
      return std::nullopt;
    }
  }
  if (!origin_) {
    origin_ = time;
  }
  return to_seconds(time - *origin_);
}

Time StateEstimator::stamp_of(double time) const {
  return *origin_ + from_seconds(time);
}

void StateEstimator::report_outcome(Source source, Outcome outcome) {
  report_outcome(std::string(to_string(source)), outcome);
}

void StateEstimator::report_outcome(const std::string& source, Outcome outcome) {
  // Before the first attitude nothing is wrong with what cannot be used yet.
  if (outcome != Outcome::kAccepted && outcome != Outcome::kWaiting &&
      outcome != Outcome::kUninitialised) {
    const std::string reason(to_string(outcome));
    report_fault(source + "." + reason,
                 "a measurement of source '" + source + "' is refused: " + reason);
  }
}

void StateEstimator::give_start() {
  if (!settings_.start || start_is_given_ || !last_reading_) {
    return;
  }
  start_is_given_ = true;
  estimation::GivenPose pose = *settings_.start;
  pose.time = last_reading_->time;
  if (pose.position) {
    *pose.position += geometry::SO3::about_z(pose.heading.value_or(0)) * settings_.imu;
  }
  if (const Outcome outcome = estimator_->add(pose);
      outcome != Outcome::kAccepted && outcome != Outcome::kWaiting) {
    report_fault("start.refused",
                 "the initial pose of start.position and start.heading is refused: " +
                     std::string(to_string(outcome)));
  }
}

void StateEstimator::take_reading(const estimation::ImuReading& reading) {
  const Outcome outcome = estimator_->add(reading);
  report_outcome(Source::kImu, outcome);
  if (outcome == Outcome::kWaiting || outcome == Outcome::kAccepted) {
    if (last_reading_ && reading.time > last_reading_->time) {
      imu_interval_ = reading.time - last_reading_->time;
    }
    last_reading_ = reading;
    give_start();
  }
}

void StateEstimator::on_imu(const Imu& message) {
  imu_silence_.heard();
  const auto time = time_of("imu", message.header.stamp);
  if (!time) {
    return;
  }
  take_reading(imu_reading(message, *time));
  if (settings_.heading_from_imu) {
    try {
      if (const auto measured = heading(message, *time, settings_)) {
        report_outcome(Source::kHeading, estimator_->add(*measured));
      }
    } catch (const std::invalid_argument& error) {
      report_fault("heading.refused", std::string("orientation in imu/data: ") + error.what());
    }
  }
  publish_news();
}

void StateEstimator::on_fix(const Fix& message) {
  if (message.status.status < sensor_msgs::msg::NavSatStatus::STATUS_FIX) {
    diagnostics().count("gps.no_fix");
    return;
  }
  const auto time = time_of("gps", message.header.stamp);
  if (!time) {
    return;
  }
  if (message.latitude == 0 && message.longitude == 0) {
    report_fault(
        "gps.refused",
        "fix refused: latitude and longitude are exactly 0, as of a receiver without a fix");
    return;
  }
  if (!covariance_is_stated(message) && !told_unstated_covariance_) {
    told_unstated_covariance_ = true;
    logger().warn("gps: position_covariance states no usable variances (" +
                  validation::number_text(message.position_covariance[0]) + ", " +
                  validation::number_text(message.position_covariance[4]) + ", " +
                  validation::number_text(message.position_covariance[8]) +
                  "): gps.deviation is used for such fixes");
  }
  if (!may_place(message)) {
    return;
  }
  use_fix(message, *time);
  publish_news();
}

void StateEstimator::place_map(const geometry::GeodeticPosition& origin) {
  map_.emplace(origin);
  if (settings_.earth && !settings_.implied_imu) {
    estimator_->set_earth(estimation::Earth::at_latitude(origin.latitude));
  }
}

bool StateEstimator::may_place(const Fix& message) {
  constexpr double kElsewhere = 1e5;  // m, from the origin, while the state is not in the map yet
  if (settings_.datum) {
    return true;
  }
  try {
    (void)geodetic(message);
  } catch (const std::invalid_argument& error) {
    report_fault("gps.refused", std::string("fix refused: ") + error.what());
    return false;
  }
  const auto estimate = estimator_->estimate();
  const bool in_map = estimate && estimate->in_map;
  if (map_ && (in_map || map_->position(geodetic(message)).norm() < kElsewhere)) {
    first_fixes_.clear();
    return true;
  }
  if (!first_fixes_.add(message)) {
    return false;
  }
  const std::vector<Fix> agreeing = first_fixes_.take();
  if (map_) {
    logger().warn("the fixes so far were elsewhere: starts again with another origin of the map");
    estimator_->restart();
  }
  place_map(geodetic(agreeing.front()));
  logger().info("the map's origin is the first of " + std::to_string(agreeing.size()) +
                " fixes that agree: " + validation::number_text(map_->datum().latitude) + ", " +
                validation::number_text(map_->datum().longitude));
  for (std::size_t i = 0; i + 1 < agreeing.size(); ++i) {
    use_fix(agreeing[i], to_seconds(from_message(agreeing[i].header.stamp) - *origin_));
  }
  return true;
}

void StateEstimator::use_fix(const Fix& message, double time) {
  try {
    const auto estimate = estimator_->estimate();
    const double height = estimate && estimate->in_map ? estimate->state.position.z() : 0.0;
    estimation::GpsMeasurement measured = gps_measurement(message, time, *map_, height, settings_);
    if (estimate) {
      measured.angular_rate = estimate->angular_rate;
    }
    report_outcome(Source::kGps, estimator_->add(measured));
  } catch (const std::invalid_argument& error) {
    report_fault("gps.refused", std::string("fix refused: ") + error.what());
  }
}

void StateEstimator::on_odometer(const Odometer& message) {
  if (const auto time = time_of("odometer", message.header.stamp)) {
    report_outcome(Source::kOdometer, estimator_->add(odometer_reading(message, *time)));
    publish_news();
  }
}

std::optional<SE3> StateEstimator::camera_at(Time stamp) {
  std::string missing;
  auto T_base_camera = settings_.camera.T_base_camera(stamp, &missing);
  if (!T_base_camera) {
    report_fault("visual_pose.tf", "where the camera is on the robot is not known: " + missing);
  }
  return T_base_camera;
}

void StateEstimator::on_rack_pose(const Pose& message) {
  const auto time = time_of("visual_pose", message.header.stamp);
  if (!time) {
    return;
  }
  if (message.header.frame_id != settings_.rack_frame) {
    report_fault("visual_pose.header.frame_id", "rack/pose is in frame '" +
                                                    message.header.frame_id + "', not in '" +
                                                    settings_.rack_frame + "'");
    return;
  }
  const auto T_base_camera = camera_at(from_message(message.header.stamp));
  if (!T_base_camera) {
    return;
  }
  try {
    estimation::VisualPoseMeasurement measured =
        mounting(settings_, *T_base_camera)
            .visual_pose(*time, from_message(message.pose.pose),
                         covariance_from_message(message.pose.covariance));
    measured.angular_rate = angular_rate();
    measured.mounting = settings_.camera_mounting;
    report_outcome(Source::kVisualPose, estimator_->add(measured));
  } catch (const std::invalid_argument& error) {
    report_fault("visual_pose.refused", std::string("rack/pose refused: ") + error.what());
  }
  publish_news();
}

void StateEstimator::on_rack_state(const RackState& message) {
  using pipescout_msgs::msg::RackState;
  rack_is_lost_ =
      message.status == RackState::STATUS_LOST || message.status == RackState::STATUS_NOT_STARTED;
}

void StateEstimator::on_weld(const Weld& message) {
  if (!settings_.estimator.centre_line || !std::isfinite(message.chainage) ||
      !(message.weld_probability >= settings_.least_weld_probability)) {
    return;  // which weld it is, or where that is, is not known
  }
  const auto time = time_of("weld", message.header.stamp);
  if (!time) {
    return;
  }
  const double along = std::hypot(message.standard_deviation, std::sqrt(message.chainage_variance));
  const auto weld = settings_.estimator.centre_line->weld(
      *time, message.chainage, along, settings_.weld_deviation,
      mounting(settings_).in_body(settings_.weld_sensor));
  if (!weld) {
    report_fault("weld.beyond_centre_line", "a weld at chainage " +
                                                validation::number_text(message.chainage) +
                                                " m is not on the centre line");
    return;
  }
  report_outcome(Source::kWeld, estimator_->add(*weld));
  publish_news();
}

void StateEstimator::on_initial_pose(const Pose& message) {
  const auto time = time_of("initialpose", message.header.stamp);
  if (!time) {
    return;
  }
  if (message.header.frame_id != settings_.map_frame) {
    report_fault("initialpose.header.frame_id", "initialpose is in frame '" +
                                                    message.header.frame_id + "', not in '" +
                                                    settings_.map_frame + "'");
    return;
  }
  try {
    const SE3 pose = from_message(message.pose.pose);
    const double heading = pose.rotation().roll_pitch_yaw().z();
    const auto& variances = message.pose.covariance;
    for (const std::size_t i : {0, 7, 35}) {
      if (!(std::isfinite(variances[i]) && variances[i] >= 0)) {
        throw std::invalid_argument("pose.covariance[" + std::to_string(i) + "] is " +
                                    validation::number_text(variances[i]) +
                                    ", which is no variance");
      }
    }
    estimation::GivenPose given{
        .time = *time,
        .position = pose.translation() + geometry::SO3::about_z(heading) * settings_.imu,
        .position_deviation =
            std::clamp(std::sqrt(std::max(variances[0], variances[7])), 1e-3, 1e4),
        .heading = heading,
        .heading_deviation = std::clamp(std::sqrt(variances[35]), 1e-4, 1.0)};
    estimator_->restart();
    logger().info("restarts at the pose of initialpose");
    if (const Outcome outcome = estimator_->add(given);
        outcome != Outcome::kAccepted && outcome != Outcome::kWaiting) {
      report_fault("initialpose.refused",
                   "initialpose is refused: " + std::string(to_string(outcome)));
    }
  } catch (const std::invalid_argument& error) {
    report_fault("initialpose.refused", std::string("initialpose is refused: ") + error.what());
  }
}

void StateEstimator::publish_news() {
  const bool updated = estimator_->updates() != told_updates_;
  if (updated) {
    told_updates_ = estimator_->updates();
    status_ = estimator_->status();
    origin_is_due_ = true;
  }
  if (const auto estimate = estimator_->estimate(); estimate && is_due(stamp_of(estimate->time))) {
    published_ = stamp_of(estimate->time);
    publish_estimate(*estimate);
  }
  if (updated) {
    publish_state();
    publish_pose_hint();
    tell_status();
  }
}

bool StateEstimator::is_due(Time stamp) const {
  if (!published_) {
    return true;
  }
  const Duration since = stamp - *published_;
  // Times from long before are those of a clock that was set back.
  return since > Duration::zero()
             ? since >= settings_.publish_period
             : -since > settings_.publish_period + from_seconds(settings_.estimator.smoother.lag);
}

void StateEstimator::publish_estimate(const estimation::Estimate& estimate) {
  const SensorMounting mounted = mounting(settings_);
  const Time stamp = stamp_of(estimate.time);
  if (settings_.publish_tf) {
    auto message = std::make_unique<Transforms>();
    const SE3 T_body_base = mounted.T_body_base();
    if (estimate.in_map) {
      message->transforms.push_back(
          transform(estimate.T_map_odom, stamp, settings_.map_frame, settings_.odom_frame));
      if (status_.of(Source::kVisualPose).accepted > 0) {
        const estimation::GlobalStates& globals = estimator_->smoother().globals();
        message->transforms.push_back(transform({globals.R_map_rack, globals.rack_position}, stamp,
                                                settings_.map_frame, settings_.rack_frame));
      }
      // Not on tf_static: a replay must leave that to those who know the robot.
      if (map_ && std::exchange(origin_is_due_, false)) {
        message->transforms.push_back(map_origin_transform(*map_, settings_.map_frame, stamp));
      }
    }
    message->transforms.push_back(transform(estimate.T_odom_body * T_body_base, stamp,
                                            settings_.odom_frame, settings_.base_frame));
    tf_publisher_.publish(std::move(message));
  }
  if (!estimate.in_map) {
    return;
  }
  const double gyro = settings_.estimator.smoother.imu_noise.gyro;
  const double rate_variance = imu_interval_ > 0 ? gyro * gyro / imu_interval_ : 0.0;
  const auto motion = mounted.base_motion(estimate, estimator_->covariance(), rate_variance);
  auto message = std::make_unique<Odometry>();
  message->header.stamp = to_message(stamp);
  message->header.frame_id = settings_.map_frame;
  message->child_frame_id = settings_.base_frame;
  message->pose.pose = to_message(motion.T_map_base);
  message->pose.covariance = to_message(motion.pose_covariance);
  message->twist.twist = twist_message(motion.twist.head<3>(), motion.twist.tail<3>());
  message->twist.covariance = to_message(motion.twist_covariance);
  odometry_publisher_.publish(std::move(message));
}

void StateEstimator::publish_state() {
  const estimation::FixedLagSmoother& smoother = estimator_->smoother();
  auto message =
      std::make_unique<State>(state_message(*estimator_, status_, *origin_, settings_.sources));
  if (smoother.initialised()) {
    message->header.stamp = to_message(stamp_of(smoother.time(smoother.keyframes() - 1)));
  } else if (last_reading_) {
    message->header.stamp = to_message(stamp_of(last_reading_->time));
  }
  message->header.frame_id = settings_.map_frame;
  state_publisher_.publish(std::move(message));
}

bool StateEstimator::may_hint_place(Time stamp) const {
  // A state that has never seen the rack does not know where it is, unless it was told.
  const bool knows_rack = settings_.estimator.smoother.global_deviations.rack_position == 0 ||
                          status_.of(Source::kVisualPose).accepted > 0;
  return knows_rack && !(hinted_ && stamp >= *hinted_ && stamp - *hinted_ < kHintPeriod);
}

void StateEstimator::publish_pose_hint() {
  const auto estimate = estimator_->estimate();
  if (!rack_is_lost_ || !estimate) {
    return;
  }
  const Time stamp = stamp_of(estimate->time);
  if (estimate->in_map && !may_hint_place(stamp)) {
    return;
  }
  const auto T_base_camera = camera_at(stamp);
  if (!T_base_camera) {
    return;
  }
  SensorMounting::CameraPose pose =
      mounting(settings_, *T_base_camera)
          .camera_pose(*estimate, pose_covariance(estimator_->covariance()),
                       estimator_->smoother().globals(), estimator_->smoother().global_covariance(),
                       settings_.camera_mounting);
  if (!estimate->in_map) {
    forget_all_but_tilt(pose.covariance);
  }
  if (estimate->in_map ? !tells_place(pose.covariance) : !tells_tilt(pose.covariance)) {
    return;
  }
  hinted_ = stamp;
  auto message = std::make_unique<Pose>();
  message->header.stamp = to_message(stamp);
  message->header.frame_id = settings_.rack_frame;
  message->pose.pose = to_message(pose.T_rack_camera);
  message->pose.covariance = to_message(pose.covariance);
  hint_publisher_.publish(std::move(message));
}

void StateEstimator::tell_status() {
  has_run_ = has_run_ || status_.phase == Phase::kRunning;
  if (status_.phase != told_.phase || status_.text != told_.text) {
    const std::string phase(to_string(status_.phase));
    const std::string text = status_.text.empty() ? phase : phase + ": " + status_.text;
    if (status_.phase == Phase::kFault) {
      // The names are those of the algorithm.
      const std::string fault =
          text +
          " (R_body_imu is parameter imu.roll_pitch_yaw, specific_force_scale is "
          "imu.specific_force_scale)";
      report_fault("start.fault", fault);
      diagnostics().set_status(DiagnosticLevel::kError, fault);
    } else if (status_.phase == Phase::kRunning && status_.text.empty()) {
      diagnostics().set_status(DiagnosticLevel::kOk, text);
    } else {
      // What it waits for at its start has not begun, which is no fault.
      diagnostics().set_status(has_run_ ? DiagnosticLevel::kWarn : DiagnosticLevel::kStale, text);
    }
    if (status_.phase != told_.phase) {
      logger().info(text);
    }
  }
  for (std::size_t i = 0; i < estimation::kRestartReasons; ++i) {
    if (const std::size_t more = status_.restarts[i] - told_.restarts[i]; more > 0) {
      const std::string reason(to_string(static_cast<estimation::RestartReason>(i)));
      report_fault("restart." + reason, "the state was reset or discarded: " + reason);
      diagnostics().count("restart." + reason, more - 1);
    }
  }
  const estimation::ImuGaps& gaps = status_.imu_gaps;
  if (const std::size_t more = gaps.count - told_.imu_gaps.count; more > 0) {
    report_fault("imu.gap", "readings of the IMU are missing: up to " + seconds(gaps.longest) +
                                " between two stamps");
    diagnostics().count("imu.gap", more - 1);
  }
  diagnostics().set_value("imu.longest_gap", seconds(gaps.longest));
  diagnostics().set_value("imu.missing", seconds(gaps.total));
  diagnostics().set_value("imu.bridged", seconds(gaps.bridged));
  diagnostics().set_value("imu.behind", seconds(gaps.behind));
  for (std::size_t i = 0; i < estimation::kSources; ++i) {
    const std::string source(to_string(static_cast<Source>(i)));
    const estimation::SourceStatus& now_so = status_.sources[i];
    const estimation::SourceStatus& before = told_.sources[i];
    if (now_so.state == SourceState::kDoubted && before.state != SourceState::kDoubted) {
      report_fault(source + ".doubted",
                   "source '" + source + "' contradicts the state and is no longer used");
    } else if (now_so.state != before.state) {
      logger().info("source '" + source + "' is " + std::string(to_string(now_so.state)));
    }
    if (now_so.gated > before.gated) {
      diagnostics().count(source + ".gated", now_so.gated - before.gated);
    }
    if (now_so.reassigned > before.reassigned) {
      diagnostics().count(source + ".reassigned", now_so.reassigned - before.reassigned);
    }
    diagnostics().set_value(source + ".state", std::string(to_string(now_so.state)));
    diagnostics().set_value(source + ".accepted", std::to_string(now_so.accepted));
    if (now_so.held > 0) {
      diagnostics().set_value(source + ".held", std::to_string(now_so.held));
    }
    diagnostics().set_value(source + ".waiting", std::to_string(now_so.waiting));
  }
  if (status_.of(Source::kVisualPose).accepted > 0) {
    const std::string camera = camera_calibration_text(
        estimator_->smoother(), settings_.estimator.smoother, settings_.camera_mounting);
    if (!camera.empty()) {
      diagnostics().set_value("visual_pose.camera", camera);
    }
  }
  tell_sources();
  told_ = status_;
}

void StateEstimator::tell_correlations() {
  for (const Source source : {Source::kGps, Source::kVisualPose}) {
    const std::string name(to_string(source));
    const estimation::CorrelationFinding finding = estimator_->correlation_of(source);
    const std::string text = estimation::correlation_text(name, finding);
    if (text.empty()) {
      continue;
    }
    diagnostics().set_value(name + ".correlation", text);
    bool& is_told = correlation_is_told_[static_cast<std::size_t>(source)];
    if (finding.is_beyond_stated() && !is_told) {
      report_fault(name + ".correlation_time", text);
    }
    is_told = finding.is_beyond_stated();
  }
}

}  // namespace pipescout

PIPESCOUT_REGISTER_COMPONENT(pipescout::StateEstimator)
