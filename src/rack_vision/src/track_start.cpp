// SPDX-License-Identifier: Apache-2.0
// The start of a track: from a pose that is only roughly right.
#include <algorithm>
#include <array>
#include <bitset>
#include <cmath>
#include <limits>
#include <span>

#include "pipescout/linear_algebra/products.hpp"
#include "pose_belief.hpp"
#include "ray_motion.hpp"
#include "track_step.hpp"

namespace pipescout::rack_vision {
namespace {

using geometry::Matrix6d;
using geometry::SE3;

constexpr std::size_t kTried = 6;       // places that are solved for
constexpr std::size_t kMostTried = 24;  // while none of them explains the image
constexpr double kDistinctTried = 4;    // px, between what is seen from two of them
constexpr double kFirstStep = 2.5;      // px between the poses that are tried
constexpr std::array kNextSteps{2.0, 1.0};
constexpr double kWideRange = 16;     // px: beyond it other contours are nearer than a pipe's own
constexpr double kShortest = 8;       // px: shorter contours say nothing
constexpr double kFarthest = 150;     // px: within which the unknown place along y moves contours
constexpr double kMuchWorse = 20;     // log-likelihood: places that need not be tried
constexpr double kAlongStep = 1.5;    // px
constexpr double kSameAlong = 0.005;  // m
constexpr double kClearlyBetterAlong = 4;  // log-likelihood
constexpr double kDistinct = 8;            // px, between what is seen from two places
// Of what is looked for, found: more where what is found lies farther from its place. Measured at
// 60 right places: at least 0.63, and 0.72 where the residuals are 1.4 times their deviations.
constexpr double kLeastShare = 0.5;
constexpr double kShareByScale = 0.1;
constexpr double kClearlyBetter = 0.12;  // of the share of samples found, over other places
constexpr double kLeastHeight = 0.5;     // m
// px, across the pipes and along them, from a place at which edges may be taken for their
// neighbours to the one at which they are not.
constexpr std::array kAside{-14.0, -7.0, 7.0, 14.0};
// px, at the borders of the image: higher and lower. There the end of a beam may be taken for what
// is beside it, and then the scale is wrong.
constexpr std::array kAtBorders{-7.0, -3.5, 3.5, 7.0};
constexpr int kMostMovesAside = 3;
constexpr double kClearlyBetterAside = 1;       // log-likelihood
constexpr double kAlikeAtStart = 8;             // images
constexpr double kLeastOfReference = 0.35;      // share of its samples found
constexpr double kLeastOfReferenceAlone = 0.5;  // where it alone says where all pipes lie
constexpr int kJudgedSamples = 20;
constexpr double kContrastWeight = 0.25;  // the samples that were found have seen some of it
// Log-likelihood of a sample against one that lies anywhere: of 0.75 found against 0.35, of 0.25
// missed against 0.65.
constexpr double kFound = 0.76;
constexpr double kMissed = -0.96;
constexpr double kAlikeSamples = 8;     // of one edge: they are found or missed together
constexpr double kCertainPlace = 0.06;  // m, one sigma across and in height
constexpr double kCertainTurn = 0.03;   // rad
constexpr double kFarthestAlong = 3;    // deviations before the image
// Deviations of an offset: a pipe beyond it is likelier to be taken for its neighbour.
constexpr double kFarthestPlace = 2;
constexpr double kNoLessSure = 1.2;    // deviation after the image by that before it
constexpr double kImprobable = 16.8;   // chi-square of six, 1 in 100: not where it was said to be
constexpr double kFirstRange = 5;      // px, of the search from a place
constexpr double kNextRange = 3.5;     // px
constexpr int kMostRounds = 10;        // the edges nearest to a place lead to the next one
constexpr double kArrived = 0.3;       // px
constexpr double kAnewPlace = 0.03;    // m, of a second opinion
constexpr double kAnewTurn = 0.015;    // rad
constexpr double kAnotherPlace = 1.0;  // px, between what is seen from both
constexpr double kClearlySharper = 0.1;
constexpr int kFewestRadii = 2;      // pipes: one may be in a bad light
constexpr double kClearRadii = 2.5;  // evidence for each: 1 by chance
constexpr int kY = 1;
constexpr int kZ = 2;

/// Share of what was looked for that was found; proven points count, once there are enough, as much
/// as edges do.
double found_share(const TrackEvidence& evidence) {
  constexpr int kEnoughPoints = 10;
  if (evidence.edge_samples == 0) {
    return 0;
  }
  const double edges = static_cast<double>(evidence.edge_samples_found) / evidence.edge_samples;
  if (evidence.proven_points < kEnoughPoints) {
    return edges;
  }
  return 0.5 * (edges + static_cast<double>(evidence.proven_matched) / evidence.proven_points);
}

/// Of what was found: a place at which more is to be seen, and is, explains more of the image than
/// one at which little is.
double log_likelihood(const TrackEvidence& evidence, double share) {
  return evidence.edge_samples * (share * kFound + (1 - share) * kMissed) / kAlikeSamples;
}

/// Whether the pipes along y that cannot have moved or have another shape are seen where they
/// should be, if they are in view. All others may be taken for pipes that lie elsewhere, and so
/// bear any pose out.
bool reference_is_found(const RackModel& model, const OffsetBelief& offsets,
                        const std::bitset<kMaxPipes>& shaped, std::span<const PipeSupport> pipes,
                        double least) {
  PipeSupport fixed;
  for (std::size_t i = 0; i < model.pipes.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    const Eigen::Vector3d& direction = model.pipes[i].direction;
    if (offsets.covariance(row, row) == 0 && !shaped[i] &&
        std::abs(direction.y()) > std::abs(direction.x())) {
      fixed.searched += pipes[i].searched;
      fixed.found += pipes[i].found;
    }
  }
  return fixed.searched < kJudgedSamples || fixed.found >= least * fixed.searched;
}

}  // namespace

double TrackStep::farthest_of_pipes(const TrackBelief& belief) const {
  double farthest = 0;
  for (std::size_t i = 0; i < edges_.size(); ++i) {
    if (edges_[i].id.kind == EdgeKind::kPipe) {
      farthest = std::max(farthest, range_of(edges_[i], normals_[i], belief));
    }
  }
  return farthest;
}

bool TrackStep::is_wide(const TrackBelief& belief) const {
  return farthest_of_pipes(belief) > kWideRange;
}

double TrackStep::apart(const SE3& a, const SE3& b) const {
  const geometry::Vector6d difference = pose_difference(a, b);
  const double height = std::max(kLeastHeight, a.translation().z());
  const double focal = camera_.matrix()(0, 0);
  const double half_width = 0.5 * camera_.parameters().width;
  // A turn about y is a move along x, almost; moves along the pipes are not seen at all.
  return focal * std::abs(difference.x() / height - difference(4)) +
         half_width * (std::abs(difference(5)) + std::abs(difference.z()) / height);
}

void TrackStep::gather_contours(const SE3& T_rack_camera, double along_deviation, double farthest,
                                const Bodies& of) {
  contours_.clear();
  for (std::size_t i = 0; i < edges_.size(); ++i) {
    const VisibleEdge& edge = edges_[i];
    if (!(edge.id.kind == EdgeKind::kPipe ? of.pipes[edge.id.body] : of.supports)) {
      continue;
    }
    if ((edge.image_end - edge.image_start).norm() < kShortest) {
      continue;
    }
    AlignmentContour contour;
    contour.start = edge.image_start;
    contour.end = edge.image_end;
    contour.normal = normals_[i];
    contour.start_by_motion = by_motion(edge.start, normals_[i], T_rack_camera);
    contour.end_by_motion = by_motion(edge.end, normals_[i], T_rack_camera);
    if (rows_.is_rolling()) {
      const auto moved = [&](const geometry::Vector6d& by_motion, const Eigen::Vector2d& pixel) {
        return by_motion.dot(rows_.velocity) * edge_search_.instant(pixel);
      };
      contour.start += moved(contour.start_by_motion, edge.image_start) * normals_[i];
      contour.end += moved(contour.end_by_motion, edge.image_end) * normals_[i];
    }
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

SE3 TrackStep::narrowed(const ImageView& image, const TrackBelief& around,
                        const AlignmentPeak& peak) {
  SE3 T_rack_camera = moved_pose(around.T_rack_camera, peak.motion);
  Matrix6d covariance = left_by_peaks_;
  for (const double step : kNextSteps) {
    render(T_rack_camera, around.offsets);
    gather_contours(T_rack_camera, std::sqrt(covariance(kY, kY)), kFarthest);
    alignment_.search(image, contours_, covariance, step, kDistinct, 1, narrowed_);
    if (narrowed_.empty()) {
      break;
    }
    covariance = AlignmentSearch::remaining(contours_, covariance, 2 * step);
    T_rack_camera = moved_pose(T_rack_camera, narrowed_.front().motion);
  }
  return T_rack_camera;
}

void TrackStep::find_peaks(const ImageView& image, const TrackBelief& around, std::size_t most) {
  render(around.T_rack_camera, around.offsets);
  // First those that tell the pose across the pipes, whatever it is along them.
  gather_contours(around.T_rack_camera, std::sqrt(around.covariance(kY, kY)), kFirstStep);
  alignment_.search(image, contours_, around.covariance, kFirstStep, kDistinctTried, most, peaks_);
  left_by_peaks_ = AlignmentSearch::remaining(contours_, around.covariance, 2 * kFirstStep);
  const auto much_worse = std::ranges::find_if(peaks_, [this](const AlignmentPeak& peak) {
    return peak.score < peaks_.front().score - kMuchWorse;
  });
  peaks_.erase(much_worse, peaks_.end());
}

bool TrackStep::refine_start(const ImageView& image, const TrackBelief& around,
                             const StartGuess& start, double along_variance, PoseSolver& solver) {
  TrackBelief guess = around;
  guess.T_rack_camera = start.T_rack_camera;
  guess.covariance.setZero();
  if (start.offsets) {
    guess.offsets.mean = *start.offsets;
    guess.offsets.covariance.setZero();
  }
  use_believed_shapes();
  double range = kFirstRange;
  for (int round = 0; round < kMostRounds; ++round) {
    const SE3 before = guess.T_rack_camera;
    render(guess.T_rack_camera, guess.offsets);
    search(image, guess, range, along_variance);
    if (!solve_by(solver, guess, around.covariance, around.T_rack_camera, around.offsets, false,
                  start.offsets ? PipeOffsets(guess.offsets.mean) : PipeOffsets())) {
      return false;
    }
    guess.T_rack_camera = solution_.T_camera_rack.inverse();
    guess.offsets.mean = solution_.offsets.mean;
    if (round == 0) {
      // And no later one: what loses the edges across once would not look for them again.
      along_variance = solution_.covariance(kY, kY);
    } else if (apart(before, guess.T_rack_camera) < kArrived) {
      break;
    }
    range = kNextRange;
  }
  return true;
}

bool TrackStep::try_start(const ImageView& image, const TrackBelief& around,
                          const StartGuess& start, StepOutcome& outcome) {
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
  const Matrix6d before = linear_algebra::inverse(around.covariance);
  const Matrix6d after = linear_algebra::inverse(outcome.belief.covariance);
  outcome.belief.covariance = linear_algebra::inverse<6>(before + (after - before) / kAlikeAtStart);
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
  alignment_.search(image, contours_, along, kAlongStep, kDistinct, 2, peaks_);
  const double found = outcome.belief.anchor_variance;
  return peaks_.empty() ||
         (peaks_.front().motion(kY) * peaks_.front().motion(kY) <
              9 * (found + kSameAlong * kSameAlong) &&
          (peaks_.size() < 2 || peaks_[1].score < peaks_[0].score - kClearlyBetterAlong));
}

bool TrackStep::explains_the_image(const TrackBelief& around, const StepOutcome& tried,
                                   double share, const geometry::Vector6d& moved) const {
  const geometry::Vector6d before = around.covariance.diagonal().cwiseSqrt();
  const geometry::Vector6d sigma = tried.belief.covariance.diagonal().cwiseSqrt();
  return share >= kLeastShare &&
         reference_is_found(model_, around.offsets, shaped_pipes(), tried.pipes,
                            kLeastOfReference) &&
         std::max(sigma(0), sigma(kZ)) <= kCertainPlace &&
         sigma.tail<3>().maxCoeff() <= kCertainTurn &&
         // Beyond it those are the edges of another support, or its other edges.
         std::abs(moved(kY)) <= kFarthestAlong * before(kY) &&
         // Otherwise it contradicts what was known: the residuals say so.
         sigma(0) <= kNoLessSure * before(0) && sigma(kZ) <= kNoLessSure * before(kZ);
}

bool TrackStep::any_explains() const {
  return std::ranges::any_of(tried_, &TriedStart::explains);
}

void TrackStep::consider_start(const ImageView& image, const TrackBelief& around,
                               const StartGuess& start, StepOutcome& outcome) {
  if (!try_start(image, around, start, outcome)) {
    return;
  }
  const SE3& found = outcome.belief.T_rack_camera;
  const geometry::Vector6d moved = pose_difference(around.T_rack_camera, found);
  const double chi_square = moved.dot(linear_algebra::inverse(around.covariance) * moved);
  if (chi_square > kImprobable) {
    return;
  }
  double misplaced = 0;
  bool likely = true;
  for (std::size_t i = 0; start.offsets && i < model_.pipes.size(); ++i) {
    const auto pipe = static_cast<Eigen::Index>(i);
    const double variance = around.offsets.covariance(pipe, pipe);
    const double offset = outcome.belief.offsets.mean[i] - around.offsets.mean[i];
    if (variance > 0) {
      misplaced += offset * offset / variance;
      likely = likely && offset * offset <= kFarthestPlace * kFarthestPlace * variance;
    }
  }
  const double share = found_share(outcome.evidence);
  bool explains = likely && explains_the_image(around, outcome, share, moved) &&
                  rests_on_what_is_known() &&
                  (!start.offsets || reference_is_found(model_, around.offsets, shaped_pipes(),
                                                        outcome.pipes, kLeastOfReferenceAlone));
  const double contrast = start.offsets ? kContrastWeight * contrast_along(image, found) : 0.0;
  if (explains && share < kLeastShare + kShareByScale * solution_.residual_scale) {
    // What lies on pipes hides their contours.
    const RadiusEvidence radii = evidence_for_radii(image, outcome);
    explains = radii.pipes >= kFewestRadii && radii.sum >= kClearRadii * radii.pipes;
  }
  tried_.push_back(
      {.start = start,
       .found = found,
       .offsets = outcome.belief.offsets.mean,
       .share = share,
       .merit = log_likelihood(outcome.evidence, share) + contrast - 0.5 * (chi_square + misplaced),
       .explains = explains});
}

void TrackStep::look_beside_the_best(const ImageView& image, const TrackBelief& around,
                                     StepOutcome& outcome) {
  for (int round = 0; round < kMostMovesAside && !tried_.empty(); ++round) {
    const TriedStart best = *std::ranges::max_element(tried_, {}, &TriedStart::merit);
    const std::optional<std::array<double, kMaxPipes>>& offsets = best.start.offsets;
    const double height = std::max(kLeastHeight, best.found.translation().z());
    const double pixel = height / camera_.matrix()(0, 0);             // m
    const double rise = height / (0.5 * camera_.parameters().width);  // m, a pixel at the borders
    for (const double aside : kAside) {
      for (const int axis : {0, kY}) {
        geometry::Vector6d move = geometry::Vector6d::Zero();
        move(axis) = aside * pixel;
        consider_start(image, around, {moved_pose(best.found, move), offsets}, outcome);
      }
    }
    for (const double at_borders : kAtBorders) {
      // One border of the view, its middle, or the other border stays where it is.
      for (const double sideways : {-pixel, 0.0, pixel}) {
        geometry::Vector6d move = geometry::Vector6d::Zero();
        move(0) = at_borders * sideways;
        move(kZ) = at_borders * rise;
        consider_start(image, around, {moved_pose(best.found, move), offsets}, outcome);
      }
    }
    const double found = std::ranges::max_element(tried_, {}, &TriedStart::merit)->merit;
    if (found < best.merit + kClearlyBetterAside) {
      return;
    }
  }
}

void TrackStep::find_from_far(const ImageView& image, const TrackBelief& before,
                              StepOutcome& outcome) {
  map_error_ = before.map;
  set_velocity(before);
  begin_shapes(before);
  TrackBelief around = before;
  around.covariance(kY, kY) += before.anchor_variance;
  if (map_.size() > 0 && find_by_texture(image, around, outcome)) {
    return;  // clutter lines up as well as contours do, but looks like no texture that was mapped
  }
  StepOutcome refused;
  refused.belief = before;
  refused.status = PoseStatus::kTooFewInliers;
  around.offsets.unplaced.reset();
  tried_.clear();
  TrackBelief misplaced = around;
  const double deviation = misplace(misplaced);
  if (farthest_by_offsets(around) <= kFarFromBelieved) {
    const bool found = start_at_offsets(image, around, outcome);
    if (found && are_probable(outcome.belief.offsets, around.offsets) &&
        supported_share(outcome) >= kLeastSupported) {
      return;
    }
    tried_.clear();
    if (deviation == 0) {
      outcome = refused;
      return;
    }
    if (found) {
      consider_start(image, misplaced, {outcome.belief.T_rack_camera, outcome.belief.offsets.mean},
                     outcome);
    }
  }
  find_with_offsets(image, misplaced, outcome);
  outcome = refused;
  if (declare_with_offsets(image, misplaced, outcome)) {
    outcome.misplaced_by = deviation;
  }
}

bool TrackStep::start_at_offsets(const ImageView& image, const TrackBelief& around,
                                 StepOutcome& outcome) {
  find_at_offsets(image, around, outcome);
  const std::optional<TriedStart> best = clear_best(&TrackStep::is_elsewhere);
  if (best) {
    declare_start(image, around, best->start, outcome);
  }
  return best && outcome.solved;
}

void TrackStep::find_at_offsets(const ImageView& image, const TrackBelief& around,
                                StepOutcome& outcome) {
  find_peaks(image, around, kMostTried);
  for (std::size_t i = 0; i < peaks_.size() && (i < kTried || !any_explains()); ++i) {
    consider_start(image, around, {narrowed(image, around, peaks_[i]), {}}, outcome);
  }
  look_beside_the_best(image, around, outcome);
}

bool TrackStep::is_elsewhere(const TriedStart& best, const TriedStart& other) const {
  return apart(best.found, other.found) >= kDistinct && other.share > best.share - kClearlyBetter;
}

std::optional<TrackStep::TriedStart> TrackStep::clear_best(Rivalry rivals) const {
  if (!any_explains()) {
    return std::nullopt;
  }
  const TriedStart best = *std::ranges::max_element(tried_, {}, [](const TriedStart& tried) {
    return tried.explains ? tried.merit : -std::numeric_limits<double>::infinity();
  });
  if (std::ranges::any_of(tried_,
                          [&](const TriedStart& other) { return (this->*rivals)(best, other); })) {
    return std::nullopt;
  }
  return best;
}

void TrackStep::declare_start(const ImageView& image, const TrackBelief& around,
                              const StartGuess& start, StepOutcome& outcome) {
  // Once more, for the working memory that `learn` reads.
  if (try_start(image, around, start, outcome) &&
      !along_is_clear(image, outcome, around.covariance(kY, kY))) {
    // One edge of a support looks like another: nothing is known that was not known before.
    outcome.belief.anchor_variance =
        std::max(outcome.belief.anchor_variance, around.covariance(kY, kY));
  }
}

bool TrackStep::find_anew(const ImageView& image, const OffsetBelief& offsets,
                          StepOutcome& outcome) {
  const double before = sharpness();
  TrackBelief around = outcome.belief;
  around.offsets = offsets;
  around.covariance.diagonal().head<3>().array() += kAnewPlace * kAnewPlace;
  around.covariance.diagonal().tail<3>().array() += kAnewTurn * kAnewTurn;
  points_.clear();
  matches_.clear();
  if (!refine_start(image, around, {around.T_rack_camera, {}}, 0, start_solver_)) {
    return false;
  }
  // Offsets that are free explain every image a little better.
  if (apart(around.T_rack_camera, solution_.T_camera_rack.inverse()) < kAnotherPlace) {
    return false;
  }
  StepOutcome anew;
  const double along = solution_.covariance(kY, kY);
  const bool is_told = along < 0.5 * around.covariance(kY, kY);
  accept(std::max(around.anchor_variance, is_told ? along : 0.0), anew);
  if (sharpness() < before + kClearlySharper) {
    return false;
  }
  outcome = anew;
  return true;
}

}  // namespace pipescout::rack_vision
