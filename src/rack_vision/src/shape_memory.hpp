// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "alignment_search.hpp"
#include "offset_memory.hpp"
#include "pipescout/rack_vision/pose_solver.hpp"
#include "pipescout/rack_vision/rack_model.hpp"

namespace pipescout::rack_vision {

/// What is believed of the shape of one pipe (Pipe::shape_deviation). First its contours are
/// searched in several views together: in one alone, neighbours, stripes and shadows look like
/// them. Once one shape explains the views, each image improves it.
class ShapeMemory {
 public:
  /// `pipe` as the model has it; `offset_sigma`, m: of its offset, 0 where it cannot move.
  ShapeMemory(const Pipe& pipe, double offset_sigma);

  void reset();

  /// One shape explains what was seen.
  [[nodiscard]] bool found() const noexcept { return found_; }
  [[nodiscard]] const ShapeVector& mean() const noexcept { return mean_; }
  [[nodiscard]] const ShapeMatrix& covariance() const noexcept { return covariance_; }
  [[nodiscard]] PipeShape value() const noexcept { return to_shape(mean_); }
  [[nodiscard]] PipeShape deviation() const { return to_shape(covariance_.diagonal().cwiseSqrt()); }
  /// px that one standard deviation moves a contour by.
  [[nodiscard]] double deviation_along(const ShapeVector& by_shape) const {
    return std::sqrt(std::max(0.0, by_shape.dot(covariance_ * by_shape)));
  }

  /// Of a view, what was not told by those before it, in [0, 1]. Returns whether that is enough for
  /// another one to be taken.
  bool is_another_view(double share);
  static constexpr double kStep = 1;  ///< px, of the tables of views
  /// Takes a view for the search: its contours as the model has them, `start_by_motion` and
  /// `end_by_motion` by the shape (ShapeVector, and 0), and tables of kStep. Searches once there
  /// are enough.
  void take_view(std::span<const AlignmentContour> contours, std::span<AlignmentTable> tables,
                 AlignmentSearch& search);

  /// Takes over what an image says, which began with this belief, of a shape that was found: the
  /// `share` of it that was not told by those before. Where few of the contours are found in many
  /// images, the search begins anew.
  void learn(const ShapeBelief& after, const PipeSupport& support, double share);

 private:
  struct View {
    std::vector<AlignmentContour> contours;
    std::vector<AlignmentTable> tables;
  };
  void search(AlignmentSearch& search);
  void keep_floor();

  ShapeMatrix prior_ = ShapeMatrix::Zero();
  ShapeVector mean_ = ShapeVector::Zero();
  ShapeMatrix covariance_ = ShapeMatrix::Zero();
  bool found_ = false;
  double seen_ = 0;  ///< of the view that is taken next
  std::vector<View> views_;
  int images_in_doubt_ = 0;
};

}  // namespace pipescout::rack_vision
