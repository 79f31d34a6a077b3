// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_vision/texture_map.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "lens_scale.hpp"
#include "pipescout/validation/check.hpp"
#include "texture_corner.hpp"

namespace pipescout::rack_vision {
namespace {

constexpr double kMargin = 13;            // px from the border of the image: room for the patch
constexpr double kSmallestWindow = 0.7;   // px, half
constexpr double kWithinAlignment = 1.6;  // px, half
constexpr double kLargestWindow = 48.0;   // px, half
// Best against second best place in a window: 1 - correlation must be this much smaller.
constexpr double kLargestRatio = 0.75;
constexpr std::uint32_t kProven = 3;          // times found
constexpr double kClearlyWorseAnchor = 1e-6;  // m^2

}  // namespace

void TextureMapParameters::validate() const {
  validation::check_within("capacity", capacity, 0, 20000);
  validation::check_within("points_per_frame", points_per_frame, 0, 200);
  validation::check_within("cells_per_frame", cells_per_frame, 0, 500);
  validation::check_within("cell_side", cell_side, 24, kLargestCell);
  validation::check_above("point_sigma", point_sigma, 0, 10);
  validation::check_above("least_contrast", least_contrast, 0, 255);
  validation::check_within("least_correlation", least_correlation, 0, 1);
  validation::check_within("least_facing", least_facing, 0, 1);
}

TextureMap::TextureMap(const RackModel& model, const geometry::Camera& camera,
                       const TextureMapParameters& parameters)
    : pipes_(model.pipes), camera_(camera), parameters_(parameters) {
  parameters.validate();
  columns_ = camera.parameters().width / parameters.cell_side;
  rows_ = camera.parameters().height / parameters.cell_side;
  const auto cells = static_cast<std::size_t>(columns_ * rows_);
  occupied_.resize(cells);
  points_.reserve(static_cast<std::size_t>(parameters.capacity));
  choices_.reserve(static_cast<std::size_t>(parameters.capacity));
}

Eigen::Vector3d TextureMap::around(const Point& point) const noexcept {
  return pipes_[point.pipe].direction.cross(point.normal).normalized();
}

bool TextureMap::anchored_by_y(const Point& point) const noexcept {
  return std::abs(pipes_[point.pipe].direction.y()) > 0.99;
}

std::optional<TextureMap::Projection> TextureMap::project(
    const Point& point, const UncertainView& view) const noexcept {
  geometry::Matrix23d derivative;
  const std::optional<Eigen::Vector2d> pixel =
      camera_.project(view.T_camera_rack * point.place, derivative);
  if (!pixel || !camera_.contains(*pixel, kMargin)) {
    return std::nullopt;
  }
  Projection projection;
  projection.pixel = *pixel;
  projection.by_place = derivative * view.T_camera_rack.rotation().matrix();
  projection.scale.col(0) = projection.by_place * pipes_[point.pipe].direction;
  projection.scale.col(1) = projection.by_place * around(point);
  projection.from_camera = point.place - view.T_camera_rack.inverse().translation();
  return projection;
}

Eigen::Matrix<double, 2, 6> TextureMap::by_motion(const Projection& projection) noexcept {
  // Motion [dc; dphi] of the camera moves the point by -dc + from_camera x dphi against it.
  Eigen::Matrix<double, 2, 6> result;
  result.leftCols<3>() = -projection.by_place;
  result.rightCols<3>() = projection.by_place * geometry::skew(projection.from_camera);
  return result;
}

UncertainView TextureMap::view_of_row(const UncertainView& view, double row) const {
  UncertainView result = view;
  if (row_motion_.is_rolling()) {
    result.T_camera_rack = row_motion_.pose_at(view.T_camera_rack.inverse(), row).inverse();
  }
  return result;
}

Eigen::Matrix2d TextureMap::row_variance(const Projection& projection, double row) const {
  const Eigen::Matrix<double, 2, 6> moves = by_motion(projection);
  return moves * row_motion_.covariance_at(row) * moves.transpose();
}

void TextureMap::correct_for_row(const Point& point, const UncertainView& view, double row,
                                 const Projection& projection, MatchedPoint& match) const {
  const auto ideal = [&](const geometry::SE3& T_camera_rack) -> Eigen::Vector2d {
    return (camera_.matrix() * (T_camera_rack * point.place)).hnormalized();
  };
  match.pixel -= ideal(view_of_row(view, row).T_camera_rack) - ideal(view.T_camera_rack);
  match.sigma =
      std::hypot(match.sigma, std::sqrt(row_variance(projection, row).diagonal().maxCoeff()));
}

void TextureMap::choose(const UncertainView& view, const RackSurface& surface,
                        std::vector<MatchedPoint>& matches) {
  ++image_;
  matches.clear();
  choices_.clear();
  std::ranges::fill(occupied_, std::uint8_t{0});
  const Eigen::Vector3d eye = view.T_camera_rack.inverse().translation();
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const Point& point = points_[i];
    const Eigen::Vector3d to_eye = eye - point.place;
    if (point.normal.dot(to_eye) < parameters_.least_facing * to_eye.norm()) {
      continue;
    }
    const std::optional<Eigen::Vector2d> pixel = camera_.project(view.T_camera_rack * point.place);
    if (!pixel || !camera_.contains(*pixel, kMargin)) {
      continue;
    }
    const int column = std::min(static_cast<int>(pixel->x()) / parameters_.cell_side, columns_ - 1);
    const int row = std::min(static_cast<int>(pixel->y()) / parameters_.cell_side, rows_ - 1);
    const int cell = row * columns_ + column;
    std::uint8_t& occupied = occupied_[static_cast<std::size_t>(cell)];
    occupied = static_cast<std::uint8_t>(std::min(occupied + 1, 255));
    const double trust = (point.found + 1.0) / (point.found + point.failed + 2.0);
    // A millimetre of anchor is worth ten per cent of trust.
    choices_.push_back({static_cast<std::uint32_t>(i), cell,
                        trust - 100.0 * std::sqrt(point.anchor_variance), *pixel});
  }
  // The best of each cell come first, then the second best ...
  std::ranges::sort(choices_, [](const Choice& a, const Choice& b) {
    return a.cell != b.cell ? a.cell < b.cell
                            : (a.score != b.score ? a.score > b.score : a.point < b.point);
  });
  int cell = -1;
  int rank = 0;
  for (Choice& choice : choices_) {
    rank = choice.cell == cell ? rank + 1 : 0;
    cell = choice.cell;
    // ... and within a rank in an order that jumps over the image, so that any first few are
    // spread.
    const auto jump = static_cast<std::uint32_t>(choice.cell) * 2654435761U;
    choice.score = rank * 4294967296.0 + static_cast<double>(jump);
  }
  std::ranges::sort(choices_, [](const Choice& a, const Choice& b) {
    return a.score != b.score ? a.score < b.score : a.point < b.point;
  });
  for (const Choice& choice : choices_) {
    if (matches.size() >= static_cast<std::size_t>(parameters_.points_per_frame)) {
      break;
    }
    const Point& point = points_[choice.point];
    const double offset = view.offsets.empty() ? 0.0 : view.offsets[point.pipe];
    // With its pipe, and just above the surface: a place refined to a hair's breadth below it is
    // not hidden.
    const Eigen::Vector3d place =
        point.place + (offset - point.offset) * Eigen::Vector3d::UnitX() + 0.001 * point.normal;
    if (surface.visible_at(place, point.normal, camera_, view.T_camera_rack, kMargin,
                           parameters_.least_facing)) {
      matches.push_back({.point = choice.point,
                         .proven = point.found >= kProven && point.found >= 2 * point.failed,
                         .predicted = choice.pixel});
    }
  }
}

void TextureMap::match(const ImageView& image, const UncertainView& view, std::size_t first,
                       std::size_t count, std::vector<MatchedPoint>& matches) {
  WarpedPatch warped;
  const std::size_t end = std::min(matches.size(), first + count);
  for (std::size_t i = first; i < end; ++i) {
    MatchedPoint& match = matches[i];
    const Point& point = points_[match.point];
    match.found = false;
    std::optional<Projection> projection = project(point, view);
    Eigen::Matrix2d by_row = Eigen::Matrix2d::Zero();
    if (projection && row_motion_.is_rolling()) {
      const double row = projection->pixel.y();
      by_row = row_variance(*projection, row);
      projection = project(point, view_of_row(view, row));
    }
    if (!projection) {
      continue;
    }
    match.predicted = projection->pixel;
    const Eigen::Matrix2d stored_from_current = point.stored_scale * projection->scale.inverse();
    const double level = point.patch.mean();
    const double noise = noise_.excess(level);
    if (!warp_patch(point.patch, stored_from_current,
                    noise_.texture_contrast(parameters_.least_contrast, level), warped)) {
      continue;
    }
    const PatchInNoise in_noise = patch_in_noise(warped, noise);
    const double least_correlation = parameters_.least_correlation * in_noise.correlation;
    const Eigen::Matrix<double, 2, 6> moves = by_motion(*projection);
    const double anchor = std::abs(point.anchor_variance - view.anchor_variance);
    // Three sigma of what is a point's own; what it shares with the others is in the view by now.
    const Eigen::Vector2d place_variance(9.0 * point.own_variance + point.along_variance +
                                             (anchored_by_y(point) ? 9.0 * anchor : 0.0),
                                         9.0 * point.own_variance + point.around_variance);
    const Eigen::Matrix2d place_error =
        projection->scale * place_variance.asDiagonal() * projection->scale.transpose();
    const Eigen::Vector2d variance =
        (9.0 * moves * view.covariance * moves.transpose() + place_error).diagonal() +
        9.0 * by_row.diagonal();
    const Eigen::Vector2d half_size =
        variance.cwiseMax(0).cwiseSqrt().cwiseMin(kLargestWindow).array() + kSmallestWindow;
    Eigen::Vector2d near = projection->pixel;
    // The alignment itself finds what is within a pixel and a half.
    if (half_size.maxCoeff() > kWithinAlignment) {
      const PatchMatch coarse = search_patch(image, warped, {projection->pixel, half_size});
      if (!coarse.found || coarse.correlation < least_correlation - 0.1 ||
          1 - coarse.correlation > kLargestRatio * (1 - coarse.second)) {
        continue;
      }
      near = coarse.pixel;
    }
    const PatchAlignment fine = align_patch(image, warped, near);
    if (!fine.converged || fine.correlation < least_correlation) {
      continue;
    }
    const std::optional<Eigen::Vector2d> ideal = camera_.undistort(fine.pixel);
    if (!ideal) {
      continue;
    }
    match.found = true;
    match.pixel = *ideal;
    match.correlation = fine.correlation;
    match.sigma =
        std::hypot(parameters_.point_sigma,
                   in_noise.widening * std::sqrt(0.5 * std::max(0.0, fine.covariance.trace())));
    if (row_motion_.is_rolling()) {
      correct_for_row(point, view, fine.pixel.y(), *projection, match);
    }
  }
}

std::optional<double> TextureMap::observations(const std::vector<MatchedPoint>& matches,
                                               std::vector<PointObservation>& points) const {
  points.clear();
  double best = std::numeric_limits<double>::infinity();
  double found = 0;
  for (const MatchedPoint& match : matches) {
    if (match.found) {
      ++found;
      if (anchored_by_y(points_[match.point])) {
        best = std::min(best, points_[match.point].anchor_variance);
      }
    }
  }
  if (found == 0) {
    return std::nullopt;
  }
  double worse = 0;
  for (const MatchedPoint& match : matches) {
    const Point& point = points_[match.point];
    worse +=
        match.found && anchored_by_y(point) && point.anchor_variance > best + kClearlyWorseAnchor
            ? 1
            : 0;
  }
  for (const MatchedPoint& match : matches) {
    if (!match.found) {
      continue;
    }
    const Point& point = points_[match.point];
    const Eigen::Vector3d& along = pipes_[point.pipe].direction;
    // An error that n points share must not average out over them: each gets n times its variance.
    const double shared_along =
        found * point.along_variance +
        (anchored_by_y(point) ? worse * std::max(0.0, point.anchor_variance - best) : 0.0);
    const Eigen::Vector3d side = around(point);
    PointObservation& observation = points.emplace_back();
    observation.pipe = PointObservation::kOnNoPipe;
    observation.place = point.place;
    observation.pixel = match.pixel;
    observation.sigma = match.sigma * ideal_per_pixel(camera_, match.pixel);
    observation.place_by_map_error = by_map_error(point);
    observation.place_covariance =
        (point.own_variance + shared_along) * along * along.transpose() +
        (point.own_variance + found * point.around_variance) * side * side.transpose();
  }
  return std::isfinite(best) ? std::optional(best) : std::nullopt;
}

}  // namespace pipescout::rack_vision
