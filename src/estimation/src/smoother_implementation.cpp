// SPDX-License-Identifier: Apache-2.0
#include "smoother_implementation.hpp"

#include <cmath>
#include <exception>

#include "pipescout/statistics/chi_square.hpp"
#include "pipescout/validation/check.hpp"

namespace pipescout::estimation {
namespace {

using validation::require;

/// Rows of the factors of one time, by kind; the gates' degrees.
constexpr std::array<int, kFactorKinds> kRows = {15, 15, 3, 1, 6, 3, 2, 3, 3, 6, 3, 2};

}  // namespace

FixedLagSmoother::Implementation::Implementation(const FixedLagSmootherParameters& parameters)
    : parameters_(parameters), imu_(parameters.max_imu_samples) {
  // One more than stay: the newest comes before the oldest goes.
  ring_.resize(parameters.max_keyframes + 1);
  old_deltas_.resize(ring_.size());
  watched_states_.resize(ring_.size());
  for (Keyframe& keyframe : ring_) {
    keyframe.factors.reserve(parameters.max_factors_per_keyframe);
  }
  waiting_.reserve(parameters.max_waiting);
  report_.factors.reserve(parameters.max_waiting);
  for (std::size_t kind = 0; kind < kFactorKinds; ++kind) {
    const double probability = parameters.robustness[kind].gate_probability;
    gates_[kind] = probability < 1 ? statistics::chi_square_quantile(probability, kRows[kind]) : 0;
  }
  const GlobalVector deviations = parameters.global_deviations.tangent();
  for (int i = 0; i < kGlobalSize; ++i) {
    if (deviations[i] > 0) {
      estimated_.push_back(i);
      global_information_[i] = 1 / (deviations[i] * deviations[i]);
    }
  }
  imu_scaled_ = deviations.segment<kImuScaleSize>(kImuScale).any() ||
                ImuScale{}.local(parameters.globals.imu_scale).any();
  given_globals_ = globals_ = linear_globals_ = parameters.globals;
  given_information_ = global_information_;
}

void FixedLagSmoother::Implementation::initialise(double time, const NavState& mean,
                                                  const StateMatrix& covariance) {
  require("time", time, true, "the finite numbers");
  const PriorFactor prior(mean, covariance);
  reset(ResetReason::kNone);
  parameters_.globals = given_globals_;
  global_information_ = given_information_;
  begin(time, mean, prior);
}

void FixedLagSmoother::Implementation::restart(double time, const NavState& mean,
                                               const StateMatrix& covariance) {
  if (count_ == 0) {
    initialise(time, mean, covariance);
    return;
  }
  require("time", time, true, "the finite numbers");
  const PriorFactor prior(mean, covariance);
  parameters_.globals = globals_;
  const GlobalVector variances = global_covariance().diagonal();
  for (const int i : estimated_) {
    global_information_[i] = 1 / variances[i];
  }
  if (time != newest().time) {
    reset(ResetReason::kNone);
  }
  begin(time, mean, prior);
  if (!imu_.empty() && imu_.end() > ahead_time_) {
    carry_ahead(imu_.end());
  }
}

void FixedLagSmoother::Implementation::begin(double time, const NavState& mean,
                                             const PriorFactor& prior) {
  prior_ = prior;
  first_ = 0;
  count_ = 1;
  Keyframe& first = newest();
  first.time = time;
  first.linear = first.estimate = mean;
  first.delta.setZero();
  first.linearised_delta.setZero();
  first.link.reset();
  first.coasted = 0;
  first.factors.clear();
  globals_ = linear_globals_ = parameters_.globals;
  global_delta_.setZero();
  linearised_global_delta_.setZero();
  bound_ = true;
  for (const int place : estimated_) {
    bound_[place] = false;
  }
  linearise_prior();
  linearise_clique(0);
  eliminated_ = 0;
  // A prior is regular: this cannot fail.
  static_cast<void>(eliminate_chain(0));
  ahead_ = no_motion(mean, globals_.imu_scale);
  ahead_time_ = time;
  report_ = UpdateReport{.initialised = true, .factors = std::move(report_.factors)};
}

Outcome FixedLagSmoother::Implementation::count(FactorKind kind, Outcome outcome) noexcept {
  ++counts_[index_of(kind)][static_cast<std::size_t>(outcome)];
  return outcome;
}

void FixedLagSmoother::Implementation::reset(ResetReason reason) noexcept {
  count_ = 0;
  waiting_.clear();
  imu_.clear();
  prior_.reset();
  report_.reset = reason;
  report_.initialised = false;
}

void FixedLagSmoother::Implementation::bind_globals(const Clique& clique) {
  for (Eigen::Index i = 0; i < clique.own.corner.cols(); ++i) {
    if (clique.own.corner.col(i).isZero(0) && clique.link_border.col(i).isZero(0)) {
      continue;
    }
    // The IMU tells of its scale from the first keyframe on, of the rest other sensors do, which
    // may come much later.
    const int place = estimated_[static_cast<std::size_t>(i)];
    if (place < kImuScale) {
      bound_.head<kImuScale>() = true;
    } else {
      bound_[place] = true;
    }
  }
}

void FixedLagSmoother::Implementation::drop_oldest() {
  while (count_ > 2 && (newest().time - keyframe(0).time > parameters_.lag + kSameTime ||
                        count_ == ring_.size())) {
    Keyframe& oldest = keyframe(0);
    bind_globals(oldest.clique);
    // What its elimination has left to the next is the Schur complement.
    oldest.factors.clear();
    oldest.link.reset();
    first_ = (first_ + 1) % ring_.size();
    --count_;
    --eliminated_;
    prior_.reset();
    ++report_.marginalised;
  }
}

void FixedLagSmoother::Implementation::update(double time) noexcept {
  report_.factors.clear();
  report_ = UpdateReport{.initialised = count_ > 0, .factors = std::move(report_.factors)};
  if (!std::isfinite(time)) {
    report_.time_refused = true;
    return;
  }
  if (count_ == 0) {
    return;
  }
  if (time > newest().time + parameters_.max_step) {
    reset(ResetReason::kTimeJumpForwards);
    return;
  }
  if (time < keyframe(0).time - kSameTime) {
    reset(ResetReason::kTimeJumpBackwards);
    return;
  }
  // Sound input leads to no exception; what is finite but absurd might, in an exponential map.
  try {
    if (time > newest().time + kSameTime) {
      append_keyframe(time);
    }
    place_waiting();
    do {
      solve();
    } while (count_ > 0 && drop_contradicted());
    if (count_ == 0) {
      return;
    }
    note_fresh();
    drop_oldest();
    ahead_ = no_motion(newest().estimate, globals_.imu_scale);
    ahead_time_ = newest().time;
    if (!imu_.empty() && imu_.end() > ahead_time_) {
      carry_ahead(imu_.end());
    }
  } catch (const std::exception&) {
    reset(ResetReason::kNumericalFailure);
  }
}

}  // namespace pipescout::estimation
