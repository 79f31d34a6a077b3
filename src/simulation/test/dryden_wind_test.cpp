// SPDX-License-Identifier: Apache-2.0
#include "pipescout/simulation/dryden_wind.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <complex>
#include <cstdint>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>
#include <unsupported/Eigen/FFT>
#include <vector>

namespace pipescout::simulation {
namespace {

constexpr double kPi = std::numbers::pi;

/// u, v, w, p, q, r without the mean wind.
using Gust = std::array<double, 6>;

std::vector<Gust> gusts(const DrydenWindParameters& parameters, std::uint64_t seed,
                        std::size_t samples) {
  DrydenWind wind(parameters, seed);
  std::vector<Gust> result;
  result.reserve(samples);
  for (std::size_t i = 0; i < samples; ++i) {
    const WindSample sample = wind.next();
    result.push_back({sample.velocity.x() - wind.model().mean_speed, sample.velocity.y(),
                      sample.velocity.z(), sample.rotation_rate.x(), sample.rotation_rate.y(),
                      sample.rotation_rate.z()});
  }
  return result;
}

double spectrum(const DrydenModel& model, std::size_t component, double angular_frequency) {
  const auto row = static_cast<Eigen::Index>(component % 3);
  return component < 3 ? model.velocity_spectrum(angular_frequency)[row]
                       : model.rotation_spectrum(angular_frequency)[row];
}

/// Of samples `period` apart: what lies beyond the Nyquist frequency is folded back.
double folded_spectrum(const DrydenModel& model, std::size_t component, double angular_frequency,
                       double period) {
  constexpr int kFolds = 300;
  const double rate = 2 * kPi / period;
  double sum = spectrum(model, component, angular_frequency);
  for (int k = 1; k <= kFolds; ++k) {
    sum += spectrum(model, component, k * rate - angular_frequency) +
           spectrum(model, component, k * rate + angular_frequency);
  }
  return sum;
}

/// Integral of a spectrum over [0, inf), by the substitution angular frequency = tan(x) / time.
double variance(const DrydenModel& model, std::size_t component, double time) {
  constexpr int kSteps = 200000;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double x = (i + 0.5) * (kPi / 2) / kSteps;
    const double jacobian = 1 / (std::cos(x) * std::cos(x) * time);
    sum += spectrum(model, component, std::tan(x) / time) * jacobian * (kPi / 2) / kSteps;
  }
  return sum;
}

/// Welch's estimate with Hann windows that overlap by half; one-sided, per rad/s. Entry i is that
/// at the angular frequency 2 pi i / (length period).
std::vector<double> welch(const std::vector<Gust>& samples, std::size_t component,
                          std::size_t length, double period) {
  std::vector<double> window(length);
  double power = 0;
  for (std::size_t i = 0; i < length; ++i) {
    window[i] =
        0.5 * (1 - std::cos(2 * kPi * static_cast<double>(i) / static_cast<double>(length)));
    power += window[i] * window[i];
  }
  Eigen::FFT<double> transform;
  std::vector<double> segment(length);
  std::vector<std::complex<double>> frequency(length);
  std::vector<double> estimate(length / 2, 0);
  int segments = 0;
  for (std::size_t begin = 0; begin + length <= samples.size(); begin += length / 2, ++segments) {
    for (std::size_t i = 0; i < length; ++i) {
      segment[i] = window[i] * samples[begin + i][component];
    }
    transform.fwd(frequency, segment);
    for (std::size_t i = 0; i < estimate.size(); ++i) {
      estimate[i] += std::norm(frequency[i]);
    }
  }
  for (double& entry : estimate) {
    entry *= period / (kPi * power * segments);
  }
  return estimate;
}

TEST(DrydenModel, HasTheStandardsScalesAndIntensities) {
  // MIL-F-8785C by hand for 100 ft: 0.177 + 0.0823 = 0.2593; 0.2593^1.2 = 0.19796, ^0.4 = 0.58281.
  const DrydenModel model =
      dryden_model({.speed_at_20_feet = 15, .height = 100 * 0.3048, .vehicle_speed = 10});
  EXPECT_NEAR(model.length_scale.x(), 100 / 0.19796 * 0.3048, 0.01);
  EXPECT_EQ(model.length_scale.y(), model.length_scale.x());
  EXPECT_NEAR(model.length_scale.z(), 100 * 0.3048, 1e-9);
  EXPECT_NEAR(model.intensity.x(), 1.5 / 0.58281, 1e-4);
  EXPECT_EQ(model.intensity.y(), model.intensity.x());
  EXPECT_NEAR(model.intensity.z(), 1.5, 1e-12);
  EXPECT_NEAR(model.mean_speed, 15 * std::log(100 / 0.15) / std::log(20 / 0.15), 1e-9);
  EXPECT_NEAR(model.airspeed, model.mean_speed + 10, 1e-12);
}

TEST(DrydenModel, MeetsTheMediumAltitudeModelWhereTheyJoin) {
  // At 1000 ft the standard's low-altitude model is isotropic: L = 1000 ft, equal intensities.
  const DrydenModel model = dryden_model({.speed_at_20_feet = 10, .height = 304.8});
  EXPECT_NEAR(model.length_scale.x(), 304.8, 1e-6);
  EXPECT_NEAR(model.length_scale.z(), 304.8, 1e-6);
  EXPECT_NEAR(model.intensity.x(), model.intensity.z(), 1e-9);
}

TEST(DrydenModel, IsThatOfTenFeetBelow) {
  const DrydenModel low = dryden_model({.height = 0});
  const DrydenModel ten_feet = dryden_model({.height = 3.048});
  EXPECT_EQ(low.length_scale, ten_feet.length_scale);
  EXPECT_EQ(low.mean_speed, ten_feet.mean_speed);
}

TEST(DrydenModel, TakesAFloorForTheAirspeedOfAHoveringVehicle) {
  EXPECT_EQ(dryden_model({.speed_at_20_feet = 0, .smallest_airspeed = 0.7}).airspeed, 0.7);
}

TEST(DrydenModel, SpectraOfTheVelocityIntegrateToTheIntensities) {
  const DrydenModel model = dryden_model({.speed_at_20_feet = 8, .height = 5});
  for (std::size_t i = 0; i < 3; ++i) {
    const double sigma = model.intensity[static_cast<Eigen::Index>(i)];
    const double time = model.length_scale[static_cast<Eigen::Index>(i)] / model.airspeed;
    EXPECT_NEAR(variance(model, i, time) / (sigma * sigma), 1, 1e-6) << i;
  }
}

TEST(DrydenWindParameters, RejectsWhatIsOutOfRange) {
  const auto message = [](const DrydenWindParameters& parameters) -> std::string {
    try {
      parameters.validate();
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  using testing::HasSubstr;
  EXPECT_EQ(message({}), "");
  EXPECT_THAT(message({.speed_at_20_feet = -1}), HasSubstr("speed_at_20_feet: -1"));
  EXPECT_THAT(message({.direction = std::numeric_limits<double>::infinity()}),
              HasSubstr("direction"));
  EXPECT_THAT(message({.height = 305}), HasSubstr("height: 305"));
  EXPECT_THAT(message({.vehicle_speed = -0.1}), HasSubstr("vehicle_speed"));
  EXPECT_THAT(message({.smallest_airspeed = 0}), HasSubstr("smallest_airspeed: 0"));
  EXPECT_THAT(message({.span = 0}), HasSubstr("span"));
  EXPECT_THAT(message({.period = std::nan("")}), HasSubstr("period"));
  EXPECT_THROW(DrydenWind({.period = 0}, 1), std::invalid_argument);
}

TEST(DrydenWind, BlowsInItsDirectionWithTheMeanSpeed) {
  DrydenWind wind({.speed_at_20_feet = 0, .direction = 1}, 3);
  EXPECT_EQ(wind.next().velocity.norm(), 0);

  DrydenWindParameters parameters{.speed_at_20_feet = 6, .direction = 2.5, .period = 1};
  DrydenWind stronger(parameters, 3);
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  constexpr int kSamples = 200000;
  for (int i = 0; i < kSamples; ++i) {
    mean += stronger.next().velocity / kSamples;
  }
  // sigma_u = 1.2 m/s over 2e5 s of a time constant of 4 s: the mean is good to 0.008 m/s.
  const Eigen::Vector3d expected =
      stronger.model().mean_speed * Eigen::Vector3d(std::cos(2.5), std::sin(2.5), 0);
  EXPECT_LT((mean - expected).norm(), 0.04);
}

TEST(DrydenWind, IsTheSameForTheSameSeed) {
  DrydenWind first({}, 7);
  DrydenWind second({}, 7);
  DrydenWind other({}, 8);
  bool differs = false;
  for (int i = 0; i < 1000; ++i) {
    const WindSample sample = first.next();
    const WindSample same = second.next();
    ASSERT_EQ(sample.velocity, same.velocity);
    ASSERT_EQ(sample.rotation_rate, same.rotation_rate);
    differs = differs || sample.velocity != other.next().velocity;
  }
  EXPECT_TRUE(differs);
}

TEST(DrydenWind, StartsAsItGoesOn) {
  // The variance over many seeds at the first sample, and after a while, is the model's.
  const DrydenWindParameters parameters{.speed_at_20_feet = 10, .height = 10, .period = 0.5};
  const DrydenModel model = dryden_model(parameters);
  constexpr int kSeeds = 20000;
  for (const int steps : {1, 7}) {
    Eigen::Array3d squares = Eigen::Array3d::Zero();
    for (int seed = 1; seed <= kSeeds; ++seed) {
      const Gust gust =
          gusts(parameters, static_cast<std::uint64_t>(seed), static_cast<std::size_t>(steps))
              .back();
      squares += Eigen::Array3d(gust[0], gust[1], gust[2]).square() / kSeeds;
    }
    // A variance of 20,000 draws is good to 1 %; 4 of those.
    for (Eigen::Index i = 0; i < 3; ++i) {
      EXPECT_NEAR(squares[i] / (model.intensity[i] * model.intensity[i]), 1, 0.04)
          << i << " after " << steps;
    }
  }
}

struct Case {
  const char* name;
  DrydenWindParameters parameters;
};

class DrydenSpectrum : public testing::TestWithParam<Case> {};

TEST_P(DrydenSpectrum, IsThatOfTheStandard) {
  // Averages over bands of a third of an octave.
  constexpr std::size_t kLength = 4096;
  constexpr std::size_t kSamples = kLength * 128;
  const DrydenWindParameters& parameters = GetParam().parameters;
  const DrydenModel model = dryden_model(parameters);
  const std::vector<Gust> samples = gusts(parameters, 11, kSamples);
  const double resolution = 2 * kPi / (kLength * parameters.period);
  for (std::size_t component = 0; component < 6; ++component) {
    const std::vector<double> estimate = welch(samples, component, kLength, parameters.period);
    // The lowest ones are smeared by the window, and few to a band.
    for (std::size_t begin = 8; begin < estimate.size();) {
      const std::size_t end =
          std::min(estimate.size(), begin + std::max<std::size_t>(2, begin / 4));
      double found = 0;
      double expected = 0;
      double used = 0;
      // No need for each of a thousand frequencies; both sums skip the same.
      for (std::size_t i = begin; i < end; i += 1 + (end - begin) / 64) {
        found += estimate[i];
        expected += folded_spectrum(model, component, static_cast<double>(i) * resolution,
                                    parameters.period);
        ++used;
      }
      // 255 segments that overlap, and frequencies that their windows mix: together as many
      // independent estimates as about 120 for each frequency.
      const double averaged = 120 * used;
      EXPECT_NEAR(found / expected, 1, 4.5 / std::sqrt(averaged))
          << "component " << component << ", " << static_cast<double>(begin) * resolution
          << " rad/s";
      begin = end;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Speeds, DrydenSpectrum,
    testing::Values(
        Case{"hover_in_light_wind", {.speed_at_20_feet = 3, .height = 3, .period = 0.05}},
        Case{"inspection", {.speed_at_20_feet = 7.7, .height = 5, .vehicle_speed = 0.5}},
        Case{"fast_and_high",
             {.speed_at_20_feet = 15.4, .height = 60, .vehicle_speed = 20, .span = 10}},
        Case{"floor_of_the_airspeed", {.speed_at_20_feet = 0.5, .period = 0.2}}),
    [](const testing::TestParamInfo<Case>& tested) { return tested.param.name; });

TEST(DrydenWind, TurnsTheAirAsItsGustsChange) {
  // An updraught that grows comes from behind (carried along u): the air turns about v, its front
  // down. One to the left that grows turns it to the right.
  const std::vector<Gust> samples = gusts({.speed_at_20_feet = 8}, 2, 100000);
  double pitch = 0;
  double yaw = 0;
  for (std::size_t i = 1; i + 1 < samples.size(); ++i) {
    pitch += samples[i][4] * (samples[i + 1][2] - samples[i - 1][2]);
    yaw += samples[i][5] * (samples[i + 1][1] - samples[i - 1][1]);
  }
  EXPECT_GT(pitch, 0);
  EXPECT_LT(yaw, 0);
}

TEST(DrydenWind, IsTheSameProcessWhateverThePeriod) {
  // Sampled each 0.1 ms, far below the time constants, the increments over 10 ms have the variance
  // 2 (R(0) - R(0.01 s)), R(t) = sigma^2 exp(-a t) for u and sigma^2 exp(-a t) (1 - a t / 2) for v.
  const DrydenWindParameters parameters{.speed_at_20_feet = 8, .height = 20, .period = 1e-4};
  const DrydenModel model = dryden_model(parameters);
  const double step = 100 * parameters.period;
  const std::vector<Gust> samples = gusts(parameters, 5, 2'000'000);
  std::array<double, 3> found{};
  const std::size_t increments = samples.size() / 100 - 1;
  for (std::size_t i = 0; i < increments; ++i) {
    for (std::size_t component = 0; component < 3; ++component) {
      const double increment = samples[100 * (i + 1)][component] - samples[100 * i][component];
      found[component] += increment * increment / static_cast<double>(increments);
    }
  }
  for (std::size_t component = 0; component < 3; ++component) {
    const auto row = static_cast<Eigen::Index>(component);
    const double x = model.airspeed / model.length_scale[row] * step;
    const double correlation = std::exp(-x) * (component == 0 ? 1 : 1 - x / 2);
    const double expected = 2 * model.intensity[row] * model.intensity[row] * (1 - correlation);
    // 20,000 increments: 1 %, 4 of those.
    EXPECT_NEAR(found[component] / expected, 1, 0.04) << component;
  }
}

}  // namespace
}  // namespace pipescout::simulation
