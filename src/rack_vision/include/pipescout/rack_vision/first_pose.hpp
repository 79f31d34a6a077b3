// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "pipescout/geometry/camera.hpp"
#include "pipescout/geometry/se3.hpp"
#include "pipescout/rack_vision/rack_model.hpp"

/// The pose of a camera over a rack from one image and no guess: what the tracking of Lippiello and
/// Cacace starts from, which their paper takes as given.
///
/// The contours of parallel pipes are a pencil of lines: their planes through the camera's centre
/// all hold the flow direction. It gives two angles of the rotation. Seen along the flow, what is
/// left is a resection in a plane: place and roll of the camera from the bearings of tangents to
/// circles that are known, three of which have a closed form.
namespace pipescout::rack_vision {

/// A straight edge in the image.
struct ImageSegment {
  /// Ideal pixels (no distortion). Looking from start to end, the brighter side is on the right.
  Eigen::Vector2d start = Eigen::Vector2d::Zero();
  Eigen::Vector2d end = Eigen::Vector2d::Zero();
  double contrast = 1;  ///< mean step of brightness across it, grey levels, > 0
};

/// What is known beforehand, from GPS or an operator. Each part may be missing.
struct FirstPoseHint {
  struct Value {
    double value = 0;
    double standard_deviation = 1;  ///< > 0
  };
  std::optional<Value> x, y, z;  ///< the camera's centre, rack frame, m
  /// Angle about rack z from rack x to the camera's x axis (to the right in the image), rad: at 0
  /// the upper border of a camera that looks down is ahead, in the direction of the flow.
  std::optional<Value> heading;

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

struct FirstPoseParameters {
  double smallest_height = 0.5;      ///< of the camera above the highest pipe's axis, m, > 0
  double largest_height = 12;        ///< m, > smallest_height
  double largest_beside = 2;         ///< of the camera, beyond the outermost pipes' axes, m, >= 0
  double largest_tilt = 0.45;        ///< of the optical axis against straight down, rad, (0, 1.2]
  double pixel_tolerance = 2.0;      ///< of an edge from where the model has it, pixels, > 0
  double segment_sigma = 0.3;        ///< of a segment's ends across it, pixels, > 0
  double shortest_segment = 20;      ///< pixels, > 0
  std::size_t largest_lines = 48;    ///< of the pencil that are tried, longest first, 4 to 64
  std::size_t smallest_matches = 4;  ///< contours that must have been found, >= 4
  double smallest_score = 0.55;      ///< of a pose that is believed, (0, 1)
  /// Poses as good that are to be expected among lines that are parallel by chance, > 0.
  double largest_false_alarms = 0.05;
  /// A different pose that scores this share of the best makes the result ambiguous, (0, 1).
  double rival_share = 0.85;
  /// Standard deviation along the flow when nothing says where the camera is, m, > 0.
  double unknown_along = 100;

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

enum class FirstPoseStatus : std::uint8_t {
  kFound,           ///< one pose explains the image, and no other does about as well
  kAmbiguous,       ///< several poses do: see FirstPose::candidates. None is to be trusted
  kNotEnoughEdges,  ///< no pose explains the image
};

/// One pose that explains the image.
struct FirstPoseCandidate {
  geometry::SE3 T_camera_rack;
  /// Of mu = [translation; rotation] in the rack frame, T' = T exp(mu), m and rad (equation 5).
  /// Along the flow it is that of the hint, or FirstPoseParameters::unknown_along squared, unless
  /// `along_from_image`.
  geometry::Matrix6d covariance = geometry::Matrix6d::Zero();
  double score = 0;               ///< 0 to 1: share of the model's edges and the image's explained
  std::size_t matches = 0;        ///< contours of pipes that were found
  bool along_from_image = false;  ///< place along the flow from supports, ends or crossing pipes
};

struct FirstPose {
  FirstPoseStatus status = FirstPoseStatus::kNotEnoughEdges;
  /// Best first, at most kMaxFirstPoseCandidates; the first is the pose when status is kFound.
  std::vector<FirstPoseCandidate> candidates;
  std::size_t pencil_lines = 0;  ///< lines of the image that run along the flow
};

inline constexpr std::size_t kMaxFirstPoseCandidates = 8;

/// Bad segments (NaN, no length) are left out. Deterministic; allocates.
class FirstPoseFinder {
 public:
  /// Throws as FirstPoseParameters::validate.
  explicit FirstPoseFinder(const FirstPoseParameters& parameters);

  /// `model` must be valid, `offsets` as PipeOffsets. Throws std::invalid_argument as
  /// FirstPoseHint::validate, when there are offsets of another number than pipes, and when no two
  /// pipes of the model run along y.
  [[nodiscard]] FirstPose find(std::span<const ImageSegment> segments, const RackModel& model,
                               PipeOffsets offsets, const geometry::Camera& camera,
                               const FirstPoseHint& hint) const;

  [[nodiscard]] const FirstPoseParameters& parameters() const noexcept { return parameters_; }

 private:
  FirstPoseParameters parameters_;
};

/// For people: "found", "ambiguous", "not enough edges"; "unknown" for a value that is none.
[[nodiscard]] const char* to_string(FirstPoseStatus status) noexcept;

}  // namespace pipescout::rack_vision
