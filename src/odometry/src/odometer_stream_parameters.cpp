// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>

#include "pipescout/odometry/odometer_stream.hpp"

namespace pipescout::odometry {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// The name of a field, put together only when it is refused: corrections are set while running.
struct Field {
  std::string_view prefix;
  std::string_view name;
};

template <typename... Parts>
std::string text(const Parts&... parts) {
  std::ostringstream out;
  (out << ... << parts);
  return out.str();
}

template <typename Value>
[[noreturn]] void refuse(const Field& field, const Value& value, std::string_view range) {
  throw std::invalid_argument(text(field.prefix, field.name, ": ", value, " is outside ", range));
}

/// (low, high)
void check_open(const Field& field, double value, double low, double high) {
  if (!(value > low && value < high)) {
    refuse(field, value, text("(", low, ", ", high, ")"));
  }
}

/// (low, high]
void check_above(const Field& field, double value, double low, double high) {
  if (!(value > low && value <= high)) {
    refuse(field, value, text("(", low, ", ", high, "]"));
  }
}

/// [low, high], finite
void check_within(const Field& field, double value, double low, double high) {
  if (!(value >= low && value <= high && std::isfinite(value))) {
    refuse(field, value, text("[", low, ", ", high, "]"));
  }
}

void check_correction(std::string_view prefix, const OdometerCorrection& correction) {
  check_within({prefix, "scale"}, correction.scale, 0.5, 2.0);
  if (!std::isfinite(correction.offset)) {
    refuse({prefix, "offset"}, correction.offset, "(-inf, inf)");
  }
  const auto& covariance = correction.covariance;
  check_within({prefix, "covariance(0, 0)"}, covariance(0, 0), 0.0, kInfinity);
  check_within({prefix, "covariance(1, 1)"}, covariance(1, 1), 0.0, kInfinity);
  // Semi-definite and symmetric, but for rounding.
  const double bound = std::sqrt(covariance(0, 0) * covariance(1, 1)) * (1.0 + 1e-9);
  check_within({prefix, "covariance(0, 1)"}, covariance(0, 1), -bound, bound);
  if (!(std::abs(covariance(1, 0) - covariance(0, 1)) <= 1e-9 * bound)) {
    refuse({prefix, "covariance(1, 0)"}, covariance(1, 0), "what covariance(0, 1) is");
  }
}

void check_odometer(const std::string& prefix, const OdometerParameters& odometer) {
  if (odometer.kind != OdometerKind::kAbsolute && odometer.kind != OdometerKind::kIncrement) {
    refuse({prefix, "kind"}, static_cast<int>(odometer.kind), "{0, 1}");
  }
  check_open({prefix, "resolution"}, odometer.resolution, 0.0, kInfinity);
  check_open({prefix, "sigma_per_sqrt_metre"}, odometer.sigma_per_sqrt_metre, 0.0, kInfinity);
  check_within({prefix, "wrap"}, odometer.wrap, 0.0, kInfinity);
  check_within({prefix, "period"}, odometer.period, 0.0, kInfinity);
  check_correction(prefix + "correction.", odometer.correction);
}

void check_health(const OdometerHealthParameters& health, double window_distance) {
  check_open({"health.", "slip_ratio"}, health.slip_ratio, 0.0, 1.0);
  check_within({"health.", "slip_sigmas"}, health.slip_sigmas, 1.0, 10.0);
  check_open({"health.", "stuck_ratio"}, health.stuck_ratio, 0.0, 1.0);
  check_open({"health.", "worn_tolerance"}, health.worn_tolerance, 0.0, 0.5);
  check_open({"health.", "worn_release"}, health.worn_release, 0.0, 1.0);
  check_within({"health.", "scale_memory"}, health.scale_memory, window_distance, kInfinity);
  check_within({"health.", "enter_windows"}, health.enter_windows, 1, 1000);
  check_within({"health.", "leave_windows"}, health.leave_windows, 1, 1000);
  check_open({"health.", "bad_share_enter"}, health.bad_share_enter, 0.0, 1.0);
  check_open({"health.", "bad_share_leave"}, health.bad_share_leave, 0.0, health.bad_share_enter);
}

}  // namespace

void OdometerCorrection::validate() const {
  check_correction("", *this);
}

void OdometerStreamParameters::validate() const {
  if (odometers.size() < kMinOdometers || odometers.size() > kMaxOdometers) {
    refuse({"", "odometers"}, text(odometers.size(), " of them"),
           text("[", kMinOdometers, ", ", kMaxOdometers, "]"));
  }
  for (std::size_t i = 0; i < odometers.size(); ++i) {
    check_odometer(text("odometers[", i, "]."), odometers[i]);
  }
  consensus.validate();
  if (!consensus.offsets.empty()) {
    refuse({"", "consensus.offsets"}, text(consensus.offsets.size(), " values"),
           "what a stream can use: give OdometerCorrection::offset");
  }
  check_within({"", "sigma_margin"}, sigma_margin, 1.0, 10.0);
  if (sigma_source != SigmaSource::kGiven && sigma_source != SigmaSource::kResiduals) {
    refuse({"", "sigma_source"}, static_cast<int>(sigma_source), "{0, 1}");
  }
  check_within({"", "residual_windows"}, static_cast<double>(residual_windows), 8, 64);
  check_above({"", "tick_period"}, tick_period, 0.0, 60.0);
  check_above({"", "window_distance"}, window_distance, 0.0, 100.0);
  check_within({"", "lookback_windows"}, static_cast<double>(lookback_windows), 0, 16);
  check_within({"", "lookback_sigmas"}, lookback_sigmas, 1.0, 10.0);
  check_within({"", "window_time"}, window_time, tick_period, kInfinity);
  check_within({"", "maximum_delay"}, maximum_delay, 0.0, 60.0 * tick_period);
  check_within({"", "maximum_gap"}, maximum_gap, tick_period, 1000.0 * tick_period);
  check_open({"", "silent_after"}, silent_after, 0.0, kInfinity);
  check_open({"", "maximum_speed"}, maximum_speed, 0.0, kInfinity);
  check_within({"", "common_sigma_per_sqrt_metre"}, common_sigma_per_sqrt_metre, 0.0, kInfinity);
  check_within({"", "common_scale_sigma"}, common_scale_sigma, 0.0, 1.0);
  check_above({"", "unverified_ratio"}, unverified_ratio, 0.0, 1.0);
  check_health(health, window_distance);
}

const char* to_string(SampleOutcome outcome) noexcept {
  switch (outcome) {
    case SampleOutcome::kAccepted:
      return "accepted";
    case SampleOutcome::kMarkedInvalid:
      return "marked invalid";
    case SampleOutcome::kNotANumber:
      return "not a number";
    case SampleOutcome::kBadStamp:
      return "bad stamp";
    case SampleOutcome::kDuplicateStamp:
      return "duplicate stamp";
    case SampleOutcome::kOutOfOrder:
      return "out of order";
    case SampleOutcome::kStampLeap:
      return "stamp leap";
    case SampleOutcome::kImplausible:
      return "implausible";
    case SampleOutcome::kUnknownOdometer:
      return "unknown odometer";
  }
  return "unknown";
}

const char* to_string(OdometerHealth health) noexcept {
  switch (health) {
    case OdometerHealth::kOk:
      return "ok";
    case OdometerHealth::kWorn:
      return "worn";
    case OdometerHealth::kSlipping:
      return "slipping";
    case OdometerHealth::kStuck:
      return "stuck";
    case OdometerHealth::kBadValues:
      return "bad values";
    case OdometerHealth::kSilent:
      return "silent";
  }
  return "unknown";
}

const char* to_string(OdometerUse use) noexcept {
  switch (use) {
    case OdometerUse::kAbsent:
      return "absent";
    case OdometerUse::kIncomplete:
      return "incomplete";
    case OdometerUse::kStuck:
      return "stuck";
    case OdometerUse::kDrifted:
      return "drifted";
    case OdometerUse::kUnsupported:
      return "unsupported";
    case OdometerUse::kFused:
      return "fused";
    case OdometerUse::kFallback:
      return "fallback";
  }
  return "unknown";
}

const char* to_string(StreamStatus status) noexcept {
  switch (status) {
    case StreamStatus::kWaiting:
      return "waiting";
    case StreamStatus::kOk:
      return "ok";
    case StreamStatus::kNoConsensus:
      return "no consensus";
    case StreamStatus::kNoData:
      return "no data";
  }
  return "unknown";
}

}  // namespace pipescout::odometry
