// SPDX-License-Identifier: Apache-2.0
#include "pipescout/odometry/weld_calibration.hpp"

#include <algorithm>
#include <cmath>

#include "pipescout/validation/check.hpp"

namespace pipescout::odometry {
namespace {

using validation::refuse;
using validation::require;

/// Of the scale: from here on it is known well enough to tell wear from ignorance.
constexpr double kKnownScale = 0.002;

}  // namespace

void WeldCalibrationParameters::validate() const {
  calibration.validate();
  if (history < 16 || history > 1000000) {
    refuse("history: ", history, " is outside [16, 1e6]");
  }
  require("least_change", least_change, least_change >= 0.0 && least_change <= 0.1, "[0, 0.1]");
  require("worn_tolerance", worn_tolerance, worn_tolerance > 0.0 && worn_tolerance < 0.5,
          "(0, 0.5)");
  require("worn_release", worn_release, worn_release > 0.0 && worn_release < 1.0, "(0, 1)");
}

WeldCalibration::WeldCalibration(WeldCalibrationParameters parameters, std::size_t odometers)
    : parameters_(parameters), calibration_(parameters.calibration, odometers) {
  parameters_.validate();
  entries_.resize(parameters_.history);
}

void WeldCalibration::record(const FusedStream& state) noexcept {
  if (size_ > 0 && !(state.time > entry(size_ - 1).time)) {
    size_ = 0;  // the clocks have leapt back: what was before cannot be found by its time
  }
  std::size_t place = first_ + size_;
  if (size_ == entries_.size()) {
    first_ = (first_ + 1) % entries_.size();
  } else {
    ++size_;
  }
  place %= entries_.size();
  Entry& latest = entries_[place];
  latest.time = state.time;
  latest.uneven_windows = state.uneven_windows;
  for (std::size_t i = 0; i < calibration_.odometers(); ++i) {
    latest.measured[i] = state.odometers[i].measured;
    latest.gaps[i] = state.odometers[i].gaps;
    latest.unsupported[i] = state.odometers[i].unsupported;
  }
}

const WeldCalibration::Entry& WeldCalibration::entry(std::size_t k) const noexcept {
  return entries_[(first_ + k) % entries_.size()];
}

double WeldCalibration::Place::measured(std::size_t odometer) const noexcept {
  return before->measured[odometer] +
         share * (after->measured[odometer] - before->measured[odometer]);
}

bool WeldCalibration::find(double time, Place& place) const noexcept {
  if (size_ < 2 || time < entry(0).time || time > entry(size_ - 1).time) {
    return false;
  }
  std::size_t low = 0;
  std::size_t high = size_ - 1;
  while (high - low > 1) {
    const std::size_t middle = low + (high - low) / 2;
    (entry(middle).time <= time ? low : high) = middle;
  }
  place.before = &entry(low);
  place.after = &entry(high);
  place.share = (time - place.before->time) / (place.after->time - place.before->time);
  return true;
}

SpacingOutcome WeldCalibration::observe(const KnownSpacing& spacing, OdometerStream& stream) {
  const bool finite = std::isfinite(spacing.from) && std::isfinite(spacing.to) &&
                      std::isfinite(spacing.length) && std::isfinite(spacing.standard_deviation);
  if (!finite || spacing.from >= spacing.to || spacing.length <= 0.0 ||
      spacing.standard_deviation < 0.0 || spacing.joints == 0) {
    return SpacingOutcome::kBadValue;
  }
  const bool offsets = parameters_.calibration.initial_offset_standard_deviation > 0.0 ||
                       parameters_.calibration.initial_offset != 0.0;
  if (offsets && spacing.joints != 1) {
    return SpacingOutcome::kSeveralJoints;
  }
  Place from;
  Place to;
  if (!find(spacing.from, from) || !find(spacing.to, to)) {
    return SpacingOutcome::kTooOld;
  }
  if (offsets) {
    stream.end_segment();
  }
  if (from.before->uneven_windows != to.after->uneven_windows) {
    return SpacingOutcome::kUneven;  // in a bend each wheel goes its own way
  }
  for (std::size_t i = 0; i < calibration_.odometers(); ++i) {
    if (from.before->gaps[i] != to.after->gaps[i] ||
        from.before->unsupported[i] != to.after->unsupported[i]) {
      continue;
    }
    const OdometerParameters& odometer = stream.parameters().odometers[i];
    const double measured = std::abs(to.measured(i) - from.measured(i));
    const double noise = stream.state().odometers[i].sigma_per_sqrt_metre;
    const CalibrationOutcome outcome =
        calibration_.observe(i, {.measured = measured,
                                 .measured_standard_deviation =
                                     std::hypot(noise * std::sqrt(measured), odometer.resolution),
                                 .length = spacing.length,
                                 .length_standard_deviation = spacing.standard_deviation});
    const OdometerCorrection& latest = calibration_.correction(i);
    if (outcome != CalibrationOutcome::kBadValue &&
        is_effective(stream.state().odometers[i].correction, latest)) {
      stream.set_correction(i, latest);
    }
    judge_wear(i);
  }
  return SpacingOutcome::kUsed;
}

bool WeldCalibration::is_effective(const OdometerCorrection& in_use,
                                   const OdometerCorrection& latest) const noexcept {
  const double change =
      std::max(std::abs(latest.scale - in_use.scale), std::abs(latest.offset - in_use.offset));
  return change > std::min(parameters_.least_change, std::sqrt(latest.covariance(0, 0)));
}

void WeldCalibration::judge_wear(std::size_t odometer) noexcept {
  Wear& wear = wear_[odometer];
  const OdometerCorrection& latest = calibration_.correction(odometer);
  if (std::isnan(wear.first_scale)) {
    if (std::sqrt(latest.covariance(0, 0)) < kKnownScale) {
      wear.first_scale = latest.scale;
    }
    return;
  }
  const double off = std::abs(latest.scale / wear.first_scale - 1.0);
  const double limit = parameters_.worn_tolerance * (wear.worn ? parameters_.worn_release : 1.0);
  wear.worn = off > limit;
}

const OdometerCorrection& WeldCalibration::correction(std::size_t odometer) const {
  return calibration_.correction(odometer);
}

bool WeldCalibration::is_worn(std::size_t odometer) const {
  static_cast<void>(calibration_.correction(odometer));  // throws when there is none
  return wear_[odometer].worn;
}

const char* to_string(SpacingOutcome outcome) noexcept {
  switch (outcome) {
    case SpacingOutcome::kUsed:
      return "used";
    case SpacingOutcome::kBadValue:
      return "bad value";
    case SpacingOutcome::kTooOld:
      return "too old";
    case SpacingOutcome::kSeveralJoints:
      return "several joints";
    case SpacingOutcome::kUneven:
      return "uneven";
  }
  return "unknown";
}

}  // namespace pipescout::odometry
