// SPDX-License-Identifier: Apache-2.0
// From factors to normal equations.
#include <cmath>

#include "pipescout/linear_algebra/products.hpp"
#include "smoother_implementation.hpp"

namespace pipescout::estimation {

double FixedLagSmoother::Implementation::linearise(const PlacedFactor& placed, std::size_t k,
                                                   FactorValue& linear) const {
  const Keyframe& from = keyframe(k);
  const Keyframe& to = placed.to_next ? keyframe(k + 1) : from;
  const AnyFactor& factor = placed.factor;
  evaluate_carried(factor, placed.motions, from.linear, to.linear, linear_globals_, gravity(), true,
                   linear);
  FactorValue there;
  evaluate_carried(factor, placed.motions, from.estimate, to.estimate, globals_, gravity(), false,
                   there);
  for (int row = 0; row < linear.rows; ++row) {
    linear.residual[row] = there.residual[row] - linear.from.row(row).dot(from.delta);
    if (factor.is_of_two_times()) {
      linear.residual[row] -= linear.to.row(row).dot(to.delta);
    }
    if (!estimated_.empty()) {
      linear.residual[row] -= linear.globals.row(row).dot(global_delta_);
    }
  }
  if (factor.is_of_two_times() && !placed.to_next) {
    linear.from.topRows(linear.rows) += linear.to.topRows(linear.rows);
    linear.to.topRows(linear.rows).setZero();
  }
  return there.residual.head(there.rows).squaredNorm();
}

double FixedLagSmoother::Implementation::chi_square(const PlacedFactor& placed,
                                                    std::size_t k) const {
  const Keyframe& from = keyframe(k);
  const Keyframe& to = placed.to_next ? keyframe(k + 1) : from;
  return estimation::chi_square(placed.factor, placed.motions, from.estimate, to.estimate, globals_,
                                gravity());
}

statistics::KernelValue FixedLagSmoother::Implementation::kernel(const PlacedFactor& placed,
                                                                 double chi_square) const {
  const Robustness& robustness = parameters_.robustness[index_of(placed.factor.kind())];
  return evaluate(robustness.kernel, std::sqrt(chi_square), robustness.width);
}

CornerVector FixedLagSmoother::Implementation::estimated_part(const GlobalVector& all) const {
  CornerVector part(static_cast<Eigen::Index>(estimated_.size()));
  for (Eigen::Index i = 0; i < part.size(); ++i) {
    part[i] = all[estimated_[static_cast<std::size_t>(i)]];
  }
  return part;
}

GlobalVector FixedLagSmoother::Implementation::whole(const CornerVector& part) const {
  GlobalVector all = GlobalVector::Zero();
  for (Eigen::Index i = 0; i < part.size(); ++i) {
    all[estimated_[static_cast<std::size_t>(i)]] = part[i];
  }
  return all;
}

bool FixedLagSmoother::Implementation::may_judge(const PlacedFactor& placed) const noexcept {
  // A kernel judges by the residual alone. After some time without the IMU it is the velocity that
  // is uncertain, and what measures it would be rejected for contradicting a guess: it is fitted
  // first, and judged by what remains.
  return placed.judged || !placed.to_next || !has_coasted();
}

bool FixedLagSmoother::Implementation::has_coasted() const noexcept {
  for (std::size_t k = 0; k < count_; ++k) {
    if (keyframe(k).coasted > 0) {
      return true;
    }
  }
  return false;
}

void FixedLagSmoother::Implementation::linearise_prior() {
  Message& in = keyframe(0).in;
  const auto globals = static_cast<int>(estimated_.size());
  if (prior_) {
    Jacobians<kStateSize> d;
    prior_->evaluate(keyframe(0).linear, &d);
    const StateVector r = prior_->evaluate(keyframe(0).estimate) - d.from * keyframe(0).delta;
    in.set_zero(globals);
    in.h = linear_algebra::information_of<kStateSize>(d.from);
    in.b = -d.from.transpose() * r;
  }
  // Of those that are not bound nothing but their own prior is known, so that it can be taken anew.
  Eigen::Matrix<double, kGlobalSize, kGlobalSize> d =
      Eigen::Matrix<double, kGlobalSize, kGlobalSize>::Identity();
  const GlobalVector there = parameters_.globals.local(linear_globals_);
  d.block<3, 3>(kRackRotation, kRackRotation) =
      geometry::SO3::right_jacobian_inverse(there.segment<3>(kRackRotation));
  const GlobalVector r = parameters_.globals.local(globals_) - d * global_delta_;
  for (int i = 0; i < globals; ++i) {
    if (!bound_[estimated_[static_cast<std::size_t>(i)]]) {
      in.corner.row(i).setZero();
      in.corner.col(i).setZero();
      in.corner_b[i] = 0;
    }
  }
  for (int i = 0; i < globals; ++i) {
    const int place = estimated_[static_cast<std::size_t>(i)];
    if (bound_[place]) {
      continue;
    }
    const GlobalVector row = d.row(place);
    const CornerVector part = estimated_part(row);
    const double information = global_information_[place];
    in.corner += information * part * part.transpose();
    in.corner_b -= information * r[place] * part;
  }
}

void FixedLagSmoother::Implementation::linearise_clique(std::size_t k) {
  Keyframe& from = keyframe(k);
  const auto globals = static_cast<int>(estimated_.size());
  from.clique.set_zero(globals);
  from.linearised_delta = from.delta;
  from.dirty = false;
  if (from.link) {
    const Keyframe& to = keyframe(k + 1);
    Jacobians<ImuFactor::kRows> d;
    from.link->evaluate(from.linear, to.linear, linear_globals_, &d);
    StateVector r = from.link->evaluate(from.estimate, to.estimate, globals_) -
                    d.from * from.delta - d.to * to.delta;
    const Block by_from = d.from;
    const Block by_to = d.to;
    CornerVector by_globals(0);
    if (imu_scaled_) {
      r.noalias() -= d.globals * global_delta_;
    }
    for (int row = 0; row < kStateSize; ++row) {
      if (imu_scaled_) {
        const GlobalVector all = d.globals.row(row);
        by_globals = estimated_part(all);
      }
      add_row(from.clique, by_from.data() + row * kStateSize, by_to.data() + row * kStateSize,
              by_globals, r[row]);
    }
  }
  FactorValue linear;
  for (PlacedFactor& placed : from.factors) {
    const double chi_square = linearise(placed, k, linear);
    placed.weight = may_judge(placed) ? kernel(placed, chi_square).weight : 1;
    placed.judged = true;
    const double scale = std::sqrt(placed.weight);
    if (!std::isfinite(scale) || !linear.residual.head(linear.rows).allFinite() ||
        !linear.from.topRows(linear.rows).allFinite()) {
      placed.weight = 0;  // undefined here: a heading of a body that points up
      continue;
    }
    for (int row = 0; row < linear.rows; ++row) {
      linear.from.row(row) *= scale;
      linear.to.row(row) *= scale;
      const GlobalVector by_globals = scale * linear.globals.row(row);
      const double* to = placed.to_next ? linear.to.data() + row * kStateSize : nullptr;
      add_row(from.clique, linear.from.data() + row * kStateSize, to, estimated_part(by_globals),
              scale * linear.residual[row]);
    }
  }
}

double FixedLagSmoother::Implementation::cost() const {
  const Keyframe& oldest = keyframe(0);
  const CornerVector globals = estimated_part(global_delta_);
  double sum = 0.5 * oldest.delta.dot(oldest.in.h * oldest.delta) - oldest.in.b.dot(oldest.delta);
  if (globals.size() > 0) {
    sum += 0.5 * globals.dot(oldest.in.corner * globals) - oldest.in.corner_b.dot(globals) +
           oldest.delta.dot(oldest.in.border * globals);
  }
  for (std::size_t k = 0; k < count_; ++k) {
    const Keyframe& from = keyframe(k);
    if (from.link) {
      sum += 0.5 *
             from.link->evaluate(from.estimate, keyframe(k + 1).estimate, globals_).squaredNorm();
    }
    for (const PlacedFactor& placed : from.factors) {
      if (placed.weight > 0) {
        sum += kernel(placed, chi_square(placed, k)).cost;
      }
    }
  }
  return sum;
}

}  // namespace pipescout::estimation
