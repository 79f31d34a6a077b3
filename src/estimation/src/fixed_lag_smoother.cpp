// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation/fixed_lag_smoother.hpp"

#include <array>
#include <stdexcept>
#include <string>
#include <utility>

#include "pipescout/validation/check.hpp"
#include "pipescout/validation/number_text.hpp"
#include "smoother_implementation.hpp"

namespace pipescout::estimation {

using validation::require;

GlobalVector GlobalDeviations::tangent() const {
  const auto by_rows = [](double scale, double misalignment) {
    Eigen::Matrix<double, 9, 1> rows = Eigen::Matrix<double, 9, 1>::Constant(misalignment);
    rows[0] = rows[4] = rows[8] = scale;
    return rows;
  };
  GlobalVector all;
  all << odometer_scale, mount_yaw, mount_pitch, Eigen::Vector3d::Constant(rack_position),
      Eigen::Vector3d::Constant(rack_rotation), Eigen::Vector3d::Constant(gps_lever_arm),
      gps_time_offset, visual_pose_time_offset, by_rows(gyro_scale, gyro_misalignment),
      by_rows(accelerometer_scale, accelerometer_misalignment), own;
  return all;
}

void GlobalDeviations::validate() const {
  const auto deviation = [](const char* field, double value) {
    require(field, value, value == 0 || (value >= 1e-9 && value <= 1e6), "{0} or [1e-9, 1e6]");
  };
  deviation("global_deviations.odometer_scale", odometer_scale);
  deviation("global_deviations.mount_yaw", mount_yaw);
  deviation("global_deviations.mount_pitch", mount_pitch);
  deviation("global_deviations.rack_position", rack_position);
  deviation("global_deviations.rack_rotation", rack_rotation);
  deviation("global_deviations.gps_lever_arm", gps_lever_arm);
  deviation("global_deviations.gps_time_offset", gps_time_offset);
  deviation("global_deviations.visual_pose_time_offset", visual_pose_time_offset);
  deviation("global_deviations.gyro_scale", gyro_scale);
  deviation("global_deviations.gyro_misalignment", gyro_misalignment);
  deviation("global_deviations.accelerometer_scale", accelerometer_scale);
  deviation("global_deviations.accelerometer_misalignment", accelerometer_misalignment);
  for (const double one : own) {
    deviation("global_deviations.own", one);
  }
}

int FixedLagSmootherParameters::estimate_camera_mounting(double position_deviation,
                                                         double rotation_deviation) {
  constexpr int kPlace = kOwnSize - kMountingSize;
  require("position_deviation", position_deviation,
          position_deviation == 0 || (position_deviation >= 1e-9 && position_deviation <= 1e6),
          "{0} or [1e-9, 1e6]");
  require("rotation_deviation", rotation_deviation,
          rotation_deviation == 0 || (rotation_deviation >= 1e-9 && rotation_deviation <= 1),
          "{0} or [1e-9, 1]");
  auto states = global_deviations.own.segment<kMountingSize>(kPlace);
  if (states.any()) {
    throw std::invalid_argument(
        "the mounting of the camera needs six of the eight states of the user: at most two others, "
        "such as biases of sources, are possible");
  }
  states << Eigen::Vector3d::Constant(position_deviation),
      Eigen::Vector3d::Constant(rotation_deviation);
  relinearisation.own.segment<kMountingSize>(kPlace)
      << Eigen::Vector3d::Constant(relinearisation.position),
      Eigen::Vector3d::Constant(relinearisation.rotation);
  return kPlace;
}

std::array<Robustness, kFactorKinds> FixedLagSmootherParameters::default_robustness() {
  constexpr double kGate = 0.9999;
  std::array<Robustness, kFactorKinds> all{};
  for (std::size_t i = 0; i < kOwnFactorKinds; ++i) {
    all[index_of(own_kind(i))].gate_probability = kGate;
  }
  for (const FactorKind kind : {FactorKind::kGps, FactorKind::kHeading, FactorKind::kVisualPose,
                                FactorKind::kWeld, FactorKind::kCentreLine}) {
    all[index_of(kind)].gate_probability = kGate;
  }
  return all;
}

ImuIntegration FixedLagSmootherParameters::imu_integration() const noexcept {
  ImuIntegration how{.noise = imu_noise,
                     .coasting = imu_noise,
                     .max_held = max_held_imu,
                     .gravity = gravity,
                     .map_rate = earth.rate};
  how.coasting.gyro = coasting_angular_rate;
  how.coasting_turn = coasting_turn;
  how.coasting.accelerometer = coasting_acceleration;
  return how;
}

void FixedLagSmootherParameters::validate() const {
  const auto within = [](const char* field, double value, double low, double high,
                         const char* range) {
    require(field, value, value >= low && value <= high, range);
  };
  within("lag", lag, 0.01, 1000, "[0.01, 1000]");
  within("max_keyframes", static_cast<double>(max_keyframes), 3, 1e4, "[3, 10000]");
  within("max_factors_per_keyframe", static_cast<double>(max_factors_per_keyframe), 1, 1000,
         "[1, 1000]");
  within("max_waiting", static_cast<double>(max_waiting), 1, 1e5, "[1, 100000]");
  within("max_imu_samples", static_cast<double>(max_imu_samples), 16, 1e7, "[16, 10000000]");
  within("max_step", max_step, 1e-3, 100, "[1e-3, 100]");
  within("max_held_imu", max_held_imu, 0, 1, "[0, 1]");
  within("gravity", gravity, 0, 100, "[0, 100]");
  earth.validate();
  imu_noise.validate();
  within("coasting_acceleration", coasting_acceleration, 1e-6, 1000, "[1e-6, 1000]");
  within("coasting_angular_rate", coasting_angular_rate, 1e-6, 1000, "[1e-6, 1000]");
  within("coasting_turn", coasting_turn, 0, 1000, "[0, 1000]");
  if (!globals.is_finite()) {
    throw std::invalid_argument("globals: one is not finite");
  }
  global_deviations.validate();
  for (const double walk : own_walks) {
    require("own_walks", walk, walk == 0 || (walk >= 1e-9 && walk <= 1e6), "{0} or [1e-9, 1e6]");
  }
  for (const Robustness& one : robustness) {
    one.validate();
  }
  within("relinearisation.position", relinearisation.position, 1e-9, 1, "[1e-9, 1]");
  within("relinearisation.rotation", relinearisation.rotation, 1e-9, 1, "[1e-9, 1]");
  within("relinearisation.velocity", relinearisation.velocity, 1e-9, 10, "[1e-9, 10]");
  within("relinearisation.gyro_bias", relinearisation.gyro_bias, 1e-9, 1, "[1e-9, 1]");
  within("relinearisation.accelerometer_bias", relinearisation.accelerometer_bias, 1e-9, 10,
         "[1e-9, 10]");
  within("relinearisation.odometer_scale", relinearisation.odometer_scale, 1e-9, 1, "[1e-9, 1]");
  within("relinearisation.mount", relinearisation.mount, 1e-9, 1, "[1e-9, 1]");
  within("relinearisation.time_offset", relinearisation.time_offset, 1e-9, 1, "[1e-9, 1]");
  within("relinearisation.imu_scale", relinearisation.imu_scale, 1e-9, 1, "[1e-9, 1]");
  for (const double most : relinearisation.own) {
    if (!(most >= 1e-9)) {  // `require` allows no infinity
      throw std::invalid_argument("relinearisation.own: " + validation::number_text(most) +
                                  " is outside [1e-9, inf]");
    }
  }
  within("max_iterations", max_iterations, 1, 100, "[1, 100]");
}

Outcome outcome_of(InputFault fault, Outcome sound) noexcept {
  switch (fault) {
    case InputFault::kNone:
      break;
    case InputFault::kNotFinite:
      return Outcome::kNotFinite;
    case InputFault::kBadCovariance:
      return Outcome::kBadCovariance;
    case InputFault::kBadInterval:
      return Outcome::kBadInterval;
    case InputFault::kBadDirection:
      return Outcome::kBadDirection;
  }
  return sound;
}

std::string_view to_string(Outcome outcome) noexcept {
  constexpr std::array<std::string_view, kOutcomes> kNames = {
      "accepted",  "waiting",       "gated",          "late",         "future",
      "duplicate", "not_finite",    "bad_covariance", "bad_interval", "bad_direction",
      "full",      "uninitialised", "quarantined",    "dead"};
  const auto i = static_cast<std::size_t>(outcome);
  return i < kNames.size() ? kNames[i] : "unknown";
}

std::string_view to_string(ResetReason reason) noexcept {
  switch (reason) {
    case ResetReason::kNone:
      return "none";
    case ResetReason::kTimeJumpForwards:
      return "time_jump_forwards";
    case ResetReason::kTimeJumpBackwards:
      return "time_jump_backwards";
    case ResetReason::kNumericalFailure:
      return "numerical_failure";
  }
  return "unknown";
}

FixedLagSmoother::FixedLagSmoother(const FixedLagSmootherParameters& parameters) {
  parameters.validate();
  implementation_ = std::make_unique<Implementation>(parameters);
}
FixedLagSmoother::~FixedLagSmoother() = default;
FixedLagSmoother::FixedLagSmoother(FixedLagSmoother&&) noexcept = default;
FixedLagSmoother& FixedLagSmoother::operator=(FixedLagSmoother&&) noexcept = default;

void FixedLagSmoother::initialise(double time, const NavState& mean,
                                  const StateMatrix& covariance) {
  implementation_->initialise(time, mean, covariance);
}
void FixedLagSmoother::restart(double time, const NavState& mean, const StateMatrix& covariance) {
  implementation_->restart(time, mean, covariance);
}
void FixedLagSmoother::set_earth(const Earth& earth) {
  earth.validate();
  implementation_->set_earth(earth);
}
Outcome FixedLagSmoother::add(const ImuSample& sample) noexcept {
  return implementation_->add_imu(sample);
}
Outcome FixedLagSmoother::add(const AnyFactor& factor) noexcept {
  return implementation_->add(factor);
}
const UpdateReport& FixedLagSmoother::update(double time) noexcept {
  implementation_->update(time);
  return implementation_->report();
}
bool FixedLagSmoother::initialised() const noexcept {
  return implementation_->size() > 0;
}
std::size_t FixedLagSmoother::keyframes() const noexcept {
  return implementation_->size();
}
double FixedLagSmoother::time(std::size_t keyframe) const noexcept {
  return std::as_const(*implementation_).keyframe(keyframe).time;
}
const NavState& FixedLagSmoother::state(std::size_t keyframe) const noexcept {
  return std::as_const(*implementation_).keyframe(keyframe).estimate;
}
StateMatrix FixedLagSmoother::covariance(std::size_t keyframe) const noexcept {
  return implementation_->covariance(keyframe);
}
const GlobalStates& FixedLagSmoother::globals() const noexcept {
  return implementation_->globals();
}
Eigen::Matrix<double, kGlobalSize, kGlobalSize> FixedLagSmoother::global_covariance()
    const noexcept {
  return implementation_->global_covariance();
}
std::optional<FixedLagSmoother::Propagated> FixedLagSmoother::propagated() const noexcept {
  return implementation_->propagated();
}
StateMatrix FixedLagSmoother::propagated_covariance() const noexcept {
  return implementation_->propagated_covariance();
}
void FixedLagSmoother::report_factors(std::vector<FactorReport>& reports) const {
  implementation_->report_factors(reports);
}
const OutcomeCounts& FixedLagSmoother::counts(FactorKind kind) const noexcept {
  return implementation_->counts(kind);
}

}  // namespace pipescout::estimation
