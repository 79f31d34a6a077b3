// SPDX-License-Identifier: Apache-2.0
// The start of a track over pipes that may lie elsewhere than the rack file has them.
#include <algorithm>
#include <cmath>
#include <span>

#include "pipescout/statistics/chi_square.hpp"
#include "pose_belief.hpp"
#include "track_step.hpp"

namespace pipescout::rack_vision {
namespace {

using geometry::Matrix6d;
using geometry::SE3;

constexpr double kMisplaced = 0.035;  // m, one sigma: a rack file that is wrong by up to 6 cm
// px, three deviations of what the pose moves contours: beyond it they are those of a neighbour.
constexpr double kKnownPose = 30;
constexpr double kImprobable = 0.999;  // offsets beyond this quantile are not as they were believed
constexpr double kStep = 2.5;          // px between the poses and places that are tried
constexpr double kFineStep = 1;        // px
constexpr double kDistinctPose = 4;    // px, between what is seen from two of them
constexpr double kDistinctPlace = 6;   // px
constexpr double kDistinct = 8;        // px: the one can no longer be refined to the other
constexpr std::size_t kPoses = 6;      // by what cannot have moved
constexpr std::size_t kPlaces = 5;     // of a pipe
constexpr std::size_t kCombinations = 2;  // of places, from each pose
constexpr double kTolerance = 0.02;       // m: places are exact to a step, 1 cm
constexpr std::size_t kFollowed = 3;      // poses from which other places are tried
constexpr int kMostRounds = 3;
constexpr double kRefined = 0.25;        // of the variance of the pose, once edges were solved for
constexpr double kAnotherPlace = 0.015;  // m
// Log-likelihood, over other poses and over other places of a pipe. Samples of one edge are found
// or missed together, so that one pipe of five changes it little.
constexpr double kClearlyBetterPose = 2;
constexpr double kClearlyBetterNear = 0.5;
constexpr double kClearlyBetterPlace = 2;
constexpr double kMostClear = 10;  // where there is no other place
// Without supports in view the pose rests on the pipes, and a pipe at a wrong place leads it away.
constexpr double kClearlyBetterAlone = 2;
constexpr double kLeastHeight = 0.5;  // m
// Of pipes that were searched, on average, the evidence for their radii: over files of other racks
// above it in 1 of 15 starts, over the right ones below it in 1 of 60.
constexpr double kLeastForRadiiOfPlaces = 1.5;
constexpr int kJudgedSamples = 10;
constexpr double kSupportedShare = 0.5;  // of the samples of a pipe: it is where it is seen
constexpr double kAlong = 0.9;           // of the direction of a pipe along y
constexpr int kY = 1;

bool can_move(const OffsetBelief& offsets, std::size_t pipe) {
  const auto row = static_cast<Eigen::Index>(pipe);
  return offsets.covariance(row, row) > 0;
}

}  // namespace

double TrackStep::farthest_by_offsets(const TrackBelief& around) {
  render(around.T_rack_camera, around.offsets);
  TrackBelief offsets = around;
  offsets.covariance.setZero();
  return farthest_of_pipes(offsets);
}

void TrackStep::render_placed(TrackBelief& belief) {
  render(belief.T_rack_camera, belief.offsets);
  TrackBelief offsets = belief;
  offsets.covariance.setZero();
  for (std::size_t i = 0; i < edges_.size(); ++i) {
    if (edges_[i].id.kind == EdgeKind::kPipe &&
        range_of(edges_[i], normals_[i], offsets) > kFarFromBelieved) {
      belief.offsets.unplaced.set(edges_[i].id.body);
    }
  }
  if (belief.offsets.unplaced != offsets.offsets.unplaced) {
    render(belief.T_rack_camera, belief.offsets);
  }
}

std::optional<FoundPipe> TrackStep::find_unplaced(const ImageView& image,
                                                  const StepOutcome& outcome) {
  std::optional<FoundPipe> found;
  double clearest = kClearlyBetterPlace;
  for (std::size_t pipe = 0; pipe < model_.pipes.size(); ++pipe) {
    if (!outcome.belief.offsets.unplaced[pipe]) {
      continue;
    }
    TrackBelief around = outcome.belief;
    around.covariance(kY, kY) += around.anchor_variance;
    around.offsets.unplaced[pipe] = false;
    find_places(image, around, around.T_rack_camera, around.covariance);
    const std::vector<PipePlace> candidates = places_[pipe];
    for (std::size_t other = 0; other < places_.size(); ++other) {
      if (other != pipe && !places_[other].empty()) {
        places_[other].assign(1, {around.offsets.mean[other], 0});
      }
    }
    tried_.clear();
    StepOutcome tried;
    for (const PipePlace& candidate : candidates) {
      places_[pipe].assign(1, candidate);
      consider_places(image, around, around.T_rack_camera, 1, tried);
    }
    if (tried_.empty()) {
      continue;
    }
    const TriedStart best = *std::ranges::max_element(tried_, {}, &TriedStart::merit);
    double next = best.merit - kMostClear;
    for (const TriedStart& other : tried_) {
      if (std::abs(other.offsets[pipe] - best.offsets[pipe]) > kAnotherPlace) {
        next = std::max(next, other.merit);
      }
    }
    (void)try_start(image, around, best.start, tried);
    if (tried.solved && best.merit - next > clearest &&
        tried.pipes[pipe].found >=
            kSupportedShare * std::max(kJudgedSamples, tried.pipes[pipe].searched)) {
      clearest = best.merit - next;
      found = FoundPipe{pipe, best.offsets[pipe]};
    }
  }
  points_.clear();
  matches_.clear();
  return found;
}

bool TrackStep::are_probable(const OffsetBelief& found, const OffsetBelief& believed) const {
  double sum = 0;
  int count = 0;
  for (std::size_t i = 0; i < model_.pipes.size(); ++i) {
    if (can_move(believed, i)) {
      const auto row = static_cast<Eigen::Index>(i);
      const double moved = found.mean[i] - believed.mean[i];
      sum += moved * moved / believed.covariance(row, row);
      ++count;
    }
  }
  return count == 0 || sum <= statistics::chi_square_quantile(kImprobable, count);
}

double TrackStep::misplace(TrackBelief& around) {
  render(around.T_rack_camera, around.offsets);
  TrackBelief pose = around;
  pose.offsets.covariance.setZero();
  pose.covariance.row(kY).setZero();
  pose.covariance.col(kY).setZero();
  if (farthest_of_pipes(pose) > kKnownPose) {
    return 0;
  }
  bool widened = false;
  for (std::size_t i = 0; i < model_.pipes.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    if (can_move(around.offsets, i) &&
        around.offsets.covariance(row, row) < kMisplaced * kMisplaced) {
      around.offsets.covariance.row(row).setZero();
      around.offsets.covariance.col(row).setZero();
      around.offsets.covariance(row, row) = kMisplaced * kMisplaced;
      widened = true;
    }
  }
  return widened ? kMisplaced : 0;
}

void TrackStep::find_places(const ImageView& image, const TrackBelief& around,
                            const SE3& T_rack_camera, const Matrix6d& covariance) {
  render(T_rack_camera, around.offsets);
  places_.assign(model_.pipes.size(), {});
  for (std::size_t pipe = 0; pipe < model_.pipes.size(); ++pipe) {
    if (!can_move(around.offsets, pipe) || std::abs(model_.pipes[pipe].direction.y()) < kAlong) {
      places_[pipe].push_back({around.offsets.mean[pipe], 0});
      continue;
    }
    Bodies only_this{.pipes = {}, .supports = false};
    only_this.pipes.set(pipe);
    gather_contours(T_rack_camera, std::sqrt(covariance(kY, kY)), kStep, only_this);
    // A pipe that moves along x is seen to go against what the camera's own motion does.
    Matrix6d with_offset = covariance;
    const auto row = static_cast<Eigen::Index>(pipe);
    const double variance = around.offsets.covariance(row, row);
    with_offset(0, 0) += variance;
    alignment_.search(image, contours_, with_offset, kStep, kDistinctPlace, kPlaces, narrowed_);
    for (const AlignmentPeak& peak : narrowed_) {
      places_[pipe].push_back(
          {around.offsets.mean[pipe] - peak.motion(0) * variance / with_offset(0, 0), peak.score});
    }
  }
}

double TrackStep::contrast_along(const ImageView& image, const SE3& T_rack_camera) {
  gather_contours(T_rack_camera, 0, kStep);
  alignment_.search(image, contours_, Matrix6d::Zero(), kFineStep, kDistinctPose, 1, narrowed_);
  return narrowed_.empty() ? 0.0 : narrowed_.front().score;
}

double TrackStep::supported_share(const StepOutcome& outcome) const {
  int searched = 0;
  int supported = 0;
  for (std::size_t i = 0; i < model_.pipes.size(); ++i) {
    const PipeSupport& pipe = outcome.pipes[i];
    if (pipe.searched >= kJudgedSamples) {
      ++searched;
      supported += pipe.found >= kSupportedShare * pipe.searched ? 1 : 0;
    }
    searched += outcome.belief.offsets.unplaced[i] ? 1 : 0;
  }
  return searched > 0 ? static_cast<double>(supported) / searched : 1.0;
}

void TrackStep::consider_places(const ImageView& image, const TrackBelief& around,
                                const SE3& T_rack_camera, std::size_t most, StepOutcome& outcome) {
  place_pipes(model_, places_, kTolerance, most, placed_);
  for (PlacedPipes& placed : placed_) {
    for (std::size_t i = 0; i < places_.size(); ++i) {
      if (places_[i].empty()) {
        placed.offsets[i] = around.offsets.mean[i];
      }
    }
    consider_start(image, around, {T_rack_camera, placed.offsets}, outcome);
  }
}

void TrackStep::look_beside_places(const ImageView& image, const TrackBelief& around,
                                   const Matrix6d& covariance, std::size_t from,
                                   StepOutcome& outcome) {
  for (int round = 0; round < kMostRounds && tried_.size() > from; ++round) {
    const auto best_of_them = [&] {
      return *std::ranges::max_element(std::span(tried_).subspan(from), {}, &TriedStart::merit);
    };
    const TriedStart first = best_of_them();
    TriedStart best = first;
    find_places(image, around, first.found, covariance);
    const std::vector<std::vector<PipePlace>> found = places_;
    for (std::size_t pipe = 0; pipe < model_.pipes.size(); ++pipe) {
      if (!can_move(around.offsets, pipe)) {
        continue;
      }
      for (const PipePlace& place : found[pipe]) {
        if (std::abs(place.offset - best.offsets[pipe]) < kAnotherPlace) {
          continue;
        }
        for (std::size_t i = 0; i < places_.size(); ++i) {
          places_[i].assign(1, i == pipe ? place : PipePlace{best.offsets[i], 0});
        }
        consider_places(image, around, best.found, 1, outcome);
        best = best_of_them();
      }
    }
    if (best.merit < first.merit + kClearlyBetterNear) {
      return;
    }
  }
}

void TrackStep::find_with_offsets(const ImageView& image, const TrackBelief& around,
                                  StepOutcome& outcome) {
  // What cannot have moved tells the pose.
  render(around.T_rack_camera, around.offsets);
  Bodies fixed;
  const std::bitset<kMaxPipes> shaped = shaped_pipes();
  for (std::size_t i = 0; i < model_.pipes.size(); ++i) {
    fixed.pipes.set(i, !can_move(around.offsets, i) && !shaped[i]);
  }
  gather_contours(around.T_rack_camera, std::sqrt(around.covariance(kY, kY)), kStep, fixed);
  alignment_.search(image, contours_, around.covariance, kStep, kDistinctPose, kPoses, peaks_);
  if (peaks_.empty()) {
    peaks_.push_back({geometry::Vector6d::Zero(), 0});
  }
  const Matrix6d left = AlignmentSearch::remaining(contours_, around.covariance, 2 * kStep);
  std::vector<TriedStart> bests;  // from each of these poses
  for (const AlignmentPeak& peak : peaks_) {
    const std::size_t from = tried_.size();
    const SE3 T_rack_camera = moved_pose(around.T_rack_camera, peak.motion);
    find_places(image, around, T_rack_camera, left);
    consider_places(image, around, T_rack_camera, kCombinations, outcome);
    if (tried_.size() > from) {
      bests.push_back(
          *std::ranges::max_element(std::span(tried_).subspan(from), {}, &TriedStart::merit));
    }
  }
  std::ranges::stable_sort(bests, std::ranges::greater{}, &TriedStart::merit);
  const Matrix6d near = kRefined * left;
  for (const TriedStart& best : std::span(bests).first(std::min(bests.size(), kFollowed))) {
    const std::size_t from = tried_.size();
    tried_.push_back(best);
    look_beside_places(image, around, near, from, outcome);
  }
  look_beside_the_best(image, around, outcome);
}

bool TrackStep::is_rival(const TriedStart& best, const TriedStart& other) const {
  const double pose = apart(best.found, other.found);
  if (pose >= kDistinct) {
    return other.merit > best.merit - kClearlyBetterPose;
  }
  const bool supported = std::ranges::any_of(
      edges_, [](const VisibleEdge& edge) { return edge.id.kind == EdgeKind::kSupport; });
  return pose >= kDistinctPose &&
         other.merit > best.merit - (supported ? kClearlyBetterNear : kClearlyBetterAlone);
}

std::bitset<kMaxPipes> TrackStep::in_doubt(const TriedStart& best) const {
  const double pixel =
      std::max(kLeastHeight, best.found.translation().z()) / camera_.matrix()(0, 0);  // m
  std::bitset<kMaxPipes> result;
  for (const TriedStart& other : tried_) {
    for (std::size_t i = 0; i < model_.pipes.size(); ++i) {
      result[i] = result[i] || (other.merit > best.merit - kClearlyBetterPlace &&
                                std::abs(best.offsets[i] - other.offsets[i]) >= kDistinct * pixel);
    }
  }
  return result;
}

bool TrackStep::declare_with_offsets(const ImageView& image, const TrackBelief& misplaced,
                                     StepOutcome& outcome) {
  const std::optional<TriedStart> best = clear_best(&TrackStep::is_rival);
  if (!best) {
    return false;
  }
  const StepOutcome refused = outcome;
  TrackBelief around = misplaced;
  around.offsets.unplaced = in_doubt(*best);
  declare_start(image, around, best->start, outcome);
  const bool found = outcome.solved && supported_share(outcome) >= kLeastSupported;
  const RadiusEvidence radii = found ? evidence_for_radii(image, outcome) : RadiusEvidence{};
  if (!found || radii.sum < kLeastForRadiiOfPlaces * radii.pipes) {
    outcome = refused;
    return false;
  }
  outcome.places_searched = true;
  return true;
}

}  // namespace pipescout::rack_vision
