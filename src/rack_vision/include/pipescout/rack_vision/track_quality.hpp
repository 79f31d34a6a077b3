// SPDX-License-Identifier: Apache-2.0
#pragma once

/// How far the image bears out the pose that was found in it.
namespace pipescout::rack_vision {

/// What one image says about one pose.
struct TrackEvidence {
  int edge_samples = 0;  ///< samples on visible edges of pipes and supports, whole in the image
  int edge_samples_found = 0;  ///< with an edge where the pose has it
  int edges = 0;               ///< pieces with enough samples to be judged
  int points = 0;              ///< texture points searched
  int points_matched = 0;      ///< found where the pose has them
  /// The same of points that were found again and again before: when these fail it is not for want
  /// of texture.
  int proven_points = 0;
  int proven_matched = 0;
};

/// 0 (nothing speaks for the pose) to 1. Half and more: safe to use.
///
/// Edges: share found. Points: share of proven ones matched, once there are enough of them; points
/// that fail while edges are found mean that the edges are those of another place, and the lower of
/// the two counts. How far the rest lies is not asked: clutter may be anywhere.
[[nodiscard]] double track_quality(const TrackEvidence& evidence) noexcept;

}  // namespace pipescout::rack_vision
