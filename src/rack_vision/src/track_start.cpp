// SPDX-License-Identifier: Apache-2.0
// The start of a track: from a pose that is only roughly right.
#include <algorithm>
#include <array>
#include <cmath>

#include "pose_belief.hpp"
#include "track_step.hpp"

namespace pipescout::rack_vision {
namespace {

using geometry::Matrix6d;
using geometry::SE3;

constexpr std::size_t kTried = 6;   // places that are solved for
constexpr double kFirstStep = 2.5;  // px between the poses that are tried
constexpr std::array kNextSteps{2.0, 1.0};
constexpr double kShortest = 8;   // px: shorter contours say nothing
constexpr double kFarthest = 90;  // px: within which the unknown place along y moves contours
constexpr double kDistinct = 8;   // px, between what is seen from two places
constexpr double kClearlyBetter = 0.12;  // of the share of samples found, over other places
constexpr double kCertainPlace = 0.06;   // m, one sigma across and in height
constexpr double kCertainTurn = 0.03;    // rad
constexpr double kImprobable = 22.5;  // chi-square of six, 1 in 1000: not where it was said to be
constexpr std::array<double, 2> kRanges{5.0, 3.5};  // px, of the searches from a place
constexpr int kY = 1;

}  // namespace

double TrackStep::apart(const TrackBelief& a, const TrackBelief& b) const {
  const geometry::Vector6d difference = pose_difference(a.T_rack_camera, b.T_rack_camera);
  const double height = std::max(0.5, a.T_rack_camera.translation().z());
  const double focal = camera_.matrix()(0, 0);
  const double half_width = 0.5 * camera_.parameters().width;
  // A turn about y is a move along x, almost; moves along the pipes are not seen at all.
  return focal * std::abs(difference.x() / height - difference(4)) +
         half_width * (std::abs(difference(5)) + std::abs(difference.z()) / height);
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
  std::vector<AlignmentPeak> best;
  for (const double step : kNextSteps) {
    render(start.T_rack_camera, around.offsets);
    gather_contours(start.T_rack_camera, std::sqrt(covariance(kY, kY)), kFarthest);
    alignment_.search(image, contours_, covariance, step, kDistinct, 1, best);
    if (best.empty()) {
      break;
    }
    covariance = AlignmentSearch::remaining(contours_, covariance, 2 * step);
    start.T_rack_camera = moved_pose(start.T_rack_camera, best.front().motion);
    start.score = best.front().score;
  }
  return start;
}

void TrackStep::propose_starts(const ImageView& image, const TrackBelief& around) {
  starts_.clear();
  render(around.T_rack_camera, around.offsets);
  // First those that tell the pose across the pipes, whatever it is along them.
  gather_contours(around.T_rack_camera, std::sqrt(around.covariance(kY, kY)), kFirstStep);
  alignment_.search(image, contours_, around.covariance, kFirstStep, kDistinct, kTried, peaks_);
  const Matrix6d left = AlignmentSearch::remaining(contours_, around.covariance, 2 * kFirstStep);
  for (const AlignmentPeak& peak : peaks_) {
    starts_.push_back(narrowed(image, around, moved_pose(around.T_rack_camera, peak.motion), left));
  }
}

bool TrackStep::refine_start(const ImageView& image, const TrackBelief& around, const Start& start,
                             PoseSolver& solver) {
  TrackBelief guess = around;
  guess.T_rack_camera = start.T_rack_camera;
  guess.covariance.setZero();
  // Pipes are taken to be where they are believed: what a wide search finds may be anything.
  guess.offsets.covariance.setZero();
  double along_variance = 0;
  for (const double range : kRanges) {
    render(guess.T_rack_camera, guess.offsets);
    search(image, guess, range, along_variance);
    if (!solve_by(solver, guess, around.covariance, around.T_rack_camera, guess.offsets, false)) {
      return false;
    }
    guess.T_rack_camera = solution_.T_camera_rack.inverse();
    along_variance = solution_.covariance(kY, kY);
  }
  return true;
}

void TrackStep::find_from_far(const ImageView& image, const TrackBelief& before,
                              StepOutcome& outcome) {
  outcome = {};
  outcome.belief = before;
  points_.clear();
  matches_.clear();
  TrackBelief around = before;
  around.covariance(kY, kY) += before.anchor_variance;
  propose_starts(image, around);
  const auto share = [](const TrackEvidence& evidence) {
    return evidence.edge_samples > 0
               ? static_cast<double>(evidence.edge_samples_found) / evidence.edge_samples
               : 0.0;
  };
  const Matrix6d information = around.covariance.inverse();
  StepOutcome best;
  double best_share = -1;
  double rival_share = -1;
  Start best_start;
  for (const Start& start : starts_) {
    if (!refine_start(image, around, start, start_solver_)) {
      continue;
    }
    const geometry::Vector6d moved =
        pose_difference(around.T_rack_camera, solution_.T_camera_rack.inverse());
    const double improbability = moved.dot(information * moved);
    StepOutcome tried;
    accept(before.anchor_variance, tried);
    const double tried_share = share(tried.evidence);
    if (improbability > kImprobable) {
      continue;
    }
    const bool same = best_share >= 0 && apart(best.belief, tried.belief) < kDistinct;
    if (tried_share > best_share) {
      rival_share = same ? rival_share : best_share;
      best_share = tried_share;
      best = tried;
      best_start = start;
    } else if (!same) {
      rival_share = std::max(rival_share, tried_share);
    }
  }
  outcome.status = solution_.status;
  const Eigen::Matrix<double, 6, 1> sigma = best.belief.covariance.diagonal().cwiseSqrt();
  const bool certain = best_share >= 0 && std::max(sigma(0), sigma(2)) < kCertainPlace &&
                       sigma.tail<3>().maxCoeff() < kCertainTurn;
  if (!certain || best_share - rival_share < kClearlyBetter) {
    outcome.status = PoseStatus::kTooFewInliers;
    return;
  }
  // Once more, for the working memory that `learn` reads.
  (void)refine_start(image, around, best_start, start_solver_);
  outcome = {};
  accept(before.anchor_variance, outcome);
  outcome.belief.offsets = before.offsets;
  outcome.belief.anchor_variance = outcome.belief.covariance(kY, kY);
  outcome.belief.covariance.row(kY).setZero();
  outcome.belief.covariance.col(kY).setZero();
  outcome.belief.covariance(kY, kY) = kRelativeVariance;
}

}  // namespace pipescout::rack_vision
