// SPDX-License-Identifier: Apache-2.0
#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <string_view>

#include "pipescout/odometry/odometer_stream.hpp"
#include "pipescout/validation/check.hpp"

namespace pipescout::odometry {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

using validation::check_above;
using validation::check_between;
using validation::check_within;
using validation::refuse;
using validation::require;

void check_correction(std::string_view prefix, const OdometerCorrection& correction) {
  check_within({prefix, "scale"}, correction.scale, 0.5, 2.0);
  require({prefix, "offset"}, correction.offset, true, "(-inf, inf)");
  const auto& covariance = correction.covariance;
  check_within({prefix, "covariance(0, 0)"}, covariance(0, 0), 0.0, kInfinity);
  check_within({prefix, "covariance(1, 1)"}, covariance(1, 1), 0.0, kInfinity);
  // Semi-definite and symmetric, but for rounding.
  const double bound = std::sqrt(covariance(0, 0) * covariance(1, 1)) * (1.0 + 1e-9);
  check_within({prefix, "covariance(0, 1)"}, covariance(0, 1), -bound, bound);
  require({prefix, "covariance(1, 0)"}, covariance(1, 0),
          std::abs(covariance(1, 0) - covariance(0, 1)) <= 1e-9 * bound,
          "what covariance(0, 1) is");
}

void check_odometer(const std::string& prefix, const OdometerParameters& odometer) {
  require({prefix, "kind"}, static_cast<int>(odometer.kind),
          odometer.kind == OdometerKind::kAbsolute || odometer.kind == OdometerKind::kIncrement,
          "{0, 1}");
  check_between({prefix, "resolution"}, odometer.resolution, 0.0, kInfinity);
  check_between({prefix, "sigma_per_sqrt_metre"}, odometer.sigma_per_sqrt_metre, 0.0, kInfinity);
  check_within({prefix, "wrap"}, odometer.wrap, 0.0, kInfinity);
  check_within({prefix, "period"}, odometer.period, 0.0, kInfinity);
  check_between({prefix, "lateral"}, odometer.lateral, -kInfinity, kInfinity);
  check_correction(prefix + "correction.", odometer.correction);
}

void check_health(const OdometerHealthParameters& health, double window_distance) {
  check_between({"health.", "slip_ratio"}, health.slip_ratio, 0.0, 1.0);
  check_within({"health.", "slip_sigmas"}, health.slip_sigmas, 1.0, 10.0);
  check_between({"health.", "stuck_ratio"}, health.stuck_ratio, 0.0, 1.0);
  check_between({"health.", "worn_tolerance"}, health.worn_tolerance, 0.0, 0.5);
  check_between({"health.", "worn_release"}, health.worn_release, 0.0, 1.0);
  check_within({"health.", "scale_memory"}, health.scale_memory, window_distance, kInfinity);
  check_within({"health.", "enter_windows"}, health.enter_windows, 1, 1000);
  check_within({"health.", "leave_windows"}, health.leave_windows, 1, 1000);
  check_between({"health.", "bad_share_enter"}, health.bad_share_enter, 0.0, 1.0);
  check_between({"health.", "bad_share_leave"}, health.bad_share_leave, 0.0,
                health.bad_share_enter);
}

/// How well the wheels tell a bend from a distance: the determinant of the normal equations for one
/// wheel; 1/4 for wheels that are evenly spaced.
double spread_around(const std::vector<OdometerParameters>& odometers) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const OdometerParameters& odometer : odometers) {
    const Eigen::Vector3d row(1.0, -std::cos(odometer.clock), -std::sin(odometer.clock));
    sum += row * row.transpose() / static_cast<double>(odometers.size());
  }
  return sum.determinant();
}

void check_circumference(const OdometerStreamParameters& parameters) {
  const CircumferenceParameters& circumference = parameters.circumference;
  check_above({"circumference.", "radius"}, circumference.radius, 0.0, kInfinity);
  check_within({"circumference.", "tightest_bend"}, circumference.tightest_bend, 0.6, 100.0);
  check_above({"circumference.", "smallest_bend"}, circumference.smallest_bend, 0.0,
              std::numbers::pi);
  check_within({"circumference.", "clock_sigma"}, circumference.clock_sigma, 0.0, 0.5);
  const auto& odometers = parameters.odometers;
  if (odometers.size() < 3) {
    refuse("odometers: ", odometers.size(), " of them is outside what a circumference takes: 3");
  }
  for (std::size_t i = 0; i < odometers.size(); ++i) {
    require("odometers[" + std::to_string(i) + "].clock", odometers[i].clock,
            std::isfinite(odometers[i].clock), "(-inf, inf)");
  }
  constexpr double kLeastSpread = 0.01;
  if (!(spread_around(odometers) >= kLeastSpread)) {
    refuse(
        "odometers[].clock: the wheels are too near each other on the circumference: the spread ",
        spread_around(odometers), " is outside [", kLeastSpread, ", 0.25]");
  }
}

}  // namespace

void OdometerCorrection::validate() const {
  check_correction("", *this);
}

void OdometerStreamParameters::validate() const {
  if (odometers.size() < kMinOdometers || odometers.size() > kMaxOdometers) {
    refuse("odometers: ", odometers.size(), " of them is outside [", kMinOdometers, ", ",
           kMaxOdometers, "]");
  }
  for (std::size_t i = 0; i < odometers.size(); ++i) {
    check_odometer("odometers[" + std::to_string(i) + "].", odometers[i]);
  }
  consensus.validate();
  if (!consensus.offsets.empty()) {
    refuse("consensus.offsets: ", consensus.offsets.size(),
           " values is outside what a stream can use: give OdometerCorrection::offset");
  }
  if (rule == FusionRule::kCircumference) {
    check_circumference(*this);
  } else if (rule != FusionRule::kConsensus && rule != FusionRule::kAverage) {
    refuse("rule: ", static_cast<int>(rule), " is outside {0, 1, 2}");
  }
  check_within("sigma_margin", sigma_margin, 1.0, 10.0);
  if (sigma_source != SigmaSource::kGiven && sigma_source != SigmaSource::kResiduals) {
    refuse("sigma_source: ", static_cast<int>(sigma_source), " is outside {0, 1}");
  }
  check_within("residual_windows", static_cast<double>(residual_windows), 8, 64);
  check_above("tick_period", tick_period, 0.0, 60.0);
  check_above("window_distance", window_distance, 0.0, 100.0);
  check_within("lookback_windows", static_cast<double>(lookback_windows), 0, 16);
  check_within("lookback_sigmas", lookback_sigmas, 1.0, 10.0);
  check_within("window_time", window_time, tick_period, kInfinity);
  check_within("maximum_delay", maximum_delay, 0.0, 60.0 * tick_period);
  check_within("maximum_gap", maximum_gap, tick_period, 1000.0 * tick_period);
  check_between("silent_after", silent_after, 0.0, kInfinity);
  check_between("maximum_speed", maximum_speed, 0.0, kInfinity);
  check_within("common_sigma_per_sqrt_metre", common_sigma_per_sqrt_metre, 0.0, kInfinity);
  check_within("common_scale_sigma", common_scale_sigma, 0.0, 1.0);
  check_above("unverified_ratio", unverified_ratio, 0.0, 1.0);
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
