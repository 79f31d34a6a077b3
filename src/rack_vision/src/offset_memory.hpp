// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "pipescout/rack_vision/pose_solver.hpp"
#include "pipescout/rack_vision/rack_model.hpp"

namespace pipescout::rack_vision {

/// What an image shows of the contours of one pipe.
struct PipeSupport {
  int searched = 0;  ///< samples
  int found = 0;     ///< where pose and offset have them
};

/// What is believed of the pipes' offsets from image to image.
class OffsetMemory {
 public:
  /// `sigma`: how well the model knows the offsets, m; 0: they stay as they are.
  OffsetMemory(const RackModel& model, double sigma);

  void reset();
  /// After dt s, in which pipes may have moved.
  void predict(double dt);
  /// Takes over the offsets of an image, which began with this belief, as far as the image tells
  /// what others did not: `share` of its information, in [0, 1]. Nothing is learnt of a pipe whose
  /// contours are not found; one that is not where it is believed in ten images is doubted, as all
  /// are by `doubt`.
  void learn(const OffsetBelief& after, std::span<const PipeSupport> support, double share);

  /// A pipe that was unplaced lies here, m.
  void place(std::size_t pipe, double offset);

  /// The model knows the offsets no better than by `sigma`, m.
  void widen(double sigma);

  /// The pipes may lie anywhere about where they are believed, as far as the model leaves it open.
  void doubt();

  [[nodiscard]] const OffsetBelief& belief() const noexcept { return belief_; }

 private:
  [[nodiscard]] bool may_move(std::size_t pipe) const noexcept;
  void doubt(std::size_t pipe);
  /// At `mean`, m, with this deviation, and unrelated to the others.
  void set(std::size_t pipe, double mean, double sigma);
  /// Returns whether the image shows where the pipe is.
  bool judge(std::size_t pipe, const PipeSupport& support);

  std::array<bool, kMaxPipes> movable_{};
  std::size_t pipes_ = 0;
  double sigma_ = 0;
  std::array<int, kMaxPipes> images_in_doubt_{};
  OffsetBelief belief_;
};

}  // namespace pipescout::rack_vision
