// SPDX-License-Identifier: Apache-2.0
#include "feature_system.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "feature_rows.hpp"

namespace pipescout::rack_vision {
namespace {

/// Points nearer to the focal plane than this are not used, m.
constexpr double kSmallestDepth = 1e-6;
constexpr int kEdgesOfSupport = 12;
constexpr double kShapeStep = 1e-5;  // m and rad: of the central differences of shapes

bool usable(double sigma) {
  return std::isfinite(sigma) && sigma > 0;
}

bool usable(const EdgeSample& sample) {
  if (!usable(sample.sigma) || !std::isfinite(sample.bias_sigma) || sample.bias_sigma < 0 ||
      sample.candidate_count < 1 || sample.candidate_count > EdgeSample::kMaxCandidates) {
    return false;
  }
  return std::all_of(sample.candidates.begin(), sample.candidates.begin() + sample.candidate_count,
                     [](const Eigen::Vector2d& pixel) { return pixel.allFinite(); });
}

bool usable(const PointObservation& point, std::size_t pipes) {
  return usable(point.sigma) && point.place.allFinite() && point.pixel.allFinite() &&
         point.place_covariance.allFinite() && point.place_covariance.diagonal().minCoeff() >= 0 &&
         (point.pipe < pipes || point.pipe == PointObservation::kOnNoPipe);
}

void add_sums(ResidualSums& sums, const statistics::KernelValue& value, double e, bool inlier) {
  sums.count += 1;
  sums.weight += value.weight;
  sums.slope += value.slope;
  sums.square += value.weight * value.weight * e * e;
  if (inlier) {
    sums.inliers += 1;
    sums.inlier_square += e * e;
  }
}

}  // namespace

/// Sums over the samples of one line, from which every row of its part of the system follows.
struct FeatureSystem::LineSums {
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();  ///< sum(s m m^T)
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();     ///< sum(s e m)
};

ResidualSums& ResidualSums::operator+=(const ResidualSums& other) noexcept {
  count += other.count;
  weight += other.weight;
  slope += other.slope;
  square += other.square;
  inliers += other.inliers;
  inlier_square += other.inlier_square;
  return *this;
}

void NormalEquations::reset(int size) {
  edge_information.setZero(size, size);
  point_information.setZero(size, size);
  gradient.setZero(size);
  cost = 0;
  edges = {};
  points = {};
}

FeatureSystem::FeatureSystem(const RackModel& model)
    : pipes_(model.pipes), supports_(model.supports) {
  for (const Pipe& pipe : model.pipes) {
    append_sections(pipe, 0, sections_.emplace_back());
  }
}

void FeatureSystem::reserve(std::size_t edges, std::size_t samples, std::size_t points) {
  runs_.reserve(edges);
  support_.reserve(edges);
  samples_.reserve(samples);
  edge_residuals_.reserve(samples);
  points_.reserve(points);
  point_residuals_.reserve(points);
}

bool FeatureSystem::exists(const EdgeId& edge) const noexcept {
  if (edge.kind == EdgeKind::kSupport) {
    return edge.body < supports_.size() && edge.part < kEdgesOfSupport;
  }
  return edge.kind == EdgeKind::kPipe && edge.body < sections_.size() &&
         edge.part < sections_[edge.body].size() && edge.side < 2;
}

void FeatureSystem::prepare(const geometry::Camera& camera, const PoseProblem& problem,
                            const PoseSolverParameters& parameters) {
  camera_ = camera.parameters();
  gate_ = parameters.gate;
  edge_bias_sigma_ = parameters.edge_bias_sigma;
  refused_ = 0;
  samples_.clear();
  runs_.clear();
  points_.clear();
  for (const EdgeSample& sample : problem.edges) {
    if (!usable(sample) || !exists(sample.edge)) {
      ++refused_;
      continue;
    }
    if (runs_.empty() || !(runs_.back().edge == sample.edge)) {
      runs_.push_back({.edge = sample.edge, .first = samples_.size()});
    }
    ++runs_.back().count;
    runs_.back().bias_square_sum += sample.bias_sigma * sample.bias_sigma;
    samples_.push_back(sample);
  }
  for (const PointObservation& point : problem.points) {
    if (usable(point, sections_.size())) {
      points_.push_back(point);
    } else {
      ++refused_;
    }
  }
  sample_count_ = samples_.size();
  edge_residuals_.reserve(samples_.size());
  point_residuals_.reserve(points_.size());
  support_.reserve(runs_.size());
}

void FeatureSystem::shape_sections(const SolverState& state, const UnknownLayout& layout) {
  for (std::size_t i = 0; i < pipes_.size() && layout.shape_count > 0; ++i) {
    if (layout.shape[i] < 0) {
      continue;
    }
    const auto slot = static_cast<std::size_t>(layout.shape[i]);
    const auto fill = [&](const ShapeVector& shape, std::vector<PipeSection>& sections) {
      sections.clear();
      append_sections(shaped(pipes_[i], to_shape(shape)), 0, sections);
    };
    fill(state.shapes[slot], shaped_[slot].here);
    for (int k = 0; k < kShapeUnknowns; ++k) {
      const ShapeVector step = kShapeStep * ShapeVector::Unit(k);
      fill(state.shapes[slot] + step, shaped_[slot].more[static_cast<std::size_t>(k)]);
      fill(state.shapes[slot] - step, shaped_[slot].less[static_cast<std::size_t>(k)]);
    }
  }
}

FeatureSystem::LineByShape FeatureSystem::line_by_shape(const EdgeId& edge,
                                                        const ShapedSections& sections,
                                                        const CameraView& view) const {
  LineByShape derivative = LineByShape::Zero();
  for (std::size_t k = 0; k < kShapeUnknowns; ++k) {
    const auto line_of = [&](const std::vector<PipeSection>& of, ImageLine& line) {
      ContourLine both[2];
      return contour_lines(of[edge.part], view.centre, both) &&
             image_line(view, both[edge.side], line);
    };
    ImageLine more, less;
    if (line_of(sections.more[k], more) && line_of(sections.less[k], less)) {
      derivative.col(static_cast<Eigen::Index>(k)) = (more.line - less.line) / (2 * kShapeStep);
    }
  }
  return derivative;
}

bool FeatureSystem::contour(const EdgeId& edge, const SolverState& state,
                            const UnknownLayout& layout, const Eigen::Vector3d& eye,
                            ContourLine& line) const noexcept {
  if (edge.kind == EdgeKind::kSupport) {
    return support_line(support_edge(supports_[edge.body], edge.part), eye, line);
  }
  const int shape = layout.shape[edge.body];
  PipeSection section = shape < 0 ? sections_[edge.body][edge.part]
                                  : shaped_[static_cast<std::size_t>(shape)].here[edge.part];
  section.start.x() += state.offsets[edge.body];
  ContourLine both[2];
  if (!contour_lines(section, eye, both)) {
    return false;
  }
  line = both[edge.side];
  return true;
}

Eigen::Matrix3d FeatureSystem::camera_matrix(const SolverState& state,
                                             const UnknownLayout& layout) const noexcept {
  const bool estimated = layout.intrinsics >= 0;
  const double focal_length = estimated ? state.intrinsics[0] : camera_.focal_length;
  Eigen::Matrix3d k = Eigen::Matrix3d::Identity();
  k(0, 0) = focal_length;
  k(0, 1) = camera_.skew;
  k(1, 1) = camera_.aspect_ratio * focal_length;
  k(0, 2) = estimated ? state.intrinsics[1] : camera_.centre_u;
  k(1, 2) = estimated ? state.intrinsics[2] : camera_.centre_v;
  return k;
}

void FeatureSystem::add_samples(const Run& run, const ImageLine& line, const Weighting& weighting,
                                NormalEquations& equations, LineSums& sums, std::size_t& inliers) {
  const double a = line.line[0], b = line.line[1], c = line.line[2];
  // Kept in registers; in matrices the compiler has to store them with each sample.
  double uu = 0, uv = 0, vv = 0, u = 0, v = 0, one = 0, eu = 0, ev = 0, e1 = 0;
  double cost = 0;
  ResidualSums counted;
  for (std::size_t i = run.first; i < run.first + run.count; ++i) {
    const EdgeSample& sample = samples_[i];
    const Eigen::Vector2d* nearest = sample.candidates.data();
    double residual = a * nearest->x() + b * nearest->y() + c;
    for (std::size_t k = 1; k < sample.candidate_count; ++k) {
      const Eigen::Vector2d& candidate = sample.candidates[k];
      const double other = a * candidate.x() + b * candidate.y() + c;
      if (std::abs(other) < std::abs(residual)) {
        residual = other;
        nearest = &candidate;
      }
    }
    const double inverse_sigma = 1 / sample.sigma;
    const double e = std::min(std::abs(residual), gate_) * inverse_sigma;
    const statistics::KernelValue value = evaluate(weighting.kernel, e, weighting.edge_width);
    cost += value.cost;
    if (std::abs(residual) > gate_) {
      continue;
    }
    add_sums(counted, value, e, e <= weighting.inlier_bound);
    edge_residuals_.push_back(e);
    const double s = value.weight * inverse_sigma * inverse_sigma;
    const double su = s * nearest->x(), sv = s * nearest->y();
    uu += su * nearest->x();
    uv += su * nearest->y();
    vv += sv * nearest->y();
    u += su;
    v += sv;
    one += s;
    eu += su * residual;
    ev += sv * residual;
    e1 += s * residual;
  }
  sums.information << uu, uv, u, uv, vv, v, u, v, one;
  sums.gradient << eu, ev, e1;
  inliers = static_cast<std::size_t>(counted.inliers);
  equations.cost += cost;
  equations.edges += counted;
}

void FeatureSystem::add_line(const Run& run, const ImageLine& line, const CameraView& view,
                             const UnknownLayout& layout, LineSums sums,
                             NormalEquations& equations) const {
  const double bias_variance =
      edge_bias_sigma_ * edge_bias_sigma_ + run.bias_square_sum / static_cast<double>(run.count);
  if (bias_variance > 0) {
    // A shared error b of the samples, eliminated: it is an unknown that this line alone has.
    const Eigen::Vector3d weighted = sums.information.col(2);  // sum(s m), as m ends with 1
    // Most edges are where they should be, a few are shadows or stripes beside them: the tails of
    // Cauchy's distribution.
    const double mean = weighted[2] > 0 ? sums.gradient[2] / weighted[2] : 0;
    const double total = weighted[2] + 1 / (bias_variance + mean * mean);
    sums.information -= weighted * weighted.transpose() / total;
    sums.gradient -= weighted * (sums.gradient[2] / total);
  }
  const auto add = [&](auto derivative) {
    derivative.template leftCols<6>() = line.derivative;
    derivative.col(kOffsetColumn) = -line.derivative.col(0);
    if constexpr (decltype(derivative)::ColsAtCompileTime == kWithIntrinsics) {
      // d(K^-T) = -K^-T dK^T K^-T, and the line keeps its norm.
      const Eigen::Vector3d by_focal_length =
          view.matrix.transpose().template triangularView<Eigen::Lower>().solve(
              Eigen::Vector3d(-line.line[0], -camera_.aspect_ratio * line.line[1], 0));
      derivative.col(7) =
          by_focal_length - line.line * line.line.head<2>().dot(by_focal_length.head<2>());
      derivative.col(8) << 0, 0, -line.line[0];
      derivative.col(9) << 0, 0, -line.line[1];
    }
    const int offset = run.edge.kind == EdgeKind::kPipe ? layout.offset[run.edge.body] : -1;
    scatter<3>(derivative, sums.information, sums.gradient, offset, layout,
               equations.edge_information, equations.gradient);
    const int shape = run.edge.kind == EdgeKind::kPipe ? layout.shape[run.edge.body] : -1;
    if (shape >= 0) {
      const LineByShape by_shape =
          line_by_shape(run.edge, shaped_[static_cast<std::size_t>(shape)], view);
      const int k = layout.first_shape + kShapeUnknowns * shape;
      const LineByShape weighted = sums.information * by_shape;
      SystemMatrix& system = equations.edge_information;
      system.block<kShapeUnknowns, kShapeUnknowns>(k, k) += by_shape.transpose() * weighted;
      equations.gradient.segment<kShapeUnknowns>(k) += by_shape.transpose() * sums.gradient;
      const auto couple = [&](int unknown, const auto& columns) {
        const auto block = (columns.transpose() * weighted).eval();
        system.block<decltype(block)::RowsAtCompileTime, kShapeUnknowns>(unknown, k) += block;
        system.block<kShapeUnknowns, decltype(block)::RowsAtCompileTime>(k, unknown) +=
            block.transpose();
      };
      couple(0, derivative.template leftCols<6>());
      if constexpr (decltype(derivative)::ColsAtCompileTime == kWithIntrinsics) {
        couple(layout.intrinsics, derivative.template rightCols<3>());
      }
    }
  };
  if (layout.intrinsics >= 0) {
    add(Rows<3, kWithIntrinsics>());
  } else {
    add(Rows<3, kWithoutIntrinsics>());
  }
}

void FeatureSystem::add_point(const PointObservation& point, const SolverState& state,
                              const CameraView& view, const UnknownLayout& layout,
                              const Weighting& weighting, NormalEquations& equations) {
  const bool on_pipe = point.pipe != PointObservation::kOnNoPipe;
  Eigen::Vector3d from_eye = point.place - view.centre;
  from_eye.x() += on_pipe ? state.offsets[point.pipe] : 0;
  if (layout.map_error >= 0) {
    from_eye += point.place_by_map_error * state.map_error;
  }
  const Eigen::Vector3d in_camera = view.R_camera_rack * from_eye;
  if (!(in_camera.z() > kSmallestDepth)) {
    return;
  }
  const Eigen::Vector2d ray = in_camera.head<2>() / in_camera.z();
  const Eigen::Matrix2d focal = view.matrix.topLeftCorner<2, 2>();
  const Eigen::Vector2d residual = focal * ray + view.matrix.topRightCorner<2, 1>() - point.pixel;
  Eigen::Matrix<double, 2, 3> by_ray;
  by_ray << 1, 0, -ray.x(), 0, 1, -ray.y();
  const Eigen::Matrix<double, 2, 3> by_place = focal * by_ray * view.R_camera_rack / in_camera.z();

  Eigen::Matrix2d covariance = by_place * point.place_covariance * by_place.transpose();
  covariance.diagonal().array() += point.sigma * point.sigma;
  Eigen::Matrix2d information = covariance.inverse();
  const double e = std::sqrt(residual.dot(information * residual));
  if (!std::isfinite(e)) {
    return;  // its covariance is none
  }
  const double pixels = residual.norm();
  const bool beyond = !(pixels <= gate_);
  const statistics::KernelValue value =
      evaluate(weighting.kernel, beyond ? gate_ / point.sigma : e, weighting.point_width);
  equations.cost += value.cost;
  if (beyond) {
    return;
  }
  statistics::KernelValue per_row = value;
  per_row.slope = 0.5 * (value.slope + value.weight);
  add_sums(equations.points, per_row, e * std::sqrt(0.5), e <= weighting.inlier_bound);
  point_residuals_.push_back(e);
  if (weighting.points_along_displacement && pixels > 0) {
    const Eigen::Vector2d along = residual / pixels;
    information = along * along.transpose() / along.dot(covariance * along);
  }
  information *= value.weight;
  const auto add = [&](auto derivative) {
    derivative.template leftCols<3>() = -by_place;
    derivative.template middleCols<3>(3) = by_place * geometry::skew(from_eye);
    derivative.col(kOffsetColumn) = by_place.col(0);
    if constexpr (decltype(derivative)::ColsAtCompileTime == kWithIntrinsics) {
      derivative.col(7) << ray.x(), camera_.aspect_ratio * ray.y();
      derivative.template rightCols<2>().setIdentity();
    }
    scatter<2>(derivative, information, Eigen::Vector2d(information * residual),
               on_pipe ? layout.offset[point.pipe] : -1, layout, equations.point_information,
               equations.gradient);
    if (layout.map_error >= 0) {
      const Eigen::Matrix<double, 2, 6> by_map_error = by_place * point.place_by_map_error;
      const Eigen::Matrix<double, 2, 6> weighted = information * by_map_error;
      const int k = layout.map_error;
      SystemMatrix& system = equations.point_information;
      system.block<6, 6>(k, k) += by_map_error.transpose() * weighted;
      equations.gradient.segment<6>(k) += weighted.transpose() * residual;
      // Below the diagonal the sum is the transpose: `accumulate` sets it once.
      const auto couple = [&](int unknown, const auto& columns) {
        const auto block = columns.transpose().lazyProduct(weighted).eval();
        system.block<decltype(block)::RowsAtCompileTime, 6>(unknown, k) += block;
      };
      couple(0, derivative.template leftCols<6>());
      if (on_pipe && layout.offset[point.pipe] >= 0) {
        couple(layout.offset[point.pipe], derivative.template middleCols<1>(kOffsetColumn));
      }
      if constexpr (decltype(derivative)::ColsAtCompileTime == kWithIntrinsics) {
        couple(layout.intrinsics, derivative.template rightCols<3>());
      }
    }
  };
  if (layout.intrinsics >= 0) {
    add(Rows<2, kWithIntrinsics>());
  } else {
    add(Rows<2, kWithoutIntrinsics>());
  }
}

void FeatureSystem::accumulate(const SolverState& state, const UnknownLayout& layout,
                               const Weighting& weighting, NormalEquations& equations) {
  equations.reset(layout.size);
  edge_residuals_.clear();
  point_residuals_.clear();
  support_.clear();
  const CameraView view(camera_matrix(state, layout), state.T_camera_rack);
  shape_sections(state, layout);
  for (const Run& run : runs_) {
    ContourLine edge;
    ImageLine line;
    LineSums sums;
    std::size_t inliers = 0;
    if (contour(run.edge, state, layout, view.centre, edge) && image_line(view, edge, line)) {
      add_samples(run, line, weighting, equations, sums, inliers);
      add_line(run, line, view, layout, sums, equations);
    }
    support_.push_back(
        {run.edge, static_cast<std::uint16_t>(run.count), static_cast<std::uint16_t>(inliers)});
  }
  equations.edge_weight = weighting.edge_weight;
  equations.edge_information *= weighting.edge_weight;
  equations.gradient *= weighting.edge_weight;
  equations.cost *= weighting.edge_weight;
  for (const PointObservation& point : points_) {
    add_point(point, state, view, layout, weighting, equations);
  }
  if (const int k = layout.map_error; k >= 0) {
    SystemMatrix& system = equations.point_information;
    system.block(k, 0, kMapErrorUnknowns, k) = system.block(0, k, k, kMapErrorUnknowns).transpose();
  }
}

}  // namespace pipescout::rack_vision
