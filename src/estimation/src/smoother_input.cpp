// SPDX-License-Identifier: Apache-2.0
// From measurements to factors of keyframes.
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "pipescout/linear_algebra/cholesky.hpp"
#include "smoother_implementation.hpp"

namespace pipescout::estimation {
namespace {

/// Rates and forces that no sensor measures; sums over them could overflow.
constexpr double kMostRate = 1e4;   // rad/s
constexpr double kMostForce = 1e6;  // m/s^2

/// Beside those of the IMU.
constexpr int kMaxRelativeRows = Clique::kMaxRows - ImuFactor::kRows;

int rows_to_next(const Keyframe& keyframe) {
  int rows = 0;
  for (const PlacedFactor& placed : keyframe.factors) {
    rows += placed.to_next ? placed.factor.rows() : 0;
  }
  return rows;
}

}  // namespace

Outcome FixedLagSmoother::Implementation::add_imu(const ImuSample& given) noexcept {
  constexpr FactorKind kKind = FactorKind::kImu;
  constexpr double kOverlap = 1e-9;
  if (!(std::isfinite(given.time) && std::isfinite(given.duration) &&
        given.angular_rate.cwiseAbs().maxCoeff() <= kMostRate &&
        given.specific_force.cwiseAbs().maxCoeff() <= kMostForce &&
        given.angular_rate.allFinite() && given.specific_force.allFinite())) {
    return count(kKind, Outcome::kNotFinite);
  }
  if (!(given.duration > 0 && given.duration <= parameters_.max_step)) {
    return count(kKind, Outcome::kBadInterval);
  }
  if (count_ == 0) {
    return count(kKind, Outcome::kUninitialised);
  }
  if (given.time > newest().time + 2 * parameters_.max_step) {
    return count(kKind, Outcome::kFuture);
  }
  ImuSample sample = given;
  if (!imu_.empty()) {
    const double overlap = imu_.end() - given.time;
    if (given.time == imu_.newest().time) {
      return count(kKind, Outcome::kDuplicate);
    }
    if (overlap >= given.duration - kOverlap) {
      return count(kKind, Outcome::kLate);
    }
    if (overlap > 0) {
      sample.time += overlap;
      sample.duration -= overlap;
    }
  }
  imu_.push(sample);
  carry_ahead(imu_.end());
  return count(kKind, Outcome::kAccepted);
}

Outcome FixedLagSmoother::Implementation::add(const AnyFactor& factor) noexcept {
  const FactorKind kind = factor.kind();
  const InputFault fault = factor.fault();
  if (fault != InputFault::kNone) {
    return count(kind, outcome_of(fault, Outcome::kWaiting));
  }
  if (count_ == 0) {
    return count(kind, Outcome::kUninitialised);
  }
  if (factor.from_time() < keyframe(0).time - kSameTime) {
    return count(kind, Outcome::kLate);
  }
  if (factor.to_time() > newest().time + parameters_.max_step) {
    return count(kind, Outcome::kFuture);
  }
  if (is_known(factor.fingerprint())) {
    return count(kind, Outcome::kDuplicate);
  }
  if (waiting_.size() == parameters_.max_waiting) {
    return count(kind, Outcome::kFull);
  }
  waiting_.push_back({.factor = factor});
  return Outcome::kWaiting;
}

bool FixedLagSmoother::Implementation::is_known(std::uint64_t fingerprint) const noexcept {
  const auto same = [&](const PlacedFactor& f) { return f.factor.fingerprint() == fingerprint; };
  if (std::any_of(waiting_.begin(), waiting_.end(), same)) {
    return true;
  }
  for (std::size_t k = 0; k < count_; ++k) {
    const auto& factors = keyframe(k).factors;
    if (std::any_of(factors.begin(), factors.end(), same)) {
      return true;
    }
  }
  return false;
}

std::size_t FixedLagSmoother::Implementation::keyframe_at(double time) const noexcept {
  std::size_t k = count_ - 1;
  while (k > 0 && keyframe(k).time > time + kSameTime) {
    --k;
  }
  return k;
}

double FixedLagSmoother::Implementation::integrate(const NavState& start, double begin, double end,
                                                   ImuPreintegration& sum) const {
  return imu_.integrate(integration(), start.R_map_body, begin, end, sum);
}

ImuIntegration FixedLagSmoother::Implementation::integration() const noexcept {
  constexpr double kTurnEnds = 1;  // s
  ImuIntegration how = parameters_.imu_integration();
  how.turning = turning_;
  how.turning_time = turning_time_;
  how.turning_ends = kTurnEnds;
  return how;
}

ImuPreintegration FixedLagSmoother::Implementation::no_motion(const NavState& start,
                                                              const ImuScale& scale) const {
  return ImuPreintegration(imu_scaled_ ? ImuMotion(start.gyro_bias, start.accelerometer_bias, scale)
                                       : ImuMotion(start.gyro_bias, start.accelerometer_bias));
}

ImuMotion FixedLagSmoother::Implementation::motion_to(std::size_t k, double time) const {
  const Keyframe& from = keyframe(k);
  // As the link that it is part of: while an update places its measurements the estimate moves.
  ImuPreintegration sum =
      no_motion(from.estimate, from.link ? from.link->motion().scale() : globals_.imu_scale);
  if (time > from.time + kSameTime) {
    integrate(from.estimate, from.time, time, sum);
  }
  return sum.motion();
}

void FixedLagSmoother::Implementation::append_keyframe(double time) {
  Keyframe& from = newest();
  ImuPreintegration link = no_motion(from.estimate, globals_.imu_scale);
  report_.coasted = integrate(from.estimate, from.time, time, link);
  from.coasted = report_.coasted;
  from.link.emplace(link, gravity());
  from.dirty = true;
  eliminated_ = std::min(eliminated_, count_ - 1);
  ++count_;
  Keyframe& added = newest();
  added.time = time;
  added.linear = from.link->motion().propagate(from.estimate, gravity());
  added.estimate = added.linear;
  added.delta.setZero();
  added.linearised_delta.setZero();
  added.link.reset();
  added.coasted = 0;
  added.factors.clear();
  added.dirty = true;
  report_.new_keyframe = true;
  if (report_.coasted == 0) {
    const double duration = time - from.time;
    const Eigen::Vector3d turned = from.estimate.R_map_body * from.link->motion().rotation().log();
    turning_ = turned.z() / duration;
    turning_time_ = time;
  }
}

double FixedLagSmoother::Implementation::innovation(const PlacedFactor& placed, std::size_t k,
                                                    bool in_the_equations) const {
  // Whitened, so that the measurement's own covariance is 1. What the estimate has already learnt
  // from it comes off: r^T (1 - J P J^T)^-1 r is by how much the least cost falls without it.
  constexpr double kLeast = 1e-9;
  constexpr int kMost = kMaxFactorRows;
  FactorValue linear;
  linear.from.setZero();
  linear.globals.setZero();
  linearise(placed, k, linear);
  const auto globals = static_cast<Eigen::Index>(estimated_.size());
  Eigen::Matrix<double, Eigen::Dynamic, kMost, 0, kGlobalSize, kMost> by_globals(globals, kMost);
  Eigen::Matrix<double, kMost, 1> r = Eigen::Matrix<double, kMost, 1>::Zero();
  for (int row = 0; row < linear.rows; ++row) {
    const GlobalVector all = linear.globals.row(row);
    by_globals.col(row) = estimated_part(all);
    r[row] =
        linear.residual[row] + linear.from.row(row).dot(keyframe(k).delta) + all.dot(global_delta_);
  }
  by_globals.rightCols(kMost - linear.rows).setZero();
  Eigen::Matrix<double, kMost, kMost> s =
      covariance_of<kMost>(k, linear.from.transpose(), by_globals);
  if (in_the_equations) {
    s = -s;
    s.diagonal().array() += kLeast;
  }
  s.diagonal().array() += 1;
  const linear_algebra::Cholesky<kMost> root(s);
  if (in_the_equations && !root.succeeded()) {
    return this->chi_square(placed, k);  // nothing else is known of what it says
  }
  const double chi_square = r.dot(root.solve(r));
  return std::isfinite(chi_square) ? chi_square : std::numeric_limits<double>::infinity();
}

Outcome FixedLagSmoother::Implementation::place(PlacedFactor& placed) {
  const double from_time = placed.factor.from_time();
  const double to_time = placed.factor.to_time();
  if (from_time < keyframe(0).time - kSameTime) {
    return Outcome::kLate;
  }
  const std::size_t from = keyframe_at(from_time);
  const std::size_t to = keyframe_at(to_time);
  if (to > from + 1) {
    return Outcome::kBadInterval;
  }
  Keyframe& place = keyframe(from);
  if (place.factors.size() == parameters_.max_factors_per_keyframe) {
    return Outcome::kFull;
  }
  placed.to_next = to != from;
  if (placed.to_next && rows_to_next(place) + placed.factor.rows() > kMaxRelativeRows) {
    return Outcome::kFull;
  }
  placed.motions.from = motion_to(from, from_time);
  if (to_time != from_time) {
    placed.motions.to = motion_to(to, to_time);
  }
  const double chi_square = this->chi_square(placed, from);
  if (!std::isfinite(chi_square)) {
    note(placed, Outcome::kQuarantined, chi_square);
    return Outcome::kQuarantined;
  }
  if (gate_of(placed) > 0 && from_time == to_time) {
    const double difference = innovation(placed, from, false);
    if (difference > gate_of(placed)) {
      note(placed, Outcome::kGated, difference);
      return Outcome::kGated;
    }
  }
  place.factors.push_back(placed);
  place.dirty = true;
  return Outcome::kAccepted;
}

void FixedLagSmoother::Implementation::place_waiting() {
  const double latest = newest().time + kSameTime;
  const auto place_those = [&](auto&& wanted) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < waiting_.size(); ++i) {
      if (wanted(waiting_[i])) {
        const Outcome outcome = place(waiting_[i]);
        if (outcome != Outcome::kAccepted && outcome != Outcome::kGated &&
            outcome != Outcome::kQuarantined) {
          note(waiting_[i], outcome, 0);
        }
      } else {
        if (kept != i) {
          waiting_[kept] = waiting_[i];
        }
        ++kept;
      }
    }
    waiting_.erase(waiting_.begin() + static_cast<std::ptrdiff_t>(kept), waiting_.end());
  };
  // What measures motion first: gates judge by it.
  place_those([&](const PlacedFactor& f) {
    return f.factor.to_time() <= latest && f.factor.from_time() != f.factor.to_time();
  });
  const bool gates = std::any_of(waiting_.begin(), waiting_.end(), [&](const PlacedFactor& f) {
    return f.factor.to_time() <= latest;
  });
  if (gates) {
    prepare();
    remember();
    bool sound = eliminate_sound();
    while (sound && !(substitute_globals() && substitute_state(count_ - 1, nullptr))) {
      sound = go_back_and_blame();
    }
    if (!sound) {
      throw std::runtime_error("the equations cannot be solved");
    }
  }
  place_those([&](const PlacedFactor& f) { return f.factor.to_time() <= latest; });
}

void FixedLagSmoother::Implementation::carry_ahead(double until) {
  integrate(newest().estimate, ahead_time_, until, ahead_);
  ahead_time_ = std::max(ahead_time_, until);
}

}  // namespace pipescout::estimation
