// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pipescout/statistics/robust_kernel.hpp"

namespace pipescout::estimation {

/// What is done about measurements of one kind that do not fit: a weight in the equations, and a
/// consistency gate before. Residuals are in standard deviations.
struct Robustness {
  /// Not kTukey, whose weight of an outlier is 0: leaving out is for the gate.
  statistics::RobustKernel kernel = statistics::RobustKernel::kNone;
  double width = 1;  ///< standard deviations, in [1e-3, 1e3]
  /// The share of good measurements that the gate lets through; in (0, 1], 1: no gate.
  double gate_probability = 1;

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

}  // namespace pipescout::estimation
