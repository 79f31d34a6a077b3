// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <random>
#include <span>
#include <vector>

#include "pipescout/tracking/shape_model.hpp"
#include "pipescout/tracking/shapes.hpp"

namespace pipescout::tracking {

enum class Resampling : std::uint8_t {
  kSystematic,   ///< one draw for all: the number of copies is within one of its expected value
  kMultinomial,  ///< one draw for each, with replacement: as in the paper
};

template <ShapeModel Model>
struct ParticleFilterParameters {
  std::size_t particles = 1000;  ///< [10, 1000000]
  /// Of the particles, in (0, 1]: resampled when the effective sample size, equations (17) and
  /// (18), is below it.
  double resample_share = 0.5;
  Resampling resampling = Resampling::kSystematic;
  std::size_t best_particles = 10;  ///< [1, particles]: of the robust mean
  /// Initial standard deviation of each parameter, >= 0.
  ShapeState<Model> start_deviation = ShapeState<Model>::Ones();
  /// Of V in equation (10), per square root of a second, >= 0.
  ShapeState<Model> process_deviation = ShapeState<Model>::Ones();

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

/// The particle filter of Ibarguren, Molina, Susperregi, Maurtua, Sensors 13 (2013), section 6.2,
/// over any shape. The same parameters, seed and calls give the same bits. Particles are kept in
/// single precision, as a structure of arrays. Allocates nothing after construction. Not
/// thread-safe.
///
/// Compiled for PipeShape, ValveShape and VesselShape; for a shape of your own include
/// particle_filter_definition.hpp in one source file.
template <ShapeModel Model>
class ParticleFilter {
 public:
  using State = ShapeState<Model>;
  using Covariance = Eigen::Matrix<double, State::RowsAtCompileTime, State::RowsAtCompileTime>;

  /// Throws as the `validate` of its arguments.
  ParticleFilter(const Model& model, const ParticleFilterParameters<Model>& parameters,
                 std::uint64_t seed);

  /// Draws all particles about a shape, with equal weights. Throws std::invalid_argument when it is
  /// not finite.
  void start(const State& state);
  [[nodiscard]] bool started() const noexcept { return started_; }

  /// Steps 2 and 3 of the paper's procedure: resamples when the effective sample size is too small,
  /// then equation (10): X + dt rate + V. `rate` is that of all particles, 1/s. Returns false
  /// without an effect before the start, for a negative dt and for values that are not finite.
  bool predict(double dt, const State& rate);

  struct Update {
    std::size_t regions = 0;  ///< that were used
    std::size_t refused = 0;  ///< not used, because they are not finite
  };
  /// Equations (14) to (16): weights by the nearest region. Without a usable region, or before the
  /// start, nothing changes.
  Update update(std::span<const State> regions);

  /// The particle with the greatest weight. This and the others are zero before the start.
  [[nodiscard]] State best() const;
  /// Weighted mean of the `best_particles` with the greatest weights.
  [[nodiscard]] State robust_mean() const;
  [[nodiscard]] State weighted_mean() const;
  /// About the weighted mean.
  [[nodiscard]] Covariance covariance() const;

  /// Equations (17) and (18), of the weights as they are; 0 before the start.
  [[nodiscard]] double effective_samples() const noexcept;
  /// Times that it was resampled.
  [[nodiscard]] std::size_t resamplings() const noexcept { return resamplings_; }

  [[nodiscard]] const Model& model() const noexcept { return model_; }
  [[nodiscard]] const ParticleFilterParameters<Model>& parameters() const noexcept {
    return parameters_;
  }
  /// Parameter `i` of all particles, and their weights, whose sum is 1.
  [[nodiscard]] std::span<const float> numbers(std::size_t i) const { return numbers_.at(i); }
  [[nodiscard]] std::span<const float> weights() const noexcept { return weights_; }

 private:
  using Numbers = std::array<std::vector<float>, Model::kSize>;

  void add_noise(std::size_t number, float shift, float deviation);
  void weigh();
  void resample();
  [[nodiscard]] State particle(std::size_t index) const;
  /// `state` with each periodic parameter shifted to the value nearest to that of `reference`.
  [[nodiscard]] static double brought_near(double value, double reference, double period);
  [[nodiscard]] static State in_range(State state);
  [[nodiscard]] State mean_of(std::span<const std::uint32_t> particles) const;

  Model model_;
  ParticleFilterParameters<Model> parameters_;
  std::mt19937_64 engine_;
  Numbers numbers_;
  Numbers resampled_;
  std::vector<float> costs_;  // sum of the distances since the last resampling
  std::vector<float> weights_;
  std::vector<float> distances_;
  std::vector<float> noise_;
  // Of particles; the last place is for those that are not copied.
  mutable std::vector<std::uint32_t> order_;
  std::size_t resamplings_ = 0;
  bool started_ = false;
};

extern template class ParticleFilter<PipeShape>;
extern template class ParticleFilter<ValveShape>;
extern template class ParticleFilter<VesselShape>;
extern template struct ParticleFilterParameters<PipeShape>;
extern template struct ParticleFilterParameters<ValveShape>;
extern template struct ParticleFilterParameters<VesselShape>;

}  // namespace pipescout::tracking
