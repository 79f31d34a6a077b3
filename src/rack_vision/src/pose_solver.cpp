// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_vision/pose_solver.hpp"

#include <algorithm>
#include <cmath>

#include "feature_system.hpp"
#include "offset_prior.hpp"
#include "pipescout/linear_algebra/cholesky.hpp"
#include "pose_prior.hpp"
#include "solution_covariance.hpp"
#include "system_solver.hpp"

namespace pipescout::rack_vision {
namespace {

/// A step is shortened to these: beyond them the linear model says nothing.
constexpr double kLargestTurn = 0.3;  // rad
constexpr double kLargestMove = 1.0;  // m
/// The saliency hands over when its steps move the features by less than this many sigmas.
constexpr double kNearEnough = 0.5;
/// Median of |e| for normal residuals, of one and of two dimensions.
constexpr double kHalfNormalMedian = 0.674490;
constexpr double kRayleighMedian = 1.177410;
/// A third of gross outliers raises the scale by the median to about this. Up to it the stated
/// sigmas are believed.
constexpr double kScaleOfOutliers = 1.5;
/// A scale of fewer residuals than these is chance.
constexpr std::size_t kEnoughForScale = 10;
constexpr double kInlierSigmas = 3;
constexpr double kSmallestInlierShare = 0.35;

double scale_of(std::vector<double>& residuals, double median_of_unit) {
  if (residuals.size() < kEnoughForScale) {
    return 1;
  }
  const auto middle = residuals.begin() + static_cast<std::ptrdiff_t>(residuals.size() / 2);
  std::nth_element(residuals.begin(), middle, residuals.end());
  return *middle / median_of_unit;
}

bool is_covariance(const auto& matrix) {
  return matrix.allFinite() && matrix.diagonal().minCoeff() >= 0;
}

bool is_finite(const geometry::SE3& pose) {
  return pose.translation().allFinite() && pose.rotation().quaternion().coeffs().allFinite();
}

bool is_sound(const PoseProblem& problem) {
  if (!is_finite(problem.T_camera_rack) || !is_covariance(problem.offsets.covariance) ||
      !std::ranges::all_of(problem.offsets.mean, [](double x) { return std::isfinite(x); }) ||
      !std::ranges::all_of(problem.first_offsets, [](double x) { return std::isfinite(x); })) {
    return false;
  }
  if (problem.pose_prior && !(is_finite(problem.pose_prior->T_camera_rack) &&
                              is_covariance(problem.pose_prior->information))) {
    return false;
  }
  if (problem.map_error &&
      !(problem.map_error->by_pose.allFinite() && is_covariance(problem.map_error->information))) {
    return false;
  }
  if (problem.shapes.size() > kMaxShapedPipes ||
      !std::ranges::all_of(problem.shapes,
                           [](const ShapeBelief& shape) {
                             return shape.mean.allFinite() && is_covariance(shape.covariance);
                           }) ||
      !std::ranges::all_of(problem.first_shapes,
                           [](const ShapeVector& shape) { return shape.allFinite(); })) {
    return false;
  }
  return !problem.intrinsics ||
         (problem.intrinsics->mean.allFinite() && problem.intrinsics->mean[0] > 0 &&
          is_covariance(problem.intrinsics->covariance) &&
          problem.intrinsics->covariance.diagonal().minCoeff() > 0);
}

}  // namespace

class PoseSolver::Implementation {
 public:
  Implementation(const RackModel& model, const PoseSolverParameters& parameters)
      : parameters_(parameters), features_(model) {
    parameters_.validate();
    for (std::size_t i = 0; i < model.pipes.size(); ++i) {
      movable_[i] = model.pipes[i].movable;
    }
    factors_ = {covariance_factor(final_kernel(), final_width(), 1),
                covariance_factor(final_kernel(), final_width(), 2)};
  }

  void reserve(std::size_t edges, std::size_t samples, std::size_t points) {
    features_.reserve(edges, samples, points);
  }
  void solve(const geometry::Camera& camera, const PoseProblem& problem, PoseSolution& solution);

  [[nodiscard]] const PoseSolverParameters& parameters() const noexcept { return parameters_; }

 private:
  [[nodiscard]] bool iterated() const { return parameters_.method == SolverMethod::kIterated; }
  [[nodiscard]] statistics::RobustKernel final_kernel() const {
    switch (parameters_.method) {
      case SolverMethod::kLippielloLeastSquares:
        return statistics::RobustKernel::kNone;
      case SolverMethod::kLippielloSaliency:
        return statistics::RobustKernel::kSaliency;
      case SolverMethod::kIterated:
        break;
    }
    return parameters_.kernel;
  }
  [[nodiscard]] double final_width() const {
    return iterated() ? parameters_.kernel_width : parameters_.saliency_nu;
  }
  [[nodiscard]] Weighting first_weighting() const;
  /// How far the residuals of the last evaluation spread, as a multiple of their sigmas.
  struct ResidualScales {
    double edges = 1;
    double points = 1;
  };
  [[nodiscard]] ResidualScales residual_scales();
  [[nodiscard]] Weighting final_weighting(const ResidualScales& scales) const;

  /// Returns false where a covariance is none, or a shape that of no pipe.
  bool start(const PoseProblem& problem);
  bool start_shapes(const PoseProblem& problem);
  /// The sums at `state_`, with damping and all priors.
  void evaluate_state(const PoseProblem& problem, const Weighting& weighting);
  void add_priors(const PoseProblem& problem);
  /// Solves for a step from `state_`; its size in sigmas of the features.
  double step_from_here(double damping);
  void take_step();
  bool iterate(const PoseProblem& problem, int& iterations);
  void finish(const PoseProblem& problem, bool converged, PoseSolution& solution);

  PoseSolverParameters parameters_;
  FeatureSystem features_;
  std::bitset<kMaxPipes> movable_;
  CovarianceFactors factors_;

  UnknownLayout layout_;
  OffsetPrior offset_prior_;
  std::array<ShapeMatrix, kMaxShapedPipes> shape_information_{};
  Eigen::Matrix3d intrinsics_information_ = Eigen::Matrix3d::Zero();
  SolverState state_, better_state_;
  NormalEquations equations_;
  SystemMatrix prior_;     // information of all priors
  SystemVector gradient_;  // of data and priors
  double cost_ = 0;        // of data and priors
  SystemVector step_;
};

Weighting PoseSolver::Implementation::first_weighting() const {
  const bool unweighted = parameters_.method == SolverMethod::kLippielloLeastSquares;
  return {
      .kernel = unweighted ? statistics::RobustKernel::kNone : statistics::RobustKernel::kSaliency,
      .edge_width = parameters_.saliency_nu,
      .point_width = parameters_.saliency_nu,
      .inlier_bound = kInlierSigmas,
      .points_along_displacement = !iterated()};
}

PoseSolver::Implementation::ResidualScales PoseSolver::Implementation::residual_scales() {
  return {scale_of(features_.edge_residuals(), kHalfNormalMedian),
          scale_of(features_.point_residuals(), kRayleighMedian)};
}

Weighting PoseSolver::Implementation::final_weighting(const ResidualScales& scales) const {
  const auto widened = [](double scale) { return std::max(1.0, scale / kScaleOfOutliers); };
  const double edges = std::min(parameters_.largest_edge_widening, widened(scales.edges));
  const double points = widened(scales.points);
  return {.kernel = final_kernel(),
          .edge_width = final_width() * edges,
          .point_width = final_width() * points,
          .inlier_bound = kInlierSigmas * std::max(edges, points),
          .edge_weight = parameters_.spread_weakens_edges
                             ? 1 / std::max(1.0, scales.edges * scales.edges)
                             : 1.0};
}

bool PoseSolver::Implementation::start(const PoseProblem& problem) {
  state_.T_camera_rack = problem.T_camera_rack;
  state_.offsets = problem.offsets.mean;
  std::ranges::copy(problem.first_offsets.first(std::min(kMaxPipes, problem.first_offsets.size())),
                    state_.offsets.begin());
  layout_ = {};
  for (std::size_t i = 0; i < kMaxPipes; ++i) {
    const bool free =
        movable_[i] && problem.offsets.covariance(static_cast<int>(i), static_cast<int>(i)) > 0;
    layout_.offset[i] = free ? kPoseUnknowns + layout_.offset_count++ : -1;
  }
  layout_.size += layout_.offset_count;
  if (!start_shapes(problem)) {
    return false;
  }
  if (problem.intrinsics) {
    layout_.intrinsics = layout_.size;
    layout_.size += kIntrinsicUnknowns;
    state_.intrinsics = problem.intrinsics->mean;
    intrinsics_information_ = linear_algebra::Cholesky<3>(problem.intrinsics->covariance).inverse();
  }
  if (problem.map_error) {
    layout_.map_error = layout_.size;
    layout_.size += kMapErrorUnknowns;
    state_.map_error.setZero();
  }
  return true;
}

bool PoseSolver::Implementation::start_shapes(const PoseProblem& problem) {
  layout_.shape.fill(-1);
  layout_.first_shape = layout_.size;
  layout_.shape_count = kShapeUnknowns * static_cast<int>(problem.shapes.size());
  layout_.size += layout_.shape_count;
  for (std::size_t slot = 0; slot < problem.shapes.size(); ++slot) {
    const ShapeBelief& belief = problem.shapes[slot];
    // What is exact is held tightly.
    constexpr double kExact = 1e-6;  // m and rad
    SystemMatrix covariance = belief.covariance;
    covariance.diagonal().array() += kExact * kExact;
    const std::optional<SystemMatrix> information = inverse_positive(covariance);
    if (belief.pipe >= kMaxPipes || layout_.shape[belief.pipe] >= 0 || !information) {
      return false;
    }
    layout_.shape[belief.pipe] = static_cast<int>(slot);
    state_.shapes[slot] =
        slot < problem.first_shapes.size() ? problem.first_shapes[slot] : belief.mean;
    shape_information_[slot] = *information;
  }
  return true;
}

void PoseSolver::Implementation::add_priors(const PoseProblem& problem) {
  prior_.setZero(layout_.size, layout_.size);
  gradient_ = equations_.gradient;
  cost_ = equations_.cost;
  add_pose_prior(problem, state_, layout_, prior_, gradient_, cost_);
  offset_prior_.add(state_, prior_, gradient_, cost_);
  for (std::size_t slot = 0; slot < problem.shapes.size(); ++slot) {
    const int k = layout_.first_shape + kShapeUnknowns * static_cast<int>(slot);
    const ShapeVector difference = state_.shapes[slot] - problem.shapes[slot].mean;
    const ShapeVector weighted = shape_information_[slot] * difference;
    prior_.block<kShapeUnknowns, kShapeUnknowns>(k, k) += shape_information_[slot];
    gradient_.segment<kShapeUnknowns>(k) += weighted;
    cost_ += 0.5 * difference.dot(weighted);
  }
  if (layout_.intrinsics >= 0) {
    const Eigen::Vector3d difference = state_.intrinsics - problem.intrinsics->mean;
    const Eigen::Vector3d weighted = intrinsics_information_ * difference;
    prior_.block<3, 3>(layout_.intrinsics, layout_.intrinsics) += intrinsics_information_;
    gradient_.segment<3>(layout_.intrinsics) += weighted;
    cost_ += 0.5 * difference.dot(weighted);
  }
}

void PoseSolver::Implementation::evaluate_state(const PoseProblem& problem,
                                                const Weighting& weighting) {
  features_.accumulate(state_, layout_, weighting, equations_);
  add_priors(problem);
}

double PoseSolver::Implementation::step_from_here(double damping) {
  SystemMatrix system = equations_.edge_information + equations_.point_information + prior_;
  // A trace of information about the pose, so that what nothing observes stays where it is.
  system.diagonal() *= 1 + damping;
  system.diagonal().head<3>().array() +=
      1 / (parameters_.largest_position_deviation * parameters_.largest_position_deviation);
  system.diagonal().segment<3>(3).array() +=
      1 / (parameters_.largest_rotation_deviation * parameters_.largest_rotation_deviation);
  step_ = solve_system(system, -gradient_);
  if (!step_.allFinite()) {
    return std::numeric_limits<double>::infinity();
  }
  const double turn = step_.segment<3>(3).norm();
  const double move = step_.head<3>().norm();
  step_ *= std::min({1.0, kLargestTurn / std::max(turn, kLargestTurn),
                     kLargestMove / std::max(move, kLargestMove)});
  const double features = equations_.edges.count + 2 * equations_.points.count;
  return std::sqrt(std::max(0.0, step_.dot(system * step_)) / std::max(1.0, features));
}

void PoseSolver::Implementation::take_step() {
  state_.T_camera_rack = moved(state_.T_camera_rack, step_.head<6>());
  for (std::size_t i = 0; i < kMaxPipes; ++i) {
    if (layout_.offset[i] >= 0) {
      state_.offsets[i] += step_[layout_.offset[i]];
    }
  }
  for (int k = 0; k < layout_.shape_count; k += kShapeUnknowns) {
    state_.shapes[static_cast<std::size_t>(k / kShapeUnknowns)] +=
        step_.segment<kShapeUnknowns>(layout_.first_shape + k);
  }
  if (layout_.intrinsics >= 0) {
    state_.intrinsics += step_.segment<3>(layout_.intrinsics);
    // A focal length that a wild step turns round would mirror the image.
    state_.intrinsics[0] = std::max(state_.intrinsics[0], 1.0);
  }
  if (layout_.map_error >= 0) {
    state_.map_error += step_.segment<6>(layout_.map_error);
  }
}

/// Saliency until near, then the kernel until the steps are small. Levenberg's damping steps in
/// where a step makes things worse. Returns whether it converged.
bool PoseSolver::Implementation::iterate(const PoseProblem& problem, int& iterations) {
  Weighting weighting = first_weighting();
  bool near = !iterated() || !parameters_.saliency_first;
  if (near && iterated()) {
    evaluate_state(problem, weighting);
    weighting = final_weighting(residual_scales());
    offset_prior_.judge(state_, equations_.edge_information + equations_.point_information + prior_,
                        parameters_.innovation_gate);
  }
  double damping = 0;
  double best_cost = std::numeric_limits<double>::infinity();
  NormalEquations& equations = equations_;
  const int most = iterated() ? parameters_.iterations : 1;
  for (iterations = 0; iterations < most; ++iterations) {
    evaluate_state(problem, weighting);
    constexpr double kWorse = 1 + 1e-9;
    if (cost_ > best_cost * kWorse) {
      constexpr double kFirstDamping = 1e-3, kMoreDamping = 10, kMostDamping = 1e6;
      damping = std::max(kFirstDamping, damping * kMoreDamping);
      if (damping > kMostDamping) {
        return false;
      }
      state_ = better_state_;
      evaluate_state(problem, weighting);
    } else {
      damping *= 0.1;
    }
    best_cost = cost_;
    better_state_ = state_;
    const double step = step_from_here(damping);
    if (!std::isfinite(step)) {
      return false;
    }
    if (equations.edges.count + equations.points.count == 0) {
      return false;
    }
    take_step();
    if (!near && (step < kNearEnough || 2 * (iterations + 1) >= most)) {
      near = true;
      damping = 0;
      best_cost = std::numeric_limits<double>::infinity();
      weighting = final_weighting(residual_scales());
      offset_prior_.judge(state_, equations.edge_information + equations.point_information + prior_,
                          parameters_.innovation_gate);
    } else if (near && step < parameters_.smallest_step) {
      ++iterations;
      return true;
    }
  }
  return !iterated();
}

void PoseSolver::Implementation::finish(const PoseProblem& problem, bool converged,
                                        PoseSolution& solution) {
  const ResidualScales scales = residual_scales();
  solution.residual_scale = std::max(scales.edges, scales.points);
  const Weighting weighting = iterated() ? final_weighting(scales) : first_weighting();
  evaluate_state(problem, weighting);
  solution.T_camera_rack = state_.T_camera_rack;
  offset_prior_.report(solution);
  describe_solution(equations_, prior_, layout_, state_, factors_, parameters_, solution);
  solution.edges.assign(features_.support().begin(), features_.support().end());
  const double inliers = equations_.edges.inliers + equations_.points.inliers;
  const double features = static_cast<double>(features_.sample_count() + features_.point_count());
  solution.inlier_share = inliers / features;
  solution.chi_square = equations_.edges.inlier_square + 2 * equations_.points.inlier_square;
  if (!converged) {
    solution.status = PoseStatus::kNotConverged;
  } else if (solution.inlier_share < kSmallestInlierShare) {
    solution.status = PoseStatus::kTooFewInliers;
  }
}

void PoseSolver::Implementation::solve(const geometry::Camera& camera, const PoseProblem& problem,
                                       PoseSolution& solution) {
  solution.T_camera_rack = problem.T_camera_rack;
  solution.offsets = problem.offsets;
  solution.shapes.assign(problem.shapes.begin(), problem.shapes.end());
  solution.intrinsics = problem.intrinsics;
  solution.pose_by_intrinsics.setZero();
  solution.map_error.reset();
  solution.covariance_by_offsets.setZero();
  solution.edge_information.setZero();
  solution.covariance.setZero();
  solution.covariance.diagonal().head<3>().setConstant(parameters_.largest_position_deviation *
                                                       parameters_.largest_position_deviation);
  solution.covariance.diagonal().tail<3>().setConstant(parameters_.largest_rotation_deviation *
                                                       parameters_.largest_rotation_deviation);
  solution.weakest_direction = Eigen::Vector3d::UnitY();
  solution.weakest_deviation = parameters_.largest_position_deviation;
  solution.unobserved_directions = kPoseUnknowns;
  solution.offset_observed.reset();
  solution.offset_moved.reset();
  solution.offset_innovation = solution.innovation_deviation = {};
  solution.edges.clear();
  solution.samples = solution.points = solution.refused = 0;
  solution.inlier_share = solution.chi_square = solution.residual_scale = 0;
  solution.iterations = 0;
  solution.status = PoseStatus::kBadInput;
  if (!is_sound(problem)) {
    return;
  }
  if (!start(problem) ||
      !offset_prior_.start(problem.offsets, layout_, iterated() ? parameters_.offset_freedom : 0)) {
    return;
  }
  features_.prepare(camera, problem, parameters_);
  solution.samples = features_.sample_count();
  solution.points = features_.point_count();
  solution.refused = features_.refused();
  if (solution.samples + solution.points == 0) {
    solution.status = PoseStatus::kNoFeatures;
    return;
  }
  const bool converged = iterate(problem, solution.iterations);
  if (!is_finite(state_.T_camera_rack)) {
    solution.status = PoseStatus::kNotConverged;
    return;
  }
  finish(problem, converged, solution);
}

PipeShape to_shape(const ShapeVector& vector) noexcept {
  return {.offset = vector(0),
          .height = vector(1),
          .turn_aside = vector(2),
          .turn_up = vector(3),
          .radius = vector(4)};
}

PoseSolver::PoseSolver(const RackModel& model, const PoseSolverParameters& parameters)
    : implementation_(std::make_unique<Implementation>(model, parameters)) {}
PoseSolver::~PoseSolver() = default;
PoseSolver::PoseSolver(PoseSolver&&) noexcept = default;
PoseSolver& PoseSolver::operator=(PoseSolver&&) noexcept = default;

void PoseSolver::reserve(std::size_t edges, std::size_t samples, std::size_t points) {
  implementation_->reserve(edges, samples, points);
}

void PoseSolver::solve(const geometry::Camera& camera, const PoseProblem& problem,
                       PoseSolution& solution) {
  implementation_->solve(camera, problem, solution);
}

const PoseSolverParameters& PoseSolver::parameters() const noexcept {
  return implementation_->parameters();
}

}  // namespace pipescout::rack_vision
