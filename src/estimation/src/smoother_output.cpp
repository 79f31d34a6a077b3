// SPDX-License-Identifier: Apache-2.0
// Covariances and reports.
#include "pipescout/linear_algebra/products.hpp"
#include "smoother_implementation.hpp"

namespace pipescout::estimation {

StateMatrix FixedLagSmoother::Implementation::covariance(std::size_t k) const noexcept {
  using ByGlobals = GlobalRows<kStateSize>;
  return covariance_of<kStateSize>(
      k, StateMatrix::Identity(),
      ByGlobals::Zero(static_cast<Eigen::Index>(estimated_.size()), kStateSize));
}

Eigen::Matrix<double, kGlobalSize, kGlobalSize>
FixedLagSmoother::Implementation::global_covariance() const noexcept {
  Eigen::Matrix<double, kGlobalSize, kGlobalSize> all;
  all.setZero();
  const auto size = static_cast<Eigen::Index>(estimated_.size());
  Corner inverse = Corner::Identity(size, size);
  corner_root_.triangularView<Eigen::Lower>().solveInPlace(inverse);
  for (Eigen::Index i = 0; i < size; ++i) {
    for (Eigen::Index j = 0; j < size; ++j) {
      all(estimated_[static_cast<std::size_t>(i)], estimated_[static_cast<std::size_t>(j)]) =
          inverse.col(i).dot(inverse.col(j));
    }
  }
  return all;
}

std::optional<FixedLagSmoother::Propagated> FixedLagSmoother::Implementation::propagated()
    const noexcept {
  if (count_ == 0) {
    return std::nullopt;
  }
  return Propagated{
      .time = ahead_time_,
      .state = ahead_.motion().propagate(newest().estimate, globals_.imu_scale, gravity())};
}

StateMatrix FixedLagSmoother::Implementation::propagated_covariance() const noexcept {
  StateMatrix by_newest;
  ImuMotion::ScaleJacobian by_scale;
  ahead_.motion().propagate(newest().estimate, globals_.imu_scale, gravity(), &by_newest,
                            &by_scale);
  const Eigen::Matrix3d r = newest().estimate.R_map_body.matrix();
  StateMatrix to_map = StateMatrix::Identity();
  to_map.block<3, 3>(kPosition, kPosition) = r;
  to_map.block<3, 3>(kVelocity, kVelocity) = r;
  GlobalRows<kStateSize> by_globals(static_cast<Eigen::Index>(estimated_.size()), kStateSize);
  by_globals.setZero();
  if (imu_scaled_) {
    for (Eigen::Index i = 0; i < by_globals.rows(); ++i) {
      const int place = estimated_[static_cast<std::size_t>(i)];
      if (place >= kImuScale && place < kOwnStates) {
        by_globals.row(i).head<9>() = by_scale.col(place - kImuScale).transpose();
      }
    }
  }
  return covariance_of<kStateSize>(count_ - 1, by_newest.transpose(), by_globals) +
         linear_algebra::propagate(to_map, ahead_.covariance());
}

FactorReport FixedLagSmoother::Implementation::report_of(const PlacedFactor& placed) const {
  return {.kind = placed.factor.kind(),
          .time = placed.factor.to_time(),
          .degrees = placed.factor.rows()};
}

void FixedLagSmoother::Implementation::note(const PlacedFactor& placed, Outcome outcome,
                                            double chi_square) {
  FactorReport report = report_of(placed);
  count(report.kind, outcome);
  report.outcome = outcome;
  report.chi_square = chi_square;
  report.weight = outcome == Outcome::kAccepted ? placed.weight : 0;
  report_.factors.push_back(report);
}

void FixedLagSmoother::Implementation::note_fresh() {
  for (std::size_t k = 0; k < count_; ++k) {
    for (PlacedFactor& placed : keyframe(k).factors) {
      if (placed.fresh) {
        placed.fresh = false;
        note(placed, Outcome::kAccepted, chi_square(placed, k));
      }
    }
  }
}

void FixedLagSmoother::Implementation::report_factors(std::vector<FactorReport>& reports) const {
  reports.clear();
  for (std::size_t k = 0; k < count_; ++k) {
    const Keyframe& here = keyframe(k);
    for (const PlacedFactor& placed : here.factors) {
      FactorReport report = report_of(placed);
      report.chi_square = chi_square(placed, k);
      report.weight = placed.weight;
      reports.push_back(report);
    }
    if (here.link) {
      const Keyframe& next = keyframe(k + 1);
      reports.push_back(
          {.kind = FactorKind::kImu,
           .time = next.time,
           .chi_square = here.link->evaluate(here.estimate, next.estimate, globals_).squaredNorm(),
           .degrees = ImuFactor::kRows});
    }
  }
}

}  // namespace pipescout::estimation
