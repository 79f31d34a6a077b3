// SPDX-License-Identifier: Apache-2.0
#include "pipescout/weld_locator/weld_locator.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>
#include <stdexcept>
#include <utility>

#include "pipescout/catalogue/topics.hpp"
#include "pipescout/files/whole_file.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "pipescout/runtime/register_component.hpp"
#include "pipescout/validation/number_text.hpp"

namespace pipescout {

namespace {

using odometry::Orientation;
using odometry::WeldDetectorParameters;
using odometry::WeldPositionEstimate;
using odometry::WeldPositioningParameters;
using pipescout_msgs::msg::PipePosition;
using pipescout_msgs::msg::WeldDetection;

constexpr auto kNumber = [](auto enumerator) { return static_cast<std::uint8_t>(enumerator); };
static_assert(kNumber(Orientation::kForward) == PipePosition::ORIENTATION_FORWARD);
static_assert(kNumber(Orientation::kBackward) == PipePosition::ORIENTATION_BACKWARD);
static_assert(kNumber(Orientation::kUnknown) == PipePosition::ORIENTATION_UNKNOWN);

/// Fused distances that are remembered, to find when a weld was passed.
constexpr std::size_t kHistory = 8192;
/// Messages of samples that wait for the odometer; the oldest makes room.
constexpr std::size_t kMaximumWaiting = 1000;
/// Samples of one message.
constexpr std::size_t kMaximumSamples = 1 << 20;
/// A stamp that is earlier by more than this is of a clock that was set back, and counts; by less
/// it is a late message.
constexpr Duration kLeap = std::chrono::seconds(10);
/// A recognised weld is nearer than this share of a joint to where it should be.
constexpr double kNearShare = 0.25;

constexpr FloatingPointRange kPositive{1e-9, 1e6};
constexpr FloatingPointRange kProbability{1e-9, 0.5};

Orientation orientation(const std::string& name) {
  for (const auto candidate :
       {Orientation::kForward, Orientation::kBackward, Orientation::kUnknown}) {
    if (name == odometry::to_string(candidate)) {
      return candidate;
    }
  }
  throw std::invalid_argument("parameter 'start.orientation' = '" + name +
                              "' must be 'forward', 'backward' or 'unknown'");
}

/// When the last of the samples was taken. Not for a message without samples.
Time last_stamp(const pipescout_msgs::msg::EddyCurrentSamples& message) {
  const auto samples = static_cast<double>(message.x.size() / message.channels);
  return from_message(message.header.stamp) +
         from_seconds((samples - 1.0) * message.sample_interval);
}

/// What the calibration makes of the distance of all odometers together. The positioning learns
/// this scale itself, from the same welds: it gets the distance without it.
double common_scale(const pipescout_msgs::msg::FusedOdometer& message) {
  const auto& scales = message.scale;
  return scales.empty() ? 1.0
                        : std::accumulate(scales.begin(), scales.end(), 0.0) /
                              static_cast<double>(scales.size());
}

}  // namespace

WeldLocator::WeldLocator(ComponentOptions options) : Component(std::move(options)) {
  declare_positioning_parameters();
  declare_detector_parameters();
  declare_message_parameters();
}

WeldLocator::~WeldLocator() = default;

void WeldLocator::declare_positioning_parameters() {
  const WeldPositioningParameters defaults;
  const odometry::WeldPositioningStart start_defaults;
  tally_file_ = parameters().declare<std::string>(
      "tally", "",
      {.description = "CSV file with the joints of the pipe, see docs/weld_ledger.md; empty: the "
                      "joint lengths have the prior 'standard_joint' and are estimated"});
  learnt_tally_file_ = parameters().declare<std::string>(
      "learnt_tally", "",
      {.description =
           "file for the measured joints, written when the component is deactivated; empty: none"});
  standard_joint_length_ =
      parameters().declare<double>("standard_joint.length", defaults.standard_joint.length,
                                   {.description = "m, prior of a joint's length without a tally",
                                    .floating_point_range = kPositive});
  standard_joint_deviation_ = parameters().declare<double>(
      "standard_joint.standard_deviation", defaults.standard_joint.standard_deviation,
      {.description = "m, of its length", .floating_point_range = kPositive});
  start_joint_ = parameters().declare<std::int64_t>(
      "start.joint", -1,
      {.description = "index of the joint in which the probe starts, from 0; -1: unknown",
       .integer_range = IntegerRange{-1, 1000000}});
  start_distance_ =
      parameters().declare<double>("start.distance", start_defaults.distance,
                                   {.description = "m, from the low end of that joint",
                                    .floating_point_range = FloatingPointRange{-1e6, 1e6}});
  start_deviation_ = parameters().declare<double>(
      "start.standard_deviation", start_defaults.distance_standard_deviation,
      {.description = "m, of that distance", .floating_point_range = kPositive});
  start_orientation_ = parameters().declare<std::string>(
      "start.orientation", "forward",
      {.description = "whether chainage grows when the odometer counts up",
       .additional_constraints = "forward, backward or unknown"});
  missed_probability_ =
      parameters().declare<double>("missed_probability", defaults.missed_probability,
                                   {.description = "probability that a weld is not detected",
                                    .floating_point_range = kProbability});
  spurious_probability_ = parameters().declare<double>(
      "spurious_probability", defaults.spurious_probability,
      {.description = "false detections per joint", .floating_point_range = kProbability});
  scale_deviation_ = parameters().declare<double>(
      "scale_standard_deviation", defaults.initial_scale_standard_deviation,
      {.description = "prior standard deviation of the scale of the fused odometer",
       .floating_point_range = FloatingPointRange{1e-6, 0.199}});
  scale_drift_ = parameters().declare<double>(
      "scale_drift", defaults.scale_drift,
      {.description = "process noise of that scale by wear, variance per metre",
       .floating_point_range = FloatingPointRange{0.0, 1e-4}});
  double_slip_probability_ = parameters().declare<double>(
      "double_slip_probability", defaults.double_slip_probability,
      {.description = "probability per joint of a gross error of the fused odometer",
       .floating_point_range = kProbability});
}

void WeldLocator::declare_detector_parameters() {
  const WeldDetectorParameters defaults;
  channels_ = parameters().declare<int>(
      "channels", static_cast<int>(defaults.channels),
      {.description = "coils of the probe",
       .integer_range = IntegerRange{1, odometry::kMaxEddyCurrentChannels}});
  smallest_width_ =
      parameters().declare<double>("weld.smallest_width", defaults.smallest_width,
                                   {.description = "m, between the two lobes of a weld's pulse",
                                    .floating_point_range = FloatingPointRange{1e-3, 1.0}});
  largest_width_ =
      parameters().declare<double>("weld.largest_width", defaults.largest_width,
                                   {.description = "m, between the two lobes of a weld's pulse",
                                    .floating_point_range = FloatingPointRange{1e-3, 1.0}});
  false_alarms_per_km_ = parameters().declare<double>(
      "weld.false_alarms_per_km", defaults.false_alarms_per_km,
      {.description = "false alarms by noise for each km of pipe; sets the threshold",
       .floating_point_range = FloatingPointRange{1e-12, 1000.0}});
  least_confidence_ = parameters().declare<double>(
      "weld.least_confidence", 0.0,
      {.description = "detections with a lower confidence are not published",
       .floating_point_range = FloatingPointRange{0.0, 1.0}});
  phase_ = parameters().declare<double>(
      "weld.phase", defaults.phase,
      {.description = "rad, direction of the first lobe of a weld in the impedance plane",
       .floating_point_range = FloatingPointRange{-7.0, 7.0}});
  phase_tolerance_ = parameters().declare<double>(
      "weld.phase_tolerance", defaults.phase_tolerance,
      {.description = "rad, its tolerance; pi: any direction",
       .floating_point_range = FloatingPointRange{0.0, defaults.phase_tolerance}});
  noise_floor_ = parameters().declare<double>(
      "noise_floor", defaults.noise_floor,
      {.description = "smallest noise of the signal, in its unit: the resolution of the driver",
       .floating_point_range = FloatingPointRange{1e-300, 1e100}});
}

void WeldLocator::declare_message_parameters() {
  maximum_age_ = parameters().declare<double>(
      "maximum_age", 2.0,
      {.description =
           "s, messages with an older stamp are counted as stale; 0: any age is accepted",
       .floating_point_range = FloatingPointRange{0.0, 86400.0}});
  maximum_lead_ = parameters().declare<double>(
      "maximum_lead", 0.1,
      {.description = "s, messages with a stamp further ahead of the clock are counted",
       .floating_point_range = FloatingPointRange{0.0, 86400.0}});
  silent_after_ = parameters().declare<double>(
      "silent_after", 5.0,
      {.description = "s without messages after which an input is counted as silent",
       .floating_point_range = kPositive});
}

WeldDetectorParameters WeldLocator::detector_parameters() const {
  WeldDetectorParameters result;
  result.channels = static_cast<std::size_t>(channels_.get());
  result.smallest_width = smallest_width_.get();
  result.largest_width = largest_width_.get();
  result.cell = std::min(result.cell, result.smallest_width / 4.0);
  result.false_alarms_per_km = false_alarms_per_km_.get();
  result.phase = phase_.get();
  result.phase_tolerance = phase_tolerance_.get();
  result.noise_floor = noise_floor_.get();
  result.joint_length = standard_joint_length_.get();
  return result;
}

WeldPositioningParameters WeldLocator::positioning_parameters() const {
  WeldPositioningParameters result;
  result.missed_probability = missed_probability_.get();
  result.spurious_probability = spurious_probability_.get();
  result.initial_scale_standard_deviation = scale_deviation_.get();
  result.scale_drift = scale_drift_.get();
  result.double_slip_probability = double_slip_probability_.get();
  result.standard_joint = {.length = standard_joint_length_.get(),
                           .standard_deviation = standard_joint_deviation_.get()};
  result.first_weld_chainage = first_chainage_;
  return result;
}

odometry::WeldPositioningStart WeldLocator::start() const {
  const std::int64_t joint = start_joint_.get();
  return {.joint_known = joint >= 0,
          .joint = joint >= 0 ? static_cast<std::size_t>(joint) : 0,
          .distance = start_distance_.get(),
          .distance_standard_deviation = start_deviation_.get(),
          .orientation = orientation(start_orientation_.get())};
}

CallbackReturn WeldLocator::on_configure() {
  stamp_limits_ = {.maximum_age = maximum_age_.get(), .maximum_lead = maximum_lead_.get()};
  confidence_limit_ = least_confidence_.get();
  learnt_path_ = learnt_tally_file_.get();
  tally_.reset();
  first_chainage_ = 0.0;
  if (const std::string file = tally_file_.get(); !file.empty()) {
    tally_ = read_tally(file);
    first_chainage_ = tally_->chainages.front();
    for (const std::string& note : tally_->notes) {
      logger().info(note);
    }
    logger().info(std::to_string(tally_->joints.size()) + " joints and " +
                  std::to_string(tally_->bends.size()) + " bends in " + file);
  }
  detector_.emplace(detector_parameters());
  positioning_.emplace(positioning_parameters(),
                       tally_ ? std::span<const odometry::TallyJoint>(tally_->joints)
                              : std::span<const odometry::TallyJoint>(),
                       start(),
                       tally_ ? std::span<const odometry::TallyBend>(tally_->bends)
                              : std::span<const odometry::TallyBend>());
  history_.emplace(kHistory);
  waiting_.clear();
  samples_until_.reset();
  last_weld_.reset();
  independent_variance_ = 0.0;
  was_locked_ = false;

  const auto matched = awaited_.on_matched();
  weld_publisher_ = create_publisher(topics::kWeld, {.events = {.matched = matched}});
  position_publisher_ = create_publisher(topics::kPipePosition, {.events = {.matched = matched}});
  fused_silence_.start("fused distance", silent_after_.get());
  samples_silence_.start("eddy-current samples", silent_after_.get());
  counts_timer_ = create_timer(std::chrono::seconds(1), [this] { tell_counts(); });
  awaited_.watch({weld_publisher_.untyped(), position_publisher_.untyped()},
                 [this] { subscribe(); });
  return CallbackReturn::kSuccess;
}

CallbackReturn WeldLocator::on_deactivate() {
  write_learnt_tally();
  return CallbackReturn::kSuccess;
}

CallbackReturn WeldLocator::on_cleanup() {
  awaited_.stop();
  fused_silence_.stop();
  samples_silence_.stop();
  counts_timer_.reset();
  bend_subscription_ = {};
  fused_subscription_ = {};
  samples_subscription_ = {};
  weld_publisher_ = {};
  position_publisher_ = {};
  waiting_.clear();
  detector_.reset();
  positioning_.reset();
  history_.reset();
  return CallbackReturn::kSuccess;
}

/// To bends first: who awaits this node's subscription to the fused distance publishes them too.
void WeldLocator::subscribe() {
  bend_subscription_ =
      create_subscription(topics::kBend, [this](const Bend& message) { on_bend(message); });
  fused_subscription_ = create_subscription(topics::kOdometerFused,
                                            [this](const Fused& message) { on_fused(message); });
  samples_subscription_ = create_subscription(
      topics::kEddyCurrent,
      [this](const std::shared_ptr<const Samples>& message) { on_samples(message); });
}

void WeldLocator::on_fused(const Fused& message) {
  fused_silence_.heard();
  if (!is_acceptable(message)) {
    diagnostics().count("fused.refused");
    return;
  }
  const Time stamp = from_message(message.header.stamp);
  check_stamp("fused", stamp);
  // A fusion that does not say which part is independent from stretch to stretch: all of it.
  const double variance =
      std::isfinite(message.independent_variance) ? message.independent_variance : message.variance;
  if (!history_->empty() && stamp <= history_->latest().time) {
    if (history_->latest().time - stamp < kLeap) {
      report_fault("fused.header.stamp.not_increasing",
                   "a fused distance has a stamp that is not later than the previous one");
      return;
    }
    report_fault("fused.header.stamp.leap", "a fused distance from long before");
    history_->clear();
    last_weld_.reset();
  }
  if (!history_->empty()) {
    const double step = (message.distance - history_->latest().distance) / common_scale(message);
    const auto& estimate = positioning_->add_increment(
        {.distance = step, .variance = std::max(0.0, variance - independent_variance_)});
    if (estimate.status != odometry::PositioningStatus::kAccepted) {
      report_fault("fused.distance.implausible",
                   "the fused distance jumps by " + validation::number_text(step) + " m");
    }
  }
  independent_variance_ = variance;
  history_->add({.time = stamp,
                 .distance = message.distance,
                 .uncalibrated = positioning_->odometer_distance()});
  if (frame_id_.empty()) {
    frame_id_ = message.header.frame_id;
  }
  process_waiting();
  publish_position(stamp);
}

/// A bend is told after the fused distance at which it was found, and lies before it.
void WeldLocator::on_bend(const Bend& message) {
  if (!tally_ || tally_->bends.empty()) {
    return;
  }
  const auto passage =
      std::isfinite(message.distance) ? history_->at_distance(message.distance) : std::nullopt;
  if (!passage) {
    report_fault("bend.unknown_place", "a bend at " + validation::number_text(message.distance) +
                                           " m of the fused odometer, which is not in the history");
    return;
  }
  const WeldPositionEstimate& estimate =
      positioning_->add_bend({.odometer_distance = passage->uncalibrated,
                              .standard_deviation = message.standard_deviation,
                              .angle = message.angle,
                              .angle_standard_deviation = message.angle_standard_deviation});
  if (estimate.status != odometry::PositioningStatus::kAccepted) {
    report_fault("bend.not_positioned", std::string("a bend is not used for the position: ") +
                                            odometry::to_string(estimate.status));
  }
  report_spacing_faults(estimate, "a bend");
}

bool WeldLocator::is_acceptable(const Fused& message) {
  if (!std::isfinite(message.distance)) {
    report_fault("fused.distance.not_a_number", "a fused distance is not a finite number");
    return false;
  }
  if (!std::isfinite(message.variance) || message.variance < 0.0) {
    report_fault("fused.variance.bad_value",
                 "the variance of a fused distance is not a finite number above zero");
    return false;
  }
  const auto is_bad = [](double scale) { return !(scale > 0.1 && scale < 10.0); };
  if (std::any_of(message.scale.begin(), message.scale.end(), is_bad)) {
    report_fault("fused.scale.bad_value", "the scale of an odometer is not near 1");
    return false;
  }
  return true;
}

void WeldLocator::on_samples(const std::shared_ptr<const Samples>& message) {
  samples_silence_.heard();
  if (!is_acceptable(*message)) {
    diagnostics().count("eddy_current.refused");
    return;
  }
  check_stamp("eddy_current", from_message(message->header.stamp));
  if (waiting_.size() >= kMaximumWaiting) {
    waiting_.pop_front();
    report_fault("eddy_current.without_odometer",
                 "samples are dropped: no fused distance for their time");
  }
  waiting_.push_back(message);
  process_waiting();
}

bool WeldLocator::is_acceptable(const Samples& message) {
  const auto refuse = [this](const char* counter, const std::string& text) {
    report_fault("eddy_current." + std::string(counter), "eddy-current samples " + text);
    return false;
  };
  const std::size_t channels = detector_->parameters().channels;
  if (message.channels != channels) {
    return refuse("channels.unexpected", "of " + std::to_string(message.channels) +
                                             " channels; parameter 'channels' is " +
                                             std::to_string(channels));
  }
  if (message.x.empty() || message.x.size() % channels != 0 ||
      message.x.size() > kMaximumSamples * channels) {
    return refuse("x.wrong_size", "with " + std::to_string(message.x.size()) + " values of x");
  }
  if (message.y.size() != message.x.size()) {
    return refuse("y.wrong_size", "with " + std::to_string(message.y.size()) + " values of y for " +
                                      std::to_string(message.x.size()) + " of x");
  }
  if (!(message.sample_interval > 0.0 && message.sample_interval <= 60.0)) {
    return refuse("sample_interval.bad_value",
                  "every " + validation::number_text(message.sample_interval) + " s");
  }
  const Time stamp = from_message(message.header.stamp);
  if (samples_until_ && stamp <= *samples_until_) {
    if (*samples_until_ - stamp < kLeap) {
      return refuse("header.stamp.not_increasing", "begin before the end of the previous ones");
    }
    report_fault("eddy_current.header.stamp.leap", "eddy-current samples from long before");
    waiting_.clear();
  }
  samples_until_ = last_stamp(message);
  return true;
}

void WeldLocator::check_stamp(const char* input, Time stamp) {
  if (const auto fault = stamp_limits_.find_fault(input, stamp, now())) {
    report_fault(fault->counter, fault->text);
  }
}

/// Samples wait until the odometer has come as far; a fused distance comes later than they do.
void WeldLocator::process_waiting() {
  while (!waiting_.empty() && !history_->empty()) {
    const Samples& message = *waiting_.front();
    if (last_stamp(message) > history_->latest().time) {
      return;
    }
    process(message);
    waiting_.pop_front();
  }
}

void WeldLocator::process(const Samples& message) {
  frame_id_ = message.header.frame_id;
  const Time stamp = from_message(message.header.stamp);
  const std::size_t channels = message.channels;
  std::array<odometry::Impedance, odometry::kMaxEddyCurrentChannels> values{};
  std::uint64_t without_distance = 0;
  for (std::size_t k = 0; k * channels < message.x.size(); ++k) {
    const auto place =
        history_->at_time(stamp + from_seconds(static_cast<double>(k) * message.sample_interval));
    if (!place) {
      ++without_distance;
      continue;
    }
    for (std::size_t c = 0; c < channels; ++c) {
      values[c] = {message.x[k * channels + c], message.y[k * channels + c]};
    }
    for (const auto& event : detector_->update(place->distance, {values.data(), channels})) {
      on_weld(event);
    }
  }
  if (without_distance > 0) {
    diagnostics().count("eddy_current.samples_without_distance", without_distance);
  }
}

void WeldLocator::on_weld(const odometry::WeldEvent& event) {
  if (event.confidence < confidence_limit_) {
    diagnostics().count("weld.low_confidence");
    return;
  }
  const auto passage = history_->at_distance(event.distance);
  if (!passage) {
    report_fault("weld.unknown_time",
                 "a weld was passed at a time that is no longer in the history");
    return;
  }
  auto message = std::make_unique<Weld>();
  message->header.stamp = to_message(passage->time);
  message->header.frame_id = frame_id_;
  message->distance = event.distance;
  message->standard_deviation = event.standard_deviation;
  message->confidence = event.confidence;
  message->amplitude = event.amplitude;
  message->width = event.width;
  message->weld = WeldDetection::UNKNOWN_WELD;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  message->chainage = nan;
  message->chainage_variance = nan;
  message->spacing = nan;
  message->spacing_standard_deviation = nan;
  const WeldPositionEstimate& estimate = positioning_->add_weld(
      {.odometer_distance = std::min(passage->uncalibrated, positioning_->odometer_distance()),
       .standard_deviation = event.standard_deviation,
       .confidence = event.confidence});
  if (estimate.status != odometry::PositioningStatus::kAccepted) {
    report_fault("weld.not_positioned", std::string("a weld is not used for the position: ") +
                                            odometry::to_string(estimate.status));
  } else {
    identify(event, *passage, *message);
  }
  report_spacing_faults(estimate, "weld spacing");
  weld_publisher_.publish(std::move(message));
}

void WeldLocator::report_spacing_faults(const WeldPositionEstimate& estimate, const char* by) {
  const std::string error = validation::number_text(estimate.spacing_error) + " m";
  if (estimate.double_slip_detected) {
    report_fault("double_slip",
                 std::string(by) + " shows that the fused odometer was wrong by " + error);
  }
  if (estimate.tally_error_detected) {
    report_fault("tally_error", std::string(by) + " differs from the tally by " + error);
  }
}

/// Which weld of the tally it is, when the crawler knows where it is.
void WeldLocator::identify(const odometry::WeldEvent& event, const DistanceHistory::Point& passage,
                           Weld& message) {
  const WeldPositionEstimate& estimate = positioning_->estimate();
  if (!tally_ || !estimate.locked) {
    last_weld_.reset();
    return;
  }
  const double since = estimate.scale * (history_->latest().uncalibrated - passage.uncalibrated);
  const double there =
      estimate.chainage + (estimate.orientation == Orientation::kBackward ? since : -since);
  const auto& chainages = tally_->chainages;
  const auto above = std::lower_bound(chainages.begin(), chainages.end(), there);
  auto nearest = above == chainages.end() ? chainages.end() - 1 : above;
  if (nearest != chainages.begin() &&
      std::abs(*std::prev(nearest) - there) < std::abs(*nearest - there)) {
    --nearest;
  }
  const auto weld = static_cast<std::size_t>(nearest - chainages.begin());
  const double joint = tally_->joints[std::min(weld, tally_->joints.size() - 1)].length;
  const double deviation = std::sqrt(std::max(0.0, estimate.covariance(0, 0)));
  if (std::abs(*nearest - there) > std::min(kNearShare * joint, 0.1 + 4.0 * deviation)) {
    return;  // taken as spurious
  }
  message.weld = static_cast<std::int32_t>(weld);
  message.weld_id = tally_->ids[weld];
  message.weld_probability = estimate.probability;
  message.chainage = *nearest;
  message.chainage_variance = tally_->variances[weld];
  if (last_weld_ && last_weld_->weld != weld && last_weld_->time < passage.time &&
      !estimate.tally_error_detected) {
    const auto [low, high] = std::minmax(last_weld_->weld, weld);
    const double variance = tally_->variances[high] - tally_->variances[low] +
                            event.standard_deviation * event.standard_deviation +
                            last_weld_->standard_deviation * last_weld_->standard_deviation;
    message.spacing_since = to_message(last_weld_->time);
    message.spacing = chainages[high] - chainages[low];
    message.spacing_standard_deviation = std::sqrt(variance);
    message.spacing_joints = static_cast<std::uint32_t>(high - low);
  }
  last_weld_ = {.weld = weld, .time = passage.time, .standard_deviation = event.standard_deviation};
}

void WeldLocator::publish_position(Time stamp) {
  const WeldPositionEstimate& estimate = positioning_->estimate();
  auto message = std::make_unique<Position>();
  message->header.stamp = to_message(stamp);
  message->header.frame_id = frame_id_;
  message->known = estimate.known;
  message->locked = estimate.locked;
  message->joint = static_cast<std::uint32_t>(estimate.joint);
  message->joint_probability = estimate.joint_probability;
  message->orientation = kNumber(estimate.orientation);
  message->distance_into_joint = estimate.distance_into_joint;
  message->chainage = estimate.chainage;
  message->scale = estimate.scale;
  message->covariance = {estimate.covariance(0, 0), estimate.covariance(0, 1),
                         estimate.covariance(1, 0), estimate.covariance(1, 1)};
  message->hypotheses = static_cast<std::uint32_t>(estimate.hypotheses);
  message->odometer_distance = history_->latest().distance;
  message->double_slip_detected = estimate.double_slip_detected;
  message->tally_error_detected = estimate.tally_error_detected;
  message->spacing_error = estimate.spacing_error;
  position_publisher_.publish(std::move(message));
  if (estimate.locked != was_locked_) {
    was_locked_ = estimate.locked;
    logger().info(was_locked_ ? "the probe is in joint " + std::to_string(estimate.joint) +
                                    ", found after " +
                                    std::to_string(positioning_->counts().welds) + " welds"
                              : "the position is no longer locked");
  }
}

void WeldLocator::tell_counts() {
  const odometry::WeldDetectorCounts& counts = detector_->counts();
  const auto tell = [this](const char* key, std::uint64_t value) {
    diagnostics().set_value(std::string("detector.") + key, std::to_string(value));
  };
  tell("samples", counts.samples);
  tell("bad_values", counts.bad_values);
  tell("frozen", counts.frozen);
  tell("spikes", counts.spikes);
  tell("gaps", counts.gaps);
  tell("jumps", counts.jumps);
  tell("welds", counts.welds);
  tell("no_welds", counts.too_narrow + counts.too_wide + counts.wrong_shape + counts.wrong_phase +
                       counts.crowded + counts.incomplete);
  diagnostics().set_value("positioning.hypotheses",
                          std::to_string(positioning_->estimate().hypotheses));
  const odometry::WeldPositioningCounts& positioned = positioning_->counts();
  diagnostics().set_value("positioning.bends", std::to_string(positioned.bends));
  diagnostics().set_value("positioning.unexplained_bends",
                          std::to_string(positioned.unexplained_bends));
}

void WeldLocator::write_learnt_tally() {
  if (learnt_path_.empty()) {
    return;
  }
  const std::string text = format_learnt_tally(positioning_->learnt_joints(), first_chainage_);
  if (text.empty()) {
    logger().warn("no joint was measured: " + learnt_path_ + " is not written");
    return;
  }
  replace_file(learnt_path_, text);
}

}  // namespace pipescout

PIPESCOUT_REGISTER_COMPONENT(pipescout::WeldLocator)
