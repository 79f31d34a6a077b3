// SPDX-License-Identifier: Apache-2.0
// Pipes that may lie so far from their places in the model that their contours are nearer to those
// of others.
#include <algorithm>
#include <cmath>
#include <span>

#include "track_step.hpp"

namespace pipescout::rack_vision {
namespace {

using geometry::SE3;

// Three deviations of an offset: px, and m, within which there are no contours of other pipes.
constexpr double kWidePixels = 10;
constexpr double kWidePlace = 0.08;
constexpr double kAnywhere = 0.05;           // m, one sigma: racks that were altered
constexpr double kFarthestElsewhere = 0.12;  // m
constexpr double kClearlyElsewhere = 2;      // log-likelihood: a third of one contour of two
// The same, of both contours and no others of the row; the more, the more places there are.
constexpr double kClearlyThere = 1;
constexpr double kClearlyThereByReach = 3;  // per m of reach ...
constexpr double kNearReach = 0.15;         // m, ... beyond this
constexpr double kLeastHeight = 0.5;        // m
constexpr int kY = 1;

/// How far from where they are believed pipes may lie, m.
std::array<double, kMaxPipes> reach_of(const OffsetBelief& offsets) {
  std::array<double, kMaxPipes> reach{};
  for (std::size_t i = 0; i < kMaxPipes; ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    reach[i] = 3 * std::sqrt(offsets.covariance(row, row));
  }
  return reach;
}

bool is_clear(const PipePlace& place, double reach) {
  return place.both_in_view &&
         place.margin > kClearlyThere + kClearlyThereByReach * std::max(0.0, reach - kNearReach);
}

}  // namespace

std::bitset<kMaxPipes> TrackStep::widely_placed(const TrackBelief& belief) const {
  std::bitset<kMaxPipes> wide;
  for (std::size_t i = 0; i < model_.pipes.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    const double three = 3 * std::sqrt(belief.offsets.covariance(row, row));
    const double height = std::max(
        kLeastHeight, std::abs(belief.T_rack_camera.translation().z() - model_.pipes[i].start.z()));
    wide[i] = three > kWidePlace && three * camera_.matrix()(0, 0) > kWidePixels * height;
  }
  return wide;
}

TrackStep::StartPlace TrackStep::place_pipes(const ImageView& image, const SE3& T_rack_camera,
                                             const OffsetBelief& offsets,
                                             const std::bitset<kMaxPipes>& wide) {
  StartPlace start{T_rack_camera, offsets.mean, wide};
  if (wide.none()) {
    return start;
  }
  const std::array<double, kMaxPipes> reach = reach_of(offsets);
  row_.search(image, T_rack_camera.inverse(), offsets.mean, wide, reach, offsets);
  for (std::size_t i = 0; i < model_.pipes.size(); ++i) {
    const PipePlace place = wide[i] ? row_.place(i) : PipePlace{};
    if (is_clear(place, reach[i])) {
      start.offsets[i] = place.offset;
      start.unplaced.reset(i);
    }
  }
  return start;
}

std::array<std::optional<double>, kMaxPipes> TrackStep::find_pipes(
    const ImageView& image, const SE3& T_rack_camera, const OffsetBelief& offsets,
    const std::bitset<kMaxPipes>& pipes) {
  std::array<double, kMaxPipes> reach = reach_of(offsets);
  for (double& one : reach) {
    one = std::max(one, kFarthestElsewhere);
  }
  row_.search(image, T_rack_camera.inverse(), offsets.mean, pipes, reach, {});
  std::array<std::optional<double>, kMaxPipes> found{};
  for (std::size_t i = 0; i < model_.pipes.size(); ++i) {
    const PipePlace place = pipes[i] ? row_.place(i) : PipePlace{};
    if (is_clear(place, reach[i])) {
      found[i] = place.offset;
    }
  }
  return found;
}

bool TrackStep::pipes_are_elsewhere(const ImageView& image, const TrackBelief& found,
                                    const OffsetBelief& offsets) {
  std::array<double, kMaxPipes> reach = reach_of(offsets);
  std::bitset<kMaxPipes> movable;
  for (std::size_t i = 0; i < model_.pipes.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    movable[i] = offsets.covariance(row, row) > 0 && !unplaced_[i];
    reach[i] = std::max(kFarthestElsewhere, reach[i]);
  }
  row_.search(image, found.T_rack_camera.inverse(), found.offsets.mean, movable, reach, {});
  for (std::size_t i = 0; i < model_.pipes.size(); ++i) {
    if (movable[i] && row_.better_elsewhere(i, found.offsets.mean[i]) > kClearlyElsewhere) {
      return true;
    }
  }
  return false;
}

bool TrackStep::find_offsets(const TrackBelief& before, StepOutcome& outcome) {
  constexpr double kFreeAlong = 0.5;  // m
  // What led to the pose that was predicted are the same contours at the same offsets: an error of
  // these is in both, and one may not bear the other out.
  TrackBelief around = before;
  Eigen::Vector3d place = around.T_rack_camera.translation();
  place(kY) = outcome.belief.T_rack_camera.translation()(kY);
  around.T_rack_camera = geometry::SE3(around.T_rack_camera.rotation(), place);
  around.covariance += outcome.covariance_by_offsets;
  around.covariance(kY, kY) += kFreeAlong * kFreeAlong;
  if (!solve(outcome.belief, around.covariance, around.T_rack_camera, before.offsets, false)) {
    return false;
  }
  outcome.belief.offsets = solution_.offsets;
  return true;
}

TrackBelief TrackStep::with_pipes_anywhere(const TrackBelief& belief) const {
  TrackBelief wide = belief;
  for (std::size_t i = 0; i < model_.pipes.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    double& variance = wide.offsets.covariance(row, row);
    if (variance > 0) {
      variance = std::max(variance, kAnywhere * kAnywhere);
    }
  }
  return wide;
}

}  // namespace pipescout::rack_vision
