// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "pipescout/geometry/camera.hpp"
#include "pipescout/geometry/se3.hpp"
#include "pipescout/rack_vision/image_view.hpp"

/// Where all rendered contours line up with the image, over a wide range of poses.
///
/// A straight contour gives a strong mean difference in grey level across it over all its length;
/// texture does not. That mean is tabulated once for all displacements of the two ends of a
/// contour, and then looked up for some hundred thousand poses.
namespace pipescout::rack_vision {

/// Grey level of the pixel in which an ideal pixel is seen, or of the nearest one at the border.
[[nodiscard]] float nearest_grey(const ImageView& image, const geometry::Camera& camera,
                                 const Eigen::Vector2d& ideal) noexcept;

/// A contour as it is rendered, and how it moves.
struct AlignmentContour {
  Eigen::Vector2d start, end;  ///< ideal pixels
  Eigen::Vector2d normal;      ///< unit vector, away from the body
  /// Displacement of both ends along the normal, px, by a motion of the camera as in
  /// `pose_difference`.
  geometry::Vector6d start_by_motion, end_by_motion;
  double sign = 0;  ///< of outside minus inside, where it is known: -1 or 1
};

/// Of one contour, how strong the mean difference across it is, by the displacements of its ends.
struct AlignmentTable {
  double weight = 0;          ///< of the strongest
  int reach = 0;              ///< in steps, to either side
  std::vector<float> scores;  ///< (2 reach + 1)^2, by start and end
};

struct AlignmentPeak {
  geometry::Vector6d motion;  ///< from the pose that the contours are rendered at
  double score = 0;           ///< like a log-likelihood, with that of the motion in it
};

class AlignmentSearch {
 public:
  explicit AlignmentSearch(const geometry::Camera& camera) : camera_(camera) {}
  /// Another camera of the same size, from now on.
  void set_camera(const geometry::Camera& camera) { camera_ = camera; }

  /// Searches motions of up to three standard deviations. `step`: px between neighbouring poses,
  /// and the width of what counts as an edge. Up to `most` peaks, the best first, no two of which
  /// have the contours within `distance` px of each other, root of the mean square. None without
  /// contours.
  void search(const ImageView& image, std::span<const AlignmentContour> contours,
              const geometry::Matrix6d& covariance, double step, double distance, std::size_t most,
              std::vector<AlignmentPeak>& peaks);

  /// The same over tables that were filled before with this step, one per contour: contours may be
  /// those of several images, and motions those of anything. At most `most_poses` are tried,
  /// farther apart than a step where they must.
  void search(std::span<const AlignmentContour> contours, std::span<const AlignmentTable> tables,
              const geometry::Matrix6d& covariance, double step, double distance, std::size_t most,
              std::size_t most_poses, std::vector<AlignmentPeak>& peaks);

  /// Fills a table for displacements of up to `reach`, px.
  void tabulate(const ImageView& image, const AlignmentContour& contour, double step, double reach,
                AlignmentTable& table);

  /// What remains unknown after a search with this step.
  [[nodiscard]] static geometry::Matrix6d remaining(std::span<const AlignmentContour> contours,
                                                    const geometry::Matrix6d& covariance,
                                                    double step);

 private:
  /// A direction of motions, such that different ones move the contours independently.
  struct Direction {
    geometry::Vector6d motion;   ///< one standard deviation
    geometry::Vector6d by_step;  ///< the same of one step of the search
    double pixels = 0;           ///< that `motion` moves the contours, root of the mean square
    int steps = 0;               ///< to either side
  };

  void choose_directions(std::span<const AlignmentContour> contours,
                         const geometry::Matrix6d& covariance, double step, std::size_t most_poses);
  void score_all(std::span<const AlignmentContour> contours, std::span<const AlignmentTable> tables,
                 double step);
  void find_peaks(std::span<const AlignmentContour> contours, double distance, std::size_t most,
                  std::vector<AlignmentPeak>& peaks) const;
  /// Of an entry of `scores_`.
  [[nodiscard]] geometry::Vector6d motion_of(std::size_t index) const;

  geometry::Camera camera_;
  std::vector<AlignmentTable> tables_;
  std::vector<Direction> directions_;
  std::vector<float> profile_;
  std::vector<float> differences_;
  std::vector<float> scores_;  ///< of all combinations of steps, the first direction innermost
};

}  // namespace pipescout::rack_vision
