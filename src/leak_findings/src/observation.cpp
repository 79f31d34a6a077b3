// SPDX-License-Identifier: Apache-2.0
#include "observation.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "pipescout/statistics/normal.hpp"

namespace pipescout::leak_findings {
namespace {

/// Pipe widths that parts of one leak may lie apart where no scale is known.
constexpr double kSlackWidths = 2.0;
/// Pixels, added to how far the middle of what is seen of a leak may be from its own.
constexpr double kPartialPixels = 10.0;
/// Pixels, standard, that the width of what is above a threshold may be off by blur.
constexpr double kThresholdWidth = 1.4;
/// Cosine of the angle in the picture between a pipe and the known line that it is on, at least.
constexpr double kParallel = 0.95;

Eigen::Vector3d at_unit_depth(const geometry::Camera& camera, const Eigen::Vector2d& pixel) {
  const auto ray = camera.ray(pixel);
  return ray ? *ray : Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
}

/// What is known of a point on the ray at that range.
RangePrior along_ray(const Bearing& bearing, double range, double deviation) {
  RangePrior prior;
  prior.range = range;
  prior.point = bearing.eye + range * bearing.ray;
  prior.information = bearing.ray * bearing.ray.transpose() / (deviation * deviation);
  return prior;
}

/// Below and above: of an interval, or where it is not known of a standard deviation.
std::array<double, 2> margins(double value, double low, double high, double deviation) {
  const double half = statistics::kNormal95 * deviation;
  return {std::isfinite(low) ? value - low : half, std::isfinite(high) ? high - value : half};
}
std::array<double, 2> delta_margins(const thermal::LeakDetection& leak, double deviation) {
  return margins(leak.delta, leak.delta_low, leak.delta_high, deviation);
}
std::array<double, 2> peak_delta_margins(const thermal::LeakDetection& leak, double deviation) {
  return margins(leak.peak_delta, leak.peak_delta_low, leak.peak_delta_high, deviation);
}

}  // namespace

double Observer::metres_per_pixel(const thermal::PipeSection& pipe) const {
  if (pipe.metres_per_pixel > 0) {
    return pipe.metres_per_pixel;
  }
  switch (parameters_.range_source) {
    case RangeSource::kDistance:
      return parameters_.distance / camera_.parameters().focal_length;
    case RangeSource::kDiameter:
      return parameters_.pipe_diameter / pipe.best_width();
    case RangeSource::kNone:
    case RangeSource::kLine:
      break;
  }
  return 0;
}

void Observer::collect(const thermal::Detections& detections,
                       std::vector<Observation>& observations) const {
  observations.clear();
  const auto or_else = [this](double deviation) {
    return std::isfinite(deviation) ? deviation : parameters_.delta_deviation;
  };
  for (std::size_t i = 0; i < detections.leaks.size(); ++i) {
    const thermal::LeakDetection& leak = detections.leaks[i];
    const thermal::PipeSection& pipe = detections.pipes[leak.pipe];
    // How wide it is, and so how far, only a picture tells that has all of its width.
    if (pipe.cut_along && parameters_.range_source == RangeSource::kDiameter) {
      continue;
    }
    if (!observations.empty() && observations.back().pipe == leak.pipe) {
      Observation& before = observations.back();
      const double scale = metres_per_pixel(pipe);
      const double slack =
          scale > 0 ? parameters_.extent_slack / scale : 2 * kSlackWidths * pipe.half_width;
      if ((leak.start - before.end).norm() <= slack) {
        const double a = before.pixels();
        const double b = (leak.end - leak.start).norm();
        before.across = (a * before.across + b * leak.across) / (a + b);
        before.delta = (a * before.delta + b * leak.delta) / (a + b);
        before.delta_deviation =
            (a * before.delta_deviation + b * or_else(leak.delta_deviation)) / (a + b);
        const std::array<double, 2> more = delta_margins(leak, or_else(leak.delta_deviation));
        for (std::size_t side = 0; side < 2; ++side) {
          before.delta_margins[side] = (a * before.delta_margins[side] + b * more[side]) / (a + b);
        }
        if (leak.peak_delta > before.peak_delta) {
          before.peak_delta = leak.peak_delta;
          before.peak_delta_margins = peak_delta_margins(leak, or_else(leak.peak_delta_deviation));
        }
        before.end = leak.end;
        before.last_detection = i;
        before.seen[1] = !leak.stretch.open_at_end;
        before.onset[1] = pipe.at(leak.stretch.onset_to - 0.5);
        continue;
      }
    }
    Observation o;
    o.first_detection = i;
    o.last_detection = i;
    o.pipe = leak.pipe;
    o.start = leak.start;
    o.end = leak.end;
    o.seen = {!leak.stretch.open_at_start, !leak.stretch.open_at_end};
    // Sample i reaches from half a pixel before its middle to half a pixel behind it.
    o.onset = {pipe.at(leak.stretch.onset_from - 0.5), pipe.at(leak.stretch.onset_to - 0.5)};
    o.across = leak.across;
    o.half_width = pipe.half_width;
    o.width = pipe.best_width();
    o.width_deviation = pipe.width > 0 ? 0 : kThresholdWidth;
    o.delta = leak.delta;
    o.peak_delta = leak.peak_delta;
    o.delta_deviation = or_else(leak.delta_deviation);
    o.delta_margins = delta_margins(leak, o.delta_deviation);
    o.peak_delta_margins = peak_delta_margins(leak, or_else(leak.peak_delta_deviation));
    observations.push_back(o);
  }
}

std::size_t Observer::observe(double time, const std::optional<Eye>& eye,
                              const thermal::Detections& detections,
                              std::vector<Observation>& observations) const {
  collect(detections, observations);
  if (!eye) {
    return 0;
  }
  for (Observation& o : observations) {
    if (add_bearings(time, *eye, 0, o)) {
      add_range(*eye, o);
      if (o.line >= 0 && parameters_.lines[static_cast<std::size_t>(o.line)].radius > 0) {
        put_on_surface(time, *eye, o);
      }
    }
  }
  return parameters_.range_source != RangeSource::kLine
             ? 0
             : std::erase_if(observations, [](const Observation& o) { return o.line < 0; });
}

bool Observer::add_bearings(double time, const Eye& eye, double across, Observation& o) const {
  const geometry::SO3& to_map = eye.T_map_camera.rotation();
  const double focal = camera_.parameters().focal_length;
  const Eigen::Vector3d along = at_unit_depth(camera_, o.end) - at_unit_depth(camera_, o.start);
  const Eigen::Vector2d in_image = (o.end - o.start).normalized();
  const Eigen::Vector2d beside = across * Eigen::Vector2d(-in_image.y(), in_image.x());
  const auto bearing = [&](const Eigen::Vector2d& pixel, double partial) -> std::optional<Bearing> {
    Bearing b;
    b.time = time;
    b.eye = eye.T_map_camera.translation();
    b.ray = to_map * at_unit_depth(camera_, pixel + beside).normalized();
    b.along = to_map * along;
    b.along -= b.ray * b.ray.dot(b.along);
    b.along.normalize();
    b.along_deviation = std::hypot(std::hypot(parameters_.pixel_deviation, partial) / focal,
                                   parameters_.attitude_jitter);
    b.across_deviation =
        std::hypot(parameters_.pixel_deviation / focal, parameters_.attitude_jitter);
    b.position_jitter = parameters_.position_jitter;
    b.base = eye.base;
    b.pose_covariance = eye.covariance;
    return b.ray.allFinite() && b.along.allFinite() ? std::optional(b) : std::nullopt;
  };
  o.bearing = bearing(o.centre(), o.whole() ? 0 : 0.5 * o.pixels() + kPartialPixels);
  o.ends[0] = o.seen[0] ? bearing(o.start, 0) : std::nullopt;
  o.ends[1] = o.seen[1] ? bearing(o.end, 0) : std::nullopt;
  for (std::size_t k = 0; k < 2; ++k) {
    o.onsets[k] = o.onset[k].allFinite() ? bearing(o.onset[k], 0) : std::nullopt;
  }
  o.angle = std::acos(std::clamp(
      at_unit_depth(camera_, o.start).normalized().dot(at_unit_depth(camera_, o.end).normalized()),
      -1.0, 1.0));
  // As if across the axis of the camera; a known line tells better.
  o.direction = to_map * along.normalized();
  return o.bearing.has_value();
}

void Observer::add_range(const Eye& eye, Observation& o) const {
  const Eigen::Vector3d axis = eye.T_map_camera.rotation() * Eigen::Vector3d::UnitZ();
  const double depth_to_range = 1 / o.bearing->ray.dot(axis);
  switch (parameters_.range_source) {
    case RangeSource::kNone:
      // Wide enough for any pipe; what comes out counts once motion has told the range.
      o.range = along_ray(*o.bearing, parameters_.distance, parameters_.distance);
      return;
    case RangeSource::kDistance:
      o.range = along_ray(*o.bearing, parameters_.distance * depth_to_range,
                          parameters_.distance_deviation * depth_to_range);
      return;
    case RangeSource::kDiameter: {
      const double range =
          camera_.parameters().focal_length * parameters_.pipe_diameter / o.width * depth_to_range;
      const double share = std::hypot(parameters_.width_deviation, o.width_deviation / o.width);
      o.range = along_ray(*o.bearing, range, share * range);
      return;
    }
    case RangeSource::kLine:
      add_range_of_line(o);
      return;
  }
}

/// The line that the ray comes nearest to; none when that is farther than errors reach.
void Observer::add_range_of_line(Observation& o) const {
  const Bearing& b = *o.bearing;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < parameters_.lines.size(); ++i) {
    const PipeLine& line = parameters_.lines[i];
    const Eigen::Vector3d u = (line.to - line.from).normalized();
    const Eigen::Vector3d normal = b.ray.cross(u);
    const double sine = normal.norm();
    if (sine < 0.05) {  // one looks along it
      continue;
    }
    const Eigen::Vector3d between = line.from - b.eye;
    const double range = between.cross(u).dot(normal) / (sine * sine);
    const double place = between.cross(b.ray).dot(normal) / (sine * sine);
    const double pose_deviation = std::sqrt(
        pose_part(b.eye + range * b.ray, b.base, b.pose_covariance).diagonal().maxCoeff());
    const double deviation = std::hypot(std::hypot(parameters_.line_deviation, pose_deviation),
                                        range * b.across_deviation);
    const double distance = std::abs(between.dot(normal)) / sine;
    // What crosses the pipe, a post before it, is near its line too.
    const Eigen::Vector3d seen = (u - b.ray * b.ray.dot(u)) / sine;
    if (std::abs(seen.dot(b.along)) < kParallel) {
      continue;
    }
    const bool on_line = place >= -parameters_.gate * deviation &&
                         place <= (line.to - line.from).norm() + parameters_.gate * deviation;
    const double off = distance / deviation;
    if (range > 0 && on_line && off <= parameters_.gate && off < least) {
      least = off;
      o.line = static_cast<int>(i);
      o.direction = seen.dot(b.along) > 0 ? u : Eigen::Vector3d(-u);
      o.range = along_ray(b, range, deviation / sine);
    }
  }
}

void Observer::put_on_surface(double time, const Eye& eye, Observation& o) const {
  const PipeLine& line = parameters_.lines[static_cast<std::size_t>(o.line)];
  const Eigen::Vector3d direction = o.direction;
  const double deviation = 1 / std::sqrt(o.bearing->ray.dot(o.range->information * o.bearing->ray));
  if (!add_bearings(time, eye, o.across, o)) {
    return;
  }
  o.direction = direction;
  const Bearing& b = *o.bearing;
  const Eigen::Vector3d u = (line.to - line.from).normalized();
  const Eigen::Vector3d across_ray = b.ray - u * u.dot(b.ray);
  Eigen::Vector3d across_eye = b.eye - line.from;
  across_eye -= u * u.dot(across_eye);
  // A ray that just misses the pipe meets it where it comes nearest.
  const double squared = across_ray.squaredNorm();
  const double half = across_eye.dot(across_ray);
  const double discriminant =
      half * half - squared * (across_eye.squaredNorm() - line.radius * line.radius);
  const double range = (-half - std::sqrt(std::max(0.0, discriminant))) / squared;
  o.range = along_ray(b, range, deviation);
}

}  // namespace pipescout::leak_findings
