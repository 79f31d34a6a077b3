// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace pipescout::statistics {

/// Half of the width of the central 95 % of a normal distribution, in standard deviations: the
/// square root of chi_square_quantile(0.95, 1).
inline constexpr double kNormal95 = 1.959963984540054;

}  // namespace pipescout::statistics
