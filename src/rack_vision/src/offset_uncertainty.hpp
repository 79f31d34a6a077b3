// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bitset>

#include "pipescout/rack_vision/pose_solver.hpp"
#include "pipescout/rack_vision/rack_model.hpp"

namespace pipescout::rack_vision {

/// What the images really tell of the offsets: the covariance with which they make the pose
/// uncertain.
///
/// OffsetMemory learns from solutions whose pose is predicted from the last image. Where the pipes
/// that cannot move are out of view, that prediction is the only word on where all pipes lie
/// together, and it is from the same offsets: their variance falls from image to image, and no
/// image has told anything. Here an image counts by its edges alone, with nothing known of the
/// pose; and the pipes of a file may all be off together, as much as each of them.
class OffsetUncertainty {
 public:
  /// `sigma`: as OffsetMemory.
  OffsetUncertainty(const RackModel& model, double sigma);

  void reset();
  /// A variance added to each offset, m^2.
  void widen(double variance);
  /// Nothing is known of the offset of this pipe any more but the model.
  void forget(std::size_t pipe);
  /// After the first image, which also has the word of the pose that was given: `after` is what it
  /// leaves open.
  void begin(const OffsetMatrix& after);
  /// `by_edges`: PoseSolution::offset_covariance_by_edges; `share` of its information, in [0, 1].
  void learn(const OffsetMatrix& by_edges, double share);

  [[nodiscard]] bool has_begun() const noexcept { return has_begun_; }
  [[nodiscard]] const OffsetMatrix& covariance() const noexcept { return covariance_; }

 private:
  std::bitset<kMaxPipes> movable_;
  double sigma_ = 0;
  bool has_begun_ = false;
  OffsetMatrix covariance_ = OffsetMatrix::Zero();
};

}  // namespace pipescout::rack_vision
