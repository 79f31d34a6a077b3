// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "pipescout/rack_vision/pose_solver.hpp"
#include "pipescout/rack_vision/rack_model.hpp"

namespace pipescout::rack_vision {

/// What is believed of the pipes' offsets from image to image.
class OffsetMemory {
 public:
  /// `sigma`: how well the model knows the offsets, m; 0: they stay as they are.
  OffsetMemory(const RackModel& model, double sigma);

  void reset();
  /// After dt s, in which pipes may have moved.
  void predict(double dt);
  /// Takes over the offsets of an image, which began with this belief. Errors of successive images
  /// are alike (shading and paint stay where they are): each counts for one in kAlikeImages of what
  /// it says.
  void learn(const OffsetBelief& after);

  [[nodiscard]] const OffsetBelief& belief() const noexcept { return belief_; }

 private:
  std::array<bool, kMaxPipes> movable_{};
  std::size_t pipes_ = 0;
  double sigma_ = 0;
  OffsetBelief belief_;
};

}  // namespace pipescout::rack_vision
