// SPDX-License-Identifier: Apache-2.0
// What an image says for or against the pose that was found in it, and what it teaches.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>
#include <span>

#include "lens_scale.hpp"
#include "pose_belief.hpp"
#include "ray_motion.hpp"
#include "track_step.hpp"

namespace pipescout::rack_vision {
namespace {

constexpr double kInlierGate = 1.25;  // px: an edge or point this near is where the pose has it
constexpr double kSharp = 0.35;       // px, one deviation
constexpr std::size_t kFewestPoints = 5;
constexpr std::size_t kPointsForShift = 14;    // for a median that a few false matches do not move
constexpr double kSupportsSay = 0.02;          // m: y from supports is used when better than this
constexpr double kLeastOfAcross = 0.5;         // of what is looked for of them, found
constexpr double kAnchorFloor = 0.0015;        // m: what supports leave of the error along y
constexpr double kLeastOfReferenceSeen = 0.5;  // of its samples, found
constexpr int kSamplesOfReference = 20;
constexpr int kY = 1;
constexpr int kJudgedSamples = 5;

/// Distance of an ideal pixel from the line on which an edge is seen.
double distance_from(const VisibleEdge& edge, const Eigen::Vector2d& pixel) {
  const Eigen::Vector2d along = (edge.image_end - edge.image_start).normalized();
  const Eigen::Vector2d from = pixel - edge.image_start;
  return along.x() * from.y() - along.y() * from.x();
}

/// The candidate of a sample that lies on the line on which the edge is seen, if one does.
const EdgeCandidate* agreeing(const SearchedSample& sample, const VisibleEdge& edge) {
  const auto candidates =
      std::span(sample.candidates).first(static_cast<std::size_t>(sample.count));
  const auto found = std::ranges::find_if(candidates, [&](const EdgeCandidate& candidate) {
    return std::abs(distance_from(edge, candidate.pixel)) < kInlierGate * sample.ideal_per_pixel;
  });
  return found == candidates.end() ? nullptr : &*found;
}

}  // namespace

bool borne_out_by_texture(const StepOutcome& outcome) noexcept {
  return outcome.solved && outcome.evidence.proven_points >= kEnoughProven &&
         5 * outcome.evidence.proven_matched >= 2 * outcome.evidence.proven_points;
}

const VisibleEdge* TrackStep::rendered(const EdgeId& id) const noexcept {
  const auto found = std::ranges::find(edges_, id, &VisibleEdge::id);
  return found == edges_.end() ? nullptr : &*found;
}

bool TrackStep::is_found(const SearchedSample& sample, const VisibleEdge& edge) {
  return agreeing(sample, edge) != nullptr;
}

bool TrackStep::agrees(const PointObservation& point, const CameraView& seen,
                       const OffsetBelief& offsets) const {
  const double offset = point.pipe == PointObservation::kOnNoPipe ? 0.0 : offsets.mean[point.pipe];
  const Eigen::Vector3d place = point.place + offset * Eigen::Vector3d::UnitX();
  const Eigen::Vector3d pixel = seen.matrix * seen.R_camera_rack * (place - seen.centre);
  return (pixel.hnormalized() - point.pixel).norm() <
         2 * kInlierGate * ideal_per_pixel(camera_, point.pixel);
}

bool TrackStep::points_agree() const {
  const CameraView seen(camera_, solution_.T_camera_rack);
  const auto agreeing =
      static_cast<std::size_t>(std::ranges::count_if(points_, [&](const PointObservation& point) {
        return agrees(point, seen, solution_.offsets);
      }));
  return agreeing >= kFewestPoints && 2 * agreeing >= points_.size();
}

void TrackStep::forget_matches() {
  for (MatchedPoint& match : matches_) {
    match.found = false;
  }
}

bool TrackStep::is_reference(const VisibleEdge& edge, const OffsetBelief& offsets) const {
  if (edge.id.kind == EdgeKind::kPipe) {
    const Pipe& pipe = model_.pipes[edge.id.body];
    const auto row = static_cast<Eigen::Index>(edge.id.body);
    return offsets.covariance(row, row) == 0 && !pipe.shape_deviation.any() &&
           std::abs(pipe.direction.y()) > std::abs(pipe.direction.x());
  }
  const auto index = static_cast<std::size_t>(&edge - edges_.data());
  const geometry::Vector6d moves =
      by_motion(0.5 * (edge.start + edge.end), normals_[index], solution_.T_camera_rack.inverse());
  return std::abs(moves(0)) > std::abs(moves(kY));
}

void TrackStep::collect_evidence(StepOutcome& outcome) const {
  TrackEvidence& evidence = outcome.evidence;
  evidence = {};
  outcome.pipes = {};
  PipeSupport reference;
  for (std::size_t first = 0; first < samples_.size();) {
    const std::uint32_t index = samples_[first].edge;
    const VisibleEdge* edge = rendered(searched_[index]);
    int searched = 0;
    int found = 0;
    std::size_t i = first;
    for (; i < samples_.size() && samples_[i].edge == index; ++i) {
      const SearchedSample& sample = samples_[i];
      if (edge != nullptr && sample.searched) {
        ++searched;
        found += is_found(sample, *edge) ? 1 : 0;
      }
    }
    first = i;
    if (searched_[index].kind == EdgeKind::kPipe) {
      PipeSupport& pipe = outcome.pipes[searched_[index].body];
      pipe.searched += searched;
      pipe.found += found;
    }
    if (edge != nullptr && is_reference(*edge, outcome.belief.offsets)) {
      reference.searched += searched;
      reference.found += found;
    }
    evidence.edge_samples += searched;
    evidence.edge_samples_found += found;
    evidence.edges += searched >= kJudgedSamples ? 1 : 0;
  }
  outcome.reference_found = reference.found >= kLeastOfReferenceSeen * reference.searched &&
                            reference.searched >= kSamplesOfReference;
  const CameraView seen(camera_, outcome.belief.T_rack_camera.inverse());
  // points_ holds those of matches_ that were found, in their order.
  std::size_t next = 0;
  for (const MatchedPoint& match : matches_) {
    const bool agreeing = match.found && next < points_.size() &&
                          agrees(points_[next++], seen, outcome.belief.offsets);
    ++evidence.points;
    evidence.points_matched += agreeing ? 1 : 0;
    evidence.proven_points += match.proven ? 1 : 0;
    evidence.proven_matched += match.proven && agreeing ? 1 : 0;
  }
}

double TrackStep::sharpness() const {
  int searched = 0;
  double sum = 0;
  for (const SearchedSample& sample : samples_) {
    const VisibleEdge* edge = rendered(searched_[sample.edge]);
    if (edge == nullptr || !sample.searched) {
      continue;
    }
    ++searched;
    double nearest = kInlierGate;
    for (std::size_t i = 0; i < static_cast<std::size_t>(sample.count); ++i) {
      nearest = std::min(nearest, std::abs(distance_from(*edge, sample.candidates[i].pixel)) /
                                      sample.ideal_per_pixel);
    }
    sum += nearest < kInlierGate ? std::exp(-0.5 * std::pow(nearest / kSharp, 2)) : 0.0;
  }
  return searched > 0 ? sum / searched : 0.0;
}

bool TrackStep::across_is_found() const {
  const auto across = [this](std::size_t i) {
    const Eigen::Vector3d middle = 0.5 * (edges_[i].start + edges_[i].end);
    const geometry::Vector6d moves =
        by_motion(middle, normals_[i], solution_.T_camera_rack.inverse());
    return std::abs(moves(kY)) > std::abs(moves(0));
  };
  int searched = 0;
  for (std::size_t first = 0; first < samples_.size();) {
    const std::uint32_t edge = samples_[first].edge;
    const bool counts = across(edge);
    for (; first < samples_.size() && samples_[first].edge == edge; ++first) {
      searched += counts && samples_[first].searched ? 1 : 0;
    }
  }
  int found = 0;
  for (const EdgeSupport& support : solution_.edges) {
    const auto edge = std::ranges::find(searched_, support.edge);
    if (edge != searched_.end() && across(static_cast<std::size_t>(edge - searched_.begin()))) {
      found += support.inliers;
    }
  }
  return found >= std::max<double>(kJudgedSamples, kLeastOfAcross * searched);
}

RadiusEvidence TrackStep::evidence_for_radii(const ImageView& image, const StepOutcome& outcome) {
  const geometry::SE3& T_rack_camera = outcome.belief.T_rack_camera;
  render(T_rack_camera, outcome.belief.offsets);
  RadiusEvidence evidence;
  const std::bitset<kMaxPipes> shaped = shaped_pipes();
  for (std::size_t i = 0; i < model_.pipes.size(); ++i) {
    if (shaped[i]) {
      continue;
    }
    Bodies only_this{.pipes = {}, .supports = false};
    only_this.pipes.set(i);
    gather_contours(T_rack_camera, 0, 0, only_this);
    if (const std::optional<double> share = radius_rank_.share_of_better(image, contours_)) {
      evidence.sum -= std::log(*share);
      ++evidence.pipes;
    }
  }
  return evidence;
}

std::optional<double> TrackStep::shift_of_map(const ImageView& image, const TrackBelief& belief) {
  TrackBelief supported = belief;
  supported.T_rack_camera = solution_.T_camera_rack.inverse();
  supported.covariance = solution_.covariance;
  surface_.update(model_, std::span(belief.offsets.mean).first(model_.pipes.size()));
  map_.choose(view(supported), surface_, matches_);
  map_.match(image, view(supported), 0, kPointsForShift, matches_);
  (void)map_.observations(matches_, points_);
  const CameraView seen(camera_, solution_.T_camera_rack);
  shifts_.clear();
  for (const PointObservation& point : points_) {
    const Eigen::Vector3d from_eye = seen.R_camera_rack * (point.place - seen.centre);
    const Eigen::Vector3d expected = seen.matrix * from_eye;
    const Eigen::Vector3d moved = seen.matrix * seen.R_camera_rack.col(kY);
    const Eigen::Vector2d by_shift =
        (moved.head<2>() - moved.z() * expected.hnormalized()) / expected.z();
    shifts_.push_back(by_shift.dot(point.pixel - expected.hnormalized()) / by_shift.squaredNorm());
  }
  points_.clear();
  forget_matches();
  if (shifts_.size() < kFewestPoints) {
    return std::nullopt;
  }
  const auto middle = shifts_.begin() + static_cast<std::ptrdiff_t>(shifts_.size() / 2);
  std::ranges::nth_element(shifts_, middle);
  return *middle;
}

void TrackStep::anchor_by_supports(const ImageView& image, TrackBelief& belief,
                                   StepOutcome& outcome) {
  // In the middle of the view: there the other errors of the pose do not matter.
  const MotionRow middle = middle_by_motion(belief.T_rack_camera);
  const double said = (middle * solution_.covariance * middle.transpose()).value();
  const double relative = (middle * belief.covariance * middle.transpose()).value();
  const double believed = belief.anchor_variance + relative;
  const double reached = said + kAnchorFloor * kAnchorFloor;
  if (said > kSupportsSay * kSupportsSay || believed < 4 * reached ||
      relative > belief.anchor_variance) {
    return;  // not better than what is known, or what is wrong is the prediction, not the map
  }
  const auto is_improbable = [&](double shift) { return shift * shift > 9 * (believed + said); };
  const double moved =
      middle.dot(pose_difference(belief.T_rack_camera, solution_.T_camera_rack.inverse()));
  if (is_improbable(moved) || !across_is_found()) {
    return;  // those are the edges of another support, or a few of something else
  }
  // The camera may have moved otherwise than was predicted: points tell what is wrong with the map.
  const double shift = shift_of_map(image, belief).value_or(moved);
  if (is_improbable(shift)) {
    return;
  }
  outcome.shift_along = shift;
  belief.T_rack_camera =
      geometry::SE3(belief.T_rack_camera.rotation(),
                    belief.T_rack_camera.translation() + shift * Eigen::Vector3d::UnitY());
  belief.anchor_variance = reached;
  map_.shift_seen(shift, reached);
}

std::optional<TrackStep::Intrinsics> TrackStep::find_intrinsics(const IntrinsicsBelief& before,
                                                                const OffsetBelief& offsets,
                                                                const StepOutcome& outcome) {
  PoseProblem problem;
  problem.T_camera_rack = outcome.belief.T_rack_camera.inverse();
  problem.edges = features_;
  problem.offsets = offsets;
  problem.shapes = shape_beliefs_;
  problem.first_shapes = shapes_in_use_;
  problem.intrinsics = before;
  // No prior of the pose: that was found through the camera that is in doubt.
  solver_.solve(camera_, problem, solution_);
  if (solution_.status != PoseStatus::kOk || !solution_.intrinsics) {
    return std::nullopt;
  }
  return Intrinsics{*solution_.intrinsics, solution_.pose_by_intrinsics};
}

void TrackStep::learn(const ImageView& image, const StepOutcome& outcome,
                      const geometry::Matrix6d& relative) {
  for (const SearchedSample& sample : samples_) {
    const EdgeId& id = searched_[sample.edge];
    const VisibleEdge* edge = rendered(id);
    const EdgeCandidate* candidate = edge == nullptr ? nullptr : agreeing(sample, *edge);
    if (candidate != nullptr) {
      edge_memory_.learn(id, candidate->contrast);
    }
  }
  UncertainView now = view(outcome.belief);
  now.covariance = relative;
  if (outcome.map_error) {
    map_.correct(outcome.map_error->mean);
  }
  map_.learn(now, matches_, 2 * kInlierGate);
  matches_.clear();
  surface_.update(model_, now.offsets);
  map_.grow(image, now, surface_);
}

void TrackStep::forget() {
  edge_memory_.clear();
  map_.clear();
  matches_.clear();
}

}  // namespace pipescout::rack_vision
