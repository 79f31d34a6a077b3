// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <bitset>
#include <optional>
#include <vector>

#include "image_window.hpp"
#include "pipescout/geometry/camera.hpp"
#include "pipescout/geometry/se3.hpp"
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

/// Where one pipe was found. Scores are log-likelihood ratios against contours that are nowhere.
struct PipePlace {
  double offset = 0;  ///< m
  /// By how much the row is explained better with the pipe there than with it anywhere else.
  double margin = 0;
  bool both_in_view = false;  ///< both contours, on some length
};

class RowPlacement {
 public:
  RowPlacement(const RackModel& model, const geometry::Camera& camera);

  void set_camera(const geometry::Camera& camera) { camera_ = camera; }

  /// Searches the pipes of `searched` within `reach`, m, of `offsets`; the others stay there.
  /// `prior`: of the offsets; variances that are 0 say nothing.
  void search(const ImageView& image, const geometry::SE3& T_camera_rack,
              const std::array<double, kMaxPipes>& offsets, const std::bitset<kMaxPipes>& searched,
              const std::array<double, kMaxPipes>& reach, const OffsetBelief& prior);

  /// Of a pipe of the last search; `offsets` as given to it. A pipe that was not searched, or is
  /// out of view wherever it lies, has no margin.
  [[nodiscard]] PipePlace place(std::size_t pipe);
  /// By how much the row of the last search is explained better with the pipe more than a few
  /// pixels beside `offset` than with it there; 0 when it is best there.
  [[nodiscard]] double better_elsewhere(std::size_t pipe, double offset);

 private:
  struct Lane {
    std::size_t pipe = 0;
    bool seen = false;          ///< some of its places are in view
    double first = 0;           ///< m, of the first offset
    double step = 0;            ///< m
    double pixel = 0;           ///< m, an offset that moves the contours by one
    std::vector<double> score;  ///< by offset, with the prior
    std::vector<bool> both;     ///< whether both contours are in view
    std::vector<double> best;   ///< of this lane and those before it
    std::vector<int> from;      ///< index in the lane before

    [[nodiscard]] double offset(std::size_t k) const {
      return first + static_cast<double>(k) * step;
    }
  };
  /// Offsets of one lane that count: those within, or beyond, a few pixels of one.
  struct Limit {
    std::size_t lane = 0;
    double offset = 0;
    bool within = false;
  };

  void fill(const ImageView& image, const ImageWindow& window, Lane& lane);
  /// Of one contour in view, sampled; nothing when it is too short.
  [[nodiscard]] double contour_score(const ImageView& image, const Eigen::Vector2d& start,
                                     const Eigen::Vector2d& end) const;
  /// Smallest distance of two neighbours' axes along rack x, m; nothing where one may lie over the
  /// other.
  [[nodiscard]] std::optional<double> least_distance(std::size_t left, std::size_t right) const;
  /// Score of the best offsets under a limit; with `offsets`, these.
  double best_row(const Limit* limit, std::array<double, kMaxPipes>* offsets);
  [[nodiscard]] std::optional<std::size_t> lane_of(std::size_t pipe) const;

  RackModel model_;
  geometry::Camera camera_;
  std::vector<std::size_t> order_;  ///< of the pipes along y, from left to right
  std::vector<Lane> lanes_;
  std::vector<PipeSection> sections_;
  double best_ = 0;  ///< score of the last search
  std::array<double, kMaxPipes> places_{};
};

}  // namespace pipescout::rack_vision
