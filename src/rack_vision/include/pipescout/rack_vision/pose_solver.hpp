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

/// Where an edge was found beside one place of its rendered line.
struct EdgeSample {
  static constexpr std::size_t kMaxCandidates = 3;
  EdgeId edge;
  std::uint8_t candidate_count = 1;  ///< 1 to 3 of `candidates` are used
  /// Ideal pixels (no distortion). The solver takes the one nearest to the line, anew with each
  /// iteration.
  std::array<Eigen::Vector2d, kMaxCandidates> candidates{};
  double sigma = 1;  ///< standard deviation across the edge, pixels, > 0
  /// Of an error that all samples of the edge share, pixels, >= 0; beside the edge_bias_sigma of
  /// the parameters. The root of the mean square over the samples counts.
  double bias_sigma = 0;
};

/// A texture point that was recognised in the image.
struct PointObservation {
  /// Pipe on which it is, or kOnNoPipe (a support): then offsets do not move it.
  std::uint16_t pipe = 0;
  /// Rack frame, m, with the pipe where the model has it (offset 0).
  Eigen::Vector3d place = Eigen::Vector3d::Zero();
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< ideal pixel
  double sigma = 1;                                 ///< of each coordinate, pixels, > 0
  /// How well `place` is known, m^2, rack frame; positive semi-definite.
  Eigen::Matrix3d place_covariance = Eigen::Matrix3d::Zero();

  /// How the error that all points share, see `MapErrorPrior`, moves `place`.
  Eigen::Matrix<double, 3, 6> place_by_map_error = Eigen::Matrix<double, 3, 6>::Zero();

  static constexpr std::uint16_t kOnNoPipe = std::numeric_limits<std::uint16_t>::max();
};

/// What is known about the pose from elsewhere (odometry, GPS).
struct PosePrior {
  geometry::SE3 T_camera_rack;
  /// Inverse covariance, form as above; positive semi-definite: directions may be unknown.
  geometry::Matrix6d information = geometry::Matrix6d::Zero();
};

/// What all points are wrong by together: the error of the poses from which they were mapped, form
/// as that of a pose. Known as it hangs together with the pose of this image: it is expected to be
/// `by_pose` times the difference of the pose from the PosePrior.
struct MapErrorPrior {
  geometry::Matrix6d by_pose = geometry::Matrix6d::Zero();
  /// Inverse covariance of what is left; positive semi-definite.
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
/// whose variance is 0 stays at its mean; so does one that the model does not let move.
struct OffsetBelief {
  std::array<double, kMaxPipes> mean{};
  OffsetMatrix covariance = OffsetMatrix::Zero();
};

/// Focal length f_c and centre u_0, v_0, pixels, and their covariance. Exact for a camera without
/// distortion; with it, for changes that are small against the image.
struct IntrinsicsBelief {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
};

/// How the pose is computed.
enum class SolverMethod : std::uint8_t {
  /// To convergence: saliency first, which finds its way from far, then `kernel`.
  kIterated,
  /// Lippiello and Cacace, equations (16) to (18): one step of unweighted least squares.
  kLippielloLeastSquares,
  /// Lippiello and Cacace, equations (27) to (29): one step with the saliency as weight.
  kLippielloSaliency,
};

struct PoseSolverParameters {
  SolverMethod method = SolverMethod::kIterated;
  statistics::RobustKernel kernel =
      statistics::RobustKernel::kTukey;  ///< of the last iterations; of no other method
  double kernel_width = 4.685;           ///< standard deviations, > 0
  /// kIterated: begin with the saliency, which finds its way from far, but may also find a way from
  /// near to far where edges lie close together.
  bool saliency_first = true;
  double saliency_nu = 1.0;  ///< nu of equation (29), standard deviations, > 0
  /// kIterated: where residuals of edge samples spread farther than their sigmas say, by their
  /// median, the kernel is made wider, by at most this factor, >= 1. Where more than half of them
  /// may be outliers the median is one of those: 1 then holds to the sigmas.
  double largest_edge_widening = 1e6;
  /// kIterated: where they spread farther than their sigmas say, edges count as little against
  /// priors as if their sigmas were as large as that.
  bool spread_weakens_edges = false;
  int iterations = 12;  ///< at most, 1..100
  /// Converged when a step moves the features by less than this, root of their mean square, in
  /// standard deviations, > 0.
  double smallest_step = 0.02;
  double gate = 100;  ///< pixels, > 0: candidates and points farther from where they should be
                      ///< are not used in that iteration
  /// Error that all samples of one edge share (its paint, its radius), pixels, >= 0.
  double edge_bias_sigma = 0;
  /// Cap of the standard deviations that are said where nothing is observed, > 0.
  double largest_position_deviation = 100;  ///< m
  double largest_rotation_deviation = 1;    ///< rad
  /// Within a frame a pipe may lie this far from its belief, m, > 0, before the belief is compared
  /// with what the image says; beyond `innovation_gate` standard deviations, > 0, it has moved and
  /// its belief is not used.
  double offset_freedom = 0.1;
  double innovation_gate = 5;
  /// An offset is called observed when this image alone gives it with a smaller deviation, m, > 0.
  double observed_deviation = 0.03;

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

struct PoseProblem {
  geometry::SE3 T_camera_rack;          ///< H, first guess
  std::span<const EdgeSample> edges{};  ///< samples of one edge one after the other
  std::span<const PointObservation> points{};
  std::optional<PosePrior> pose_prior{};
  /// Belief before this image. The solution holds the belief after it: nothing is counted twice
  /// when that, made wider by what may have changed in between, is the next belief. See
  /// `OffsetFilter`.
  OffsetBelief offsets{};
  /// Set: they are estimated too, by the same rule.
  std::optional<IntrinsicsBelief> intrinsics{};
  /// Set: it is estimated too. Needs a `pose_prior` where `by_pose` is not zero.
  std::optional<MapErrorPrior> map_error{};
};

enum class PoseStatus : std::uint8_t {
  kOk,             ///< converged; at most the motion along the pipes was not observed
  kUnobserved,     ///< converged, but more of the pose was not observed (one edge only): see
                   ///< `covariance`
  kNotConverged,   ///< out of iterations
  kTooFewInliers,  ///< most features contradict the pose that was found
  kNoFeatures,     ///< none that can be used; pose and beliefs are those of the problem
  kBadInput,       ///< NaN in pose, prior or beliefs, or no covariance; the same
};

/// What became of one edge: consecutive samples with one EdgeId.
struct EdgeSupport {
  EdgeId edge;
  std::uint16_t samples = 0;
  std::uint16_t inliers = 0;
};

struct PoseSolution {
  PoseStatus status = PoseStatus::kNoFeatures;
  geometry::SE3 T_camera_rack;
  /// Of T_rack_camera, form as above. From the weights and the residuals of this image, no smaller
  /// than the stated sigmas make it; capped where nothing was observed (see the parameters), with
  /// what the prior says in it.
  geometry::Matrix6d covariance = geometry::Matrix6d::Zero();
  /// Along which the camera's place is known least: unit vector, rack frame, and its deviation, m.
  Eigen::Vector3d weakest_direction = Eigen::Vector3d::UnitY();
  double weakest_deviation = 0;
  int unobserved_directions = 0;  ///< of the six, without the prior

  OffsetBelief offsets;                    ///< after this image, jointly with the pose
  std::bitset<kMaxPipes> offset_observed;  ///< by this image alone
  std::bitset<kMaxPipes> offset_moved;     ///< contradicts its belief
  /// How far the pipe seems to be from where it was believed, m, and the deviation that this has
  /// when it is there; deviation 0: not compared.
  std::array<double, kMaxPipes> offset_innovation{};
  std::array<double, kMaxPipes> innovation_deviation{};
  /// What errors of the offsets make of a pose that edges like those of this image give:
  /// covariance, m and rad. It does not average out over images.
  geometry::Matrix6d covariance_by_offsets = geometry::Matrix6d::Zero();
  std::optional<IntrinsicsBelief> intrinsics{};
  std::optional<MapErrorSolution> map_error{};  ///< when it is estimated
  /// When they are estimated: how the pose that fits moves with them, form as above, m/px, rad/px.
  Eigen::Matrix<double, 6, 3> pose_by_intrinsics = Eigen::Matrix<double, 6, 3>::Zero();

  std::vector<EdgeSupport> edges;  ///< in the order of the samples
  std::size_t samples = 0;         ///< edge samples that could be used
  std::size_t points = 0;          ///< points that could be used
  std::size_t refused = 0;         ///< features with NaN, no sigma, or of no edge that there is
  double inlier_share = 0;         ///< of samples and points together; inlier: within 3 sigma
  double chi_square = 0;           ///< of the inliers
  double residual_scale = 0;  ///< median based, in stated standard deviations: the larger one of
                              ///< edges and points; 1 of fewer than 10
  int iterations = 0;
};

/// Keeps the model and working memory; a solution depends on the problem only. One thread at a time
/// per object. No allocation once the largest number of features has been seen.
class PoseSolver {
 public:
  /// Throws std::invalid_argument as PoseSolverParameters::validate. `model` must be valid.
  explicit PoseSolver(const RackModel& model, const PoseSolverParameters& parameters = {});
  ~PoseSolver();
  PoseSolver(PoseSolver&&) noexcept;
  PoseSolver& operator=(PoseSolver&&) noexcept;

  /// Makes room: problems with up to so many edges, samples and points allocate nothing.
  void reserve(std::size_t edges, std::size_t samples, std::size_t points);

  /// Never throws for what the problem is.
  void solve(const geometry::Camera& camera, const PoseProblem& problem, PoseSolution& solution);

  [[nodiscard]] const PoseSolverParameters& parameters() const noexcept;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

[[nodiscard]] std::string_view to_string(SolverMethod method) noexcept;
[[nodiscard]] std::string_view to_string(PoseStatus status) noexcept;

}  // namespace pipescout::rack_vision
