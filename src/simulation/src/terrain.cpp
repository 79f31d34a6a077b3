// SPDX-License-Identifier: Apache-2.0
#include "pipescout/simulation/terrain.hpp"

#include <cmath>
#include <numbers>
#include <string>

#include "pipescout/statistics/draw.hpp"
#include "pipescout/validation/check.hpp"

namespace pipescout::simulation {
namespace {

constexpr double kReference = 0.1;  // cycles/m
constexpr double kTwoPi = 2 * std::numbers::pi;
constexpr std::size_t kHillWaves = 12;
constexpr double kHillSpread = 3;  // longest / shortest wave

}  // namespace

double iso_8608_density(RoadClass road) noexcept {
  return 16e-6 * std::pow(4.0, static_cast<double>(road));
}

void TerrainParameters::validate() const {
  using validation::check_within;
  check_within("roughness", roughness, 0, 0.1);
  validation::check_above("longest", longest, shortest, 1e4);
  check_within("shortest", shortest, 0.01, longest);
  if (waves < 1 || waves > 10000) {
    validation::refuse("waves: ", waves, " is outside [1, 10000]");
  }
  check_within("hill_height", hill_height, 0, 1000);
  check_within("hill_length", hill_length, 10, 1e5);
  check_within("slope.x", slope.x(), -1, 1);
  check_within("slope.y", slope.y(), -1, 1);
}

Terrain::Terrain(const TerrainParameters& parameters, std::uint64_t seed)
    : parameters_(parameters) {
  parameters_.validate();
  auto engine = statistics::make_engine(seed, 5);
  const auto add = [&](double wave_number, double variance) {
    const double towards = statistics::uniform(engine, 0, kTwoPi);
    waves_.push_back(
        {.number = kTwoPi * wave_number * Eigen::Vector2d(std::cos(towards), std::sin(towards)),
         .amplitude = std::sqrt(2 * variance),
         .phase = statistics::uniform(engine, 0, kTwoPi)});
  };
  if (parameters_.roughness > 0) {
    // Variance by wave number, A / k^2. A wave of number k at an angle t to a line shows there as
    // n = k |cos t|; over all angles the line has (2 A / pi) / n^2 when there is no shortest wave.
    const double a = std::numbers::pi / 2 * parameters_.roughness * kReference * kReference;
    const auto count = static_cast<double>(parameters_.waves);
    const double ratio = std::pow(parameters_.longest / parameters_.shortest, 1 / count);
    double low = 1 / parameters_.longest;
    for (std::size_t i = 0; i < parameters_.waves; ++i) {
      add(low * std::pow(ratio, statistics::uniform(engine)), a * (1 / low - 1 / (low * ratio)));
      low *= ratio;
    }
  }
  if (parameters_.hill_height > 0) {
    const double variance = parameters_.hill_height * parameters_.hill_height / kHillWaves;
    for (std::size_t i = 0; i < kHillWaves; ++i) {
      add(std::pow(kHillSpread, -statistics::uniform(engine)) / parameters_.hill_length, variance);
    }
  }
}

Terrain::Place Terrain::at(const Eigen::Vector2d& place) const noexcept {
  Place result{.height = parameters_.slope.dot(place), .gradient = parameters_.slope};
  for (const Wave& wave : waves_) {
    const double angle = wave.number.dot(place) + wave.phase;
    result.height += wave.amplitude * std::sin(angle);
    result.gradient += wave.amplitude * std::cos(angle) * wave.number;
  }
  return result;
}

double Terrain::spectrum(double wave_number) const noexcept {
  const double share = wave_number * parameters_.shortest;
  if (!(wave_number * parameters_.longest >= 1 && share <= 1)) {
    return 0;
  }
  const double ratio = kReference / wave_number;
  return parameters_.roughness * ratio * ratio * std::sqrt(1 - share * share);
}

}  // namespace pipescout::simulation
