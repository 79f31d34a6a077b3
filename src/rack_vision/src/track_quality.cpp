// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_vision/track_quality.hpp"

#include <algorithm>

namespace pipescout::rack_vision {
namespace {

constexpr int kEnoughSamples = 20;
constexpr int kEnoughPoints = 10;
// Shares at which edges and points are as good as they get on real images.
constexpr double kGoodEdges = 0.7;
constexpr double kGoodPoints = 0.6;

}  // namespace

double track_quality(const TrackEvidence& evidence) noexcept {
  double edges = 0;
  if (evidence.edge_samples >= kEnoughSamples) {
    const double share = static_cast<double>(evidence.edge_samples_found) / evidence.edge_samples;
    edges = std::clamp(share / kGoodEdges, 0.0, 1.0);
  }
  double quality = edges;
  if (evidence.proven_points >= kEnoughPoints) {
    const double share = static_cast<double>(evidence.proven_matched) / evidence.proven_points;
    const double points = std::clamp(share / kGoodPoints, 0.0, 1.0);
    // Either may be poor where the other is good: plain pipes, or edges covered by tarpaulins.
    quality = std::min(0.5 * (edges + points), 0.25 + 0.75 * std::min(edges, points) * 2);
  }
  return std::clamp(quality, 0.0, 1.0);
}

}  // namespace pipescout::rack_vision
