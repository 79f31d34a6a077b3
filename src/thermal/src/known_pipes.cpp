// SPDX-License-Identifier: Apache-2.0
#include "known_pipes.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <utility>

namespace pipescout::thermal {
namespace {

/// How far outside of its edges a pipe may still be seen: share of its half width, for the errors
/// of its position and of the pose, and pixels, for the blur of the lens. A pipe of 0.15 m that is
/// seen 18 pixels wide on either side: 4 cm.
constexpr double kEdgeShare = 0.15;
constexpr double kEdgePixels = 2.0;

/// Of a point, next to the axis of a strip.
struct Place {
  double share = 0;  // of the length from start to end, below 0 before it and above 1 behind it
  double off = 0;    // pixels from the axis
};

Place place_on(const PipeStrip& strip, const Eigen::Vector2d& point) {
  const Eigen::Vector2d axis = strip.end - strip.start;
  const Eigen::Vector2d from_start = point - strip.start;
  const double squared = axis.squaredNorm();
  return {axis.dot(from_start) / squared,
          std::abs(axis.x() * from_start.y() - axis.y() * from_start.x()) / std::sqrt(squared)};
}

double half_width_at(const PipeStrip& strip, double share) {
  return std::lerp(strip.half_width[0], strip.half_width[1], std::clamp(share, 0.0, 1.0));
}

/// The inverse depth of a straight line is linear in the image.
double inverse_depth_at(const PipeStrip& strip, double share) {
  return std::lerp(1 / strip.depth[0], 1 / strip.depth[1], std::clamp(share, 0.0, 1.0));
}

bool covers(const PipeStrip& strip, const Place& place) {
  const double ahead = kEdgePixels / (strip.end - strip.start).norm();
  return place.share >= -ahead && place.share <= 1 + ahead &&
         place.off <= (1 + kEdgeShare) * half_width_at(strip, place.share) + kEdgePixels;
}

bool usable(const PipeStrip& strip) {
  return strip.start.allFinite() && strip.end.allFinite() &&
         (strip.end - strip.start).norm() >= 1 && strip.half_width[0] > 0 &&
         strip.half_width[1] > 0 && strip.depth[0] > 0 && strip.depth[1] > 0 &&
         std::isfinite(strip.half_width[0] + strip.half_width[1] + strip.depth[0] + strip.depth[1] +
                       strip.metres_per_pixel);
}

/// The part of a line between the middles of the outermost pixels, as shares of its length.
std::optional<std::pair<double, double>> inside(const Eigen::Vector2d& start,
                                                const Eigen::Vector2d& end, int width, int height) {
  const Eigen::Vector2d highest(width - 1, height - 1);
  double from = 0;
  double to = 1;
  for (int i = 0; i < 2; ++i) {
    const double step = end[i] - start[i];
    if (step == 0) {
      if (start[i] < 0 || start[i] > highest[i]) {
        return std::nullopt;
      }
      continue;
    }
    const double at_low = -start[i] / step;
    const double at_high = (highest[i] - start[i]) / step;
    from = std::max(from, std::min(at_low, at_high));
    to = std::min(to, std::max(at_low, at_high));
  }
  return from < to ? std::optional(std::pair(from, to)) : std::nullopt;
}

}  // namespace

void KnownPipes::set(std::span<const PipeStrip> strips, int width, int height) {
  strips_.clear();
  axes_.clear();
  std::ranges::copy_if(strips, std::back_inserter(strips_), usable);
  for (std::size_t first = 0; first < strips_.size();) {
    std::size_t last = first + 1;
    while (last < strips_.size() && strips_[last].pipe == strips_[first].pipe) {
      ++last;
    }
    add_axis(first, last, width, height);
    first = last;
  }
  std::ranges::sort(axes_, [](const Axis& a, const Axis& b) {
    return a.length() != b.length() ? a.length() > b.length() : a.first < b.first;
  });
}

void KnownPipes::add_axis(std::size_t first, std::size_t last, int width, int height) {
  const Eigen::Vector2d start = strips_[first].start;
  const Eigen::Vector2d along = strips_[last - 1].end - start;
  const auto part = inside(start, start + along, width, height);
  if (!part) {
    return;
  }
  Axis axis;
  axis.first = first;
  axis.last = last;
  axis.start = start + part->first * along;
  axis.end = start + part->second * along;
  double pixels = 0;
  for (std::size_t i = first; i < last; ++i) {
    const PipeStrip& strip = strips_[i];
    const double length = (strip.end - strip.start).norm();
    pixels += length;
    axis.half_width += length * 0.5 * (strip.half_width[0] + strip.half_width[1]);
    axis.metres_per_pixel += length * strip.metres_per_pixel;
  }
  axis.half_width /= pixels;
  axis.metres_per_pixel /= pixels;
  axes_.push_back(axis);
}

std::size_t KnownPipes::strip_at(const Axis& axis, const Eigen::Vector2d& point) const {
  for (std::size_t i = axis.first; i + 1 < axis.last; ++i) {
    if (place_on(strips_[i], point).share <= 1) {
      return i;
    }
  }
  return axis.last - 1;
}

double KnownPipes::half_width(const Axis& axis, const Eigen::Vector2d& point) const {
  const PipeStrip& strip = strips_[strip_at(axis, point)];
  return half_width_at(strip, place_on(strip, point).share);
}

bool KnownPipes::hidden(const Axis& axis, const Eigen::Vector2d& point) const {
  const PipeStrip& own = strips_[strip_at(axis, point)];
  const double inverse_depth = inverse_depth_at(own, place_on(own, point).share);
  return std::ranges::any_of(strips_, [&](const PipeStrip& other) {
    if (other.pipe == own.pipe) {
      return false;
    }
    const Place place = place_on(other, point);
    return covers(other, place) && inverse_depth_at(other, place.share) > inverse_depth;
  });
}

bool KnownPipes::on_another(const Axis& axis, const Eigen::Vector2d& point) const {
  return std::ranges::any_of(strips_, [&](const PipeStrip& other) {
    return other.pipe != strips_[axis.first].pipe && covers(other, place_on(other, point));
  });
}

}  // namespace pipescout::thermal
