// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "pipescout/rack_vision/contour.hpp"
#include "pipescout/rack_vision/pose_solver.hpp"

/// The normal equations of a pose problem. Internal to PoseSolver.
namespace pipescout::rack_vision {

inline constexpr int kPoseUnknowns = 6;
inline constexpr int kIntrinsicUnknowns = 3;
inline constexpr int kMapErrorUnknowns = 6;
inline constexpr int kMaxUnknowns = kPoseUnknowns + static_cast<int>(kMaxPipes) +
                                    kShapeUnknowns * static_cast<int>(kMaxShapedPipes) +
                                    kIntrinsicUnknowns + kMapErrorUnknowns;

using SystemMatrix =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxUnknowns, kMaxUnknowns>;
using SystemVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxUnknowns, 1>;

/// What is solved for.
struct SolverState {
  geometry::SE3 T_camera_rack;
  std::array<double, kMaxPipes> offsets{};
  std::array<ShapeVector, kMaxShapedPipes> shapes{};     ///< in the order of the problem
  Eigen::Vector3d intrinsics = Eigen::Vector3d::Zero();  ///< f_c, u_0, v_0
  geometry::Vector6d map_error = geometry::Vector6d::Zero();
};

/// Where the unknowns stand: pose [dc; dphi], then offsets, then shapes, then intrinsics, then the
/// map's error.
struct UnknownLayout {
  std::array<int, kMaxPipes> offset{};  ///< index of a pipe's offset; -1: it is fixed
  int offset_count = 0;
  std::array<int, kMaxPipes> shape{};  ///< number of a pipe's shape; -1: it has none
  int first_shape = 0;                 ///< index of the first
  int shape_count = 0;                 ///< unknowns
  int intrinsics = -1;                 ///< index of the first; -1: they are fixed
  int map_error = -1;                  ///< index of the first; -1: it is none
  int size = kPoseUnknowns;
};

/// Sums over the residuals e (in sigmas) of one kind of feature.
struct ResidualSums {
  double count = 0;          ///< within the gate
  double weight = 0;         ///< w
  double slope = 0;          ///< psi'
  double square = 0;         ///< psi^2
  double inliers = 0;        ///< features within the inlier bound
  double inlier_square = 0;  ///< e^2 of those

  ResidualSums& operator+=(const ResidualSums& other) noexcept;
};

struct NormalEquations {
  SystemMatrix edge_information, point_information;
  double edge_weight = 1;  ///< as in Weighting; it is in the information, not in the sums
  SystemVector gradient;
  double cost = 0;
  ResidualSums edges, points;

  void reset(int size);
};

struct Weighting {
  statistics::RobustKernel kernel = statistics::RobustKernel::kNone;
  double edge_width = 1;
  double point_width = 1;
  double inlier_bound = 3;
  double edge_weight = 1;  ///< of the information of edges, against what their sigmas say
  /// As the paper has it: a point gives one row along its displacement (Figure 3), not two.
  bool points_along_displacement = false;
};

/// The features of one image, checked and grouped. Allocates only to grow.
class FeatureSystem {
 public:
  explicit FeatureSystem(const RackModel& model);
  void reserve(std::size_t edges, std::size_t samples, std::size_t points);

  /// Takes over what can be used of the problem's features; the spans must stay valid.
  void prepare(const geometry::Camera& camera, const PoseProblem& problem,
               const PoseSolverParameters& parameters);
  [[nodiscard]] std::size_t refused() const noexcept { return refused_; }
  [[nodiscard]] std::size_t sample_count() const noexcept { return sample_count_; }
  [[nodiscard]] std::size_t point_count() const noexcept { return points_.size(); }

  /// Equations (27), (28) at the state, data only.
  void accumulate(const SolverState& state, const UnknownLayout& layout, const Weighting& weighting,
                  NormalEquations& equations);

  /// Sizes of the residuals of the last `accumulate`, in sigmas: all within the gate.
  [[nodiscard]] std::vector<double>& edge_residuals() noexcept { return edge_residuals_; }
  [[nodiscard]] std::vector<double>& point_residuals() noexcept { return point_residuals_; }
  /// Of the last `accumulate`.
  [[nodiscard]] std::span<const EdgeSupport> support() const noexcept { return support_; }

 private:
  struct Run {
    EdgeId edge;
    std::size_t first = 0;
    std::size_t count = 0;
    double bias_square_sum = 0;
  };
  struct LineSums;
  /// A pipe with its shape, and with a little more and less of each part of it.
  struct ShapedSections {
    std::vector<PipeSection> here;
    std::array<std::vector<PipeSection>, kShapeUnknowns> more, less;
  };
  using LineByShape = Eigen::Matrix<double, 3, kShapeUnknowns>;

  void shape_sections(const SolverState& state, const UnknownLayout& layout);
  [[nodiscard]] LineByShape line_by_shape(const EdgeId& edge, const ShapedSections& sections,
                                          const CameraView& view) const;
  [[nodiscard]] bool exists(const EdgeId& edge) const noexcept;
  [[nodiscard]] bool contour(const EdgeId& edge, const SolverState& state,
                             const UnknownLayout& layout, const Eigen::Vector3d& eye,
                             ContourLine& line) const noexcept;
  [[nodiscard]] Eigen::Matrix3d camera_matrix(const SolverState& state,
                                              const UnknownLayout& layout) const noexcept;
  void add_samples(const Run& run, const ImageLine& line, const Weighting& weighting,
                   NormalEquations& equations, LineSums& sums, std::size_t& inliers);
  void add_line(const Run& run, const ImageLine& line, const CameraView& view,
                const UnknownLayout& layout, LineSums sums, NormalEquations& equations) const;
  void add_point(const PointObservation& point, const SolverState& state, const CameraView& view,
                 const UnknownLayout& layout, const Weighting& weighting,
                 NormalEquations& equations);

  std::vector<Pipe> pipes_;
  std::vector<std::vector<PipeSection>> sections_;  ///< per pipe, where the model has it
  std::array<ShapedSections, kMaxShapedPipes> shaped_;
  std::vector<Support> supports_;
  geometry::CameraParameters camera_;
  double gate_ = 0;
  double edge_bias_sigma_ = 0;
  std::vector<EdgeSample> samples_;
  std::vector<Run> runs_;
  std::vector<PointObservation> points_;
  std::vector<double> edge_residuals_, point_residuals_;
  std::vector<EdgeSupport> support_;
  std::size_t refused_ = 0;
  std::size_t sample_count_ = 0;
};

}  // namespace pipescout::rack_vision
