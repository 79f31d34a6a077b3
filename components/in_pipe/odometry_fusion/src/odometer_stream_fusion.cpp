// SPDX-License-Identifier: Apache-2.0
#include "pipescout/odometry_fusion/odometer_stream_fusion.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <stdexcept>
#include <utility>

#include "pipescout/catalogue/topics.hpp"
#include "pipescout/odometry_fusion/conversions.hpp"
#include "pipescout/odometry_fusion/readings_checks.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "pipescout/runtime/register_component.hpp"
#include "pipescout/validation/number_text.hpp"

namespace pipescout {

namespace {

using odometry::OdometerHealth;
using odometry::OdometerKind;
using odometry::OdometerStreamParameters;
using odometry::SampleOutcome;
using odometry::SpacingOutcome;
using odometry::WeldCalibrationParameters;

constexpr FloatingPointRange kPositive{1e-9, 1e6};
constexpr FloatingPointRange kNotNegative{0.0, 1e6};

OdometerKind kind(const std::string& name) {
  if (name == "absolute") {
    return OdometerKind::kAbsolute;
  }
  if (name == "increment") {
    return OdometerKind::kIncrement;
  }
  throw std::invalid_argument("kinds: '" + name + "' must be 'absolute' or 'increment'");
}

odometry::FusionRule rule(const std::string& name) {
  if (name == "consensus") {
    return odometry::FusionRule::kConsensus;
  }
  if (name == "average") {
    return odometry::FusionRule::kAverage;
  }
  if (name == "circumference") {
    return odometry::FusionRule::kCircumference;
  }
  throw std::invalid_argument("rule: '" + name +
                              "' must be 'consensus', 'average' or 'circumference'");
}

/// "90 degrees towards 3:00, 4.7 m long, at 123.4 m"
std::string text_of(const odometry::FoundBend& bend) {
  constexpr double kMinutesInTurn = 720.0;
  const double turns = bend.direction / (2.0 * std::numbers::pi);
  const long minutes =
      std::lround(kMinutesInTurn * (turns - std::floor(turns))) % std::lround(kMinutesInTurn);
  const long hour = minutes < 60 ? 12 : minutes / 60;
  const std::string minute = std::to_string(minutes % 60);
  return std::to_string(std::lround(bend.angle * 180.0 / std::numbers::pi)) + " degrees towards " +
         std::to_string(hour) + ":" + (minute.size() < 2 ? "0" : "") + minute + ", " +
         validation::fixed_text(bend.length, 1) + " m long, at " +
         validation::fixed_text(bend.middle, 1) + " m";
}

/// Gives each odometer its entry of a list that is either empty or as long as there are odometers.
template <class Value, class Assign>
void assign_each(const char* parameter, const std::vector<Value>& values,
                 std::vector<odometry::OdometerParameters>& odometers, Assign assign) {
  if (values.empty()) {
    return;
  }
  if (values.size() != odometers.size()) {
    throw std::invalid_argument("parameter '" + std::string(parameter) + "' has " +
                                std::to_string(values.size()) + " values for " +
                                std::to_string(odometers.size()) + " odometers");
  }
  for (std::size_t i = 0; i < values.size(); ++i) {
    assign(odometers[i], values[i]);
  }
}

}  // namespace

OdometerStreamFusion::OdometerStreamFusion(ComponentOptions options)
    : Component(std::move(options)) {
  declare_stream_parameters();
  declare_calibration_parameters();
  declare_message_parameters();
}

OdometerStreamFusion::~OdometerStreamFusion() = default;

void OdometerStreamFusion::declare_stream_parameters() {
  const OdometerStreamParameters defaults;
  const odometry::OdometerParameters odometer;
  odometers_ = parameters().declare<std::vector<std::string>>(
      "odometers", {},
      {.description = "names of the odometers as in the readings",
       .additional_constraints = "2 to 16 different names"});
  kinds_ = parameters().declare<std::vector<std::string>>(
      "kinds", {},
      {.description = "one per odometer: 'absolute', from an arbitrary zero, or 'increment', since "
                      "the previous value; empty: all absolute"});
  resolutions_ = parameters().declare<std::vector<double>>(
      "resolutions", {},
      {.description =
           "m per count, one per odometer; empty: " + std::to_string(odometer.resolution),
       .floating_point_range = kPositive});
  sigmas_ = parameters().declare<std::vector<double>>(
      "sigmas_per_sqrt_metre", {},
      {.description = "m per square root of metre, one per odometer: standard deviation of its "
                      "error over the path; empty: that of the paper",
       .floating_point_range = kPositive});
  wraps_ = parameters().declare<std::vector<double>>(
      "wraps", {},
      {.description = "m, one per odometer: range after which its counter wraps around, 0: never; "
                      "empty: never",
       .floating_point_range = kNotNegative});
  rule_ = parameters().declare<std::string>(
      "rule", "consensus",
      {.description = "how odometers are fused: 'consensus' of those that agree, plain 'average', "
                      "or wheels around the 'circumference' of the pipe, which tells bends from "
                      "slips",
       .additional_constraints = "'circumference' needs clocks and pipe_radius"});
  clocks_ = parameters().declare<std::vector<double>>(
      "clocks", {},
      {.description = "rad, one per odometer: where the wheel touches the wall, around the axis "
                      "from the crawler's top, clockwise looking forward (3 o'clock is 1.5708); "
                      "empty: not known",
       .floating_point_range = FloatingPointRange{-10.0, 10.0}});
  laterals_ = parameters().declare<std::vector<double>>(
      "laterals", {},
      {.description = "m, one per odometer: how far to the left of the robot's reference point the "
                      "wheel is; its share of a turn, by the yaw rate of imu/data, is taken out; "
                      "empty: of wheels that all go the same way",
       .floating_point_range = FloatingPointRange{-100.0, 100.0}});
  pipe_radius_ = parameters().declare<double>(
      "pipe_radius", 0.0,
      {.description = "m, from the axis of the pipe to where the wheels touch it; 0: not known",
       .floating_point_range = FloatingPointRange{0.0, 10.0}});
  tightest_bend_ = parameters().declare<double>(
      "tightest_bend", defaults.circumference.tightest_bend,
      {.description = "radius of the tightest bend, in diameters of the pipe",
       .floating_point_range = FloatingPointRange{0.6, 100.0}});
  clock_sigma_ =
      parameters().declare<double>("clock_standard_deviation", defaults.circumference.clock_sigma,
                                   {.description = "rad, standard deviation of a clock position",
                                    .floating_point_range = FloatingPointRange{0.0, 0.5}});
  epsilon_ = parameters().declare<double>(
      "epsilon", defaults.consensus.epsilon,
      {.description = "largest confidence distance at which one odometer still supports another",
       .additional_constraints = "neither 0 nor 1",
       .floating_point_range = FloatingPointRange{0.0, 1.0}});
  estimate_sigmas_ = parameters().declare<bool>(
      "estimate_sigmas", false,
      {.description = "estimate sigmas_per_sqrt_metre from the residuals of the last windows"});
  tick_period_ = parameters().declare<double>(
      "tick_period", defaults.tick_period,
      {.description = "s, between two fused distances", .floating_point_range = kPositive});
  window_distance_ = parameters().declare<double>(
      "window_distance", defaults.window_distance,
      {.description = "m, length of a window, after which the distance is fixed",
       .floating_point_range = kPositive});
  lookback_windows_ = parameters().declare<int>(
      "lookback_windows", static_cast<int>(defaults.lookback_windows),
      {.description = "number of windows over which a slip that is too small for one window is "
                      "detected and removed; 0: none",
       .integer_range = IntegerRange{0, 16}});
  maximum_delay_ = parameters().declare<double>(
      "maximum_delay", defaults.maximum_delay,
      {.description = "s, longest wait of a fused distance for late odometers",
       .floating_point_range = kNotNegative});
  maximum_gap_ = parameters().declare<double>(
      "maximum_gap", defaults.maximum_gap,
      {.description = "s, longer gaps between two readings are not bridged",
       .floating_point_range = kPositive});
  silent_after_ = parameters().declare<double>(
      "silent_after", defaults.silent_after,
      {.description = "s without readings after which an odometer is silent",
       .floating_point_range = kPositive});
  maximum_speed_ =
      parameters().declare<double>("maximum_speed", defaults.maximum_speed,
                                   {.description = "m/s, a faster reading is a counter fault",
                                    .floating_point_range = kPositive});
  common_sigma_ = parameters().declare<double>(
      "common_sigma_per_sqrt_metre", defaults.common_sigma_per_sqrt_metre,
      {.description = "m per square root of metre, of errors common to all odometers",
       .floating_point_range = kNotNegative});
  common_scale_sigma_ = parameters().declare<double>(
      "common_scale_sigma", defaults.common_scale_sigma,
      {.description = "standard deviation of a scale error common to all odometers",
       .floating_point_range = FloatingPointRange{0.0, 1.0}});
  worn_tolerance_ = parameters().declare<double>(
      "worn_tolerance", defaults.health.worn_tolerance,
      {.description = "an odometer is worn when its relative scale error is larger",
       .floating_point_range = FloatingPointRange{1e-6, 0.499}});
}

void OdometerStreamFusion::declare_calibration_parameters() {
  const WeldCalibrationParameters defaults;
  calibrate_ = parameters().declare<bool>(
      "calibrate", true,
      {.description = "estimate the scales of the odometers from the distances between welds"});
  calibration_scale_sigma_ = parameters().declare<double>(
      "calibration.scale_standard_deviation", defaults.calibration.initial_scale_standard_deviation,
      {.description = "prior standard deviation of a scale",
       .floating_point_range = FloatingPointRange{1e-6, 0.5}});
  calibration_offset_sigma_ = parameters().declare<double>(
      "calibration.offset_standard_deviation",
      defaults.calibration.initial_offset_standard_deviation,
      {.description =
           "m, prior standard deviation of an offset per joint; 0: no offset is estimated",
       .floating_point_range = kNotNegative});
  calibration_scale_drift_ = parameters().declare<double>(
      "calibration.scale_drift", defaults.calibration.scale_drift,
      {.description = "process noise of a scale by wear, variance per metre",
       .floating_point_range = FloatingPointRange{0.0, 1e-4}});
  least_weld_probability_ = parameters().declare<double>(
      "calibration.least_weld_probability", 0.99,
      {.description = "smallest probability of the data association of a weld that is used",
       .floating_point_range = FloatingPointRange{0.0, 1.0}});
}

void OdometerStreamFusion::declare_message_parameters() {
  maximum_age_ = parameters().declare<double>(
      "maximum_age", 1.0,
      {.description =
           "s, readings with an older stamp are counted as stale; 0: any age is accepted",
       .floating_point_range = FloatingPointRange{0.0, 86400.0}});
  maximum_lead_ = parameters().declare<double>(
      "maximum_lead", 0.1,
      {.description = "s, readings with a stamp further ahead of the clock are counted",
       .floating_point_range = FloatingPointRange{0.0, 86400.0}});
}

OdometerStreamParameters OdometerStreamFusion::stream_parameters() const {
  OdometerStreamParameters result;
  result.odometers.resize(odometers_.share()->size());
  assign_each("kinds", *kinds_.share(), result.odometers,
              [](auto& odometer, const std::string& name) { odometer.kind = kind(name); });
  assign_each("resolutions", *resolutions_.share(), result.odometers,
              [](auto& odometer, double value) { odometer.resolution = value; });
  assign_each("sigmas_per_sqrt_metre", *sigmas_.share(), result.odometers,
              [](auto& odometer, double value) { odometer.sigma_per_sqrt_metre = value; });
  assign_each("wraps", *wraps_.share(), result.odometers,
              [](auto& odometer, double value) { odometer.wrap = value; });
  assign_each("clocks", *clocks_.share(), result.odometers,
              [](auto& odometer, double value) { odometer.clock = value; });
  assign_each("laterals", *laterals_.share(), result.odometers,
              [](auto& odometer, double value) { odometer.lateral = value; });
  result.rule = rule(rule_.get());
  result.circumference.radius = pipe_radius_.get();
  result.circumference.tightest_bend = tightest_bend_.get();
  result.circumference.clock_sigma = clock_sigma_.get();
  result.consensus.epsilon = epsilon_.get();
  result.sigma_source =
      estimate_sigmas_.get() ? odometry::SigmaSource::kResiduals : odometry::SigmaSource::kGiven;
  result.tick_period = tick_period_.get();
  result.window_distance = window_distance_.get();
  result.lookback_windows = static_cast<std::size_t>(lookback_windows_.get());
  result.maximum_delay = maximum_delay_.get();
  result.maximum_gap = maximum_gap_.get();
  result.silent_after = silent_after_.get();
  result.maximum_speed = maximum_speed_.get();
  result.common_sigma_per_sqrt_metre = common_sigma_.get();
  result.common_scale_sigma = common_scale_sigma_.get();
  result.health.worn_tolerance = worn_tolerance_.get();
  return result;
}

WeldCalibrationParameters OdometerStreamFusion::calibration_parameters() const {
  WeldCalibrationParameters result;
  result.calibration.initial_scale_standard_deviation = calibration_scale_sigma_.get();
  result.calibration.initial_offset_standard_deviation = calibration_offset_sigma_.get();
  result.calibration.scale_drift = calibration_scale_drift_.get();
  result.worn_tolerance = worn_tolerance_.get();
  return result;
}

CallbackReturn OdometerStreamFusion::on_configure() {
  settings_ = {
      .names = odometers_.get(),
      .stamp_limits = {.maximum_age = maximum_age_.get(), .maximum_lead = maximum_lead_.get()},
      .maximum_gap = maximum_gap_.get(),
      .silent_after = silent_after_.get(),
      .least_weld_probability = least_weld_probability_.get(),
      .calibrate = calibrate_.get()};
  if (std::set<std::string>(settings_.names.begin(), settings_.names.end()).size() !=
      settings_.names.size()) {
    throw std::invalid_argument("parameter 'odometers' has a name twice");
  }
  stream_.emplace(stream_parameters());
  calibration_.emplace(calibration_parameters(), settings_.names.size());
  origin_.reset();
  last_stamp_.reset();
  leap_.reset();
  published_tick_ = 0;
  bends_ = 0;
  health_.fill(OdometerHealth::kOk);

  publisher_ =
      create_publisher(topics::kOdometerFused, {.events = {.matched = awaited_.on_matched()}});
  if (stream_->parameters().rule == odometry::FusionRule::kCircumference) {
    bend_publisher_ = create_publisher(topics::kBend);
  }
  if (settings_.calibrate) {
    weld_subscription_ =
        create_subscription(topics::kWeld, [this](const Weld& message) { on_weld(message); });
  }
  if (!laterals_.share()->empty()) {
    imu_subscription_ =
        create_subscription(topics::kImu, [this](const Imu& message) { on_imu(message); });
  }
  readings_silence_.start("readings of any odometer", settings_.silent_after);
  awaited_.watch({publisher_.untyped()}, [this] { subscribe(); });
  return CallbackReturn::kSuccess;
}

CallbackReturn OdometerStreamFusion::on_cleanup() {
  awaited_.stop();
  readings_silence_.stop();
  readings_subscription_ = {};
  weld_subscription_ = {};
  imu_subscription_ = {};
  publisher_ = {};
  bend_publisher_ = {};
  calibration_.reset();
  stream_.reset();
  return CallbackReturn::kSuccess;
}

/// See `OdometryFusion::subscribe`.
void OdometerStreamFusion::subscribe() {
  readings_subscription_ = create_subscription(
      topics::kOdometerReadings, [this](const Readings& message) { on_readings(message); });
}

void OdometerStreamFusion::on_readings(const Readings& message) {
  readings_silence_.heard();
  if (const auto fault = find_fault(message, 1)) {
    report_fault(fault->counter, fault->text);
    diagnostics().count("readings.refused");
    return;
  }
  const Time stamp = from_message(message.header.stamp);
  // The stream follows the stamps whatever the clock says; whoever uses the result sees them too.
  if (const auto fault = settings_.stamp_limits.find_fault("readings", stamp, now())) {
    report_fault(fault->counter, fault->text);
  }
  if (!follows(stamp)) {
    report_fault("readings.header.stamp.leap",
                 "readings have a stamp far from the previous ones; not used until the next ones "
                 "confirm it");
    return;
  }
  if (!origin_) {
    origin_ = stamp;
  }
  frame_id_ = message.header.frame_id;
  for (std::size_t k = 0; k < message.name.size(); ++k) {
    const auto place = std::find(settings_.names.begin(), settings_.names.end(), message.name[k]);
    if (place == settings_.names.end()) {
      report_fault("readings.name.unexpected", "readings of '" + message.name[k] +
                                                   "', which parameter 'odometers' does not have");
      continue;
    }
    const auto result =
        stream_->push({.odometer = static_cast<std::size_t>(place - settings_.names.begin()),
                       .time = stream_time(stamp),
                       .value = message.distance[k],
                       .valid = message.valid[k]});
    report_outcome(result.outcome, message.name[k]);
    if (result.ticks > 0) {
      calibration_->record(stream_->state());
      publish_state();
    }
  }
}

/// The stream follows a leap of time that two odometers agree on, and all odometers of one message
/// agree on its stamp. So here a leap takes two messages in a row.
bool OdometerStreamFusion::follows(Time stamp) {
  const auto is_near = [&](const std::optional<Time>& other) {
    return other && std::abs(to_seconds(stamp - *other)) <= settings_.maximum_gap;
  };
  if (last_stamp_ && !is_near(last_stamp_) && !is_near(leap_)) {
    leap_ = stamp;
    return false;
  }
  last_stamp_ = stamp;
  leap_.reset();
  return true;
}

void OdometerStreamFusion::report_outcome(SampleOutcome outcome, const std::string& odometer) {
  const std::string name = "odometer '" + odometer + "'";
  switch (outcome) {
    case SampleOutcome::kAccepted:
    case SampleOutcome::kUnknownOdometer:  // sorted out before
      break;
    case SampleOutcome::kMarkedInvalid:
      report_fault("readings.valid.false", name + " is marked invalid");
      break;
    case SampleOutcome::kNotANumber:
      report_fault("readings.distance.not_a_number",
                   "the distance of " + name + " is not a finite number");
      break;
    case SampleOutcome::kDuplicateStamp:
    case SampleOutcome::kOutOfOrder:
      report_fault("readings.header.stamp.not_increasing",
                   "the stamp of " + name + " is not later than that of its previous reading");
      break;
    case SampleOutcome::kBadStamp:
    case SampleOutcome::kStampLeap:
      report_fault("readings.header.stamp.leap",
                   "the stamp of " + name + " is far from all others, and not confirmed yet");
      break;
    case SampleOutcome::kImplausible:
      report_fault("readings.distance.implausible",
                   name + " is faster than parameter 'maximum_speed'");
      break;
  }
}

void OdometerStreamFusion::publish_state() {
  const odometry::FusedStream& state = stream_->state();
  if (state.status == odometry::StreamStatus::kWaiting || state.tick == published_tick_) {
    return;
  }
  published_tick_ = state.tick;
  auto message = std::make_unique<Fused>(to_message(state, settings_.names));
  for (std::size_t i = 0; i < settings_.names.size(); ++i) {
    // The stream measures wear against the others, from one calibration to the next.
    if (state.odometers[i].health == OdometerHealth::kOk && calibration_->is_worn(i)) {
      message->health[i] = pipescout_msgs::msg::FusedOdometer::HEALTH_WORN;
    }
  }
  message->header.stamp = to_message(*origin_ + from_seconds(state.time));
  message->header.frame_id = frame_id_;
  if (state.status == odometry::StreamStatus::kNoConsensus) {
    report_fault("no_consensus", "no group of odometers agrees; their median is used");
  } else if (state.status == odometry::StreamStatus::kNoData) {
    report_fault("no_data", "no odometer has a value; the last speed is extrapolated");
  }
  report_health();
  const std_msgs::msg::Header header = message->header;
  publisher_.publish(std::move(message));
  for (; bends_ != state.bends; ++bends_) {
    publish_bend(state.recent_bends[bends_ % odometry::kRecentBends], header);
  }
}

/// After the fused distance of the same time, to which it refers.
void OdometerStreamFusion::publish_bend(const odometry::FoundBend& bend,
                                        const std_msgs::msg::Header& header) {
  logger().info("a bend of " + text_of(bend));
  diagnostics().set_value("bends", std::to_string(stream_->state().bends));
  auto message = std::make_unique<Bend>(to_message(bend));
  message->header = header;
  bend_publisher_.publish(std::move(message));
}

void OdometerStreamFusion::report_health() {
  for (std::size_t i = 0; i < settings_.names.size(); ++i) {
    const OdometerHealth now = stream_->state().odometers[i].health;
    if (now == health_[i]) {
      continue;
    }
    health_[i] = now;
    const std::string text = "odometer '" + settings_.names[i] + "': " + odometry::to_string(now);
    if (now == OdometerHealth::kOk) {
      logger().info(text);
    } else {
      logger().warn(text);
    }
  }
}

void OdometerStreamFusion::on_weld(const Weld& message) {
  if (!origin_ || message.weld < 0 || std::isnan(message.spacing)) {
    return;  // not known which weld it is, or the first one that is
  }
  if (!(message.weld_probability >= settings_.least_weld_probability)) {
    return;
  }
  const SpacingOutcome outcome =
      calibration_->observe({.from = stream_time(from_message(message.spacing_since)),
                             .to = stream_time(from_message(message.header.stamp)),
                             .length = message.spacing,
                             .standard_deviation = message.spacing_standard_deviation,
                             .joints = message.spacing_joints},
                            *stream_);
  switch (outcome) {
    case SpacingOutcome::kUsed:
    case SpacingOutcome::kSeveralJoints:
    case SpacingOutcome::kUneven:
      break;
    case SpacingOutcome::kBadValue:
      report_fault(
          "weld.spacing.bad_value",
          "the distance between two welds, its standard deviation or their stamps are invalid");
      break;
    case SpacingOutcome::kTooOld:
      report_fault("weld.spacing.unknown_time",
                   "a weld was passed at a time that is not in the history of the odometers");
      break;
  }
}

void OdometerStreamFusion::on_imu(const Imu& message) {
  if (!origin_) {
    return;  // nothing is measured yet
  }
  const double rate = message.angular_velocity.z;
  if (!std::isfinite(rate)) {
    report_fault("imu.angular_velocity.not_a_number", "the yaw rate is not a finite number");
    return;
  }
  stream_->push_yaw_rate(stream_time(from_message(message.header.stamp)), rate);
}

double OdometerStreamFusion::stream_time(Time stamp) const {
  return to_seconds(stamp - *origin_);
}

}  // namespace pipescout

PIPESCOUT_REGISTER_COMPONENT(pipescout::OdometerStreamFusion)
