// SPDX-License-Identifier: Apache-2.0
#include "pipescout/simulation/terrain.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>
#include <stdexcept>

namespace pipescout::simulation {
namespace {

using Eigen::Vector2d;

constexpr double kPi = std::numbers::pi;

/// One-sided power density along a line at wave numbers k / length, through a Hann window.
std::vector<double> periodogram(const Terrain& terrain, const Vector2d& from, double towards,
                                double length, double spacing, const std::vector<int>& bins) {
  const int count = static_cast<int>(std::lround(length / spacing));
  const Vector2d along(std::cos(towards), std::sin(towards));
  std::vector<double> heights;
  double power = 0;
  for (int i = 0; i < count; ++i) {
    const double window = 1 - std::cos(2 * kPi * (i + 0.5) / count);
    heights.push_back(window * terrain.at(from + i * spacing * along).height);
    power += window * window;
  }
  std::vector<double> density;
  for (const int bin : bins) {
    std::complex<double> sum = 0;
    for (int i = 0; i < count; ++i) {
      sum += std::polar(heights[static_cast<std::size_t>(i)], -2 * kPi * bin * i / count);
    }
    density.push_back(2 * spacing * std::norm(sum) / power);
  }
  return density;
}

TEST(Terrain, HasTheSpectrumOfItsClassInEveryDirection) {
  // 100 m lines, bins that are 1/100 cycle/m wide; grounds are independent of each other.
  const std::vector<int> bins{4, 6, 9, 13, 19, 28, 40, 60, 90, 130, 190};
  constexpr int kGrounds = 400;
  for (const RoadClass road : {RoadClass::kC, RoadClass::kD, RoadClass::kE}) {
    const TerrainParameters parameters{.roughness = iso_8608_density(road)};
    std::vector<double> mean(bins.size());
    std::vector<double> square(bins.size());
    for (int i = 0; i < kGrounds; ++i) {
      const Terrain terrain(parameters, static_cast<std::uint64_t>(i));
      const auto density = periodogram(terrain, {3.0 * i, -7.0 * i}, 0.1 * i, 100, 0.125, bins);
      for (std::size_t k = 0; k < bins.size(); ++k) {
        mean[k] += density[k] / kGrounds;
        square[k] += density[k] * density[k] / kGrounds;
      }
    }
    const Terrain any(parameters, 0);
    for (std::size_t k = 0; k < bins.size(); ++k) {
      const double expected = any.spectrum(0.01 * bins[k]);
      const double deviation = std::sqrt((square[k] - mean[k] * mean[k]) / kGrounds);
      // The window smears a falling spectrum over its neighbours: less than 4 % from bin 4 on.
      EXPECT_NEAR(mean[k], expected, 4 * deviation + 0.04 * expected) << 0.01 * bins[k];
      EXPECT_LT(deviation, 0.25 * expected);
    }
  }
}

TEST(Terrain, ClassesAreThoseOfTheStandard) {
  EXPECT_DOUBLE_EQ(iso_8608_density(RoadClass::kA), 16e-6);
  EXPECT_DOUBLE_EQ(iso_8608_density(RoadClass::kC), 256e-6);
  EXPECT_DOUBLE_EQ(iso_8608_density(RoadClass::kE), 4096e-6);
  const Terrain terrain({.roughness = 256e-6, .shortest = 0.01}, 1);
  EXPECT_NEAR(terrain.spectrum(0.1), 256e-6, 1e-9);
  EXPECT_NEAR(terrain.spectrum(1), 2.56e-6, 1e-9);
  EXPECT_EQ(terrain.spectrum(0.001), 0);
  EXPECT_EQ(terrain.spectrum(200), 0);
}

TEST(Terrain, GradientIsThatOfTheHeight) {
  const Terrain terrain({.hill_height = 3, .slope = {0.1, -0.05}}, 5);
  constexpr double kStep = 1e-5;
  for (int i = 0; i < 50; ++i) {
    const Vector2d place(1.7 * i, -0.9 * i);
    const auto slope = [&](const Vector2d& step) {
      return (terrain.at(place + step).height - terrain.at(place - step).height) / (2 * kStep);
    };
    const Vector2d numeric(slope({kStep, 0}), slope({0, kStep}));
    EXPECT_LT((numeric - terrain.at(place).gradient).norm(), 1e-6);
  }
}

TEST(Terrain, HillsHaveTheirHeight) {
  double square = 0;
  constexpr int kGrounds = 400;
  for (int i = 0; i < kGrounds; ++i) {
    const Terrain terrain({.roughness = 0, .hill_height = 2}, static_cast<std::uint64_t>(i));
    square += std::pow(terrain.at({10, 20}).height, 2) / kGrounds;
  }
  // A square of a sum of 12 sines: relative deviation about sqrt(2 / 400).
  EXPECT_NEAR(square, 4, 4 * 4 * std::sqrt(2.0 / kGrounds));
}

TEST(Terrain, APlaneIsAPlane) {
  const Terrain terrain({.roughness = 0, .slope = {0.2, 0.1}}, 1);
  EXPECT_DOUBLE_EQ(terrain.at({10, -5}).height, 1.5);
  EXPECT_EQ(terrain.at({10, -5}).gradient, Vector2d(0.2, 0.1));
}

TEST(Terrain, RefusesNonsense) {
  EXPECT_THROW(Terrain({.roughness = -1}, 1), std::invalid_argument);
  EXPECT_THROW(Terrain({.longest = 0.2}, 1), std::invalid_argument);
  EXPECT_THROW(Terrain({.waves = 0}, 1), std::invalid_argument);
  EXPECT_THROW(Terrain({.hill_height = NAN}, 1), std::invalid_argument);
  EXPECT_THROW(Terrain({.slope = {2, 0}}, 1), std::invalid_argument);
}

}  // namespace
}  // namespace pipescout::simulation
