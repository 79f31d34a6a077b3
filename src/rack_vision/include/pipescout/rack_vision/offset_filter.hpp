// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <bitset>

#include "pipescout/rack_vision/pose_solver.hpp"

/// Filter of the pipes' offsets over time (equation 25 of Lippiello and Cacace has no filter).
namespace pipescout::rack_vision {

struct OffsetFilterParameters {
  /// Initial standard deviation of the pipes' positions in the model, m, > 0.
  double initial_deviation = 0.02;
  /// Process noise of the offsets (thermal expansion), m per root of a second, >= 0. Sudden moves
  /// are detected by the solver's innovation test.
  double creep = 0.0002;
  /// A pipe whose innovation is too large in this many images in a row has moved, 1..100; until
  /// then its estimate is kept and the rest of the images is used.
  int images_to_move = 2;
  /// Smaller moves are detected over many images, by the running mean of the normalised
  /// innovations. Beyond this threshold the pipe has moved, and its covariance is inflated by the
  /// apparent move; > 0.
  double largest_mean_innovation = 1.2;

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

/// A Kalman filter whose measurement is the joint solution of pose and offsets: before an image,
/// `belief` is the prior in PoseProblem::offsets, and `update` replaces it by the solution's
/// posterior, marginalised over the pose. So no information is used twice, as long as the poses of
/// the images are independent given the offsets; a pose prior from odometry makes them slightly
/// dependent.
class OffsetFilter {
 public:
  /// All movable pipes of the model start at offset 0. Throws std::invalid_argument as
  /// OffsetFilterParameters::validate.
  explicit OffsetFilter(const RackModel& model, const OffsetFilterParameters& parameters = {});

  /// Restarts from these offsets, m, one per pipe, with the initial deviation; those of fixed pipes
  /// are not used. Throws std::invalid_argument when they are not one per pipe or not finite.
  void reset(PipeOffsets offsets);

  /// Prediction over a time, s. A value that is not finite or negative has no effect.
  void predict(double seconds) noexcept;

  /// Update with a solution whose problem had `belief()` as prior of the offsets. Solutions with
  /// another status than kOk and kUnobserved have no effect.
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
