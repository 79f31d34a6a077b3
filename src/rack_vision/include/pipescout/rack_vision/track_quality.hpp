// SPDX-License-Identifier: Apache-2.0
#pragma once

/// Agreement of an image with the estimated pose.
namespace pipescout::rack_vision {

/// Evidence of one image for one pose.
struct TrackEvidence {
  /// samples on visible edges of pipes and supports, completely in the image
  int edge_samples = 0;
  int edge_samples_found = 0;  ///< with an edge at the predicted position
  int edges = 0;               ///< sections with enough samples for the score
  int points = 0;              ///< texture points searched
  int points_matched = 0;      ///< matched at the predicted position
  /// The same for points that were matched repeatedly before: if these fail, the reason is not
  /// missing texture.
  int proven_points = 0;
  int proven_matched = 0;
};

/// 0 (no evidence for the pose) to 1. 0.5 and more: safe to use.
///
/// Edges: share found. Points: share of proven ones matched, if there are enough of them; if points
/// fail while edges are found, the edges are those of another position, so the lower of the two is
/// used. The residuals of the others are not used, because clutter may be anywhere.
[[nodiscard]] double track_quality(const TrackEvidence& evidence) noexcept;

}  // namespace pipescout::rack_vision
