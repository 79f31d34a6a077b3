// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <string>

#include "pipescout/statistics/draw.hpp"
#include "pipescout/tracking/gaussian_noise.hpp"
#include "pipescout/tracking/particle_filter.hpp"
#include "pipescout/validation/check.hpp"

/// Implementation of `ParticleFilter`, for shapes that are not compiled in the library.
namespace pipescout::tracking {

namespace internal {

/// x - period round(x / period), in vectors: adding and taking off 1.5 2^23 rounds a float below
/// 2^22 to an integer. Nothing for a period of 0.
inline float wrapped(float x, float period, float turns) {
  constexpr float kRounds = 12582912.0F;
  const float whole = (x * turns + kRounds) - kRounds;
  return x - period * whole;
}

/// exp(x) for x <= 0, to 3e-7 of it; 0 below -32, which is nothing in a sum of floats whose
/// greatest is 1, while numbers below the normal range would take many times as long.
inline float exponential(float x) {
  constexpr float kRounds = 12582912.0F;
  const float cut = std::max(x, -32.0F);
  const float shifted = cut * 1.44269504F + kRounds;
  const float whole = shifted - kRounds;
  const float r = (cut - whole * 0.693145752F) - whole * 1.42860677e-6F;
  const float series =
      1.0F +
      r * (1.0F + r * (0.5F + r * (0.166666672F +
                                   r * (0.0416664853F + r * (0.00833337f + r * 0.00139304355F)))));
  const std::int32_t exponent = (static_cast<std::int32_t>(whole) + 127) << 23;
  const float result = series * std::bit_cast<float>(exponent);
  return x < -32.0F ? 0.0F : result;
}

/// Of what `of_block` makes of each 1024 numbers, an Eigen array: in vectors, and to the precision
/// of float for any number of them.
template <class OfBlock>
double sum_over_blocks(std::span<const float> numbers, const OfBlock& of_block) {
  constexpr std::size_t kBlock = 1024;
  double sum = 0;
  for (std::size_t begin = 0; begin < numbers.size(); begin += kBlock) {
    const auto block = numbers.subspan(begin, std::min(kBlock, numbers.size() - begin));
    sum += static_cast<double>(of_block(
        Eigen::Map<const Eigen::ArrayXf>(block.data(), static_cast<Eigen::Index>(block.size()))));
  }
  return sum;
}

}  // namespace internal

template <ShapeModel Model>
void ParticleFilterParameters<Model>::validate() const {
  const auto number = [](std::size_t value) { return static_cast<double>(value); };
  validation::require("particles", number(particles), particles >= 10 && particles <= 1000000,
                      "[10, 1000000]");
  validation::require("resample_share", resample_share, resample_share > 0 && resample_share <= 1,
                      "(0, 1]");
  validation::require("best_particles", number(best_particles),
                      best_particles >= 1 && best_particles <= particles, "[1, particles]");
  for (Eigen::Index i = 0; i < start_deviation.size(); ++i) {
    validation::require("start_deviation", start_deviation[i],
                        start_deviation[i] >= 0 && start_deviation[i] < 1e6, "[0, 1e6)");
    validation::require("process_deviation", process_deviation[i],
                        process_deviation[i] >= 0 && process_deviation[i] < 1e6, "[0, 1e6)");
  }
}

template <ShapeModel Model>
ParticleFilter<Model>::ParticleFilter(const Model& model,
                                      const ParticleFilterParameters<Model>& parameters,
                                      std::uint64_t seed)
    : model_(model), parameters_(parameters), engine_(seed) {
  model_.validate();
  parameters_.validate();
  for (std::size_t i = 0; i < Model::kSize; ++i) {
    numbers_[i].resize(parameters_.particles);
    resampled_[i].resize(parameters_.particles);
  }
  costs_.resize(parameters_.particles);
  weights_.resize(parameters_.particles);
  distances_.resize(parameters_.particles);
  noise_.resize(parameters_.particles);
  order_.resize(parameters_.particles + 1);
}

template <ShapeModel Model>
void ParticleFilter<Model>::start(const State& state) {
  if (!state.allFinite()) {
    throw std::invalid_argument("the initial shape is not finite");
  }
  for (std::size_t i = 0; i < Model::kSize; ++i) {
    const auto index = static_cast<Eigen::Index>(i);
    std::ranges::fill(numbers_[i], static_cast<float>(state[index]));
    add_noise(i, 0, static_cast<float>(parameters_.start_deviation[index]));
  }
  std::ranges::fill(costs_, 0.0F);
  std::ranges::fill(weights_, 1.0F / static_cast<float>(parameters_.particles));
  started_ = true;
}

template <ShapeModel Model>
void ParticleFilter<Model>::add_noise(std::size_t number, float shift, float deviation) {
  draw_gaussian(engine_, noise_);
  float* const values = numbers_[number].data();
  const float* const noise = noise_.data();
  const auto period = static_cast<float>(Model::kPeriods[number]);
  const float turns = period > 0 ? 1 / period : 0;
  for (std::size_t k = 0; k < parameters_.particles; ++k) {
    values[k] = internal::wrapped(values[k] + shift + deviation * noise[k], period, turns);
  }
}

template <ShapeModel Model>
bool ParticleFilter<Model>::predict(double dt, const State& rate) {
  if (!started_ || !std::isfinite(dt) || dt < 0 || !(dt * rate).allFinite()) {
    return false;
  }
  if (effective_samples() <
      parameters_.resample_share * static_cast<double>(parameters_.particles)) {
    resample();
  }
  const double root = std::sqrt(dt);
  for (std::size_t i = 0; i < Model::kSize; ++i) {
    const auto index = static_cast<Eigen::Index>(i);
    add_noise(i, static_cast<float>(dt * rate[index]),
              static_cast<float>(root * parameters_.process_deviation[index]));
  }
  return true;
}

template <ShapeModel Model>
typename ParticleFilter<Model>::Update ParticleFilter<Model>::update(
    std::span<const State> regions) {
  Update result;
  if (!started_) {
    return result;
  }
  std::ranges::fill(distances_, std::numeric_limits<float>::max());
  for (const State& region : regions) {
    if (!region.allFinite()) {
      ++result.refused;
      continue;
    }
    ++result.regions;
    std::array<const float*, Model::kSize> values;
    std::array<float, Model::kSize> of_region;
    std::array<float, Model::kSize> periods;
    std::array<float, Model::kSize> turns;
    for (std::size_t i = 0; i < Model::kSize; ++i) {
      values[i] = numbers_[i].data();
      of_region[i] = static_cast<float>(region[static_cast<Eigen::Index>(i)]);
      periods[i] = static_cast<float>(Model::kPeriods[i]);
      turns[i] = periods[i] > 0 ? 1 / periods[i] : 0;
    }
    float* const nearest = distances_.data();
    const Model model = model_;
    for (std::size_t k = 0; k < parameters_.particles; ++k) {
      std::array<float, Model::kSize> difference;
      for (std::size_t i = 0; i < Model::kSize; ++i) {
        const float apart = values[i][k] - of_region[i];
        difference[i] =
            Model::kPeriods[i] > 0 ? internal::wrapped(apart, periods[i], turns[i]) : apart;
      }
      nearest[k] = std::min(nearest[k], model.distance(difference));
    }
  }
  if (result.regions == 0) {
    return result;
  }
  weigh();
  return result;
}

template <ShapeModel Model>
double ParticleFilter<Model>::effective_samples() const noexcept {
  if (!started_) {
    return 0;
  }
  // Equations (17) and (18) come to 1 / sum of w^2.
  return 1.0 / internal::sum_over_blocks(
                   weights_, [](const auto& weights) { return weights.square().sum(); });
}

template <ShapeModel Model>
void ParticleFilter<Model>::weigh() {
  // The product of likelihoods is the exponential of the sum; the best particle has 1, so that
  // something is left wherever the particles are.
  const auto count = static_cast<Eigen::Index>(parameters_.particles);
  Eigen::Map<Eigen::ArrayXf> costs(costs_.data(), count);
  costs += Eigen::Map<const Eigen::ArrayXf>(distances_.data(), count);
  costs -= costs.minCoeff();
  for (std::size_t k = 0; k < parameters_.particles; ++k) {
    weights_[k] = internal::exponential(-costs_[k]);
  }
  Eigen::Map<Eigen::ArrayXf>(weights_.data(), count) *= static_cast<float>(
      1.0 / internal::sum_over_blocks(weights_, [](const auto& part) { return part.sum(); }));
}

template <ShapeModel Model>
void ParticleFilter<Model>::resample() {
  ++resamplings_;
  const std::size_t count = parameters_.particles;
  if (parameters_.resampling == Resampling::kSystematic) {
    // The copies of a particle begin at the first of the draws, which are a whole number apart,
    // that the particles before it leave. One without copies begins where the next does, which
    // takes its place; each copy is of the last particle that begins at it or before. Branches that
    // depend on weights would cost more than all this.
    const auto copies = static_cast<double>(count);
    const double first = statistics::uniform(engine_);
    double before = 0;
    std::ranges::fill(order_, 0U);
    for (std::size_t k = 0; k < count; ++k) {
      // Rounded up: what is truncated is not negative.
      const auto begin = static_cast<std::size_t>(before + (1.0 - first));
      order_[std::min(begin, count)] = static_cast<std::uint32_t>(k);
      before += static_cast<double>(weights_[k]) * copies;
    }
    std::uint32_t last = 0;
    for (std::size_t k = 0; k < count; ++k) {
      last = std::max(last, order_[k]);
      order_[k] = last;
    }
  } else {
    std::partial_sum(weights_.begin(), weights_.end(), distances_.begin());
    for (std::size_t k = 0; k < count; ++k) {
      const auto wanted = static_cast<float>(statistics::uniform(engine_)) * distances_.back();
      const auto found = std::ranges::upper_bound(distances_, wanted);
      order_[k] = static_cast<std::uint32_t>(std::min<std::ptrdiff_t>(
          found - distances_.begin(), static_cast<std::ptrdiff_t>(count) - 1));
    }
  }
  for (std::size_t i = 0; i < Model::kSize; ++i) {
    for (std::size_t k = 0; k < count; ++k) {
      resampled_[i][k] = numbers_[i][order_[k]];
    }
    std::swap(numbers_[i], resampled_[i]);
  }
  std::ranges::fill(costs_, 0.0F);
  std::ranges::fill(weights_, 1.0F / static_cast<float>(count));
}

template <ShapeModel Model>
typename ParticleFilter<Model>::State ParticleFilter<Model>::particle(std::size_t index) const {
  State result;
  for (std::size_t i = 0; i < Model::kSize; ++i) {
    result[static_cast<Eigen::Index>(i)] = static_cast<double>(numbers_[i][index]);
  }
  return result;
}

template <ShapeModel Model>
double ParticleFilter<Model>::brought_near(double value, double reference, double period) {
  return period > 0 ? reference + std::remainder(value - reference, period) : value;
}

template <ShapeModel Model>
typename ParticleFilter<Model>::State ParticleFilter<Model>::in_range(State state) {
  for (std::size_t i = 0; i < Model::kSize; ++i) {
    double& value = state[static_cast<Eigen::Index>(i)];
    value = brought_near(value, 0, Model::kPeriods[i]);
  }
  return state;
}

template <ShapeModel Model>
typename ParticleFilter<Model>::State ParticleFilter<Model>::best() const {
  if (!started_) {
    return State::Zero();
  }
  return in_range(
      particle(static_cast<std::size_t>(std::ranges::max_element(weights_) - weights_.begin())));
}

template <ShapeModel Model>
typename ParticleFilter<Model>::State ParticleFilter<Model>::mean_of(
    std::span<const std::uint32_t> particles) const {
  const State reference = best();
  State sum = State::Zero();
  double weight = 0;
  for (const std::uint32_t k : particles) {
    const auto w = static_cast<double>(weights_[k]);
    weight += w;
    for (std::size_t i = 0; i < Model::kSize; ++i) {
      const auto index = static_cast<Eigen::Index>(i);
      sum[index] += w * brought_near(static_cast<double>(numbers_[i][k]), reference[index],
                                     Model::kPeriods[i]);
    }
  }
  return in_range(sum / weight);
}

template <ShapeModel Model>
typename ParticleFilter<Model>::State ParticleFilter<Model>::robust_mean() const {
  if (!started_) {
    return State::Zero();
  }
  const auto all = std::span(order_).first(parameters_.particles);
  std::iota(all.begin(), all.end(), 0U);
  const auto best = all.first(parameters_.best_particles);
  std::partial_sort(all.begin(), best.end(), all.end(), [this](std::uint32_t a, std::uint32_t b) {
    return weights_[a] != weights_[b] ? weights_[a] > weights_[b] : a < b;
  });
  return mean_of(best);
}

template <ShapeModel Model>
typename ParticleFilter<Model>::State ParticleFilter<Model>::weighted_mean() const {
  if (!started_) {
    return State::Zero();
  }
  const auto all = std::span(order_).first(parameters_.particles);
  std::iota(all.begin(), all.end(), 0U);
  return mean_of(all);
}

template <ShapeModel Model>
typename ParticleFilter<Model>::Covariance ParticleFilter<Model>::covariance() const {
  Covariance result = Covariance::Zero();
  if (!started_) {
    return result;
  }
  const State mean = weighted_mean();
  for (std::size_t k = 0; k < parameters_.particles; ++k) {
    State away = particle(k);
    for (std::size_t i = 0; i < Model::kSize; ++i) {
      const auto index = static_cast<Eigen::Index>(i);
      away[index] = brought_near(away[index], mean[index], Model::kPeriods[i]) - mean[index];
    }
    result += static_cast<double>(weights_[k]) * away * away.transpose();
  }
  return result;
}

}  // namespace pipescout::tracking
