// SPDX-License-Identifier: Apache-2.0
#include "cost_functions.hpp"

#include <algorithm>
#include <cmath>

namespace pipescout::estimation {
namespace {

/// As `set_jacobian`, of the rows of a factor.
template <int Columns>
void set_rows(int rows, const FactorValue::Rows<Columns>& derivative, double* block) {
  if (block == nullptr) {
    return;
  }
  Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Columns + 1, Eigen::RowMajor>> out(block, rows,
                                                                                      Columns + 1);
  out.template leftCols<Columns>() = derivative.topRows(rows);
  out.col(Columns).setZero();
}

}  // namespace

FactorCost::FactorCost(const AnyFactor& factor, const CarryingMotions& motions,
                       const Gravity& gravity, const GlobalStates& globals, const Ties& ties)
    : factor_(factor), motions_(motions), gravity_(gravity), globals_(globals), ties_(ties) {
  set_num_residuals(factor.rows());
  mutable_parameter_block_sizes()->assign(ties.two_keyframes ? 2 : 1, kStateNumbers);
  if (ties.globals) {
    mutable_parameter_block_sizes()->push_back(kGlobalNumbers);
  }
}

bool FactorCost::Evaluate(const double* const* parameters, double* residuals,
                          double** jacobians) const {
  const std::size_t last = ties_.two_keyframes ? 1 : 0;
  const bool derive = jacobians != nullptr;
  FactorValue value;
  evaluate_carried(factor_, motions_, unpack_state(parameters[0]), unpack_state(parameters[last]),
                   ties_.globals ? unpack_globals(parameters[last + 1]) : globals_, gravity_,
                   derive, value);
  const int rows = value.rows;
  if (!value.residual.head(rows).allFinite() || (derive && !value.from.topRows(rows).allFinite())) {
    // Undefined here, a heading of a body that points up: it says nothing.
    value.residual.setZero();
    value.from.setZero();
    value.to.setZero();
    value.globals.setZero();
  }
  std::copy_n(value.residual.data(), rows, residuals);
  if (derive) {
    if (factor_.is_of_two_times() && !ties_.two_keyframes) {
      value.from.topRows(rows) += value.to.topRows(rows);
    }
    set_rows(rows, value.from, jacobians[0]);
    if (ties_.two_keyframes) {
      set_rows(rows, value.to, jacobians[1]);
    }
    if (ties_.globals) {
      set_rows(rows, value.globals, jacobians[last + 1]);
    }
  }
  return true;
}

ImuCost::ImuCost(const ImuFactor& factor, const GlobalStates& globals, bool estimated)
    : factor_(factor), globals_(globals), tied_(estimated && factor.motion().scaled()) {
  set_num_residuals(ImuFactor::kRows);
  mutable_parameter_block_sizes()->assign(2, kStateNumbers);
  if (tied_) {
    mutable_parameter_block_sizes()->push_back(kGlobalNumbers);
  }
}

bool ImuCost::Evaluate(const double* const* parameters, double* residuals,
                       double** jacobians) const {
  Jacobians<ImuFactor::kRows> d;
  Eigen::Map<ImuFactor::Residual> r(residuals);
  r = factor_.evaluate(unpack_state(parameters[0]), unpack_state(parameters[1]),
                       tied_ ? unpack_globals(parameters[2]) : globals_,
                       jacobians != nullptr ? &d : nullptr);
  if (jacobians != nullptr) {
    set_jacobian<ImuFactor::kRows, kStateSize>(d.from, jacobians[0]);
    set_jacobian<ImuFactor::kRows, kStateSize>(d.to, jacobians[1]);
    if (tied_) {
      set_jacobian<ImuFactor::kRows, kGlobalSize>(d.globals, jacobians[2]);
    }
  }
  return r.allFinite();
}

PriorCost::PriorCost(const PriorFactor& factor) : factor_(factor) {
  set_num_residuals(PriorFactor::kRows);
  mutable_parameter_block_sizes()->assign(1, kStateNumbers);
}

bool PriorCost::Evaluate(const double* const* parameters, double* residuals,
                         double** jacobians) const {
  Jacobians<PriorFactor::kRows> d;
  Eigen::Map<StateVector> r(residuals);
  r = factor_.evaluate(unpack_state(parameters[0]), jacobians != nullptr ? &d : nullptr);
  if (jacobians != nullptr) {
    set_jacobian<PriorFactor::kRows, kStateSize>(d.from, jacobians[0]);
  }
  return r.allFinite();
}

GlobalPriorCost::GlobalPriorCost(const GlobalStates& mean, const GlobalVector& deviations,
                                 std::vector<int> estimated)
    : mean_(mean), deviations_(deviations), estimated_(std::move(estimated)) {
  set_num_residuals(static_cast<int>(estimated_.size()));
  mutable_parameter_block_sizes()->assign(1, kGlobalNumbers);
}

bool GlobalPriorCost::Evaluate(const double* const* parameters, double* residuals,
                               double** jacobians) const {
  const GlobalVector r = mean_.local(unpack_globals(parameters[0]));
  Eigen::Matrix<double, kGlobalSize, kGlobalSize> d;
  d.setIdentity();
  d.block<3, 3>(kRackRotation, kRackRotation) =
      geometry::SO3::right_jacobian_inverse(r.segment<3>(kRackRotation));
  for (std::size_t i = 0; i < estimated_.size(); ++i) {
    const int place = estimated_[i];
    residuals[i] = r[place] / deviations_[place];
    if (jacobians != nullptr && jacobians[0] != nullptr) {
      const Eigen::Matrix<double, 1, kGlobalSize> row = d.row(place) / deviations_[place];
      set_jacobian<1, kGlobalSize>(row, jacobians[0] + i * kGlobalNumbers);
    }
  }
  return r.allFinite();
}

void KernelLoss::Evaluate(double square, double* out) const {
  const statistics::KernelValue value = evaluate(kernel_, std::sqrt(std::max(square, 0.0)), width_);
  out[0] = 2 * value.cost;
  out[1] = value.weight;
  out[2] = 0;
}

}  // namespace pipescout::estimation
