// SPDX-License-Identifier: Apache-2.0
// The start of a track: which of the places that are tried is the right one.
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "pose_belief.hpp"
#include "track_step.hpp"

namespace pipescout::rack_vision {
namespace {

using geometry::Matrix6d;
using geometry::SE3;

constexpr double kDistinct = 8;             // px, between what is seen from two places
constexpr double kLeastShare = 0.5;         // of what is looked for
constexpr double kLargestSpread = 2.5;      // of the residuals, in their deviations
constexpr double kClearlyBetter = 7;        // log-likelihood, over other places: 1 in 1000
constexpr double kGoodShare = 0.65;         // below it other places must be still worse,
constexpr double kDoubtByShare = 40;        // by this much for each that is missing
constexpr double kLeastOfReference = 0.35;  // share of its samples found
constexpr int kJudgedSamples = 20;
constexpr double kTukeyWidth = 4.685;  // standard deviations
// Log-likelihood of a sample, against finding it by chance, for six in ten found where the place
// is right and three in ten anywhere within the search: of one that lies on its edge, of a missed
// one.
constexpr double kOnItsEdge = 2.4;
constexpr double kMissed = -0.56;
constexpr double kAlikeSamples = 8;     // of one edge: they are found or missed together
constexpr double kCertainPlace = 0.06;  // m, one sigma across and in height
constexpr double kCertainTurn = 0.03;   // rad
constexpr double kFarthestAlong = 3;    // deviations before the image
constexpr double kNoLessSure = 1.2;     // deviation after the image by that before it
constexpr double kImprobable = 16.8;    // chi-square of six, 1 in 100: not where it was said to be
constexpr int kY = 1;

using OffsetVector = Eigen::Matrix<double, static_cast<int>(kMaxPipes), 1>;

Eigen::Map<const OffsetVector> offset_vector(const OffsetBelief& belief) {
  return Eigen::Map<const OffsetVector>(belief.mean.data());
}

/// Share of what was looked for that was found, of edges by how well; proven points count, once
/// there are enough, as much as edges do.
double found_share(const TrackEvidence& evidence, double edges) {
  constexpr int kEnoughPoints = 10;
  if (evidence.proven_points < kEnoughPoints) {
    return edges;
  }
  return 0.5 * (edges + static_cast<double>(evidence.proven_matched) / evidence.proven_points);
}

/// Log-likelihood of what was found of the edges, against finding it by chance: a place at which
/// more is to be seen, and is, explains more of the image than one at which little is.
double evidence_by_edges(int searched, double agreement) {
  return searched * (kMissed + (kOnItsEdge - kMissed) * agreement) / kAlikeSamples;
}

/// How improbable the offsets that were found are, by what was known of them: chi-square.
double improbability(const OffsetBelief& before, const OffsetBelief& after) {
  OffsetMatrix covariance = before.covariance;
  OffsetVector moved = offset_vector(after) - offset_vector(before);
  for (Eigen::Index i = 0; i < moved.size(); ++i) {
    if (covariance(i, i) == 0) {
      covariance(i, i) = 1;  // it stays where it is
    }
  }
  return moved.dot(covariance.llt().solve(moved));
}

/// From the line on which an edge is seen to the nearest candidate of a sample that has one, px.
double distance_of_nearest(const SearchedSample& sample, const VisibleEdge& edge) {
  const Eigen::Vector2d along = (edge.image_end - edge.image_start).normalized();
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < static_cast<std::size_t>(sample.count); ++i) {
    const Eigen::Vector2d from = sample.candidates[i].pixel - edge.image_start;
    nearest = std::min(nearest, std::abs(along.x() * from.y() - along.y() * from.x()));
  }
  return nearest;
}

/// Whether the pipes along y that cannot have moved are seen where they should be, if they are in
/// view. All others may be taken for pipes that lie elsewhere, and so bear any pose out.
bool reference_is_found(const RackModel& model, const OffsetBelief& offsets,
                        std::span<const PipeSupport> pipes) {
  PipeSupport fixed;
  for (std::size_t i = 0; i < model.pipes.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    const Eigen::Vector3d& direction = model.pipes[i].direction;
    if (offsets.covariance(row, row) == 0 && std::abs(direction.y()) > std::abs(direction.x())) {
      fixed.searched += pipes[i].searched;
      fixed.found += pipes[i].found;
    }
  }
  return fixed.searched < kJudgedSamples || fixed.found >= kLeastOfReference * fixed.searched;
}

}  // namespace

double TrackStep::edge_agreement() const {
  double sum = 0;
  int searched = 0;
  std::size_t next = 0;  // features_ holds the samples that have candidates, in their order
  for (const SearchedSample& sample : samples_) {
    const EdgeSample* feature = sample.count > 0 ? &features_[next++] : nullptr;
    const VisibleEdge* edge = rendered(searched_[sample.edge]);
    if (edge == nullptr || !sample.searched) {
      continue;
    }
    ++searched;
    if (feature == nullptr) {
      continue;
    }
    const double sigma =
        std::hypot(feature->sigma, feature->bias_sigma, parameters_.edge_bias_sigma);
    const double distance = distance_of_nearest(sample, *edge) / (kTukeyWidth * sigma);
    sum += std::pow(1 - std::min(1.0, distance * distance), 3);
  }
  return searched > 0 ? sum / searched : 0;
}

double TrackStep::apart(const SE3& a, const SE3& b) const {
  const geometry::Vector6d difference = pose_difference(a, b);
  const double height = std::max(0.5, a.translation().z());
  const double focal = camera_.matrix()(0, 0);
  const double half_width = 0.5 * camera_.parameters().width;
  // A turn about y is a move along x, almost; moves along the pipes are not seen at all.
  return focal * std::abs(difference.x() / height - difference(4)) +
         half_width * (std::abs(difference(5)) + std::abs(difference.z()) / height);
}

bool TrackStep::is_acceptable(const TrackBelief& around, const StepOutcome& tried,
                              const geometry::Vector6d& moved) const {
  const geometry::Vector6d sigma = tried.belief.covariance.diagonal().cwiseSqrt();
  const geometry::Vector6d before_sigma = around.covariance.diagonal().cwiseSqrt();
  return solution_.residual_scale <= kLargestSpread &&
         reference_is_found(model_, around.offsets, tried.pipes) &&
         std::max(sigma(0), sigma(2)) <= kCertainPlace &&
         sigma.tail<3>().maxCoeff() <= kCertainTurn &&
         // Beyond it those are the edges of another support, or its other edges.
         std::abs(moved(kY)) <= kFarthestAlong * before_sigma(kY) &&
         // Otherwise it contradicts what was known: the residuals say so.
         sigma(0) <= kNoLessSure * before_sigma(0) && sigma(2) <= kNoLessSure * before_sigma(2);
}

bool TrackStep::is_clear(const JudgedStart& best) const {
  // Those count too at which too little is found for a start: so much is found by chance.
  double rival = -std::numeric_limits<double>::infinity();
  for (const JudgedStart& other : judged_) {
    if (apart(best.belief.T_rack_camera, other.belief.T_rack_camera) >= kDistinct) {
      rival = std::max(rival, other.merit);
    }
  }
  return best.merit - rival >=
         kClearlyBetter + kDoubtByShare * std::max(0.0, kGoodShare - best.share);
}

void TrackStep::admit_the_others(const JudgedStart& best, TrackBelief& belief) const {
  TrackBelief sum = belief;
  const Matrix6d information = belief.covariance.inverse();
  double weights = 1;
  for (const JudgedStart& other : judged_) {
    geometry::Vector6d off = pose_difference(best.belief.T_rack_camera, other.belief.T_rack_camera);
    off(kY) = 0;  // along_is_clear asks for that
    if (!other.acceptable || off.dot(information * off) < 1) {
      continue;  // the same minimum
    }
    const double weight = std::exp(std::min(0.0, other.merit - best.merit));
    const OffsetVector beside =
        offset_vector(other.belief.offsets) - offset_vector(best.belief.offsets);
    sum.covariance += weight * (other.belief.covariance + off * off.transpose());
    sum.offsets.covariance +=
        weight * (other.belief.offsets.covariance + beside * beside.transpose());
    weights += weight;
  }
  belief.covariance = sum.covariance / weights;
  belief.offsets.covariance = sum.offsets.covariance / weights;
}

void TrackStep::find_from_far(const ImageView& image, const TrackBelief& before,
                              StepOutcome& outcome) {
  map_error_ = before.map;
  outcome = {};
  outcome.belief = before;
  TrackBelief around = before;
  around.covariance(kY, kY) += before.anchor_variance;
  if (map_.size() > 0 && find_by_texture(image, around, outcome)) {
    return;  // clutter lines up as well as contours do, but looks like no texture that was mapped
  }
  outcome = {};
  outcome.belief = before;
  propose_starts(image, around);
  const Matrix6d information = around.covariance.inverse();
  judged_.clear();
  judged_.reserve(starts_.size());
  const JudgedStart* best = nullptr;
  for (const Start& start : starts_) {
    if (!try_start(image, around, start, outcome)) {
      continue;
    }
    const geometry::Vector6d moved =
        pose_difference(around.T_rack_camera, outcome.belief.T_rack_camera);
    const double chi_square = moved.dot(information * moved);
    if (chi_square > kImprobable) {
      continue;
    }
    const double agreement = edge_agreement();
    JudgedStart& judged = judged_.emplace_back();
    judged.start = start;
    judged.belief = outcome.belief;
    judged.share = found_share(outcome.evidence, agreement);
    judged.merit = evidence_by_edges(outcome.evidence.edge_samples, agreement) -
                   0.5 * (chi_square + improbability(around.offsets, outcome.belief.offsets));
    judged.acceptable = judged.share >= kLeastShare && is_acceptable(around, outcome, moved);
    if (judged.acceptable && (best == nullptr || judged.merit > best->merit)) {
      best = &judged;
    }
  }
  outcome = {};
  outcome.belief = before;
  if (best == nullptr || !is_clear(*best)) {
    outcome.status = PoseStatus::kTooFewInliers;
    return;
  }
  // Once more, for the working memory that `learn` reads.
  (void)try_start(image, around, best->start, outcome);
  admit_the_others(*best, outcome.belief);
  if (!along_is_clear(image, outcome, around.covariance(kY, kY))) {
    // One edge of a support looks like another: nothing is known that was not known before.
    outcome.belief.anchor_variance =
        std::max(outcome.belief.anchor_variance, around.covariance(kY, kY));
  }
}

}  // namespace pipescout::rack_vision
