// SPDX-License-Identifier: Apache-2.0
#include "track_step.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <span>

#include "lens_scale.hpp"
#include "pipescout/linear_algebra/products.hpp"
#include "pipescout/rack_vision/contour.hpp"

namespace pipescout::rack_vision {
namespace {

using geometry::Matrix6d;

constexpr double kLargestRange = 40.0;  // px
constexpr double kRangeDeviations = 3.0;
constexpr double kSupportBias = 0.2;      // px: corners of beams are not sharp
constexpr double kSupportSigma = 2.0;     // times that of a pipe's edge: beams are less true
constexpr double kBiasPerSigma = 1.5;     // shared by an edge, as a multiple of what the fits say
constexpr double kFreeAlong = 0.5;        // m: "not known" along y
constexpr std::size_t kFirstPoints = 14;  // matched before the view is improved for the others
constexpr double kWidestAlong = 10.0;     // px: three sigma of what not knowing y does to an edge
constexpr std::size_t kPointsForAlong = 8;
constexpr double kDoubtInFar = 4;          // times the variance that a wide search states
constexpr double kStartBias = 0.6;         // px
constexpr std::size_t kPeaksInFlight = 6;  // one is used; for one alone the search is coarse
constexpr std::size_t kPiecesPerEdge = 2;
constexpr std::size_t kEdgesInView = 9;  // of the twelve of a support
constexpr int kY = 1;

PoseSolverParameters solver_parameters(const RackTrackerParameters& parameters) {
  PoseSolverParameters solver;
  solver.edge_bias_sigma = parameters.edge_bias_sigma;
  // Pipes move slowly here. A freedom within the image lets texture and shadows beside a contour
  // carry a pipe away, and the pose with it.
  solver.offset_freedom = 0.001;
  solver.innovation_gate = 1e3;
  solver.saliency_first = false;  // the prediction is near
  // Cables and tarpaulins may hide or imitate most of the contours.
  solver.largest_edge_widening = 1;
  return solver;
}

PoseSolverParameters start_solver_parameters(const RackTrackerParameters& parameters) {
  PoseSolverParameters solver = solver_parameters(parameters);
  // In the first image nothing tells a contour from a shadow or a stripe that runs along it.
  solver.edge_bias_sigma = std::max(parameters.edge_bias_sigma, kStartBias);
  solver.saliency_first = true;
  solver.spread_weakens_edges = true;
  // Nor are residuals small there while the guess is far off.
  solver.largest_edge_widening = PoseSolverParameters{}.largest_edge_widening;
  return solver;
}

EdgeSearchParameters search_parameters(const RackTrackerParameters& parameters) {
  EdgeSearchParameters search;
  search.samples_per_edge = parameters.samples_per_edge;
  search.row_time = parameters.row_time;
  return search;
}

TextureMapParameters map_parameters(const RackTrackerParameters& parameters) {
  TextureMapParameters map;
  map.capacity = parameters.map_capacity;
  map.points_per_frame = parameters.points_per_frame;
  map.point_sigma = parameters.point_sigma;
  return map;
}

/// What the pose says of the map's error, from their joint covariance.
MapErrorPrior map_error_prior(const MapErrorBelief& map, const Matrix6d& pose_information) {
  constexpr double kLeastDeviation = 1e-5;  // m; along y it has none
  constexpr double kLeastTurn = 1e-6;       // rad
  const Matrix6d by_pose = map.with_pose.transpose() * pose_information;
  Matrix6d rest = map.covariance - by_pose * map.with_pose;
  rest = (0.5 * (rest + rest.transpose())).eval();
  rest.diagonal().head<3>().array() += kLeastDeviation * kLeastDeviation;
  rest.diagonal().tail<3>().array() += kLeastTurn * kLeastTurn;
  return {by_pose, linear_algebra::inverse(rest)};
}

/// Of a pipe that may not be as the model has it, the offset is a part of its shape.
RackModel with_offsets_in_shapes(const RackModel& model) {
  RackModel result = model;
  for (Pipe& pipe : result.pipes) {
    pipe.movable = pipe.movable && !pipe.shape_deviation.any();
  }
  return result;
}

/// The candidate of a sample that is nearest to where the edge was expected; it has one.
const EdgeCandidate& nearest(const SearchedSample& sample) {
  const auto candidates =
      std::span(sample.candidates).first(static_cast<std::size_t>(sample.count));
  return *std::ranges::min_element(
      candidates, {}, [](const EdgeCandidate& candidate) { return std::abs(candidate.distance); });
}

}  // namespace

TrackStep::TrackStep(const RackModel& model, const geometry::Camera& camera,
                     const RackTrackerParameters& parameters)
    : model_(with_offsets_in_shapes(model)),
      camera_(camera),
      parameters_(parameters),
      edge_search_(camera, search_parameters(parameters)),
      edge_memory_(model),
      map_(model, camera, map_parameters(parameters)),
      solver_(model_, solver_parameters(parameters)),
      start_solver_(model_, start_solver_parameters(parameters)),
      alignment_(camera),
      radius_rank_(camera) {
  for (std::size_t i = 0; i < model.pipes.size(); ++i) {
    const Pipe& pipe = model.pipes[i];
    if (pipe.shape_deviation.any()) {
      const double offset_sigma =
          pipe.movable && parameters.estimate_offsets ? parameters.offset_sigma : 0;
      shapes_.push_back({i, pipe, ShapeMemory(pipe, offset_sigma)});
    }
  }
  rows_.row_time = parameters.row_time;
  rows_.middle_row = 0.5 * (camera.parameters().height - 1);
  reserve();
}

void TrackStep::reserve() {
  // More pieces than are ever in view allocate, and that is all.
  constexpr std::size_t kMostPieces = 300;
  std::size_t pieces = 0;
  for (const Pipe& pipe : model_.pipes) {
    pieces += 2 * kPiecesPerEdge * pipe.radii.size();
  }
  pieces = std::min(kMostPieces, pieces + kPiecesPerEdge * kEdgesInView * model_.supports.size());
  const std::size_t samples = pieces * static_cast<std::size_t>(parameters_.samples_per_edge);
  const auto points = static_cast<std::size_t>(parameters_.points_per_frame);
  edges_.reserve(pieces);
  normals_.reserve(pieces);
  searched_.reserve(pieces);
  contours_.reserve(pieces);
  samples_.reserve(samples);
  features_.reserve(samples);
  matches_.reserve(points);
  points_.reserve(points);
  shifts_.reserve(points);
  solver_.reserve(pieces, samples, points);
  start_solver_.reserve(pieces, samples, points);
  solution_.edges.reserve(pieces);
}

void TrackStep::set_camera(const geometry::Camera& camera) {
  camera_ = camera;
  edge_search_.set_camera(camera);
  map_.set_camera(camera);
  alignment_.set_camera(camera);
  radius_rank_.set_camera(camera);
}

void TrackStep::look_at(const ImageView& image) {
  noise_.measure(image);
  edge_search_.set_noise(noise_);
  map_.set_noise(noise_);
}

void TrackStep::set_velocity(const TrackBelief& before) {
  if (rows_.is_rolling()) {
    rows_.velocity = before.velocity;
    rows_.covariance = before.velocity_covariance;
    map_.set_row_motion(rows_);
  }
}

UncertainView TrackStep::view(const TrackBelief& belief) const {
  return {belief.T_rack_camera.inverse(), belief.covariance, belief.anchor_variance,
          std::span(belief.offsets.mean).first(model_.pipes.size()),
          belief.offsets.unplaced | without_texture_};
}

void TrackStep::render(const geometry::SE3& T_rack_camera, const OffsetBelief& offsets) {
  const geometry::SE3 T_camera_rack = T_rack_camera.inverse();
  renderer_.render(model_, std::span(offsets.mean).first(model_.pipes.size()), camera_,
                   T_camera_rack, edges_);
  const std::bitset<kMaxPipes> left_out = offsets.unplaced | unshaped_;
  std::erase_if(edges_, [&left_out](const VisibleEdge& edge) {
    return edge.id.kind == EdgeKind::kPipe && left_out[edge.id.body];
  });
  normals_.clear();
  for (const VisibleEdge& edge : edges_) {
    Pipe const* pipe = edge.id.kind == EdgeKind::kPipe ? &model_.pipes[edge.id.body] : nullptr;
    normals_.push_back(edge_normal(edge, pipe, T_camera_rack, camera_));
  }
}

geometry::Vector6d TrackStep::by_motion(const Eigen::Vector3d& point, const Eigen::Vector2d& normal,
                                        const geometry::SE3& T_rack_camera) const {
  const Eigen::Matrix3d R_camera_rack = T_rack_camera.rotation().inverse().matrix();
  const Eigen::Vector3d from_camera = point - T_rack_camera.translation();
  const Eigen::Vector3d seen = camera_.matrix() * (R_camera_rack * from_camera);
  Eigen::RowVector3d by_point;
  by_point << normal.x(), normal.y(), -(normal.x() * seen.x() + normal.y() * seen.y()) / seen.z();
  by_point = by_point * camera_.matrix() * R_camera_rack / seen.z();
  geometry::Vector6d result;
  result << -by_point.transpose(), (by_point * geometry::skew(from_camera)).transpose();
  return result;
}

double TrackStep::range_of(const VisibleEdge& edge, const Eigen::Vector2d& normal,
                           const TrackBelief& belief) const {
  // A contour slides over its pipe, but across itself it moves as the points of it do.
  double largest = 0;
  for (const Eigen::Vector3d& point : {edge.start, edge.end}) {
    const geometry::Vector6d moves = by_motion(point, normal, belief.T_rack_camera);
    double variance = moves.dot(belief.covariance * moves);
    if (edge.id.kind == EdgeKind::kPipe) {
      const auto pipe = static_cast<Eigen::Index>(edge.id.body);
      // Moved along x, a pipe is seen to go against what the camera's own motion does.
      variance += moves.x() * moves.x() * belief.offsets.covariance(pipe, pipe);
    }
    largest = std::max(largest, variance);
  }
  return kRangeDeviations * std::sqrt(largest);
}

EdgeMotion TrackStep::motion_of(const VisibleEdge& edge, const Eigen::Vector2d& normal,
                                const geometry::SE3& T_rack_camera) const {
  Eigen::Matrix<double, 2, 6> by_motion;
  by_motion << this->by_motion(edge.start, normal, T_rack_camera).transpose(),
      this->by_motion(edge.end, normal, T_rack_camera).transpose();
  return {by_motion * rows_.velocity, by_motion * rows_.covariance * by_motion.transpose()};
}

void TrackStep::search(const ImageView& image, const TrackBelief& belief, double least_range,
                       double along_variance) {
  samples_.clear();
  searched_.clear();
  skipped_ = 0;
  const CameraView seen(camera_, belief.T_rack_camera.inverse());
  TrackBelief along = belief;
  along.covariance.setZero();
  along.covariance(kY, kY) = along_variance;
  along.offsets.covariance.setZero();
  for (std::size_t i = 0; i < edges_.size(); ++i) {
    searched_.push_back(edges_[i].id);
    if (range_of(edges_[i], normals_[i], along) > kWidestAlong) {
      ++skipped_;
      continue;  // it may be anywhere, and what looks like it is another one
    }
    const Eigen::Vector2d middle = 0.5 * (edges_[i].image_start + edges_[i].image_end);
    double range = range_of(edges_[i], normals_[i], belief) +
                   kRangeDeviations * shape_deviation(edges_[i], normals_[i], seen) +
                   least_range * ideal_per_pixel(camera_, middle, normals_[i]);
    EdgeMotion motion;
    if (rows_.is_rolling()) {
      motion = motion_of(edges_[i], normals_[i], belief.T_rack_camera);
      const double deviation = std::sqrt(motion.covariance.diagonal().maxCoeff());
      range += kRangeDeviations * std::abs(rows_.instant(0)) * deviation;
    }
    edge_search_.search(image, edges_[i], static_cast<std::uint32_t>(i), normals_[i],
                        std::min(range, kLargestRange), edge_memory_.look(edges_[i].id), samples_,
                        motion);
  }
  features_.clear();
  for (const SearchedSample& sample : samples_) {
    if (sample.count == 0) {
      continue;
    }
    EdgeSample& feature = features_.emplace_back();
    feature.edge = searched_[sample.edge];
    feature.candidate_count = static_cast<std::uint8_t>(sample.count);
    for (std::size_t i = 0; i < static_cast<std::size_t>(sample.count); ++i) {
      feature.candidates[i] = sample.candidates[i].pixel;
    }
    // What the profile does not say well is wrong for the whole of an edge: its shading, a shadow
    // or a stripe that runs along it.
    const EdgeCandidate& found = nearest(sample);
    const double pixel = sample.ideal_per_pixel;
    if (feature.edge.kind == EdgeKind::kPipe) {
      feature.sigma = std::hypot(pixel * parameters_.edge_sigma, found.sigma);
      // But noise is another one at the next sample.
      const double not_noise =
          std::max(0.0, found.sigma * found.sigma - found.noise_sigma * found.noise_sigma);
      // The solver adds the parameter's, as of a lens without distortion.
      const double by_lens =
          parameters_.edge_bias_sigma * std::sqrt(std::max(0.0, pixel * pixel - 1));
      feature.bias_sigma = std::hypot(kBiasPerSigma * std::sqrt(not_noise), by_lens);
    } else {
      feature.sigma = std::hypot(pixel * kSupportSigma * parameters_.edge_sigma, found.noise_sigma);
      feature.bias_sigma = pixel * kSupportBias;
    }
    if (rows_.is_rolling()) {
      feature.sigma = std::hypot(feature.sigma, sample.motion_sigma);
    }
  }
}

bool TrackStep::solve(const TrackBelief& guess, const Matrix6d& prior_covariance,
                      const geometry::SE3& prior_pose, const OffsetBelief& offsets,
                      bool with_points) {
  return solve_by(solver_, guess, prior_covariance, prior_pose, offsets, with_points);
}

bool TrackStep::solve_by(PoseSolver& solver, const TrackBelief& guess,
                         const Matrix6d& prior_covariance, const geometry::SE3& prior_pose,
                         const OffsetBelief& offsets, bool with_points, PipeOffsets first_offsets) {
  PoseProblem problem;
  problem.T_camera_rack = guess.T_rack_camera.inverse();
  problem.first_offsets = first_offsets;
  problem.edges = features_;
  if (with_points) {
    problem.points = points_;
  }
  problem.pose_prior = PosePrior{prior_pose.inverse(), linear_algebra::inverse(prior_covariance)};
  problem.offsets = offsets;
  problem.shapes = shape_beliefs_;
  problem.first_shapes = shapes_in_use_;
  if (with_points && !points_.empty() && map_error_.exists()) {
    problem.map_error = map_error_prior(map_error_, problem.pose_prior->information);
  }
  solver.solve(camera_, problem, solution_);
  const bool solved = solution_.status == PoseStatus::kOk ||
                      solution_.status == PoseStatus::kUnobserved ||
                      solution_.status == PoseStatus::kNotConverged;
  if (solved && !shapes_.empty()) {
    use_solved_shapes();
  }
  return solved;
}

void TrackStep::match_points(const ImageView& image, const TrackBelief& before,
                             TrackBelief& guess) {
  surface_.update(model_, std::span(guess.offsets.mean).first(model_.pipes.size()));
  map_.choose(view(guess), surface_, matches_);
  map_.match(image, view(guess), 0, kFirstPoints, matches_);
  std::optional<double> anchor = map_.observations(matches_, points_);
  if (anchor && matches_.size() > kFirstPoints &&
      solve(guess, before.covariance, before.T_rack_camera, before.offsets, true)) {
    guess.T_rack_camera = solution_.T_camera_rack.inverse();
    guess.covariance = solution_.covariance;
  }
  map_.match(image, view(guess), kFirstPoints, matches_.size(), matches_);
}

bool TrackStep::find_edges(const ImageView& image, const TrackBelief& belief, Along along) {
  const double along_variance = along == Along::kByTexture
                                    ? kFreeAlong * kFreeAlong
                                    : belief.covariance(kY, kY) + belief.anchor_variance;
  // With y set free: what supports and orthogonal pipes say of it.
  TrackBelief free = belief;
  free.covariance(kY, kY) += kFreeAlong * kFreeAlong;
  if (is_wide(belief)) {
    // Within such a range there are edges of neighbours: first see where all of them line up.
    TrackBelief around = belief;
    around.covariance(kY, kY) = along_variance;
    find_peaks(image, around, kPeaksInFlight);
    return !peaks_.empty() &&
           refine_start(image, free, {narrowed(image, around, peaks_.front()), {}},
                        along == Along::kByTexture ? along_variance : 0, start_solver_);
  }
  TrackBelief wide = belief;
  wide.covariance(kY, kY) = along_variance;
  search(image, wide, kLeastRange, along_variance);
  return solve(belief, free.covariance, belief.T_rack_camera, belief.offsets, false);
}

void TrackStep::find(const ImageView& image, const TrackBelief& believed, StepOutcome& outcome) {
  map_error_ = believed.map;
  set_velocity(believed);
  begin_shapes(believed);
  TrackBelief before = believed;
  render_placed(before);
  if (map_.size() > 0 && is_wide(before)) {
    TrackBelief around = before;
    around.covariance(kY, kY) += before.anchor_variance;
    if (find_by_texture(image, around, outcome)) {
      return;
    }
    render(before.T_rack_camera, before.offsets);
    // One support looks like another: texture knows better, where there is enough of it.
    find_by(image, before, Along::kByTexture, outcome);
    if (borne_out_by_texture(outcome)) {
      return;
    }
    render(before.T_rack_camera, before.offsets);
    find_by(image, before, Along::kBySupports, outcome);
    if (outcome.evidence.proven_points >= kEnoughProven && !borne_out_by_texture(outcome)) {
      outcome.solved = false;
    }
    return;
  }
  find_by(image, before, Along::kBySupports, outcome);
}

void TrackStep::find_by(const ImageView& image, const TrackBelief& before, Along along,
                        StepOutcome& outcome) {
  outcome = {};
  outcome.belief = before;
  TrackBelief start = before;
  TrackBelief guess = start;
  points_.clear();
  if (find_edges(image, start, along)) {
    anchor_by_supports(image, start, outcome);
    guess.T_rack_camera = solution_.T_camera_rack.inverse();
    guess.covariance = solution_.covariance;
    // Supports know y beside the anchor, the prediction relative to it.
    const double by_supports = solution_.covariance(kY, kY) + start.anchor_variance;
    if (by_supports < start.covariance(kY, kY)) {
      guess.covariance(kY, kY) = by_supports;
    } else {
      Eigen::Vector3d place = guess.T_rack_camera.translation();
      place.y() = start.T_rack_camera.translation().y();
      guess.T_rack_camera = geometry::SE3(guess.T_rack_camera.rotation(), place);
      guess.covariance.row(kY).setZero();
      guess.covariance.col(kY).setZero();
      guess.covariance(kY, kY) = start.covariance(kY, kY);
    }
    guess.anchor_variance = start.anchor_variance;
    guess.offsets = solution_.offsets;
    if (along == Along::kByTexture) {
      guess.covariance *= kDoubtInFar;
    }
  }
  match_points(image, start, guess);

  std::optional<double> anchor = map_.observations(matches_, points_);
  Matrix6d prior = start.covariance;
  if (anchor) {
    // The prediction was relative to the anchor of the image before.
    prior(kY, kY) += std::max(0.0, start.anchor_variance - *anchor);
  }
  bool solved = solve(guess, prior, start.T_rack_camera, start.offsets, true);
  if (solved && anchor && skipped_ > 0 && points_.size() >= kPointsForAlong) {
    // Now that the points say where along the pipes, the other edges can be told apart.
    guess.T_rack_camera = solution_.T_camera_rack.inverse();
    guess.covariance = solution_.covariance;
    guess.offsets = solution_.offsets;
    render(guess.T_rack_camera, guess.offsets);
    search(image, guess, kLeastRange, guess.covariance(kY, kY) + *anchor);
    solved = solve(guess, prior, start.T_rack_camera, start.offsets, true);
  }
  if (solved && !points_.empty() && !points_agree()) {
    // Where nothing else says where along the pipes the camera is, one false match would.
    points_.clear();
    forget_matches();
    anchor.reset();
    solved = solve(guess, start.covariance, start.T_rack_camera, start.offsets, false);
  }
  if (!solved) {
    outcome.status = solution_.status;
    return;
  }
  accept(anchor.value_or(start.anchor_variance), outcome);
}

void TrackStep::accept(double anchor_variance, StepOutcome& outcome) {
  outcome.status = solution_.status;
  outcome.map_error = solution_.map_error;
  outcome.belief.T_rack_camera = solution_.T_camera_rack.inverse();
  outcome.belief.covariance = solution_.covariance;
  outcome.belief.offsets = solution_.offsets;
  outcome.belief.anchor_variance = anchor_variance;
  outcome.offset_observed = solution_.offset_observed;
  outcome.shapes = solution_.shapes;
  outcome.covariance_by_offsets = solution_.covariance_by_offsets;
  outcome.edge_information = solution_.edge_information;
  outcome.inlier_share = solution_.inlier_share;
  outcome.iterations = solution_.iterations;
  outcome.edge_samples = static_cast<int>(samples_.size());
  render(outcome.belief.T_rack_camera, outcome.belief.offsets);
  collect_evidence(outcome);
  // A pose and shapes that are both unknown explain anything.
  outcome.solved = without_texture_.none() || !is_wide(outcome.belief);
}

}  // namespace pipescout::rack_vision
