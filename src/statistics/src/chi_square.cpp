// SPDX-License-Identifier: Apache-2.0
#include "pipescout/statistics/chi_square.hpp"

#include <boost/math/distributions/chi_squared.hpp>

#include "pipescout/validation/check.hpp"

namespace pipescout::statistics {
namespace {

using boost::math::chi_squared_distribution;

chi_squared_distribution<double> chi_squared(double degrees) {
  validation::require("degrees", degrees, degrees > 0, "(0, inf)");
  return chi_squared_distribution<double>(degrees);
}

}  // namespace

double chi_square_probability(double value, double degrees) {
  validation::require("value", value, value >= 0, "[0, inf)");
  return boost::math::cdf(chi_squared(degrees), value);
}

double chi_square_quantile(double probability, double degrees) {
  validation::check_between("probability", probability, 0, 1);
  return boost::math::quantile(chi_squared(degrees), probability);
}

}  // namespace pipescout::statistics
