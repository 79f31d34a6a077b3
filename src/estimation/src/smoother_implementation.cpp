// SPDX-License-Identifier: Apache-2.0
#include "smoother_implementation.hpp"

#include <cmath>
#include <exception>

#include "pipescout/statistics/chi_square.hpp"
#include "pipescout/validation/check.hpp"

namespace pipescout::estimation {
namespace {

using validation::require;

/// Own states walk in steps of this share of the lag: each is a new elimination of the whole chain.
constexpr double kWalkShare = 0.25;

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
    for (std::size_t i = 0; i < gates_[kind].size() && probability < 1; ++i) {
      gates_[kind][i] = statistics::chi_square_quantile(probability, static_cast<int>(i) + 1);
    }
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
  walked_until_ = time;
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
  if (report_.marginalised > 0 &&
      keyframe(0).time - walked_until_ >= kWalkShare * parameters_.lag) {
    walk_own_states();
  }
}

void FixedLagSmoother::Implementation::walk_own_states() {
  const double elapsed = keyframe(0).time - walked_until_;
  walked_until_ = keyframe(0).time;
  bool any = false;
  for (std::size_t i = 0; i < estimated_.size(); ++i) {
    const int place = estimated_[i];
    const double walk = place >= kOwnStates ? parameters_.own_walks[place - kOwnStates] : 0;
    if (walk == 0) {
      continue;
    }
    any = true;
    const double variance = walk * walk * elapsed;
    double& before = global_information_[place];
    if (!bound_[place]) {
      before = before / (1 + variance * before);  // all that is known of it
      continue;
    }
    // What is known beforehand of a state to which independent noise is added, H - H e (1 / q + e^T
    // H e)^-1 e^T H, with q its variance.
    Message& in = keyframe(0).in;
    const auto g = static_cast<Eigen::Index>(i);
    const StateVector by_state = in.border.col(g);
    const CornerVector by_globals = in.corner.col(g);
    const double residual = in.corner_b[g];
    const double gain = variance / (1 + variance * by_globals[g]);
    in.h -= gain * by_state * by_state.transpose();
    in.border -= gain * by_state * by_globals.transpose();
    in.corner -= gain * by_globals * by_globals.transpose();
    in.b -= gain * residual * by_state;
    in.corner_b -= gain * residual * by_globals;
  }
  if (any) {
    linearise_prior();
    eliminated_ = 0;
    if (!eliminate_chain(0)) {
      reset(ResetReason::kNumericalFailure);
    }
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
    if (count_ == 0) {
      return;
    }
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
