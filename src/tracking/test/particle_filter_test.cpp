// SPDX-License-Identifier: Apache-2.0
#include "pipescout/tracking/particle_filter.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <stdexcept>
#include <utility>
#include <vector>

#include "pipescout/tracking/particle_filter_definition.hpp"

namespace pipescout::tracking {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;
using PipeFilter = ParticleFilter<PipeShape>;
using PipeParameters = ParticleFilterParameters<PipeShape>;
using Pipe = ShapeState<PipeShape>;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// A shape of one's own whose likelihood is a normal distribution: then the filter has to give what
/// a Kalman filter gives.
struct NormalShape {
  static constexpr std::size_t kSize = 2;
  static constexpr std::array<double, kSize> kPeriods{0, 0};
  double variance = 4;

  template <class T>
  [[nodiscard]] T distance(const std::array<T, kSize>& d) const {
    return (d[0] * d[0] + d[1] * d[1]) / static_cast<T>(2 * variance);
  }
  void validate() const {}
};

PipeParameters pipe_parameters(std::size_t particles = 1000) {
  PipeParameters result;
  result.particles = particles;
  result.start_deviation << 5, 5, 5, 0.05;
  result.process_deviation << 10, 10, 10, 0.1;
  return result;
}

double wrapped(double angle) {
  return std::remainder(angle, std::numbers::pi);
}

TEST(ParticleFilter, GivesWhatAKalmanFilterGives) {
  constexpr double kDt = 0.5;
  ParticleFilterParameters<NormalShape> parameters;
  parameters.particles = 200'000;
  parameters.start_deviation << 3, 3;
  parameters.process_deviation << 2, 1;
  const NormalShape shape;
  ParticleFilter<NormalShape> filter(shape, parameters, 3);
  using State = ShapeState<NormalShape>;
  filter.start(State(10, -20));
  Eigen::Array2d mean(10, -20);
  Eigen::Array2d variance(9, 9);
  const State rate(1, -2);
  for (int step = 0; step < 8; ++step) {
    ASSERT_TRUE(filter.predict(kDt, rate));
    mean += kDt * rate.array();
    variance += kDt * Eigen::Array2d(4, 1);
    const State seen(11.0 + step, -22.0 + 0.5 * step);
    ASSERT_EQ(filter.update(std::array{seen}).regions, 1U);
    const Eigen::Array2d gain = variance / (variance + shape.variance);
    mean += gain * (seen.array() - mean);
    variance *= 1 - gain;
    // Means of so many particles, of which resampling makes some the same.
    EXPECT_LT((filter.weighted_mean().array() - mean).abs().maxCoeff(), 0.03) << step;
    EXPECT_LT((filter.covariance().diagonal().array() / variance - 1).abs().maxCoeff(), 0.03)
        << step;
  }
  EXPECT_GT(filter.resamplings(), 0U);
}

TEST(ParticleFilter, WeightsAreEquations14To16) {
  PipeFilter filter(PipeShape{}, pipe_parameters(500), 4);
  filter.start(Pipe(100, 80, 60, 1.5));
  const std::array regions{Pipe(103, 79, 62, -1.6), Pipe(60, 80, 60, 1.5), Pipe(100, 85, 55, 1.48)};
  ASSERT_EQ(filter.update(regions).regions, 3U);
  std::vector<double> expected;
  for (std::size_t k = 0; k < 500; ++k) {
    double nearest = std::numeric_limits<double>::max();
    for (const Pipe& region : regions) {
      std::array<double, 4> d;
      for (std::size_t i = 0; i < 4; ++i) {
        d[i] = static_cast<double>(filter.numbers(i)[k]) - region[static_cast<Eigen::Index>(i)];
      }
      d[3] = wrapped(d[3]);
      nearest = std::min(nearest, PipeShape{}.distance(d));
    }
    expected.push_back(std::exp(-nearest));
  }
  const double sum = std::accumulate(expected.begin(), expected.end(), 0.0);
  double squares = 0;
  for (std::size_t k = 0; k < 500; ++k) {
    EXPECT_NEAR(static_cast<double>(filter.weights()[k]), expected[k] / sum,
                1e-4 * expected[k] / sum + 1e-9);
    squares += expected[k] * expected[k] / (sum * sum);
  }
  EXPECT_NEAR(filter.effective_samples() * squares, 1, 1e-4);
}

TEST(ParticleFilter, FollowsAPipeThatTurnsPastHalfATurn) {
  for (const Resampling resampling : {Resampling::kSystematic, Resampling::kMultinomial}) {
    PipeParameters parameters = pipe_parameters();
    parameters.resampling = resampling;
    PipeFilter filter(PipeShape{}, parameters, 5);
    const Pipe rate(20, -10, 0, 0.8);
    filter.start(Pipe(50, 200, 80, 0));
    for (int frame = 1; frame <= 200; ++frame) {
      const double time = 0.04 * frame;
      Pipe truth = Pipe(50, 200, 80, 0) + time * rate;
      truth[3] = wrapped(truth[3]);
      ASSERT_TRUE(filter.predict(0.04, rate));
      filter.update(std::array{truth});
      for (const Pipe& estimate : {filter.best(), filter.robust_mean(), filter.weighted_mean()}) {
        EXPECT_LT((estimate - truth).head<2>().norm(), 6) << frame;
        EXPECT_LT(std::abs(wrapped(estimate[3] - truth[3])), 0.12) << frame;
        EXPECT_LE(std::abs(estimate[3]), std::numbers::pi / 2 + 1e-9);
      }
    }
  }
}

TEST(ParticleFilter, TheBestParticleHasTheGreatestWeight) {
  PipeFilter filter(PipeShape{}, pipe_parameters(), 6);
  filter.start(Pipe(100, 80, 60, 0.5));
  filter.update(std::array{Pipe(102, 81, 61, 0.52)});
  const auto weights = filter.weights();
  const auto best = static_cast<std::size_t>(std::ranges::max_element(weights) - weights.begin());
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(filter.best()[static_cast<Eigen::Index>(i)],
              static_cast<double>(filter.numbers(i)[best]));
  }
  EXPECT_NEAR(std::accumulate(weights.begin(), weights.end(), 0.0), 1, 1e-5);
}

TEST(ParticleFilter, SystematicResamplingCopiesByWeight) {
  PipeParameters parameters = pipe_parameters(2000);
  parameters.resample_share = 1;
  parameters.process_deviation.setZero();
  PipeFilter filter(PipeShape{}, parameters, 7);
  filter.start(Pipe(100, 80, 60, 0.5));
  filter.update(std::array{Pipe(100, 80, 60, 0.5)});
  // Two particles may share one number, not two.
  const auto places = [&filter] {
    std::vector<std::pair<float, float>> result;
    for (std::size_t k = 0; k < 2000; ++k) {
      result.emplace_back(filter.numbers(0)[k], filter.numbers(1)[k]);
    }
    return result;
  };
  const auto before = places();
  const std::vector<float> weights(filter.weights().begin(), filter.weights().end());
  ASSERT_TRUE(filter.predict(0, Pipe::Zero()));
  ASSERT_EQ(filter.resamplings(), 1U);
  const auto after = places();
  for (std::size_t k = 0; k < before.size(); ++k) {
    const auto copies = static_cast<double>(std::ranges::count(after, before[k]));
    EXPECT_NEAR(copies, 2000 * static_cast<double>(weights[k]), 1.01) << k;
  }
}

TEST(ParticleFilter, WithoutRegionsNothingIsLearnt) {
  PipeFilter filter(PipeShape{}, pipe_parameters(), 8);
  filter.start(Pipe(100, 80, 60, 0.5));
  const Pipe before = filter.weighted_mean();
  EXPECT_EQ(filter.update({}).regions, 0U);
  const auto result = filter.update(std::array{Pipe(kNan, 0, 0, 0)});
  EXPECT_EQ(result.regions, 0U);
  EXPECT_EQ(result.refused, 1U);
  EXPECT_EQ(filter.weighted_mean(), before);
  EXPECT_NEAR(filter.effective_samples(), 1000, 0.01);
}

TEST(ParticleFilter, FarFromAllRegionsAWeightIsLeft) {
  PipeFilter filter(PipeShape{}, pipe_parameters(), 9);
  filter.start(Pipe(0, 0, 60, 0.5));
  for (int i = 0; i < 50; ++i) {
    ASSERT_TRUE(filter.predict(0.04, Pipe::Zero()));
    filter.update(std::array{Pipe(5000, 4000, 300, -0.5)});
    ASSERT_TRUE(filter.weighted_mean().allFinite());
    ASSERT_GT(filter.effective_samples(), 0.99);
  }
}

TEST(ParticleFilter, ThousandsOfRegions) {
  PipeFilter filter(PipeShape{}, pipe_parameters(), 10);
  filter.start(Pipe(100, 80, 60, 0.5));
  std::vector<Pipe> regions(5000, Pipe(900, 900, 10, 0));
  regions[4321] = Pipe(101, 81, 61, 0.51);
  filter.update(regions);
  EXPECT_LT((filter.weighted_mean() - regions[4321]).head<2>().norm(), 4);
}

TEST(ParticleFilter, BadInputChangesNothing) {
  PipeFilter filter(PipeShape{}, pipe_parameters(), 11);
  EXPECT_FALSE(filter.predict(0.04, Pipe::Zero())) << "not started";
  EXPECT_EQ(filter.update(std::array{Pipe(1, 2, 3, 0)}).regions, 0U);
  EXPECT_EQ(filter.best(), Pipe::Zero());
  EXPECT_THROW(filter.start(Pipe(0, kNan, 0, 0)), std::invalid_argument);
  filter.start(Pipe(100, 80, 60, 0.5));
  const Pipe before = filter.weighted_mean();
  EXPECT_FALSE(filter.predict(-0.04, Pipe::Zero()));
  EXPECT_FALSE(filter.predict(kNan, Pipe::Zero()));
  EXPECT_FALSE(filter.predict(0.04, Pipe(0, 0, kNan, 0)));
  EXPECT_EQ(filter.weighted_mean(), before);
}

TEST(ParticleFilter, TheSameSeedGivesTheSameBits) {
  const auto run = [](std::uint64_t seed) {
    PipeFilter filter(PipeShape{}, pipe_parameters(), seed);
    filter.start(Pipe(100, 80, 60, 0.5));
    for (int i = 0; i < 20; ++i) {
      filter.predict(0.04, Pipe(5, 0, 0, 0));
      filter.update(std::array{Pipe(100.0 + 0.2 * i, 80, 60, 0.5)});
    }
    return filter.weighted_mean();
  };
  EXPECT_EQ(run(12), run(12));
  EXPECT_NE(run(12), run(13));
}

TEST(ParticleFilter, OtherShapesAreFollowedToo) {
  ParticleFilterParameters<ValveShape> valve_parameters;
  valve_parameters.start_deviation << 4, 4, 2;
  valve_parameters.process_deviation << 10, 10, 2;
  ParticleFilter<ValveShape> valve(ValveShape{}, valve_parameters, 14);
  valve.start({50, 50, 20});
  ParticleFilterParameters<VesselShape> vessel_parameters;
  vessel_parameters.start_deviation << 4, 4, 4, 4, 0.05;
  vessel_parameters.process_deviation << 10, 10, 5, 5, 0.1;
  ParticleFilter<VesselShape> vessel(VesselShape{}, vessel_parameters, 15);
  ShapeState<VesselShape> tank;
  tank << 150, 90, 80, 40, 1.5;
  vessel.start(tank);
  for (int frame = 0; frame < 50; ++frame) {
    const ShapeState<ValveShape> wheel(50.0 + frame, 50, 20);
    valve.predict(0.04, {25, 0, 0});
    valve.update(std::array{wheel});
    EXPECT_LT((valve.weighted_mean() - wheel).norm(), 4) << frame;
    tank[0] += 0.5;
    vessel.predict(0.04, ShapeState<VesselShape>::Zero());
    vessel.update(std::array{tank});
    EXPECT_LT((vessel.robust_mean() - tank).head<2>().norm(), 6) << frame;
  }
}

TEST(ParticleFilter, ParametersOutOfRangeAreNamed) {
  const auto make = [](const auto& spoil) {
    PipeParameters parameters = pipe_parameters();
    spoil(parameters);
    return [parameters] { PipeFilter(PipeShape{}, parameters, 1); };
  };
  EXPECT_THAT(make([](auto& p) { p.particles = 3; }),
              ThrowsMessage<std::invalid_argument>(HasSubstr("particles: 3")));
  EXPECT_THAT(make([](auto& p) { p.resample_share = 0; }),
              ThrowsMessage<std::invalid_argument>(HasSubstr("resample_share")));
  EXPECT_THAT(make([](auto& p) { p.best_particles = 0; }),
              ThrowsMessage<std::invalid_argument>(HasSubstr("best_particles")));
  EXPECT_THAT(make([](auto& p) { p.start_deviation[2] = -1; }),
              ThrowsMessage<std::invalid_argument>(HasSubstr("start_deviation: -1")));
  EXPECT_THAT(make([](auto& p) { p.process_deviation[3] = kNan; }),
              ThrowsMessage<std::invalid_argument>(HasSubstr("process_deviation: nan")));
}

}  // namespace
}  // namespace pipescout::tracking
