// SPDX-License-Identifier: Apache-2.0
#include "solution_covariance.hpp"

#include <algorithm>
#include <cmath>

#include "pipescout/linear_algebra/semidefinite.hpp"
#include "pipescout/linear_algebra/symmetric_eigen.hpp"
#include "system_solver.hpp"

namespace pipescout::rack_vision {
namespace {

/// Residuals' worth of belief that the stated sigmas are true.
constexpr double kBeliefInSigmas = 8;
/// No more than this is said of residuals that fit nothing.
constexpr double kLargestFactor = 1e4;

/// The factor for these residuals: as they are, no smaller than with true sigmas. `lost`: share of
/// the residuals' degrees of freedom that the unknowns took.
double measured_factor(const ResidualSums& sums, double stated, double lost) {
  if (!(sums.count > 0)) {
    return stated;
  }
  const double slope = std::max(sums.slope, 0.0);
  const double measured =
      std::min(kLargestFactor, sums.square * sums.weight / std::max(slope * slope, 1e-12));
  const double count = sums.count * (1 - lost);
  const double mixed =
      (kBeliefInSigmas * stated + sums.count * measured) / (kBeliefInSigmas + count);
  return std::max(stated, mixed);
}

/// How many directions of the pose the data leave to more than half of the caps, and whether the
/// only one is along y.
struct Unobserved {
  int directions = 0;
  bool only_along = true;
};

Unobserved unobserved(const SystemMatrix& information, const UnknownLayout& layout,
                      const geometry::Vector6d& caps) {
  geometry::Matrix6d pose = information.topLeftCorner<6, 6>();
  const int others = layout.size - kPoseUnknowns;
  if (others > 0) {
    const SystemMatrix coupling = information.topRightCorner(kPoseUnknowns, others);
    const SystemMatrix rest = information.bottomRightCorner(others, others);
    const SystemMatrix back = coupling.transpose();
    pose -= product(coupling, solve_columns(rest, back));
  }
  const auto eigen =
      linear_algebra::symmetric_eigen<6>(caps.asDiagonal() * pose * caps.asDiagonal());
  constexpr double kHalfOfCap = 4;
  constexpr double kMostlyAlong = 0.95;
  Unobserved result;
  for (int i = 0; i < kPoseUnknowns; ++i) {
    if (!(eigen.values[i] > kHalfOfCap)) {
      ++result.directions;
      const geometry::Vector6d direction = caps.asDiagonal() * eigen.vectors.col(i);
      result.only_along =
          result.directions == 1 && std::abs(direction[1]) > kMostlyAlong * direction.norm();
    }
  }
  return result;
}

/// What errors of offsets and shapes make of the pose, and what the edges tell of it with them.
void add_covariance_by_bodies(const NormalEquations& equations, const SystemMatrix& prior,
                              const SystemMatrix& covariance, const UnknownLayout& layout,
                              const geometry::Vector6d& caps, PoseSolution& solution) {
  const SystemMatrix& edges = equations.edge_information;
  solution.edge_information = edges.topLeftCorner<6, 6>();
  // Shapes follow the offsets.
  const int bodies = layout.offset_count + layout.shape_count;
  if (bodies == 0) {
    return;
  }
  geometry::Matrix6d edges_of_pose = solution.edge_information;
  edges_of_pose.diagonal() += caps.cwiseAbs2().cwiseInverse();
  const auto with_pose = [&](int first, int count) -> SystemMatrix {
    return edges.block(0, first, kPoseUnknowns, count);
  };
  const auto of_bodies = [&](int first, int count) -> SystemMatrix {
    return (edges + prior).block(first, first, count, count);
  };
  if (const int n = layout.offset_count; n > 0) {
    const SystemMatrix by_offsets = solve_columns(edges_of_pose, with_pose(kPoseUnknowns, n));
    const SystemMatrix of_offsets = covariance.block(kPoseUnknowns, kPoseUnknowns, n, n);
    solution.covariance_by_offsets =
        product(product(by_offsets, of_offsets), by_offsets.transpose());
  }
  if (const int n = layout.shape_count; n > 0) {
    // Contours whose shape is hardly known hardly weigh: the pose moves by M^-1 K P^-1 times the
    // error of the shapes that were believed, K = B C^-1, M = A - B C^-1 B^T.
    const int first = layout.first_shape;
    const SystemMatrix coupling = with_pose(first, n);
    const SystemMatrix gain = solve_columns(of_bodies(first, n), coupling.transpose()).transpose();
    const SystemMatrix marginal = SystemMatrix(edges_of_pose) - product(gain, coupling.transpose());
    const SystemMatrix by_shapes = solve_columns(marginal, gain);
    solution.covariance_by_offsets +=
        product(product(by_shapes, prior.block(first, first, n, n)), by_shapes.transpose());
  }
  const SystemMatrix coupling = with_pose(kPoseUnknowns, bodies);
  solution.edge_information -=
      product(coupling, solve_columns(of_bodies(kPoseUnknowns, bodies), coupling.transpose()));
}

}  // namespace

void describe_solution(const NormalEquations& equations, const SystemMatrix& prior,
                       const UnknownLayout& layout, const SolverState& state,
                       const CovarianceFactors& factors, const PoseSolverParameters& parameters,
                       PoseSolution& solution) {
  const double rows = equations.edges.count + 2 * equations.points.count;
  const double lost = std::clamp(layout.size / std::max(rows, 1.0), 0.0, 0.9);
  const double edges =
      equations.edge_weight * measured_factor(equations.edges, factors.edges, lost);
  const double points = measured_factor(equations.points, factors.points, lost);

  geometry::Vector6d caps;
  caps.head<3>().setConstant(parameters.largest_position_deviation);
  caps.tail<3>().setConstant(parameters.largest_rotation_deviation);
  SystemMatrix known = prior;
  known.diagonal().head<6>() += caps.cwiseAbs2().cwiseInverse();

  // Sandwich of the weighted information between what the rows' true spread makes of it.
  const SystemMatrix inverse_information =
      inverse_system(equations.edge_information + equations.point_information + known);
  const SystemMatrix spread =
      edges * equations.edge_information + points * equations.point_information + known;
  const SystemMatrix covariance =
      product(product(inverse_information, spread), inverse_information);
  solution.covariance = covariance.topLeftCorner<6, 6>();
  solution.covariance = (0.5 * (solution.covariance + solution.covariance.transpose())).eval();

  const auto place =
      linear_algebra::symmetric_eigen_direct(solution.covariance.topLeftCorner<3, 3>());
  solution.weakest_direction = place.vectors.col(2);
  solution.weakest_deviation = std::sqrt(std::max(0.0, place.values[2]));

  SystemMatrix data = equations.edge_information + equations.point_information;
  const int others = layout.size - kPoseUnknowns;
  SystemMatrix with_priors = data;
  with_priors.bottomRightCorner(others, others) += prior.bottomRightCorner(others, others);
  const Unobserved weak = unobserved(with_priors, layout, caps);
  solution.unobserved_directions = weak.directions;
  solution.status =
      weak.directions == 0 || weak.only_along ? PoseStatus::kOk : PoseStatus::kUnobserved;

  data.diagonal().head<6>() += caps.cwiseAbs2().cwiseInverse();
  // An unseen offset has no information: a deviation far above what counts as observed instead.
  constexpr double kUnseen = 1e3;
  const double trace =
      1 / (kUnseen * kUnseen * parameters.observed_deviation * parameters.observed_deviation);
  data.diagonal().tail(others).array() += trace;
  // Of the inverse, the columns of the offsets.
  const SystemMatrix from_data = inverse_columns(data, kPoseUnknowns, layout.offset_count);
  for (std::size_t i = 0; i < kMaxPipes; ++i) {
    const int row = layout.offset[i];
    if (row < 0) {
      continue;
    }
    solution.offsets.mean[i] = state.offsets[i];
    solution.offset_observed[i] =
        std::sqrt(edges * from_data(row, row - kPoseUnknowns)) < parameters.observed_deviation;
    for (std::size_t j = 0; j < kMaxPipes; ++j) {
      const int column = layout.offset[j];
      if (column >= 0) {
        solution.offsets.covariance(static_cast<int>(i), static_cast<int>(j)) =
            0.5 * (covariance(row, column) + covariance(column, row));
      }
    }
  }
  for (std::size_t slot = 0; slot < solution.shapes.size(); ++slot) {
    const int k = layout.first_shape + kShapeUnknowns * static_cast<int>(slot);
    const ShapeMatrix block = covariance.block<kShapeUnknowns, kShapeUnknowns>(k, k);
    solution.shapes[slot].mean = state.shapes[slot];
    solution.shapes[slot].covariance = 0.5 * (block + block.transpose());
  }
  add_covariance_by_bodies(equations, prior, covariance, layout, caps, solution);
  if (layout.map_error >= 0) {
    const int k = layout.map_error;
    MapErrorSolution& found = solution.map_error.emplace();
    found.mean = state.map_error;
    found.covariance = covariance.block<6, 6>(k, k);
    found.covariance = (0.5 * (found.covariance + found.covariance.transpose())).eval();
    found.with_pose =
        0.5 * (covariance.block<6, 6>(0, k) + covariance.block<6, 6>(k, 0).transpose());
  }
  if (layout.intrinsics >= 0) {
    const Eigen::Matrix3d block = covariance.block<3, 3>(layout.intrinsics, layout.intrinsics);
    solution.intrinsics = {state.intrinsics, 0.5 * (block + block.transpose())};
    const Eigen::Matrix<double, kPoseUnknowns, kIntrinsicUnknowns> shared =
        covariance.block<kPoseUnknowns, kIntrinsicUnknowns>(0, layout.intrinsics);
    solution.pose_by_intrinsics = linear_algebra::solve_semidefinite<3, 6>(
                                      solution.intrinsics->covariance, shared.transpose())
                                      .transpose();
  }
}

}  // namespace pipescout::rack_vision
