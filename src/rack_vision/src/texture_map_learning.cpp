// SPDX-License-Identifier: Apache-2.0
// What changes the texture map: learning from matches, new points, and forgetting.
#include <algorithm>
#include <cmath>

#include "pipescout/rack_vision/texture_map.hpp"
#include "ray_motion.hpp"
#include "texture_corner.hpp"

namespace pipescout::rack_vision {
namespace {

constexpr std::uint32_t kTrials = 6;  // before a point is judged by its share of failures
constexpr double kMostFailures = 0.6;
constexpr std::uint32_t kMostCounted = 200;  // then both counts are halved: places change
// Errors of successive poses are alike for about this many images: what they say about a point
// counts once in so many.
constexpr double kAlikePoses = 25;
constexpr double kTinyVariance = 1e-12;  // m^2
constexpr double kLeastPixelError =
    0.03;  // px: a patch keeps an error that no number of looks ends
// Squared gradient of a corner in its weaker direction, of the squared contrast of texture: noise
// alone stays below it.
constexpr double kCornerShare = 0.4;
constexpr int kFewPoints = 25;
constexpr int kHaste = 5;
constexpr int kPatchReach = 7;   // px: a patch must lie on one section of a pipe
constexpr int kCellMargin = 12;  // px: the stored patch must be in the image

constexpr int kY = 1;

/// Of a square of the image, from every fourth pixel.
double mean_level(const ImageView& image, const Eigen::Vector2i& low, int side) noexcept {
  constexpr int kStep = 4;
  int sum = 0;
  int count = 0;
  for (int v = 0; v < side; v += kStep) {
    for (int u = 0; u < side; u += kStep, ++count) {
      sum += image.row(low.y() + v)[low.x() + u];
    }
  }
  return static_cast<double>(sum) / count;
}

/// The least rotation from one direction to another that is not opposite to it. (For opposite ones
/// Eigen's FromTwoVectors has a singular value decomposition, which takes 8 s to compile.)
Eigen::Quaterniond least_turn(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  const Eigen::Vector3d a = from.normalized();
  const Eigen::Vector3d b = to.normalized();
  const double twice_cosine_of_half = std::sqrt((1 + b.dot(a)) * 2);
  Eigen::Quaterniond turn;
  turn.vec() = a.cross(b) * (1 / twice_cosine_of_half);
  turn.w() = twice_cosine_of_half * 0.5;
  return turn;
}

}  // namespace

Eigen::Vector3d TextureMap::step_by_map_error(const Point& point,
                                              const geometry::Vector6d& map_error) const noexcept {
  Eigen::Vector3d end = map_error.head<3>();
  end(kY) = 0;
  end += map_error.tail<3>().cross(point.made_from);
  Eigen::Vector3d step =
      end - point.made_from * (point.normal.dot(end) / point.normal.dot(point.made_from));
  if (anchored_by_y(point)) {
    step(kY) -= point.made_middle.dot(map_error);
  }
  return step;
}

Eigen::Matrix<double, 3, 6> TextureMap::by_map_error(const Point& point) const noexcept {
  Eigen::Matrix<double, 3, 6> result;
  for (int i = 0; i < 6; ++i) {
    result.col(i) = step_by_map_error(point, geometry::Vector6d::Unit(i));
  }
  return result;
}

void TextureMap::correct(const geometry::Vector6d& map_error) noexcept {
  for (Point& point : points_) {
    point.place += step_by_map_error(point, map_error);
  }
}

TextureMap::PlaceVariance TextureMap::pose_variance(const Point& point,
                                                    const Eigen::Vector3d& from_camera,
                                                    const UncertainView& view,
                                                    const MotionRow& middle) const noexcept {
  const auto variance = [&view](const MotionRow& row) {
    return std::max(0.0, (row * view.covariance * row.transpose()).value());
  };
  const Eigen::Matrix<double, 3, 6> hit = end_by_motion(from_camera, point.normal);
  const MotionRow along = pipes_[point.pipe].direction.transpose() * hit;
  const MotionRow around = this->around(point).transpose() * hit;
  return {variance(middle),
          variance(anchored_by_y(point) ? MotionRow(hit.row(kY) - middle) : along),
          variance(around)};
}

void TextureMap::refine(Point& point, const UncertainView& view, const MotionRow& middle,
                        const Projection& projection, const MatchedPoint& match,
                        const Eigen::Vector2d& error) const {
  const Eigen::Matrix2d surface_from_pixel = projection.scale.inverse();
  const Eigen::Vector2d seen = surface_from_pixel * error;  // along, around
  const Eigen::Vector2d per_pixel =
      (surface_from_pixel * surface_from_pixel.transpose()).diagonal();
  const PlaceVariance pose = pose_variance(point, projection.from_camera, view, middle);
  const Eigen::Vector2d noise =
      per_pixel * match.sigma * match.sigma + Eigen::Vector2d(pose.along, pose.around);
  const Eigen::Vector2d own_gain =
      (point.own_variance / (noise.array() + point.own_variance)).matrix();
  Eigen::Vector2d move = own_gain.cwiseProduct(seen);
  point.own_variance = std::max(point.own_variance * (1 - own_gain.mean()),
                                per_pixel.mean() * kLeastPixelError * kLeastPixelError);

  const auto take = [](double& variance, double measured, double& moved, double left) {
    const double gain = variance / (variance + kAlikePoses * measured + kTinyVariance);
    variance *= 1 - gain;
    moved += gain * (left - moved);
  };
  take(point.along_variance, pose.along, move(0), seen(0));
  take(point.around_variance, pose.around, move(1), seen(1));
  const double reached = view.anchor_variance + pose.anchor;
  if (anchored_by_y(point) && point.anchor_variance > reached) {
    move(0) += (1 - reached / point.anchor_variance) * (seen(0) - move(0));
    point.anchor_variance = reached;
  }

  const Pipe& pipe = pipes_[point.pipe];
  const Eigen::Vector3d start = pipe.start + point.offset * Eigen::Vector3d::UnitX();
  const Eigen::Vector3d foot = start + pipe.direction * pipe.direction.dot(point.place - start);
  const double radius = (point.place - foot).norm();
  const Eigen::Vector3d moved = point.place - foot + move(1) * around(point);
  const Eigen::Quaterniond turn = least_turn(point.place - foot, moved);
  point.place = foot + move(0) * pipe.direction + radius * moved.normalized();
  point.normal = turn * point.normal;
}

int TextureMap::learn(const UncertainView& view, const std::vector<MatchedPoint>& matches,
                      double gate) {
  const MotionRow middle = middle_by_motion(view.T_camera_rack.inverse());
  int agreed = 0;
  for (const MatchedPoint& match : matches) {
    Point& point = points_[match.point];
    const std::optional<Projection> projection = project(point, view);
    if (!projection) {
      continue;
    }
    bool agrees = false;
    if (match.found) {
      const std::optional<Eigen::Vector2d> seen = camera_.distort(match.pixel);
      const Eigen::Vector2d error =
          seen ? Eigen::Vector2d(*seen - projection->pixel) : Eigen::Vector2d::Constant(gate);
      agrees = error.norm() < gate;
      if (agrees) {
        refine(point, view, middle, *projection, match, error);
        point.seen = last_seen_ = image_;
        ++agreed;
      }
    }
    (agrees ? point.found : point.failed) += 1;
    if (point.found + point.failed > kMostCounted) {
      point.found /= 2;
      point.failed /= 2;
    }
  }
  std::erase_if(points_, [](const Point& point) {
    const std::uint32_t trials = point.found + point.failed;
    return trials >= kTrials && point.failed > kMostFailures * trials;
  });
  return agreed;
}

void TextureMap::grow(const ImageView& image, const UncertainView& view,
                      const RackSurface& surface) {
  const int cells = columns_ * rows_;
  const int side = parameters_.cell_side;
  // In haste where there is little to hold on to.
  const auto held = std::ranges::count_if(occupied_, [](std::uint8_t count) { return count > 0; });
  const int wanted = parameters_.cells_per_frame * (held < kFewPoints ? kHaste : 1);
  const MotionRow middle = middle_by_motion(view.T_camera_rack.inverse());
  int looked_through = 0;
  for (int i = 0; i < cells && looked_through < wanted; ++i) {
    const int cell = next_cell_;
    next_cell_ = (next_cell_ + 1) % cells;
    if (occupied_[static_cast<std::size_t>(cell)] > 0) {
      continue;
    }
    const Eigen::Vector2i low((cell % columns_) * side, (cell / columns_) * side);
    const Eigen::Vector2d inside = low.cast<double>().array() + 0.5 * side;
    const std::optional<SurfaceHit> hit = surface.seen_at(camera_, view.T_camera_rack, inside);
    if (!hit || hit->kind != EdgeKind::kPipe || view.unplaced[hit->body]) {
      continue;
    }
    ++looked_through;
    const Eigen::Vector2i inner = low.cwiseMax(kCellMargin);
    const Eigen::Vector2i high =
        (low.array() + side)
            .min(Eigen::Array2i(image.width - kCellMargin, image.height - kCellMargin));
    const int inner_side = (high - inner).minCoeff();
    if (inner_side < 8) {
      continue;
    }
    const double level = mean_level(image, inner, inner_side);
    const double contrast = noise_.texture_contrast(parameters_.least_contrast, level);
    const std::optional<Eigen::Vector2i> corner = strongest_corner(
        image, inner, inner_side, static_cast<float>(kCornerShare * contrast * contrast));
    if (corner) {
      add(image, view_of_row(view, corner->y()), middle, surface, *corner);
    }
  }
}

void TextureMap::add(const ImageView& image, const UncertainView& view, const MotionRow& middle,
                     const RackSurface& surface, const Eigen::Vector2i& corner) {
  const Eigen::Vector2d pixel = corner.cast<double>();
  const std::optional<SurfaceHit> hit = surface.seen_at(camera_, view.T_camera_rack, pixel);
  if (!hit || hit->kind != EdgeKind::kPipe || !hit->on_side_of_pipe || view.unplaced[hit->body]) {
    return;
  }
  for (const int u : {-kPatchReach, kPatchReach}) {
    for (const int v : {-kPatchReach, kPatchReach}) {
      const std::optional<SurfaceHit> beside =
          surface.seen_at(camera_, view.T_camera_rack, pixel + Eigen::Vector2d(u, v));
      if (!beside || beside->kind != hit->kind || beside->body != hit->body ||
          beside->part != hit->part) {
        return;
      }
    }
  }
  Point point;
  point.pipe = hit->body;
  point.offset = view.offsets.empty() ? 0.0 : view.offsets[hit->body];
  point.place = hit->point;
  point.normal = hit->normal;
  const std::optional<Projection> projection = project(point, view);
  const double distance = projection ? projection->from_camera.norm() : 0;
  if (!projection ||
      -point.normal.dot(projection->from_camera) < parameters_.least_facing * distance ||
      !store_patch(image, corner, point.patch)) {
    return;
  }
  point.stored_scale = projection->scale;
  point.made_from = projection->from_camera;
  point.made_middle = middle;
  point.made_middle(kY) = 0;
  const Eigen::Matrix2d surface_from_pixel = projection->scale.inverse();
  point.own_variance = 0.5 * (surface_from_pixel * surface_from_pixel.transpose()).trace() *
                       parameters_.point_sigma * parameters_.point_sigma;
  if (row_motion_.is_rolling()) {
    // Of the rows above the middle it is opposite to that of the rows below: not one of all points.
    point.own_variance += 0.5 * (surface_from_pixel * row_variance(*projection, pixel.y()) *
                                 surface_from_pixel.transpose())
                                    .trace();
  }
  const PlaceVariance pose = pose_variance(point, projection->from_camera, view, middle);
  point.anchor_variance = anchored_by_y(point) ? view.anchor_variance + pose.anchor : 0.0;
  point.along_variance = pose.along;
  point.around_variance = pose.around;
  point.found = 1;
  point.seen = last_seen_ = image_;
  make_room(view);
  if (points_.size() < static_cast<std::size_t>(parameters_.capacity)) {
    points_.push_back(point);
  }
}

void TextureMap::make_room(const UncertainView& view) {
  if (points_.empty() || points_.size() < static_cast<std::size_t>(parameters_.capacity)) {
    return;
  }
  const Eigen::Vector3d eye = view.T_camera_rack.inverse().translation();
  const auto farthest = std::ranges::max_element(
      points_, {}, [&eye](const Point& point) { return (point.place - eye).squaredNorm(); });
  *farthest = points_.back();
  points_.pop_back();
}

void TextureMap::shift_seen(double along, double anchor_variance) {
  for (Point& point : points_) {
    if (point.seen == last_seen_ && anchored_by_y(point)) {
      point.place.y() += along;
      point.anchor_variance = std::min(point.anchor_variance, anchor_variance);
    }
  }
}

void TextureMap::clear() noexcept {
  points_.clear();
  std::ranges::fill(occupied_, std::uint8_t{0});
  image_ = 0;
  last_seen_ = 0;
  next_cell_ = 0;
}

}  // namespace pipescout::rack_vision
