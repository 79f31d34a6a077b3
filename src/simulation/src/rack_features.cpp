// SPDX-License-Identifier: Apache-2.0
#include "pipescout/simulation/rack_features.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "pipescout/statistics/draw.hpp"
#include "pipescout/validation/check.hpp"

namespace pipescout::simulation {
namespace {

using statistics::normal;
using statistics::uniform;
using validation::check_above;
using validation::check_within;

constexpr std::uint64_t kTexturePurpose = 21;
constexpr std::uint64_t kNoisePurpose = 22;

TexturePoint draw_point(const rack_vision::RackModel& model, std::size_t index,
                        double largest_angle, std::mt19937_64& engine) {
  const rack_vision::Pipe& pipe = model.pipes[index];
  const Eigen::Vector3d hint =
      std::abs(pipe.direction.z()) < 0.9 ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d::UnitX();
  const Eigen::Vector3d up = (hint - hint.dot(pipe.direction) * pipe.direction).normalized();
  const double along = uniform(engine, 0, pipe.length());
  const double angle = uniform(engine, -largest_angle, largest_angle);
  std::vector<rack_vision::PipeSection> sections;
  rack_vision::append_sections(pipe, 0, sections);
  double begin = 0;
  std::size_t i = 0;
  while (i + 1 < sections.size() && along > begin + sections[i].length) {
    begin += sections[i].length;
    ++i;
  }
  const rack_vision::PipeSection& section = sections[i];
  const double slope = (section.radius_end - section.radius_start) / section.length;
  const double radius = section.radius_start + slope * (along - begin);
  const Eigen::Vector3d radial = std::cos(angle) * up + std::sin(angle) * pipe.direction.cross(up);
  return {.pipe = static_cast<std::uint16_t>(index),
          .place = pipe.start + along * pipe.direction + radius * radial,
          .normal = (radial - slope * pipe.direction).normalized()};
}

}  // namespace

std::vector<TexturePoint> random_texture_points(const rack_vision::RackModel& model,
                                                std::size_t count, std::uint64_t seed,
                                                double largest_angle) {
  check_above("random_texture_points: largest_angle", largest_angle, 0, std::numbers::pi);
  if (model.pipes.empty()) {
    throw std::invalid_argument("random_texture_points: model.pipes: 0 pipes; there must be one");
  }
  std::mt19937_64 engine = statistics::make_engine(seed, kTexturePurpose);
  const std::size_t pipes = model.pipes.size();
  std::vector<TexturePoint> points;
  points.reserve(count);
  for (std::size_t pipe = 0; pipe < pipes; ++pipe) {
    const std::size_t of_this_pipe = count / pipes + (pipe < count % pipes ? 1 : 0);
    for (std::size_t i = 0; i < of_this_pipe; ++i) {
      points.push_back(draw_point(model, pipe, largest_angle, engine));
    }
  }
  return points;
}

void RackFeatureParameters::validate() const {
  check_within("RackFeatureParameters.samples_per_edge", samples_per_edge, 0, 1000);
  check_within("RackFeatureParameters.noise", noise, 0, 100);
  check_within("RackFeatureParameters.outlier_share", outlier_share, 0, 1);
  check_within("RackFeatureParameters.outlier_reach", outlier_reach, 0, 1e4);
  check_within("RackFeatureParameters.dropout_share", dropout_share, 0, 1);
  check_within("RackFeatureParameters.least_deviation", least_deviation, 1e-6, 100);
}

RackFeatureCamera::RackFeatureCamera(const RackFeatureParameters& parameters,
                                     const geometry::Camera& camera, std::uint64_t seed)
    : parameters_((parameters.validate(), parameters)),
      camera_(camera),
      engine_(statistics::make_engine(seed, kNoisePurpose)) {
  // The error of rounding is uniform over a pixel.
  const double rounding = parameters.quantised ? 1.0 / 12 : 0;
  sigma_ = std::max(parameters.least_deviation,
                    std::sqrt(parameters.noise * parameters.noise + rounding));
}

bool RackFeatureCamera::measure(const Eigen::Vector2d& seen, Eigen::Vector2d& found,
                                bool& outlier) {
  // The same number of draws whatever happens: two cameras of one seed that differ in one parameter
  // only see the same noise.
  const bool dropped = uniform(engine_) < parameters_.dropout_share;
  outlier = uniform(engine_) < parameters_.outlier_share;
  const Eigen::Vector2d place(uniform(engine_), uniform(engine_));
  const double noise_u = normal(engine_);
  const double noise_v = normal(engine_);
  const std::optional<Eigen::Vector2d> distorted = camera_.distort(seen);
  if (dropped || !distorted) {
    return false;
  }
  Eigen::Vector2d pixel = *distorted + parameters_.noise * Eigen::Vector2d(noise_u, noise_v);
  if (outlier && parameters_.outlier_reach > 0) {
    pixel = *distorted + parameters_.outlier_reach * (2 * place - Eigen::Vector2d::Ones());
  } else if (outlier) {
    const geometry::CameraParameters& c = camera_.parameters();
    pixel = place.cwiseProduct(Eigen::Vector2d(c.width, c.height)) - Eigen::Vector2d::Constant(0.5);
  }
  if (parameters_.quantised) {
    pixel = pixel.array().round();
  }
  const std::optional<Eigen::Vector2d> ideal = camera_.undistort(pixel);
  found = ideal.value_or(seen);
  return ideal.has_value();
}

void RackFeatureCamera::look(const rack_vision::RackModel& model, rack_vision::PipeOffsets offsets,
                             const geometry::SE3& T_camera_rack,
                             std::span<const TexturePoint> texture, RackFeatures& features) {
  renderer_.render(model, offsets, camera_, T_camera_rack, visible_);
  surface_.update(model, offsets);
  features.edges.clear();
  features.edge_is_outlier.clear();
  features.points.clear();
  features.point_ids.clear();
  features.point_is_outlier.clear();
  Eigen::Vector2d found = Eigen::Vector2d::Zero();
  bool outlier = false;
  for (const rack_vision::VisibleEdge& edge : visible_) {
    for (int j = 1; j <= parameters_.samples_per_edge; ++j) {
      const double share = static_cast<double>(j) / (parameters_.samples_per_edge + 1);
      const Eigen::Vector2d seen = edge.image_start + share * (edge.image_end - edge.image_start);
      if (measure(seen, found, outlier)) {
        features.edges.push_back({.edge = edge.id,
                                  .candidate_count = 1,
                                  .candidates = {found, found, found},
                                  .sigma = sigma_});
        features.edge_is_outlier.push_back(outlier);
      }
    }
  }
  for (std::size_t i = 0; i < texture.size(); ++i) {
    const TexturePoint& point = texture[i];
    if (point.pipe >= model.pipes.size()) {
      validation::refuse("RackFeatureCamera::look: texture[", i, "].pipe: ", point.pipe,
                         " is outside [0, ", model.pipes.size() - 1, "]");
    }
    const double offset = offsets.empty() ? 0 : offsets[point.pipe];
    const Eigen::Vector3d place = point.place + offset * Eigen::Vector3d::UnitX();
    const std::optional<Eigen::Vector2d> pixel =
        surface_.visible_at(place, point.normal, camera_, T_camera_rack);
    // The pixel of the distorted image lies in it, so it can be undistorted.
    const std::optional<Eigen::Vector2d> seen = pixel ? camera_.undistort(*pixel) : std::nullopt;
    if (seen && measure(*seen, found, outlier)) {
      features.points.push_back(
          {.pipe = point.pipe, .place = point.place, .pixel = found, .sigma = sigma_});
      features.point_ids.push_back(i);
      features.point_is_outlier.push_back(outlier);
    }
  }
}

}  // namespace pipescout::simulation
