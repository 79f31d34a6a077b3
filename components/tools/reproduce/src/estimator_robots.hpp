// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "pipescout/estimation_study/vehicle_run.hpp"

namespace pipescout::reproduce {

struct Robot {
  estimation_study::Vehicle vehicle;
  const char* name;     ///< of figures
  const char* article;  ///< of studies
  std::vector<estimation_study::Sensor> sensors;
};

/// The three of which the state estimator is scored.
[[nodiscard]] const std::vector<Robot>& robots();
[[nodiscard]] const char* name_of(estimation_study::Sensor sensor);

/// Root mean square of root mean squares; of at least one.
[[nodiscard]] double pooled(const std::vector<double>& root_mean_squares);

}  // namespace pipescout::reproduce
