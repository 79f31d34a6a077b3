// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <ceres/cost_function.h>
#include <ceres/loss_function.h>

#include <utility>
#include <vector>

#include "manifolds.hpp"
#include "pipescout/estimation/carried_factor.hpp"
#include "pipescout/estimation/factors.hpp"
#include "pipescout/estimation/robustness.hpp"

/// The factors of pipescout_estimation as Ceres asks for them. Derivatives are over the tangent
/// space: see manifolds.hpp.
namespace pipescout::estimation {

/// Fills a block of Ceres's with derivatives by a tangent vector; null: it does not ask.
template <int Rows, int Columns, class Derivative>
void set_jacobian(const Derivative& derivative, double* block) {
  if (block == nullptr) {
    return;
  }
  Eigen::Map<Eigen::Matrix<double, Rows, Columns + 1, Eigen::RowMajor>> out(block);
  out.template leftCols<Columns>() = derivative;
  out.col(Columns).setZero();
}

/// Blocks: the keyframe of the measurement; that of its end, when that is another one; the globals,
/// when they are estimated and count.
class FactorCost final : public ceres::CostFunction {
 public:
  struct Ties {
    bool two_keyframes = false;
    bool globals = false;
  };

  /// `globals` are those of a factor that is not tied to them; they must outlive it.
  FactorCost(const AnyFactor& factor, const CarryingMotions& motions, const Gravity& gravity,
             const GlobalStates& globals, const Ties& ties);
  bool Evaluate(const double* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  AnyFactor factor_;
  CarryingMotions motions_;
  Gravity gravity_;
  const GlobalStates& globals_;
  Ties ties_;
};

/// Blocks: the keyframes at both ends; the globals, when the scale of the IMU counts and they are
/// estimated.
class ImuCost final : public ceres::CostFunction {
 public:
  /// `globals` are those of a factor that is not tied to them; they must outlive it.
  ImuCost(const ImuFactor& factor, const GlobalStates& globals, bool estimated);
  bool Evaluate(const double* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  ImuFactor factor_;
  const GlobalStates& globals_;
  bool tied_;
};

/// Block: the first keyframe.
class PriorCost final : public ceres::CostFunction {
 public:
  explicit PriorCost(const PriorFactor& factor);
  bool Evaluate(const double* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  PriorFactor factor_;
};

/// What is known of the globals beforehand; a row for each that is estimated. Block: the globals.
class GlobalPriorCost final : public ceres::CostFunction {
 public:
  GlobalPriorCost(const GlobalStates& mean, const GlobalVector& deviations,
                  std::vector<int> estimated);
  bool Evaluate(const double* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  GlobalStates mean_;
  GlobalVector deviations_;
  std::vector<int> estimated_;
};

/// A kernel as weights of reweighted least squares: no second derivative, as in FixedLagSmoother.
class KernelLoss final : public ceres::LossFunction {
 public:
  KernelLoss(statistics::RobustKernel kernel, double width) : kernel_(kernel), width_(width) {}
  void Evaluate(double square, double* out) const override;

 private:
  statistics::RobustKernel kernel_;
  double width_;
};

}  // namespace pipescout::estimation
