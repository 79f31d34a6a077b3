// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "pipescout/geometry/camera.hpp"
#include "pipescout/geometry/se3.hpp"
#include "pipescout/rack_vision/image_noise.hpp"
#include "pipescout/rack_vision/image_view.hpp"
#include "pipescout/rack_vision/patch_alignment.hpp"
#include "pipescout/rack_vision/pose_solver.hpp"
#include "pipescout/rack_vision/rack_model.hpp"
#include "pipescout/rack_vision/row_motion.hpp"
#include "pipescout/rack_vision/surface_points.hpp"

/// The texture of the pipes as a map of points (Lippiello and Cacace, section III, "Texture
/// features"): created where the rays of corners meet the surface, matched in later images.
///
/// Error model of a point. The error of a point has two sources: noise of its pixels, and the error
/// of the pose from which it was created, which is common to all points created then. The second
/// part does not average out: it is one common state of all points, estimated with the pose (see
/// MapErrorPrior) and removed by `correct`. Along the rack's y axis, where only points (and a
/// support now and then) determine the position, it is the `anchor_variance`: the uncertainty of
/// the absolute position along y. Poses are computed relative to the best anchored points in view,
/// and new points inherit their anchor plus the error of the chain. So the drift of a chain of
/// points is in the covariance, and matching old points again removes it (loop closure).
namespace pipescout::rack_vision {

struct TextureMapParameters {
  int capacity = 2000;        ///< points kept, 0..20000
  int points_per_frame = 60;  ///< searched in one image, 0..200
  int cells_per_frame = 10;   ///< cells of the image searched for new points, 0..500
  int cell_side = 40;         ///< px, 24..120: one point is wanted in each cell
  double point_sigma = 0.15;  ///< px, > 0: noise of a matched point
  /// Grey levels, > 0: smallest standard deviation of a textured patch, up to kNominalNoise; above
  /// it, it grows with the noise.
  double least_contrast = 3;
  /// 0..1, of a match, of the correlation that noise leaves to two images of the same place.
  double least_correlation = 0.80;
  double least_facing = 0.5;  ///< cosine between surface normal and ray, 0..1

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

/// Estimated view of an image.
struct UncertainView {
  geometry::SE3 T_camera_rack;
  /// Of T_rack_camera, as in pose_solver.hpp; along y relative to the anchor. For updating and
  /// adding points, the part that is independent of the map.
  geometry::Matrix6d covariance = geometry::Matrix6d::Zero();
  double anchor_variance = 0;  ///< m^2
  PipeOffsets offsets;
  std::bitset<kMaxPipes> unplaced;  ///< as in OffsetBelief: no points are added on them
};

/// A point searched in an image.
struct MatchedPoint {
  std::uint32_t point = 0;  ///< of the map; valid until the map grows
  bool proven = false;      ///< matched in most earlier images, and in several
  bool found = false;
  /// Ideal; with a rolling shutter, where the middle row would have seen it.
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  Eigen::Vector2d predicted = Eigen::Vector2d::Zero();  ///< of the image, distorted
  double sigma = 0;                                     ///< px
  double correlation = 0;                               ///< -1..1
};

class TextureMap {
 public:
  /// Throws std::invalid_argument as TextureMapParameters::validate. `model` must be valid.
  TextureMap(const RackModel& model, const geometry::Camera& camera,
             const TextureMapParameters& parameters);

  /// Selects the points to search: visible, distributed over the image, proven and well anchored
  /// ones first. Replaces `matches`, ordered so that the first ones are already well distributed.
  void choose(const UncertainView& view, const RackSurface& surface,
              std::vector<MatchedPoint>& matches);

  /// Searches matches first .. first + count - 1 in the image. Large windows (an uncertain view)
  /// take more time than small ones: search a few, solve, and search the others from the solution.
  void match(const ImageView& image, const UncertainView& view, std::size_t first,
             std::size_t count, std::vector<MatchedPoint>& matches);

  /// Input of the solver from the successful matches. The poses are relative to the anchor whose
  /// variance is returned, m^2; nothing when no point was matched.
  std::optional<double> observations(const std::vector<MatchedPoint>& matches,
                                     std::vector<PointObservation>& points) const;

  /// Updates the points with the matches at the final view: counts, refines, prunes. A match
  /// farther than `gate` px from its predicted pixel counts as failed. Returns the number of
  /// inliers. Invalidates the matches.
  int learn(const UncertainView& view, const std::vector<MatchedPoint>& matches, double gate);

  /// Creates points in cells without points.
  void grow(const ImageView& image, const UncertainView& view, const RackSurface& surface);

  /// Corrects all points by their estimated common error: see MapErrorPrior.
  void correct(const geometry::Vector6d& map_error) noexcept;

  /// Moves the points seen in the last image that was learned from along y, and anchors them at
  /// least as well.
  void shift_seen(double along, double anchor_variance);

  /// Sets a better calibration of the same camera: points keep their positions.
  void set_camera(const geometry::Camera& camera) { camera_ = camera; }

  /// Sets the noise of the images that come next; none before.
  void set_noise(const ImageNoise& noise) noexcept { noise_ = noise; }

  /// Sets the motion during the images that come next; a global shutter before. Views are those of
  /// the middle row.
  void set_row_motion(const RowMotion& rows) noexcept { row_motion_ = rows; }

  [[nodiscard]] std::size_t size() const noexcept { return points_.size(); }
  void clear() noexcept;

 private:
  /// Derivative of one coordinate with respect to the motion [dc; dphi] of the camera.
  using MotionRow = Eigen::Matrix<double, 1, 6>;
  struct Point {
    std::uint16_t pipe = 0;
    Eigen::Vector3d place;      ///< rack frame
    double offset = 0;          ///< of its pipe, m, estimated when the point was created
    Eigen::Vector3d made_from;  ///< from the camera to it when it was created, rack frame
    /// Effect of errors of the creating pose, except that along y, on the middle of the view along
    /// y.
    MotionRow made_middle;
    Eigen::Vector3d normal;  ///< outward
    /// Derivative of the pixel by (along, around) when the patch was stored, px/m.
    Eigen::Matrix2d stored_scale;
    double own_variance = 0;  ///< m^2, in both directions on the surface
    /// m^2, pipes along y: of the whole section of rack in the same view
    double anchor_variance = 0;
    double along_variance = 0;   ///< m^2: along the pipe, from the pose; without the anchor
    double around_variance = 0;  ///< m^2: around it, from the pose
    std::uint32_t found = 0;
    std::uint32_t failed = 0;
    std::uint64_t seen = 0;  ///< number of the image in which it was last matched
    StoredPatch patch;
  };
  struct Projection {
    Eigen::Vector2d pixel;
    Eigen::Matrix2d scale;  ///< derivative by (along, around), px/m
    geometry::Matrix23d by_place;
    Eigen::Vector3d from_camera;  ///< rack frame
  };
  struct Choice {
    std::uint32_t point;
    std::int32_t cell;
    double score;
    Eigen::Vector2d pixel;
  };

  [[nodiscard]] std::optional<Projection> project(const Point& point,
                                                  const UncertainView& view) const noexcept;
  /// Derivative of the pixel with respect to the motion of the camera.
  [[nodiscard]] static Eigen::Matrix<double, 2, 6> by_motion(const Projection& projection) noexcept;
  /// The view when a row of the image is exposed.
  [[nodiscard]] UncertainView view_of_row(const UncertainView& view, double row) const;
  /// Moves the pixel of a match to where the middle row would have seen it, and widens its sigma by
  /// what the velocity is uncertain by. `row`: in which it was seen.
  void correct_for_row(const Point& point, const UncertainView& view, double row,
                       const Projection& projection, MatchedPoint& match) const;
  /// Covariance of that correction, px^2.
  [[nodiscard]] Eigen::Matrix2d row_variance(const Projection& projection, double row) const;
  [[nodiscard]] Eigen::Vector3d around(const Point& point) const noexcept;
  /// Variance of a point's position due to the error of the pose, m^2. `middle`: effect on the
  /// middle of the view along y.
  struct PlaceVariance {
    double anchor = 0;  ///< along y, in the middle of the image
    double along = 0;   ///< along the pipe; pipes along y: relative to the middle
    double around = 0;
  };
  [[nodiscard]] PlaceVariance pose_variance(const Point& point, const Eigen::Vector3d& from_camera,
                                            const UncertainView& view,
                                            const MotionRow& middle) const noexcept;
  void refine(Point& point, const UncertainView& view, const MotionRow& middle,
              const Projection& projection, const MatchedPoint& match,
              const Eigen::Vector2d& error) const;
  /// Effect of an error of the creating pose on a point: along y relative to the middle of the same
  /// view, which the anchor covers.
  [[nodiscard]] Eigen::Vector3d step_by_map_error(
      const Point& point, const geometry::Vector6d& map_error) const noexcept;
  [[nodiscard]] Eigen::Matrix<double, 3, 6> by_map_error(const Point& point) const noexcept;
  [[nodiscard]] bool anchored_by_y(const Point& point) const noexcept;
  void add(const ImageView& image, const UncertainView& view, const MotionRow& middle,
           const RackSurface& surface, const Eigen::Vector2i& corner);
  void make_room(const UncertainView& view);

  std::vector<Pipe> pipes_;
  geometry::Camera camera_;
  TextureMapParameters parameters_;
  ImageNoise noise_;
  RowMotion row_motion_;
  std::vector<Point> points_;
  std::vector<Choice> choices_;
  std::vector<std::uint8_t> occupied_;  ///< per cell
  int columns_ = 0;
  int rows_ = 0;
  int next_cell_ = 0;
  std::uint64_t image_ = 0;
  std::uint64_t last_seen_ = 0;  ///< the image in which points were seen last
};

}  // namespace pipescout::rack_vision
