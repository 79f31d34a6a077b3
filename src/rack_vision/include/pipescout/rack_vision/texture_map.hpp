// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "pipescout/geometry/camera.hpp"
#include "pipescout/geometry/se3.hpp"
#include "pipescout/rack_vision/image_view.hpp"
#include "pipescout/rack_vision/patch_alignment.hpp"
#include "pipescout/rack_vision/pose_solver.hpp"
#include "pipescout/rack_vision/rack_model.hpp"
#include "pipescout/rack_vision/surface_points.hpp"

/// The texture of the pipes as a map of points (Lippiello and Cacace, section III, "Texture
/// features"): made where the rays of corners meet the surface, found again in later images.
///
/// How a point's error is booked. What a point is wrong by comes from two sources: noise of its own
/// pixels, and the pose from which it was made, which is wrong for all points made then. The second
/// part does not average out: it is one unknown of all points, estimated with the pose (see
/// MapErrorPrior) and taken out by `correct`. Along the rack's y axis, where nothing but points
/// (and a support now and then) says where the camera is, it is carried as `anchor_variance`: how
/// well the place along y is known at all. Poses are computed relative to the best anchored points
/// in view, and new points inherit their anchor with what the chain adds to it; so a chain of
/// points drifts and says so, and meeting old points again takes the drift back.
namespace pipescout::rack_vision {

struct TextureMapParameters {
  int capacity = 2000;              ///< points kept, 0..20000
  int points_per_frame = 60;        ///< searched in one image, 0..200
  int cells_per_frame = 10;         ///< cells of the image looked through for new points, 0..500
  int cell_side = 40;               ///< px, 24..120: one point is wanted in each cell
  double point_sigma = 0.15;        ///< px, > 0: noise of a matched point
  double least_contrast = 3;        ///< grey levels, > 0: deviation within a patch that is texture
  double least_correlation = 0.80;  ///< 0..1, of a match
  double least_facing = 0.5;        ///< cosine between surface normal and ray, 0..1

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

/// From where an image is looked at, as far as it is known.
struct UncertainView {
  geometry::SE3 T_camera_rack;
  /// Of T_rack_camera, as in pose_solver.hpp; along y relative to the anchor. To learn and to grow,
  /// what the map does not share of it.
  geometry::Matrix6d covariance = geometry::Matrix6d::Zero();
  double anchor_variance = 0;  ///< m^2
  PipeOffsets offsets;
};

/// A point that was searched in an image.
struct MatchedPoint {
  std::uint32_t point = 0;  ///< of the map; valid until the map grows
  bool proven = false;      ///< found in most images before, and in several
  bool found = false;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();      ///< ideal
  Eigen::Vector2d predicted = Eigen::Vector2d::Zero();  ///< of the image, distorted
  double sigma = 0;                                     ///< px
  double correlation = 0;                               ///< -1..1
};

class TextureMap {
 public:
  /// Throws std::invalid_argument as TextureMapParameters::validate. `model` must be valid.
  TextureMap(const RackModel& model, const geometry::Camera& camera,
             const TextureMapParameters& parameters);

  /// Chooses the points to search: visible, spread over the image, trusted and well anchored ones
  /// first. `matches` is replaced; their order is such that the first ones are already spread.
  void choose(const UncertainView& view, const RackSurface& surface,
              std::vector<MatchedPoint>& matches);

  /// Searches matches first .. first + count - 1 in the image. Wide windows (an uncertain view)
  /// cost more than narrow ones: search a few, solve, and search the others from there.
  void match(const ImageView& image, const UncertainView& view, std::size_t first,
             std::size_t count, std::vector<MatchedPoint>& matches);

  /// What the solver needs of the matches that were found. Poses solved from it are relative to the
  /// anchor that is returned: its variance, m^2; nothing when no point was found.
  std::optional<double> observations(const std::vector<MatchedPoint>& matches,
                                     std::vector<PointObservation>& points) const;

  /// Takes over what came of the matches at the final view: counts, refines, prunes. A match whose
  /// pixel is farther than `gate` px from where the view has it counts as failed. Returns how many
  /// agreed. Matches are void afterwards.
  int learn(const UncertainView& view, const std::vector<MatchedPoint>& matches, double gate);

  /// Makes points in cells that lack them.
  void grow(const ImageView& image, const UncertainView& view, const RackSurface& surface);

  /// Moves all points by what they are found to be wrong by together: see MapErrorPrior.
  void correct(const geometry::Vector6d& map_error) noexcept;

  /// Moves the points that were seen in the last image along y, and anchors them at least as well.
  void shift_seen(double along, double anchor_variance);

  /// A better calibration of the same camera, from now on: points stay where they are.
  void set_camera(const geometry::Camera& camera) { camera_ = camera; }

  [[nodiscard]] std::size_t size() const noexcept { return points_.size(); }
  void clear() noexcept;

 private:
  /// What motion [dc; dphi] of the camera does to one coordinate.
  using MotionRow = Eigen::Matrix<double, 1, 6>;
  struct Point {
    std::uint16_t pipe = 0;
    Eigen::Vector3d place;      ///< rack frame
    double offset = 0;          ///< of its pipe, m, as believed when the point was made
    Eigen::Vector3d made_from;  ///< from the camera to it when it was made, rack frame
    /// How errors of the pose from which it was made, but the one along y, moved the middle of what
    /// was seen along y.
    MotionRow made_middle;
    Eigen::Vector3d normal;  ///< outward
    /// Derivative of the pixel by (along, around) when the patch was stored, px/m.
    Eigen::Matrix2d stored_scale;
    double own_variance = 0;     ///< m^2, in both directions on the surface
    double anchor_variance = 0;  ///< m^2, pipes along y: of the whole patch of rack seen with it
    double along_variance = 0;   ///< m^2: along the pipe, from the pose; beside the anchor
    double around_variance = 0;  ///< m^2: around it, from the pose
    std::uint32_t found = 0;
    std::uint32_t failed = 0;
    std::uint64_t seen = 0;  ///< number of the image in which it was last found
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
  [[nodiscard]] Eigen::Vector3d around(const Point& point) const noexcept;
  /// What an error of the pose makes of a point's place, m^2. `middle`: what it makes of the middle
  /// of the view along y.
  struct PlaceVariance {
    double anchor = 0;  ///< along y, in the middle of the image
    double along = 0;   ///< along the pipe; pipes along y: beside what it does in the middle
    double around = 0;
  };
  [[nodiscard]] PlaceVariance pose_variance(const Point& point, const Eigen::Vector3d& from_camera,
                                            const UncertainView& view,
                                            const MotionRow& middle) const noexcept;
  void refine(Point& point, const UncertainView& view, const MotionRow& middle,
              const Projection& projection, const MatchedPoint& match,
              const Eigen::Vector2d& error) const;
  /// How an error of the pose from which it was made moves a point: along y against the middle of
  /// what was seen with it, which is the anchor's business.
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
  std::vector<Point> points_;
  std::vector<Choice> choices_;
  std::vector<std::uint8_t> occupied_;  ///< per cell
  int columns_ = 0;
  int rows_ = 0;
  int next_cell_ = 0;
  std::uint64_t image_ = 0;
};

}  // namespace pipescout::rack_vision
