// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <bitset>

#include "pipescout/rack_vision/pose_solver.hpp"

/// The pipes' offsets over time (Lippiello and Cacace, equation 25, which filters nothing).
namespace pipescout::rack_vision {

struct OffsetFilterParameters {
  /// How well the model's places of the pipes are known at the start, m, > 0.
  double initial_deviation = 0.02;
  /// Pipes creep (thermal expansion) as a random walk of this size, m per root of a second, >= 0.
  /// Sudden moves are found by the solver's innovation test instead.
  double creep = 0.0002;
  /// A pipe that contradicts its belief in so many images running has moved, 1..100; until then its
  /// belief stays and the images' other content is used.
  int images_to_move = 2;
  /// Smaller moves show in many images: in the running mean of the innovations, in their standard
  /// deviations. Beyond this it has moved, and its belief is made wider by what it seems to have
  /// moved; > 0.
  double largest_mean_innovation = 1.2;

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

/// A Kalman filter whose measurement is the joint solution of pose and offsets: before an image
/// `belief` goes into PoseProblem::offsets as the prior, and `update` takes the solution's joint
/// posterior, with the pose integrated out, for the belief. So no information is counted twice, as
/// long as the poses of the images are independent given the offsets; a pose prior from odometry
/// makes them slightly dependent.
class OffsetFilter {
 public:
  /// All pipes of the model that may move start at offset 0. Throws std::invalid_argument as
  /// OffsetFilterParameters::validate.
  explicit OffsetFilter(const RackModel& model, const OffsetFilterParameters& parameters = {});

  /// Starts again from these offsets, m, one per pipe, with the initial deviation; those of pipes
  /// that do not move are not used. Throws std::invalid_argument when they are not one per pipe or
  /// not finite.
  void reset(PipeOffsets offsets);

  /// Time passes, s. What is not finite or negative changes nothing.
  void predict(double seconds) noexcept;

  /// Takes over a solution whose problem had `belief()` for its offsets. Solutions with another
  /// status than kOk and kUnobserved change nothing.
  void update(const PoseSolution& solution) noexcept;

  [[nodiscard]] const OffsetBelief& belief() const noexcept { return belief_; }
  /// Offsets of all pipes, m.
  [[nodiscard]] PipeOffsets offsets() const noexcept { return {belief_.mean.data(), pipes_}; }

 private:
  void watch_innovations(const PoseSolution& solution) noexcept;

  OffsetFilterParameters parameters_;
  std::size_t pipes_;
  std::bitset<kMaxPipes> movable_;
  OffsetBelief belief_;
  std::array<int, kMaxPipes> contradictions_{};
  std::array<double, kMaxPipes> mean_innovation_{};
};

}  // namespace pipescout::rack_vision
