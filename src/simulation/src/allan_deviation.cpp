// SPDX-License-Identifier: Apache-2.0
#include "pipescout/simulation/allan_deviation.hpp"

#include <cmath>

#include "pipescout/validation/check.hpp"

namespace pipescout::simulation {
namespace {

void check(std::size_t samples, std::size_t cluster) {
  if (cluster < 1 || 2 * cluster > samples) {
    validation::refuse("cluster: ", cluster, " is outside [1, ", samples / 2, "]");
  }
}

}  // namespace

double allan_deviation(std::span<const double> samples, std::size_t cluster) {
  check(samples.size(), cluster);
  // Sums over the two neighbouring clusters are carried along.
  double first = 0;
  double second = 0;
  for (std::size_t i = 0; i < cluster; ++i) {
    first += samples[i];
    second += samples[i + cluster];
  }
  const std::size_t pairs = samples.size() - 2 * cluster + 1;
  double squares = 0;
  for (std::size_t i = 0; i < pairs; ++i) {
    squares += (second - first) * (second - first);
    if (i + 1 < pairs) {
      first += samples[i + cluster] - samples[i];
      second += samples[i + 2 * cluster] - samples[i + cluster];
    }
  }
  return std::sqrt(squares / (2.0 * static_cast<double>(pairs))) / static_cast<double>(cluster);
}

double allan_degrees_of_freedom(AllanNoise noise, std::size_t samples, std::size_t cluster) {
  check(samples, cluster);
  const double n = static_cast<double>(samples) + 1;  // of phases
  const double m = static_cast<double>(cluster);
  switch (noise) {
    case AllanNoise::kWhite:
      return (3 * (n - 1) / (2 * m) - 2 * (n - 2) / n) * 4 * m * m / (4 * m * m + 5);
    case AllanNoise::kFlicker:
      return cluster == 1 ? 2 * (n - 2) * (n - 2) / (2.3 * n - 4.9)
                          : 5 * n * n / (4 * m * (n + 3 * m));
    case AllanNoise::kRandomWalk:
      return (n - 2) / m * ((n - 1) * (n - 1) - 3 * m * (n - 1) + 4 * m * m) / ((n - 3) * (n - 3));
  }
  throw std::invalid_argument("noise: not an enumerator of AllanNoise");
}

}  // namespace pipescout::simulation
