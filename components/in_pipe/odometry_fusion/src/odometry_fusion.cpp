// SPDX-License-Identifier: Apache-2.0
#include "pipescout/odometry_fusion/odometry_fusion.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "pipescout/catalogue/topics.hpp"
#include "pipescout/odometry_fusion/conversions.hpp"
#include "pipescout/odometry_fusion/readings_checks.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "pipescout/runtime/register_component.hpp"
#include "pipescout/runtime/stamp_limits.hpp"

namespace pipescout {

namespace {

using odometry::ConsensusFusionParameters;
using odometry::kMinOdometers;
using odometry::RejectionReason;
using odometry::SupportRule;
using odometry::Weighting;

constexpr std::pair<const char*, Weighting> kWeightings[] = {
    {"maximum_likelihood", Weighting::kMaximumLikelihood},
    {"paper_equation_13", Weighting::kPaperEquation13}};
constexpr std::pair<const char*, SupportRule> kSupportRules[] = {
    {"majority", SupportRule::kMajority}, {"mutual_majority", SupportRule::kMutualMajority}};

template <class Enumerator, std::size_t kSize>
Enumerator chosen(const std::pair<const char*, Enumerator> (&choices)[kSize],
                  const std::string& parameter, const std::string& text) {
  std::string names;
  for (const auto& [name, enumerator] : choices) {
    if (text == name) {
      return enumerator;
    }
    names += (names.empty() ? "'" : " or '") + std::string(name) + "'";
  }
  throw std::invalid_argument(parameter + " = '" + text + "' must be " + names);
}

/// Throws std::invalid_argument for a value that the algorithm cannot have.
void apply(ConsensusFusionParameters& algorithm, const std::string& name,
           const ParameterValue& value) {
  if (name == "epsilon") {
    algorithm.epsilon = value.get<double>();
  } else if (name == "weighting") {
    algorithm.weighting = chosen(kWeightings, name, value.get<std::string>());
  } else if (name == "support_rule") {
    algorithm.support_rule = chosen(kSupportRules, name, value.get<std::string>());
  } else if (name == "offsets") {
    algorithm.offsets = value.get<std::vector<double>>();
  }
}

/// The algorithm with some parameters changed. Throws std::invalid_argument.
std::shared_ptr<const odometry::ConsensusFusion> changed(
    ConsensusFusionParameters algorithm, const std::vector<NamedParameter>& parameters) {
  for (const NamedParameter& parameter : parameters) {
    apply(algorithm, parameter.name, parameter.value);
  }
  return std::make_shared<const odometry::ConsensusFusion>(std::move(algorithm));
}

}  // namespace

OdometryFusion::OdometryFusion(ComponentOptions options) : Component(std::move(options)) {
  set_algorithm(changed({}, {}));
  // Before the declarations: what a parameter file says is validated in the same way, and an error
  // names the file.
  validate_handle_ = parameters().on_validate([this](const std::vector<NamedParameter>& proposed) {
    (void)changed(algorithm()->parameters(), proposed);
    return SetResult::accept();
  });
  declare_parameters();
  set_algorithm(changed({}, parameters().all()));
  changed_handle_ = parameters().on_changed([this](const std::vector<NamedParameter>& now_set) {
    set_algorithm(changed(algorithm()->parameters(), now_set));
  });
}

OdometryFusion::~OdometryFusion() = default;

void OdometryFusion::declare_parameters() {
  const ConsensusFusionParameters defaults;
  (void)parameters().declare<double>(
      "epsilon", defaults.epsilon,
      {.description = "largest confidence distance at which one odometer still supports another",
       .additional_constraints = "neither 0 nor 1",
       .floating_point_range = FloatingPointRange{0.0, 1.0}});
  (void)parameters().declare<std::string>(
      "weighting", "maximum_likelihood",
      {.description =
           "weight of a supported odometer: 1 / sigma^2, or 1 / sigma as the paper prints",
       .additional_constraints = "maximum_likelihood or paper_equation_13"});
  (void)parameters().declare<std::string>(
      "support_rule", "majority",
      {.description = "which odometers form the group that supports an odometer: all that support "
                      "it, or those that it supports too",
       .additional_constraints = "majority or mutual_majority"});
  (void)parameters().declare<std::vector<double>>(
      "offsets", {},
      {.description = "m, added to the fused readings, one per odometer; empty: none",
       .additional_constraints = "none or 2 to 16 values, finite"});
  odometers_ = parameters().declare<std::vector<std::string>>(
      "odometers", {},
      {.description = "required names in the order of the message, so that offsets and standard "
                      "deviations apply to the right odometer; empty: any names"});
  standard_deviations_ = parameters().declare<std::vector<double>>(
      "standard_deviations", {},
      {.description = "m, one per odometer, for messages without standard deviations; empty: such "
                      "messages are refused",
       .floating_point_range = FloatingPointRange{1e-9, 1e6}});
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

CallbackReturn OdometryFusion::on_configure() {
  last_stamp_.reset();
  publisher_ =
      create_publisher(topics::kOdometerFused, {.events = {.matched = awaited_.on_matched()}});
  awaited_.watch({publisher_.untyped()}, [this] { subscribe(); });
  return CallbackReturn::kSuccess;
}

CallbackReturn OdometryFusion::on_cleanup() {
  awaited_.stop();
  subscription_ = {};
  publisher_ = {};
  return CallbackReturn::kSuccess;
}

/// A source that waits for subscribers thereby waits for those of the fused distance too, and the
/// first reading is not lost however the components are spread over processes.
void OdometryFusion::subscribe() {
  subscription_ = create_subscription(topics::kOdometerReadings,
                                      [this](const Readings& message) { on_readings(message); });
}

void OdometryFusion::on_readings(const Readings& message) {
  const auto fusion = algorithm();
  const auto standard_deviations = standard_deviations_.share();
  if (!is_acceptable(message, *fusion, *standard_deviations)) {
    diagnostics().count("readings.refused");
    return;
  }
  check_stamp(message);
  const ReadingsBuffer buffer(message, *standard_deviations);
  auto fused = std::make_unique<Fused>(to_message(fusion->fuse(buffer.readings()), message));
  count_rejections(*fused);
  publisher_.publish(std::move(fused));
}

bool OdometryFusion::is_acceptable(const Readings& message, const Algorithm& fusion,
                                   const std::vector<double>& standard_deviations) {
  const std::size_t odometers = message.name.size();
  const auto refuse = [this](const ReadingsFault& fault) {
    report_fault(fault.counter, fault.text);
    return false;
  };
  if (const auto fault = find_fault(message, kMinOdometers)) {
    return refuse(*fault);
  }
  if (const auto expected = odometers_.share(); !expected->empty() && *expected != message.name) {
    report_fault("readings.name.unexpected",
                 "the odometers of the readings differ from parameter 'odometers'");
    return false;
  }
  // A driver that does not know its precision leaves this list empty.
  const bool stand_in = message.standard_deviation.empty() && !standard_deviations.empty();
  const auto size_fault =
      find_size_fault("standard_deviation", message.standard_deviation.size(), odometers);
  if (!stand_in && size_fault) {
    return refuse(*size_fault);
  }
  if (stand_in && standard_deviations.size() != odometers) {
    report_fault("readings.standard_deviation.missing",
                 "readings without standard deviations; parameter 'standard_deviations' has " +
                     std::to_string(standard_deviations.size()) + " values for " +
                     std::to_string(odometers) + " odometers");
    return false;
  }
  const std::size_t offsets = fusion.parameters().offsets.size();
  if (offsets != 0 && offsets != odometers) {
    report_fault("readings.name.unlike_offsets", "readings of " + std::to_string(odometers) +
                                                     " odometers; parameter 'offsets' has " +
                                                     std::to_string(offsets) + " values");
    return false;
  }
  return true;
}

/// A wrong stamp changes no distance: the readings are fused, and whoever uses the result sees the
/// stamp too.
void OdometryFusion::check_stamp(const Readings& message) {
  const Time stamp = from_message(message.header.stamp);
  const StampLimits limits{.maximum_age = maximum_age_.get(), .maximum_lead = maximum_lead_.get()};
  if (const auto fault = limits.find_fault("readings", stamp, now())) {
    report_fault(fault->counter, fault->text);
  }
  if (last_stamp_ && stamp <= *last_stamp_) {
    report_fault("readings.header.stamp.not_increasing",
                 "readings have a stamp that is not later than the previous one");
  }
  last_stamp_ = stamp;
}

void OdometryFusion::count_rejections(const Fused& fused) {
  for (std::size_t i = 0; i < fused.rejection_reason.size(); ++i) {
    const std::string& name = fused.name[i];
    switch (static_cast<RejectionReason>(fused.rejection_reason[i])) {
      case RejectionReason::kNone:
      case RejectionReason::kUnsupported:  // a wheel that slips: what the fusion is for
        break;
      case RejectionReason::kMarkedInvalid:
        report_fault("readings.valid.false", "odometer '" + name + "' is marked invalid");
        break;
      case RejectionReason::kNotANumber:
        report_fault("readings.distance.not_a_number",
                     "the distance of odometer '" + name + "' is not a finite number");
        break;
      case RejectionReason::kBadSigma:
        report_fault(
            "readings.standard_deviation.not_positive",
            "the standard deviation of odometer '" + name + "' is not a positive finite number");
        break;
    }
  }
  if (fused.status == pipescout_msgs::msg::FusedOdometer::STATUS_NO_CONSENSUS) {
    report_fault("no_consensus", "no group of odometers agrees");
  }
}

std::shared_ptr<const OdometryFusion::Algorithm> OdometryFusion::algorithm() const {
  const std::lock_guard lock(mutex_);
  return algorithm_;
}

void OdometryFusion::set_algorithm(std::shared_ptr<const Algorithm> algorithm) {
  const std::lock_guard lock(mutex_);
  algorithm_ = std::move(algorithm);
}

}  // namespace pipescout

PIPESCOUT_REGISTER_COMPONENT(pipescout::OdometryFusion)
