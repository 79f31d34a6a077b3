// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "pipescout/geometry/camera.hpp"
#include "pipescout/geometry/se3.hpp"
#include "pipescout/rack_vision/image_view.hpp"
#include "pipescout/rack_vision/rack_model.hpp"

/// Initialisation: the pose of a camera over a rack from one image without a prior, which the paper
/// of Lippiello and Cacace assumes as given.
///
/// The contours of parallel pipes are a pencil of lines: their planes through the camera's centre
/// all contain the flow direction, which determines two angles of the rotation. Projected along the
/// flow, the image is a profile of edges over their bearings, and pipes are circles: position and
/// roll of the camera are searched on a grid. Each candidate is refined on the edges of the whole
/// model, as in tracking, and scored by the edges found in the image and by edges that should not
/// be there.
namespace pipescout::rack_vision {

/// Prior from GPS or an operator. Each part is optional.
struct FirstPoseHint {
  struct Value {
    double value = 0;
    double standard_deviation = 1;  ///< > 0
  };
  std::optional<Value> x, y, z;  ///< the camera's centre, rack frame, m
  /// Angle about rack z from rack x to the camera's x axis (to the right in the
  /// image), rad: at 0 the upper border of a camera that looks down is ahead,
  /// in the direction of the flow.
  std::optional<Value> heading;

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

struct FirstPoseParameters {
  double smallest_height = 0.5;  ///< of the camera above the highest pipe's axis, m, > 0
  double largest_height = 12;    ///< m, > smallest_height
  double largest_beside = 2;     ///< of the camera, beyond the outermost pipes' axes, m, >= 0
  double largest_tilt = 0.45;    ///< of the optical axis from straight down, rad, (0, 1.2]
  double typical_tilt = 0.2;     ///< of the optical axis, standard deviation, rad, > 0
  double edge_sigma = 0.3;       ///< of a contour relative to the model, pixels, > 0
  double shortest_segment = 20;  ///< of segments that are used to estimate directions, pixels, > 0
  std::size_t smallest_matches = 6;  ///< smallest number of found edges, >= 3
  double smallest_score = 0.55;      ///< of an accepted pose, (0, 1)
  double smallest_evidence = 3;      ///< of an accepted pose, nats, > 0
  /// The result is ambiguous if the evidence of a different pose is less than this below the best,
  /// nats, > 0.
  double rival_margin = 3;
  double largest_deviation = 0.05;  ///< in x and z of an accepted pose, m, > 0
  /// Standard deviation along the flow when that position is unobservable, m, > 0.
  double unknown_along = 100;

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

enum class FirstPoseStatus : std::uint8_t {
  kFound,  ///< one pose explains the image, and no other one about as well
  /// Several poses explain it, or one that is too uncertain: see FirstPose::candidates. Do not use
  /// any of them.
  kAmbiguous,
  kNotEnoughEdges,  ///< no pose explains the image
};

/// One pose that explains the image.
struct FirstPoseCandidate {
  geometry::SE3 T_camera_rack;
  /// Of mu = [translation; rotation] in the rack frame, T' = T exp(mu), m and
  /// rad (equation 5). Along the flow it is that of the hint, or
  /// FirstPoseParameters::unknown_along squared, unless `along_from_image`.
  geometry::Matrix6d covariance = geometry::Matrix6d::Zero();
  double score = 0;               ///< 0 to 1: evidence as a share of the possible evidence
  std::size_t matches = 0;        ///< found edges, at least three contours of pipes
  bool along_from_image = false;  ///< position along the flow from supports, ends or crossing pipes
};

struct FirstPose {
  FirstPoseStatus status = FirstPoseStatus::kNotEnoughEdges;
  /// Best first, at most kMaxFirstPoseCandidates; the first is the pose when
  /// status is kFound.
  std::vector<FirstPoseCandidate> candidates;
};

inline constexpr std::size_t kMaxFirstPoseCandidates = 8;

/// Deterministic; allocates.
class FirstPoseFinder {
 public:
  /// Throws as FirstPoseParameters::validate.
  explicit FirstPoseFinder(const FirstPoseParameters& parameters);

  /// Throws std::invalid_argument when fewer than two pipes of the model run along y:
  /// initialisation is then impossible.
  static void check(const RackModel& model);

  /// `model` must be valid, `offsets` as PipeOffsets. Takes some tens of ms. Throws
  /// std::invalid_argument as FirstPoseHint::validate, when the view is not valid or of another
  /// size than the camera, when the number of offsets differs from that of pipes, and as `check`.
  [[nodiscard]] FirstPose find(const ImageView& image, const RackModel& model, PipeOffsets offsets,
                               const geometry::Camera& camera, const FirstPoseHint& hint) const;

  [[nodiscard]] const FirstPoseParameters& parameters() const noexcept { return parameters_; }

 private:
  FirstPoseParameters parameters_;
};

/// For messages: "found", "ambiguous", "not enough edges"; "unknown" for any other value.
[[nodiscard]] const char* to_string(FirstPoseStatus status) noexcept;

}  // namespace pipescout::rack_vision
