// SPDX-License-Identifier: Apache-2.0
// Pipes that may lie so far from their places in the model that their contours are nearer to those
// of others.
#include <algorithm>
#include <cmath>
#include <span>

#include "track_step.hpp"

namespace pipescout::rack_vision {
namespace {

// Three deviations of an offset: px, and m, within which there are no contours of other pipes.
constexpr double kWidePixels = 10;
constexpr double kWidePlace = 0.08;
constexpr double kAnywhere = 0.05;           // m, one sigma: racks that were altered
constexpr double kFarthestElsewhere = 0.12;  // m
constexpr double kClearlyElsewhere = 3;      // log-likelihood, of one contour of two and no other
constexpr double kBesidePixels = 8;  // px, of the second search, from contours rendered anew
constexpr int kX = 0;
constexpr int kY = 1;

}  // namespace

void TrackStep::gather_moving(const geometry::SE3& T_rack_camera) {
  moving_.clear();
  for (std::size_t i = 0; i < edges_.size(); ++i) {
    const VisibleEdge& edge = edges_[i];
    if (edge.id.kind != EdgeKind::kPipe) {
      continue;
    }
    // A pipe that moves along x is seen to move against what a motion of the camera does.
    moving_.push_back({.pipe = edge.id.body,
                       .start = edge.image_start,
                       .end = edge.image_end,
                       .normal = normals_[i],
                       .start_by_offset = -by_motion(edge.start, normals_[i], T_rack_camera)(kX),
                       .end_by_offset = -by_motion(edge.end, normals_[i], T_rack_camera)(kX)});
  }
}

void TrackStep::choose_widely_placed(const TrackBelief& around) {
  widely_placed_.reset();
  render(around.T_rack_camera, around.offsets);
  gather_moving(around.T_rack_camera);
  for (const MovingContour& contour : moving_) {
    const auto row = static_cast<Eigen::Index>(contour.pipe);
    const double deviation = std::sqrt(around.offsets.covariance(row, row));
    const double by_offset =
        std::max(std::abs(contour.start_by_offset), std::abs(contour.end_by_offset));
    if (3 * deviation > kWidePlace && 3 * deviation * by_offset > kWidePixels) {
      widely_placed_.set(contour.pipe);
    }
  }
}

void TrackStep::place_pipes(const ImageView& image, const geometry::SE3& T_rack_camera,
                            const OffsetBelief& offsets, std::size_t most) {
  std::array<double, kMaxPipes> reach{};
  for (std::size_t i = 0; i < model_.pipes.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    reach[i] = 3 * std::sqrt(offsets.covariance(row, row));
  }
  render(T_rack_camera, offsets);
  gather_moving(T_rack_camera);
  row_.search(image, moving_, offsets.mean, widely_placed_, reach, offsets, most, rows_);
  // Seen from another side, the contours of a pipe are a little farther apart or nearer.
  std::array<double, kMaxPipes> beside{};
  beside.fill(kBesidePixels * std::max(0.5, T_rack_camera.translation().z()) /
              camera_.matrix()(0, 0));
  for (RowPlaces& row : rows_) {
    OffsetBelief there = offsets;
    there.mean = row.offsets;
    render(T_rack_camera, there);
    gather_moving(T_rack_camera);
    std::vector<RowPlaces> nearer;
    row_.search(image, moving_, row.offsets, widely_placed_, beside, offsets, 1, nearer);
    row = nearer.front();
  }
}

bool TrackStep::pipes_are_elsewhere(const ImageView& image, const TrackBelief& found,
                                    const OffsetBelief& offsets) {
  OffsetBelief free = found.offsets;
  std::array<double, kMaxPipes> reach{};
  std::bitset<kMaxPipes> movable;
  for (std::size_t i = 0; i < model_.pipes.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    movable[i] = offsets.covariance(row, row) > 0;
    reach[i] = std::max(kFarthestElsewhere, 3 * std::sqrt(offsets.covariance(row, row)));
  }
  free.covariance.setZero();
  render(found.T_rack_camera, found.offsets);
  gather_moving(found.T_rack_camera);
  row_.search(image, moving_, found.offsets.mean, movable, reach, free, 1, rows_);
  for (std::size_t i = 0; i < model_.pipes.size(); ++i) {
    if (movable[i] && row_.better_elsewhere(i) > kClearlyElsewhere) {
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
