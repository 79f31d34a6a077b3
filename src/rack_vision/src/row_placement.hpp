// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <bitset>
#include <span>
#include <vector>

#include "pipescout/geometry/camera.hpp"
#include "pipescout/rack_vision/image_view.hpp"
#include "pipescout/rack_vision/pose_solver.hpp"
#include "pipescout/rack_vision/rack_model.hpp"

/// Where the pipes of a row lie beside their places in the model, as seen from a given pose.
///
/// A pipe that lies elsewhere shows the same two contours at the same distance from each other
/// elsewhere, which a neighbour of another diameter or the border of a shadow does not; and pipes
/// do not run through each other. So: the mean difference in grey level across both contours, for
/// each offset of each pipe, and the best offsets of all pipes together by dynamic programming.
namespace pipescout::rack_vision {

/// A contour of a pipe as it is rendered, and how it moves with its pipe.
struct MovingContour {
  std::size_t pipe = 0;
  Eigen::Vector2d start, end;  ///< ideal pixels
  Eigen::Vector2d normal;      ///< unit vector
  /// Displacement along the normal by an offset, px/m, of both ends.
  double start_by_offset = 0;
  double end_by_offset = 0;
};

/// Log-likelihood-like; larger is better.
struct RowPlaces {
  std::array<double, kMaxPipes> offsets{};  ///< m; of pipes that were not searched: as before
  double score = 0;
};

class RowPlacement {
 public:
  RowPlacement(const RackModel& model, const geometry::Camera& camera);

  void set_camera(const geometry::Camera& camera) { camera_ = camera; }

  /// Searches the pipes of `searched` around `offsets`, at which the contours are rendered, within
  /// `reach` of each, m; the others stay. `prior`: of the offsets. Replaces `places`: the best
  /// first, then up to `most - 1` others that have one pipe elsewhere and score nearly as well.
  void search(const ImageView& image, std::span<const MovingContour> contours,
              const std::array<double, kMaxPipes>& offsets, const std::bitset<kMaxPipes>& searched,
              const std::array<double, kMaxPipes>& reach, const OffsetBelief& prior,
              std::size_t most, std::vector<RowPlaces>& places);

  /// Of one pipe, of the last search: the best score at any offset over that at its offset, not
  /// more than a few pixels beside it; without the prior.
  [[nodiscard]] double better_elsewhere(std::size_t pipe) const noexcept;

 private:
  struct Lane {
    std::size_t pipe = 0;
    double first = 0;              ///< m, of the first offset
    double step = 0;               ///< m
    std::vector<double> strength;  ///< of the contours, by offset
    std::vector<double> score;     ///< with the prior
    std::vector<double> best;      ///< of this lane and those before it
    std::vector<int> from;         ///< index in the lane before
  };

  void sample(const ImageView& image, std::span<const MovingContour> contours, double offset,
              Lane& lane);
  [[nodiscard]] double strength_at(const ImageView& image, const MovingContour& contour,
                                   double shift) const;
  /// Smallest distance of two neighbours' axes along rack x, m.
  [[nodiscard]] double least_distance(std::size_t left, std::size_t right) const;
  [[nodiscard]] RowPlaces best_places(const std::array<double, kMaxPipes>& offsets, int barred_lane,
                                      double barred_offset);

  RackModel model_;
  geometry::Camera camera_;
  std::vector<std::size_t> order_;  ///< of the movable pipes along y, from left to right
  std::vector<Lane> lanes_;
  std::size_t used_ = 0;  ///< lanes of the last search
};

}  // namespace pipescout::rack_vision
