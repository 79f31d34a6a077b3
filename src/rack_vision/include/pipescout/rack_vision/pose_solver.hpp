// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "pipescout/geometry/camera.hpp"
#include "pipescout/geometry/se3.hpp"
#include "pipescout/rack_vision/rack_model.hpp"
#include "pipescout/rack_vision/visible_edges.hpp"
#include "pipescout/statistics/robust_kernel.hpp"

/// The camera's pose and the pipes' offsets from features of one image: Lippiello and Cacace,
/// equations (15) to (18) and (23) to (29), iterated to convergence.
///
/// Covariances of poses here are those of geometry_msgs/PoseWithCovariance for T_rack_camera: the
/// camera's centre along the axes of the rack, then rotation about the rack's fixed axes,
/// R_rack_camera' = exp(dphi) R_rack_camera; m and rad.
namespace pipescout::rack_vision {

/// Detections of an edge along the normal at one sample of its rendered line.
struct EdgeSample {
  static constexpr std::size_t kMaxCandidates = 3;
  EdgeId edge;
  std::uint8_t candidate_count = 1;  ///< 1 to 3 of `candidates` are used
  /// Ideal pixels (no distortion). The solver selects the one nearest to the line in each
  /// iteration.
  std::array<Eigen::Vector2d, kMaxCandidates> candidates{};
  double sigma = 1;  ///< standard deviation across the edge, pixels, > 0
  /// Of an error common to all samples of the edge, pixels, >= 0; in addition to edge_bias_sigma of
  /// the parameters. The RMS over the samples is used.
  double bias_sigma = 0;
};

/// A texture point matched in the image.
struct PointObservation {
  /// Pipe of the point, or kOnNoPipe (a support): then offsets do not move it.
  std::uint16_t pipe = 0;
  /// Rack frame, m, for the pipe's position in the model (offset 0).
  Eigen::Vector3d place = Eigen::Vector3d::Zero();
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< ideal pixel
  double sigma = 1;                                 ///< of each coordinate, pixels, > 0
  /// Covariance of `place`, m^2, rack frame; positive semi-definite.
  Eigen::Matrix3d place_covariance = Eigen::Matrix3d::Zero();

  /// Derivative of `place` with respect to the common map error, see `MapErrorPrior`.
  Eigen::Matrix<double, 3, 6> place_by_map_error = Eigen::Matrix<double, 3, 6>::Zero();

  static constexpr std::uint16_t kOnNoPipe = std::numeric_limits<std::uint16_t>::max();
};

/// Prior of the pose (odometry, GPS).
struct PosePrior {
  geometry::SE3 T_camera_rack;
  /// Inverse covariance, form as above; positive semi-definite: directions may be unconstrained.
  geometry::Matrix6d information = geometry::Matrix6d::Zero();
};

/// Common error of all points: the error of the poses from which they were mapped, in the form of a
/// pose error. It is correlated with the pose of this image: its expected value is `by_pose` times
/// the difference of the pose from the PosePrior.
struct MapErrorPrior {
  geometry::Matrix6d by_pose = geometry::Matrix6d::Zero();
  /// Inverse of the conditional covariance; positive semi-definite.
  geometry::Matrix6d information = geometry::Matrix6d::Zero();
};

/// The same error after an image.
struct MapErrorSolution {
  geometry::Vector6d mean = geometry::Vector6d::Zero();
  geometry::Matrix6d covariance = geometry::Matrix6d::Zero();
  geometry::Matrix6d with_pose = geometry::Matrix6d::Zero();  ///< rows: pose; columns: map error
};

using OffsetMatrix =
    Eigen::Matrix<double, static_cast<int>(kMaxPipes), static_cast<int>(kMaxPipes)>;

/// Offsets of all pipes along rack x (see `PipeOffsets`), m, and their covariance, m^2. A pipe
/// whose variance is 0 stays at its mean, as do pipes that are fixed in the model.
struct OffsetBelief {
  std::array<double, kMaxPipes> mean{};
  OffsetMatrix covariance = OffsetMatrix::Zero();
  /// Pipes that may lie at one of several places: they are looked for nowhere until one is left.
  std::bitset<kMaxPipes> unplaced;
};

inline constexpr int kShapeUnknowns = 5;
/// PipeShape as a vector, in the order of its fields.
using ShapeVector = Eigen::Matrix<double, kShapeUnknowns, 1>;
using ShapeMatrix = Eigen::Matrix<double, kShapeUnknowns, kShapeUnknowns>;

[[nodiscard]] PipeShape to_shape(const ShapeVector& vector) noexcept;

/// Shape of a pipe that may not be as the model has it, m and rad, and its covariance. What has a
/// variance of 0 stays at its mean.
struct ShapeBelief {
  std::size_t pipe = 0;
  ShapeVector mean = ShapeVector::Zero();
  ShapeMatrix covariance = ShapeMatrix::Zero();
};

/// Focal length f_c and centre u_0, v_0, pixels, and their covariance. Exact for a camera without
/// distortion; with distortion valid for changes that are small compared with the image.
struct IntrinsicsBelief {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
};

/// Method of computing the pose.
enum class SolverMethod : std::uint8_t {
  /// Iterated to convergence: first with the saliency, which has a large region of convergence,
  /// then with `kernel`.
  kIterated,
  /// Lippiello and Cacace, equations (16) to (18): one step of unweighted least squares.
  kLippielloLeastSquares,
  /// Lippiello and Cacace, equations (27) to (29): one step with the saliency as weight.
  kLippielloSaliency,
};

struct PoseSolverParameters {
  SolverMethod method = SolverMethod::kIterated;
  statistics::RobustKernel kernel =
      statistics::RobustKernel::kTukey;  ///< of the last iterations of kIterated
  double kernel_width = 4.685;           ///< standard deviations, > 0
  /// kIterated: begin with the saliency, which converges from far, but may also diverge from a near
  /// start where edges are close together.
  bool saliency_first = true;
  double saliency_nu = 1.0;  ///< nu of equation (29), standard deviations, > 0
  /// kIterated: if the median of the edge residuals is larger than their sigmas imply, the kernel
  /// is widened by at most this factor, >= 1. If more than half of the samples may be outliers, the
  /// median is one of them: 1 keeps the sigmas.
  double largest_edge_widening = 1e6;
  /// kIterated: if the edge residuals spread more than their sigmas imply, the edges are weighted
  /// against priors with correspondingly larger sigmas.
  bool spread_weakens_edges = false;
  int iterations = 12;  ///< at most, 1..100
  /// Converged when a step moves the features by less than this (RMS), in standard deviations, > 0.
  double smallest_step = 0.02;
  double gate = 100;  ///< pixels, > 0: candidates and points farther from their predicted position
                      ///< are not used in that iteration
  /// Error common to all samples of one edge (its paint, its radius), pixels, >= 0.
  double edge_bias_sigma = 0;
  /// Upper bounds of the reported standard deviations in unobservable directions, > 0.
  double largest_position_deviation = 100;  ///< m
  double largest_rotation_deviation = 1;    ///< rad
  /// Additional standard deviation of a pipe's prior in the innovation test of an image, m, > 0;
  /// beyond `innovation_gate` standard deviations, > 0, the pipe has moved and its prior is not
  /// used.
  double offset_freedom = 0.1;
  double innovation_gate = 5;
  /// An offset is observed when this image alone determines it with a smaller standard deviation,
  /// m, > 0.
  double observed_deviation = 0.03;

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

struct PoseProblem {
  geometry::SE3 T_camera_rack;          ///< H, initial value
  std::span<const EdgeSample> edges{};  ///< samples of one edge are consecutive
  std::span<const PointObservation> points{};
  std::optional<PosePrior> pose_prior{};
  /// Prior for this image. The solution contains the posterior: no information is used twice when
  /// it is the next prior after adding process noise. See `OffsetFilter`.
  OffsetBelief offsets{};
  /// Initial values of the offsets, one per pipe or kMaxPipes; empty: the mean of the prior.
  PipeOffsets first_offsets{};
  /// The same of shapes: at most kMaxShapedPipes, each of another pipe, which is not movable.
  std::span<const ShapeBelief> shapes{};
  /// Initial values of the shapes, as many; empty: the means of the priors.
  std::span<const ShapeVector> first_shapes{};
  /// If set, the intrinsics are estimated too, in the same way.
  std::optional<IntrinsicsBelief> intrinsics{};
  /// If set, the map error is estimated too. Needs a `pose_prior` if `by_pose` is not zero.
  std::optional<MapErrorPrior> map_error{};
};

enum class PoseStatus : std::uint8_t {
  kOk,             ///< converged; at most the motion along the pipes is unobservable
  kUnobserved,     ///< converged, but more of the pose is unobservable (one edge only): see
                   ///< `covariance`
  kNotConverged,   ///< out of iterations
  kTooFewInliers,  ///< most features are inconsistent with the solution
  kNoFeatures,     ///< no usable features; pose and priors are those of the problem
  kBadInput,       ///< NaN in pose or priors, or an invalid covariance; the same
};

/// Result of one edge: consecutive samples with one EdgeId.
struct EdgeSupport {
  EdgeId edge;
  std::uint16_t samples = 0;
  std::uint16_t inliers = 0;
};

struct PoseSolution {
  PoseStatus status = PoseStatus::kNoFeatures;
  geometry::SE3 T_camera_rack;
  /// Of T_rack_camera, form as above. From the weights and the residuals of this image, not smaller
  /// than the stated sigmas imply; limited in unobservable directions (see the parameters);
  /// includes the prior.
  geometry::Matrix6d covariance = geometry::Matrix6d::Zero();
  /// Direction of the largest position uncertainty: unit vector, rack frame, and its standard
  /// deviation, m.
  Eigen::Vector3d weakest_direction = Eigen::Vector3d::UnitY();
  double weakest_deviation = 0;
  int unobserved_directions = 0;  ///< of the six, without the prior

  OffsetBelief offsets;                    ///< after this image, jointly with the pose
  std::bitset<kMaxPipes> offset_observed;  ///< by this image alone
  std::bitset<kMaxPipes> offset_moved;     ///< inconsistent with its prior
  /// Innovation of the pipe's offset, m, and its standard deviation; 0: not tested.
  std::array<double, kMaxPipes> offset_innovation{};
  std::array<double, kMaxPipes> innovation_deviation{};
  std::vector<ShapeBelief> shapes;  ///< after this image, in the order of the problem
  /// Covariance of the pose due to errors of offsets and shapes, for edges like those of this
  /// image, m and rad. It does not average out over images.
  geometry::Matrix6d covariance_by_offsets = geometry::Matrix6d::Zero();
  /// Of the pose, by the edges of this image alone; of offsets and shapes it has what was believed.
  geometry::Matrix6d edge_information = geometry::Matrix6d::Zero();
  std::optional<IntrinsicsBelief> intrinsics{};
  std::optional<MapErrorSolution> map_error{};  ///< when it is estimated
  /// If the intrinsics are estimated: derivative of the pose with respect to them, form as above,
  /// m/px, rad/px.
  Eigen::Matrix<double, 6, 3> pose_by_intrinsics = Eigen::Matrix<double, 6, 3>::Zero();

  std::vector<EdgeSupport> edges;  ///< in the order of the samples
  std::size_t samples = 0;         ///< usable edge samples
  std::size_t points = 0;          ///< usable points
  std::size_t refused = 0;         ///< features with NaN, without sigma, or of an unknown edge
  double inlier_share = 0;         ///< of samples and points together; inlier: within 3 sigma
  double chi_square = 0;           ///< of the inliers
  double residual_scale = 0;  ///< median based, in stated standard deviations: the larger one of
                              ///< edges and points; 1 of fewer than 10
  int iterations = 0;
};

/// Stores the model and working memory; a solution depends on the problem only. One thread at a
/// time per object. Allocates only until the largest number of features has occurred.
class PoseSolver {
 public:
  /// Throws std::invalid_argument as PoseSolverParameters::validate. `model` must be valid.
  explicit PoseSolver(const RackModel& model, const PoseSolverParameters& parameters = {});
  ~PoseSolver();
  PoseSolver(PoseSolver&&) noexcept;
  PoseSolver& operator=(PoseSolver&&) noexcept;

  /// Reserves memory: problems with up to this many edges, samples and points allocate nothing.
  void reserve(std::size_t edges, std::size_t samples, std::size_t points);

  /// Never throws for any content of the problem.
  void solve(const geometry::Camera& camera, const PoseProblem& problem, PoseSolution& solution);

  [[nodiscard]] const PoseSolverParameters& parameters() const noexcept;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

[[nodiscard]] std::string_view to_string(SolverMethod method) noexcept;
[[nodiscard]] std::string_view to_string(PoseStatus status) noexcept;

}  // namespace pipescout::rack_vision
