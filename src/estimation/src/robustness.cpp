// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation/robustness.hpp"

#include "pipescout/validation/check.hpp"

namespace pipescout::estimation {

void Robustness::validate() const {
  using statistics::RobustKernel;
  validation::require("robustness.kernel", static_cast<double>(kernel),
                      kernel < RobustKernel::kTukey, "none, saliency, huber, cauchy");
  validation::check_within("robustness.width", width, 1e-3, 1e3);
  validation::check_above("robustness.gate_probability", gate_probability, 0, 1);
}

}  // namespace pipescout::estimation
