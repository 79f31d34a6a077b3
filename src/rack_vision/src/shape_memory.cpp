// SPDX-License-Identifier: Apache-2.0
#include "shape_memory.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

namespace pipescout::rack_vision {
namespace {

using geometry::Matrix6d;

constexpr double kShareOfView = 0.4;     // a tenth of the height is a whole view
constexpr std::size_t kFewestViews = 5;  // for a search
constexpr std::size_t kMostViews = 12;   // the first of them are dropped
constexpr std::size_t kMostShapes = 200000;
constexpr double kDistinct = 3;  // px: another shape, and not the same one less exactly
// Log-likelihood: what one contour that is strong in half of the views tells.
constexpr double kClearlyBetterByView = 1.5;
constexpr double kLeastStrength = 0.35;  // of what strong contours would score
constexpr double kStepLeft = 3;          // px, one sigma of a contour after a search
constexpr int kJudgedSamples = 10;
constexpr double kSupportedShare = 0.5;  // of the samples: the pipe is where it is believed
constexpr int kImagesInDoubt = 15;
// What shading and shadows that stay leave of an error: half a pixel of both contours alike.
constexpr double kFloor = 0.003;      // m
constexpr double kTurnFloor = 0.001;  // rad

double squared(double value) {
  return value * value;
}

/// As AlignmentSearch has it: the sixth entry is always 0.
Matrix6d as_motion(const ShapeMatrix& covariance) {
  Matrix6d result = Matrix6d::Zero();
  result.topLeftCorner<kShapeUnknowns, kShapeUnknowns>() = covariance;
  return result;
}

}  // namespace

ShapeMemory::ShapeMemory(const Pipe& pipe, double offset_sigma) {
  const ShapeDeviation& deviation = pipe.shape_deviation;
  prior_.diagonal() << squared(offset_sigma), squared(deviation.height),
      squared(deviation.direction), squared(deviation.direction), squared(deviation.radius);
  reset();
}

void ShapeMemory::reset() {
  mean_.setZero();
  covariance_ = prior_;
  found_ = false;
  seen_ = kShareOfView;
  views_.clear();
  images_in_doubt_ = 0;
}

bool ShapeMemory::is_another_view(double share) {
  seen_ += share;
  if (seen_ < kShareOfView) {
    return false;
  }
  seen_ = 0;
  return true;
}

void ShapeMemory::take_view(std::span<const AlignmentContour> contours,
                            std::span<AlignmentTable> tables, AlignmentSearch& search) {
  if (views_.size() == kMostViews) {
    views_.erase(views_.begin());
  }
  View& view = views_.emplace_back();
  view.contours.assign(contours.begin(), contours.end());
  view.tables.assign(std::make_move_iterator(tables.begin()),
                     std::make_move_iterator(tables.end()));
  if (views_.size() >= kFewestViews) {
    this->search(search);
  }
}

void ShapeMemory::search(AlignmentSearch& search) {
  std::vector<AlignmentContour> contours;
  std::vector<AlignmentTable> tables;
  double strongest = 0;
  for (const View& view : views_) {
    contours.insert(contours.end(), view.contours.begin(), view.contours.end());
    tables.insert(tables.end(), view.tables.begin(), view.tables.end());
  }
  for (const AlignmentTable& table : tables) {
    strongest += table.weight;
  }
  std::vector<AlignmentPeak> peaks;
  search.search(contours, tables, as_motion(prior_), kStep, kDistinct, 2, kMostShapes, peaks);
  const double clearly = kClearlyBetterByView * static_cast<double>(views_.size());
  if (peaks.empty() || peaks[0].score < kLeastStrength * strongest ||
      (peaks.size() > 1 && peaks[1].score > peaks[0].score - clearly)) {
    return;
  }
  found_ = true;
  mean_ = peaks[0].motion.head<kShapeUnknowns>();
  covariance_ = AlignmentSearch::remaining(contours, as_motion(prior_), kStepLeft)
                    .topLeftCorner<kShapeUnknowns, kShapeUnknowns>();
  keep_floor();
  views_.clear();
  images_in_doubt_ = 0;
}

void ShapeMemory::learn(const ShapeBelief& after, const PipeSupport& support, double share) {
  if (!found_ || support.searched < kJudgedSamples) {
    return;
  }
  if (support.found < kSupportedShare * support.searched) {
    if (++images_in_doubt_ >= kImagesInDoubt) {
      reset();
    }
    return;
  }
  images_in_doubt_ = 0;
  // What is exact keeps the inverses regular.
  constexpr double kExact = 1e-6;  // m and rad
  const ShapeMatrix exact = kExact * kExact * ShapeMatrix::Identity();
  const ShapeMatrix prior = (covariance_ + exact).inverse();
  const ShapeMatrix posterior = (after.covariance + exact).inverse();
  const ShapeMatrix covariance = (prior + share * (posterior - prior)).inverse();
  const ShapeVector moved = share * covariance * (posterior * (after.mean - mean_));
  if (!covariance.allFinite() || !moved.allFinite() || covariance.diagonal().minCoeff() < 0) {
    return;
  }
  mean_ += moved;
  covariance_ = 0.5 * (covariance + covariance.transpose());
  keep_floor();
}

void ShapeMemory::keep_floor() {
  for (int k = 0; k < covariance_.rows(); ++k) {
    const double floor = squared(k == 2 || k == 3 ? kTurnFloor : kFloor);
    covariance_(k, k) = std::max(covariance_(k, k), std::min(floor, prior_(k, k)));
  }
}

}  // namespace pipescout::rack_vision
