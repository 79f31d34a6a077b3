// SPDX-License-Identifier: Apache-2.0
// The start of a track from a pose that is only roughly right: places that are tried.
#include <algorithm>
#include <array>
#include <cmath>

#include "pose_belief.hpp"
#include "ray_motion.hpp"
#include "track_step.hpp"

namespace pipescout::rack_vision {
namespace {

using geometry::Matrix6d;
using geometry::SE3;

constexpr std::size_t kTried = 24;  // places that are solved for
constexpr double kFirstStep = 2.5;  // px between the poses that are tried
constexpr std::array kNextSteps{2.0, 1.0};
constexpr double kWideRange = 16;     // px
constexpr double kShortest = 8;       // px: shorter contours say nothing
constexpr double kFarthest = 150;     // px: within which the unknown place along y moves contours
constexpr double kMuchWorse = 20;     // log-likelihood: places that need not be tried
constexpr double kAlongStep = 1.5;    // px
constexpr double kSameAlong = 0.005;  // m
constexpr double kClearlyBetterAlong = 4;  // log-likelihood
constexpr double kDistinctTried = 4;  // px, between what is seen from two places that are tried
constexpr double kDistinctAlong = 8;  // px, the same along y
constexpr double kAlikeAtStart = 8;   // images
constexpr std::array<double, 2> kRanges{5.0, 3.5};  // px, of the searches from a place
constexpr int kY = 1;

}  // namespace

bool TrackStep::is_wide(const TrackBelief& belief) const {
  for (std::size_t i = 0; i < edges_.size(); ++i) {
    if (edges_[i].id.kind == EdgeKind::kPipe &&
        range_of(edges_[i], normals_[i], belief) > kWideRange) {
      return true;
    }
  }
  return false;
}

void TrackStep::gather_contours(const SE3& T_rack_camera, double along_deviation, double farthest) {
  contours_.clear();
  for (std::size_t i = 0; i < edges_.size(); ++i) {
    const VisibleEdge& edge = edges_[i];
    if ((edge.image_end - edge.image_start).norm() < kShortest) {
      continue;
    }
    AlignmentContour contour;
    contour.start = edge.image_start;
    contour.end = edge.image_end;
    contour.normal = normals_[i];
    contour.start_by_motion = by_motion(edge.start, normals_[i], T_rack_camera);
    contour.end_by_motion = by_motion(edge.end, normals_[i], T_rack_camera);
    const EdgeMemory::Look& look = edge_memory_.look(edge.id);
    contour.sign = look.decides_sign() ? std::copysign(1.0, look.contrast) : 0.0;
    const double along =
        3 * along_deviation *
        std::max(std::abs(contour.start_by_motion(kY)), std::abs(contour.end_by_motion(kY)));
    if (along <= farthest) {
      contours_.push_back(contour);
    }
  }
}

TrackStep::Start TrackStep::narrowed(const ImageView& image, const TrackBelief& around,
                                     const SE3& T_rack_camera, Matrix6d covariance) {
  Start start{T_rack_camera, 0};
  for (const double step : kNextSteps) {
    render(start.T_rack_camera, around.offsets);
    gather_contours(start.T_rack_camera, std::sqrt(covariance(kY, kY)), kFarthest);
    alignment_.search(image, contours_, covariance, step, kDistinctAlong, 1, narrowed_);
    if (narrowed_.empty()) {
      break;
    }
    covariance = AlignmentSearch::remaining(contours_, covariance, 2 * step);
    start.T_rack_camera = moved_pose(start.T_rack_camera, narrowed_.front().motion);
    start.score = narrowed_.front().score;
  }
  return start;
}

void TrackStep::propose_starts(const ImageView& image, const TrackBelief& around) {
  starts_.clear();
  render(around.T_rack_camera, around.offsets);
  // First those that tell the pose across the pipes, whatever it is along them.
  gather_contours(around.T_rack_camera, std::sqrt(around.covariance(kY, kY)), kFirstStep);
  alignment_.search(image, contours_, around.covariance, kFirstStep, kDistinctTried, kTried,
                    peaks_);
  const Matrix6d left = AlignmentSearch::remaining(contours_, around.covariance, 2 * kFirstStep);
  for (const AlignmentPeak& peak : peaks_) {
    if (peak.score < peaks_.front().score - kMuchWorse) {
      break;
    }
    starts_.push_back(narrowed(image, around, moved_pose(around.T_rack_camera, peak.motion), left));
  }
}

bool TrackStep::refine_start(const ImageView& image, const TrackBelief& around, const Start& start,
                             double along_variance, PoseSolver& solver) {
  TrackBelief guess = around;
  guess.T_rack_camera = start.T_rack_camera;
  guess.covariance.setZero();
  for (const double range : kRanges) {
    render(guess.T_rack_camera, guess.offsets);
    search(image, guess, range, along_variance);
    if (!solve_by(solver, guess, around.covariance, around.T_rack_camera, around.offsets, false)) {
      return false;
    }
    guess.T_rack_camera = solution_.T_camera_rack.inverse();
    guess.offsets.mean = solution_.offsets.mean;
    along_variance = solution_.covariance(kY, kY);
  }
  return true;
}

bool TrackStep::try_start(const ImageView& image, const TrackBelief& around, const Start& start,
                          StepOutcome& outcome) {
  points_.clear();
  matches_.clear();
  if (!refine_start(image, around, start, 0, start_solver_)) {
    return false;
  }
  TrackBelief guess = around;
  guess.T_rack_camera = solution_.T_camera_rack.inverse();
  guess.covariance = solution_.covariance;
  std::optional<double> anchor;
  if (map_.size() > 0) {
    // It was here before: texture tells this place from one that looks like it.
    match_points(image, around, guess);
    anchor = map_.observations(matches_, points_);
    if (anchor && !(solve_by(start_solver_, guess, around.covariance, around.T_rack_camera,
                             around.offsets, true) &&
                    points_agree())) {
      points_.clear();
      forget_matches();
      anchor.reset();
      if (!refine_start(image, around, start, 0, start_solver_)) {
        return false;
      }
    }
  }
  outcome = {};
  accept(0, outcome);
  // What is wrong with the contours in this image will be wrong with them in the next ones.
  const Matrix6d before = around.covariance.inverse();
  outcome.belief.covariance =
      (before + (outcome.belief.covariance.inverse() - before) / kAlikeAtStart).inverse();
  // What is known along y of the middle of the view is the anchor; there the pose is exact relative
  // to what it will see, whatever its other errors are.
  MotionRow middle = middle_by_motion(outcome.belief.T_rack_camera);
  outcome.belief.anchor_variance =
      (middle * outcome.belief.covariance * middle.transpose()).value() + anchor.value_or(0);
  middle(kY) = 0;
  Matrix6d with_the_others = Matrix6d::Identity();
  with_the_others.row(kY) = -middle;
  outcome.belief.covariance =
      (with_the_others * outcome.belief.covariance * with_the_others.transpose()).eval();
  outcome.belief.covariance(kY, kY) += kRelativeVariance;
  return true;
}

bool TrackStep::along_is_clear(const ImageView& image, const StepOutcome& outcome,
                               double along_variance) {
  const SE3& T_rack_camera = outcome.belief.T_rack_camera;
  render(T_rack_camera, outcome.belief.offsets);
  gather_contours(T_rack_camera, std::sqrt(along_variance), kFarthest);
  std::erase_if(contours_, [along_variance](const AlignmentContour& contour) {
    const double moved =
        std::max(std::abs(contour.start_by_motion(kY)), std::abs(contour.end_by_motion(kY)));
    return moved * std::sqrt(along_variance) < kAlongStep;
  });
  Matrix6d along = Matrix6d::Zero();
  along(kY, kY) = along_variance;
  alignment_.search(image, contours_, along, kAlongStep, kDistinctAlong, 2, peaks_);
  const double found = outcome.belief.anchor_variance;
  return peaks_.empty() ||
         (peaks_.front().motion(kY) * peaks_.front().motion(kY) <
              9 * (found + kSameAlong * kSameAlong) &&
          (peaks_.size() < 2 || peaks_[1].score < peaks_[0].score - kClearlyBetterAlong));
}

}  // namespace pipescout::rack_vision
