// SPDX-License-Identifier: Apache-2.0
// The start of a track: from a pose that is only roughly right.
#include <algorithm>
#include <array>
#include <cmath>

#include "pose_belief.hpp"
#include "track_step.hpp"

namespace pipescout::rack_vision {
namespace {

constexpr double kAcrossStep = 5.0;      // px between places that are tried, across the pipes
constexpr double kYawStep = 0.02;        // rad
constexpr double kPitchStep = 0.05;      // rad
constexpr int kReach = 6;                // px to both sides of an edge within which it may line up
constexpr int kReachStep = 2;            // px
constexpr int kSamples = 12;             // per edge
constexpr double kSaturated = 30;        // grey levels: stronger edges do not count for more
constexpr std::size_t kTried = 6;        // places that are solved for
constexpr double kClearlyBetter = 0.12;  // of the share of samples found, over other places
constexpr double kCertainPlace = 0.012;  // m, one sigma across and in height
constexpr double kCertainTurn = 0.005;   // rad
constexpr double kSamePlace = 10;        // px, between what is seen from two places
constexpr std::array<double, 3> kRanges{14.0, 8.0, 4.0};  // px, of the searches from a place

double difference_at(const ImageView& image, const Eigen::Vector2d& at,
                     const Eigen::Vector2d& step) {
  const Eigen::Vector2d outer = at + step;
  const Eigen::Vector2d inner = at - step;
  const auto inside = [&image](const Eigen::Vector2d& p) {
    return p.x() >= 0 && p.y() >= 0 && p.x() < image.width - 1 && p.y() < image.height - 1;
  };
  if (!inside(outer) || !inside(inner)) {
    return 0;
  }
  return static_cast<double>(
      image.row(static_cast<int>(outer.y() + 0.5))[static_cast<int>(outer.x() + 0.5)] -
      image.row(static_cast<int>(inner.y() + 0.5))[static_cast<int>(inner.x() + 0.5)]);
}

/// Signed steps of a share of the range, both ends included: -n..n.
int steps(double range, double step) {
  return static_cast<int>(std::ceil(std::max(0.0, range) / step - 1e-9));
}

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

double TrackStep::alignment(const ImageView& image) const {
  double score = 0;
  double weight = 0;
  for (std::size_t i = 0; i < edges_.size(); ++i) {
    if (edges_[i].id.kind != EdgeKind::kPipe) {
      continue;
    }
    const Eigen::Vector2d along = edges_[i].image_end - edges_[i].image_start;
    const double length = along.norm();
    const Eigen::Vector2d& normal = normals_[i];
    const EdgeMemory::Look& look = edge_memory_.look(edges_[i].id);
    double best = 0;
    for (int reach = -kReach; reach <= kReach; reach += kReachStep) {
      // A straight edge adds up along the line; texture does not.
      double sum = 0;
      for (int j = 1; j <= kSamples; ++j) {
        const Eigen::Vector2d ideal = edges_[i].image_start +
                                      along * (static_cast<double>(j) / (kSamples + 1)) +
                                      normal * reach;
        const Eigen::Vector2d pixel =
            camera_.has_distortion() ? camera_.distort(ideal).value_or(ideal) : ideal;
        sum += difference_at(image, pixel, 2.0 * normal);
      }
      const double mean = sum / kSamples;
      const double size =
          look.decides_sign() ? std::copysign(1.0, look.contrast) * mean : std::abs(mean);
      best = std::max(best, std::min(size, kSaturated));
    }
    score += length * best;
    weight += length;
  }
  // Little in view is little said.
  return weight > 0 ? score / (weight + 500.0) : 0.0;
}

void TrackStep::propose_starts(const ImageView& image, const TrackBelief& before) {
  const Eigen::Vector3d sigma_place = before.covariance.diagonal().head<3>().cwiseSqrt();
  const Eigen::Vector3d sigma_turn = before.covariance.diagonal().tail<3>().cwiseSqrt();
  const double height = std::max(0.5, before.T_rack_camera.translation().z());
  const double across = std::min(3 * sigma_place.x(), parameters_.start_range_m) / height +
                        std::min(3 * sigma_turn.y(), parameters_.start_range_rad);
  const double across_step = kAcrossStep / camera_.matrix()(0, 0);
  const int columns = steps(across - across_step, across_step);
  const int rows =
      steps(std::min(3 * sigma_turn.z(), parameters_.start_range_rad) - kYawStep / 2, kYawStep);
  const int tilts =
      steps(std::min(3 * sigma_turn.x(), parameters_.start_range_rad) - kPitchStep / 2, kPitchStep);
  starts_.clear();
  for (int row = -rows; row <= rows; ++row) {
    for (int column = -columns; column <= columns; ++column) {
      Start best{{}, column, row, -1};
      for (int tilt = -std::min(tilts, 1); tilt <= std::min(tilts, 1); ++tilt) {
        geometry::Vector6d motion = geometry::Vector6d::Zero();
        motion(3) = tilt * kPitchStep;
        motion(4) = column * across_step;
        motion(5) = row * kYawStep;
        const geometry::SE3 place = moved_pose(before.T_rack_camera, motion);
        render(place, before.offsets);
        const double score = alignment(image);
        if (score > best.score) {
          best.score = score;
          best.T_rack_camera = place;
        }
      }
      starts_.push_back(best);
    }
  }
  std::ranges::stable_sort(starts_, std::ranges::greater{}, &Start::score);
  // Neighbours of a better place lead to the same solution.
  std::size_t kept = 0;
  for (std::size_t i = 0; i < starts_.size() && kept < kTried; ++i) {
    const bool is_new =
        std::none_of(starts_.begin(), starts_.begin() + static_cast<std::ptrdiff_t>(kept),
                     [this, i](const Start& better) {
                       return std::abs(better.column - starts_[i].column) <= 2 &&
                              std::abs(better.row - starts_[i].row) <= 1;
                     });
    if (is_new) {
      starts_[kept++] = starts_[i];
    }
  }
  starts_.resize(kept);
}

bool TrackStep::refine_start(const ImageView& image, const TrackBelief& before, const Start& start,
                             double along_variance) {
  TrackBelief guess = before;
  guess.T_rack_camera = start.T_rack_camera;
  guess.covariance.setZero();
  // Pipes are taken to be where they are believed: what a wide search finds may be anything.
  guess.offsets.covariance.setZero();
  for (const double range : kRanges) {
    render(guess.T_rack_camera, guess.offsets);
    search(image, guess, range, along_variance);
    if (!solve(guess, before.covariance, before.T_rack_camera, guess.offsets, false)) {
      return false;
    }
    guess.T_rack_camera = solution_.T_camera_rack.inverse();
  }
  return true;
}

void TrackStep::find_from_far(const ImageView& image, const TrackBelief& before,
                              StepOutcome& outcome) {
  outcome = {};
  outcome.belief = before;
  points_.clear();
  matches_.clear();
  propose_starts(image, before);
  const double along_variance = before.covariance(1, 1) + before.anchor_variance;
  const auto share = [](const TrackEvidence& evidence) {
    return evidence.edge_samples > 0
               ? static_cast<double>(evidence.edge_samples_found) / evidence.edge_samples
               : 0.0;
  };
  StepOutcome best;
  double best_share = -1;
  double rival_share = -1;
  Start best_start;
  for (const Start& start : starts_) {
    if (!refine_start(image, before, start, along_variance)) {
      continue;
    }
    StepOutcome tried;
    accept(before.anchor_variance, tried);
    const double tried_share = share(tried.evidence);
    const bool same = best_share >= 0 && apart(best.belief, tried.belief) < kSamePlace;
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
  (void)refine_start(image, before, best_start, along_variance);
  outcome = {};
  accept(before.anchor_variance, outcome);
  outcome.belief.offsets = before.offsets;
}

}  // namespace pipescout::rack_vision
