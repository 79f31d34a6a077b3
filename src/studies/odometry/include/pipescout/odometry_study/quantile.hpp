// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

namespace pipescout::odometry_study {

/// The least of the values that at least `part`, [0, 1], of them do not exceed; NaN without values.
[[nodiscard]] double quantile(std::vector<double> values, double part);

}  // namespace pipescout::odometry_study
