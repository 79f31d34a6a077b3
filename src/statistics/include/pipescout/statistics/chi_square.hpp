// SPDX-License-Identifier: Apache-2.0
#pragma once

/// The chi-square distribution, by Boost.Math. Compiled here once, as its headers are large.
namespace pipescout::statistics {

/// The probability that a chi-square variable is at most `value`. Throws std::invalid_argument
/// unless `degrees` is above 0 and `value` at least 0, both finite.
[[nodiscard]] double chi_square_probability(double value, double degrees);

/// Its inverse. Throws std::invalid_argument unless `degrees` is above 0 and finite and
/// `probability` in (0, 1).
[[nodiscard]] double chi_square_quantile(double probability, double degrees);

}  // namespace pipescout::statistics
