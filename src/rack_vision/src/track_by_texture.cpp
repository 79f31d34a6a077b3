// SPDX-License-Identifier: Apache-2.0
// A pose from texture that was mapped before, where contours may be far from where they are
// expected.
#include "track_step.hpp"

namespace pipescout::rack_vision {
namespace {

constexpr double kSafe = 0.5;  // quality
constexpr int kY = 1;

}  // namespace

bool TrackStep::find_by_texture(const ImageView& image, const TrackBelief& around,
                                StepOutcome& outcome) {
  TrackBelief guess = around;
  samples_.clear();
  searched_.clear();
  features_.clear();
  std::optional<double> anchor;
  // At first without edges: the nearest ones are those of something else.
  for (const bool with_edges : {false, true}) {
    if (with_edges) {
      guess.T_rack_camera = solution_.T_camera_rack.inverse();
      guess.covariance = solution_.covariance;
      guess.offsets = solution_.offsets;
      render(guess.T_rack_camera, guess.offsets);
      search(image, guess, kLeastRange, guess.covariance(kY, kY) + *anchor);
    }
    match_points(image, around, guess);
    anchor = map_.observations(matches_, points_);
    if (!anchor || points_.size() < static_cast<std::size_t>(kEnoughProven) ||
        !solve(guess, around.covariance, around.T_rack_camera, around.offsets, true) ||
        !points_agree()) {
      return false;
    }
  }
  outcome = {};
  accept(*anchor, outcome);
  return borne_out_by_texture(outcome) && track_quality(outcome.evidence) >= kSafe;
}

}  // namespace pipescout::rack_vision
