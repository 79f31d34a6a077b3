// SPDX-License-Identifier: Apache-2.0
// Gauss-Newton steps over the chain, damped where they would raise the cost.
#include <algorithm>
#include <cmath>

#include "smoother_implementation.hpp"

namespace pipescout::estimation {
namespace {

/// A robust weight that has changed by more is taken anew.
constexpr double kWeightChange = 0.05;
/// Estimates that go farther in one step are of no use, whatever the unit.
constexpr double kFarthestStep = 1e6;

bool exceeds(const StateVector& d, const RelinearisationThresholds& most) {
  // Norms: turning the map must not change what is linearised anew.
  const auto size = [&](int part) { return d.segment<3>(part).norm(); };
  return size(kPosition) > most.position || size(kRotation) > most.rotation ||
         size(kVelocity) > most.velocity || size(kGyroBias) > most.gyro_bias ||
         size(kAccelerometerBias) > most.accelerometer_bias;
}

bool exceeds(const GlobalVector& d, const RelinearisationThresholds& most) {
  return std::abs(d[kOdometerScale]) > most.odometer_scale || std::abs(d[kMountYaw]) > most.mount ||
         std::abs(d[kMountPitch]) > most.mount ||
         d.segment<3>(kRackPosition).norm() > most.position ||
         d.segment<3>(kRackRotation).norm() > most.rotation ||
         d.segment<3>(kGpsLeverArm).norm() > most.position ||
         std::abs(d[kGpsTimeOffset]) > most.time_offset ||
         std::abs(d[kVisualPoseTimeOffset]) > most.time_offset ||
         d.segment<kImuScaleSize>(kImuScale).norm() > most.imu_scale ||
         (d.segment<kOwnSize>(kOwnStates).array().abs() > most.own.array()).any();
}

}  // namespace

void FixedLagSmoother::Implementation::relinearise() {
  const RelinearisationThresholds& most = parameters_.relinearisation;
  const auto mark = [&](std::size_t k) { keyframe(k).dirty = true; };
  if (exceeds(GlobalVector(global_delta_ - linearised_global_delta_), most)) {
    if (!bound_.all()) {
      const GlobalVector free = bound_.select(0, global_delta_);
      linear_globals_ = linear_globals_.retract(free);
      global_delta_ -= free;
      linearise_prior();
      eliminated_ = 0;
    }
    linearised_global_delta_ = global_delta_;
    for (std::size_t k = 0; k < count_; ++k) {
      mark(k);
    }
  }
  for (std::size_t k = 0; k < count_; ++k) {
    Keyframe& here = keyframe(k);
    const bool bound = k == 0 && !prior_;
    if (bound && exceeds(StateVector(here.delta - here.linearised_delta), most)) {
      mark(k);
    } else if (!bound && exceeds(here.delta, most)) {
      here.linear = here.estimate;
      here.delta.setZero();
      mark(k);
      if (k > 0) {
        mark(k - 1);
      } else {
        linearise_prior();
      }
      ++report_.relinearised;
    }
    for (const PlacedFactor& placed : here.factors) {
      if (parameters_.robustness[index_of(placed.factor.kind())].kernel !=
              statistics::RobustKernel::kNone &&
          !here.dirty) {
        const double weight = kernel(placed, chi_square(placed, k)).weight;
        if (std::abs(weight - placed.weight) > kWeightChange) {
          mark(k);
        }
      }
    }
  }
}

bool FixedLagSmoother::Implementation::prepare() {
  relinearise();
  bool any = false;
  for (std::size_t k = 0; k < count_; ++k) {
    if (keyframe(k).dirty) {
      linearise_clique(k);
      eliminated_ = std::min(eliminated_, k);
      any = true;
    }
  }
  return any;
}

bool FixedLagSmoother::Implementation::eliminate_chain(double damping) {
  std::size_t k = damping > 0 ? 0 : std::min(eliminated_, count_ - 1);
  // What is damped is no marginal: the next elimination begins at the oldest.
  eliminated_ = damping > 0 ? 0 : k;
  for (; k + 1 < count_; ++k) {
    Keyframe& here = keyframe(k);
    if (!eliminate(here.clique, here.in, {damping, here.delta}, here.eliminated,
                   keyframe(k + 1).in)) {
      return false;
    }
    eliminated_ = damping > 0 ? 0 : k + 1;
  }
  Keyframe& here = keyframe(k);
  if (!eliminate_last(here.clique, here.in, {damping, here.delta}, here.eliminated, last_)) {
    return false;
  }
  corner_root_ = last_.corner;
  if (damping > 0) {
    const CornerVector centre = estimated_part(global_delta_);
    last_.corner_b += damping * corner_root_.diagonal().cwiseProduct(centre);
    corner_root_.diagonal() *= 1 + damping;
  }
  return factorise(corner_root_);
}

bool FixedLagSmoother::Implementation::substitute_globals() {
  CornerVector globals = last_.corner_b;
  if (globals.size() == 0) {
    return true;
  }
  corner_root_.triangularView<Eigen::Lower>().solveInPlace(globals);
  corner_root_.transpose().triangularView<Eigen::Upper>().solveInPlace(globals);
  if (!(globals.cwiseAbs().maxCoeff() < kFarthestStep)) {
    return false;
  }
  global_delta_ = whole(globals);
  globals_ = linear_globals_.retract(global_delta_);
  return true;
}

bool FixedLagSmoother::Implementation::substitute_state(std::size_t k, const StateVector* next) {
  Keyframe& here = keyframe(k);
  here.delta = substitute(here.eliminated, next, estimated_part(global_delta_));
  if (!(here.delta.cwiseAbs().maxCoeff() < kFarthestStep)) {
    return false;
  }
  here.estimate = here.linear.retract(here.delta);
  return true;
}

bool FixedLagSmoother::Implementation::substitute_all() {
  if (!substitute_globals()) {
    return false;
  }
  const StateVector* next = nullptr;
  for (std::size_t k = count_; k-- > 0;) {
    if (!substitute_state(k, next)) {
      return false;
    }
    next = &keyframe(k).delta;
  }
  return true;
}

void FixedLagSmoother::Implementation::remember() {
  for (std::size_t k = 0; k < count_; ++k) {
    old_deltas_[k] = keyframe(k).delta;
  }
  old_global_delta_ = global_delta_;
}

void FixedLagSmoother::Implementation::go_back() {
  for (std::size_t k = 0; k < count_; ++k) {
    Keyframe& here = keyframe(k);
    here.delta = old_deltas_[k];
    here.estimate = here.linear.retract(here.delta);
  }
  global_delta_ = old_global_delta_;
  globals_ = linear_globals_.retract(global_delta_);
}

void FixedLagSmoother::Implementation::go_back_to_watched() {
  for (std::size_t k = 0; k < count_; ++k) {
    Keyframe& here = keyframe(k);
    here.delta = here.linear.local(watched_states_[k]);
    here.estimate = watched_states_[k];
    here.dirty = true;
  }
  global_delta_ = linear_globals_.local(watched_globals_);
  globals_ = watched_globals_;
}

bool FixedLagSmoother::Implementation::step() {
  constexpr double kFirstDamping = 1e-5;
  constexpr double kLastDamping = 1e5;
  constexpr double kRounding = 1e-9;
  remember();
  if (!substitute_all()) {
    return false;
  }
  const RelinearisationThresholds& most = parameters_.relinearisation;
  bool far = exceeds(GlobalVector(global_delta_ - old_global_delta_), most);
  for (std::size_t k = 0; k < count_ && !far; ++k) {
    far = exceeds(StateVector(keyframe(k).delta - old_deltas_[k]), most);
  }
  if (!far && watchdog_ != Watchdog::kWatching) {
    return true;  // the linear cost is as good as the true one
  }
  const double after = cost();
  go_back();
  const double before = cost();
  const double allowed = before + kRounding * (1 + std::abs(before));
  if (watchdog_ == Watchdog::kWatching) {
    if (after <= watched_cost_) {
      watchdog_ = Watchdog::kIdle;
      return substitute_all();
    }
    watchdog_ = Watchdog::kFailed;
    go_back_to_watched();
    return true;
  }
  if (after <= allowed) {
    return substitute_all();
  }
  if (watchdog_ == Watchdog::kIdle && has_coasted()) {
    // An attitude that is uncertain after some time without the IMU turns all later ones with it,
    // along a curve: the first step leaves it, the next one returns to it (the watchdog technique
    // of Nocedal and Wright, 2006, "Numerical Optimization", 15.6). Damping would only creep.
    watchdog_ = Watchdog::kWatching;
    watched_cost_ = allowed;
    for (std::size_t k = 0; k < count_; ++k) {
      watched_states_[k] = keyframe(k).estimate;
    }
    watched_globals_ = globals_;
    return substitute_all();
  }
  for (double damping = kFirstDamping; damping <= kLastDamping; damping *= 10) {
    if (!eliminate_chain(damping)) {
      return false;
    }
    if (substitute_all() && cost() <= allowed) {
      return true;
    }
    go_back();
  }
  return true;  // nowhere to go from here
}

bool FixedLagSmoother::Implementation::blame_a_factor(Blame blame) {
  std::size_t frame = count_;
  std::size_t worst = 0;
  double most = -1;
  FactorValue linear;
  for (std::size_t k = 0; k < count_; ++k) {
    for (std::size_t i = 0; i < keyframe(k).factors.size(); ++i) {
      const PlacedFactor& placed = keyframe(k).factors[i];
      if (!placed.fresh) {
        continue;
      }
      double guilt = 0;
      if (blame == Blame::kInformation) {
        linearise(placed, k, linear);
        guilt = linear.from.topRows(linear.rows).squaredNorm();
      } else {
        guilt = chi_square(placed, k);
      }
      if (guilt > most) {
        most = guilt;
        frame = k;
        worst = i;
      }
    }
  }
  if (frame == count_) {
    return false;
  }
  take_out(frame, worst, Outcome::kQuarantined);
  return true;
}

bool FixedLagSmoother::Implementation::drop_contradicted() {
  std::size_t frame = count_;
  std::size_t worst = 0;
  double most = 1;
  int judged = 0;
  for (std::size_t k = 0; k < count_; ++k) {
    for (std::size_t i = 0; i < keyframe(k).factors.size(); ++i) {
      const PlacedFactor& placed = keyframe(k).factors[i];
      const double gate = gate_of(placed);
      if (!placed.fresh || gate == 0) {
        continue;
      }
      ++judged;
      const double misfit = innovation(placed, k, true) / gate;
      if (misfit > most) {
        most = misfit;
        frame = k;
        worst = i;
      }
    }
  }
  if (judged < 2 || frame == count_) {
    return false;
  }
  take_out(frame, worst, Outcome::kGated);
  return true;
}

void FixedLagSmoother::Implementation::take_out(std::size_t k, std::size_t factor,
                                                Outcome outcome) {
  Keyframe& place = keyframe(k);
  const auto which = place.factors.begin() + static_cast<std::ptrdiff_t>(factor);
  note(*which, outcome, chi_square(*which, k));
  place.factors.erase(which);
  place.dirty = true;
}

bool FixedLagSmoother::Implementation::eliminate_sound() {
  while (!eliminate_chain(0)) {
    if (!blame_a_factor(Blame::kInformation)) {
      return false;
    }
    prepare();
  }
  return true;
}

bool FixedLagSmoother::Implementation::go_back_and_blame() {
  go_back();
  if (!blame_a_factor(Blame::kResidual)) {
    return false;
  }
  prepare();
  return eliminate_sound();
}

void FixedLagSmoother::Implementation::solve() {
  watchdog_ = Watchdog::kIdle;
  for (report_.iterations = 0;
       report_.iterations < parameters_.max_iterations || watchdog_ == Watchdog::kWatching;) {
    if (!prepare() && report_.iterations > 0) {
      report_.converged = true;
      break;
    }
    if (!eliminate_sound()) {
      reset(ResetReason::kNumericalFailure);
      return;
    }
    ++report_.iterations;
    while (!step()) {
      if (!go_back_and_blame()) {
        reset(ResetReason::kNumericalFailure);
        return;
      }
    }
  }
  // After damped steps, for marginals and covariances.
  if (eliminated_ + 1 < count_ && !eliminate_chain(0)) {
    reset(ResetReason::kNumericalFailure);
  }
}

}  // namespace pipescout::estimation
