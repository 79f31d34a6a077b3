// SPDX-License-Identifier: Apache-2.0
#include "pipescout/odometry/centre_line.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "pipescout/geometry/geodesy.hpp"
#include "pipescout/validation/check.hpp"

namespace pipescout::odometry {
namespace {

using validation::refuse;
using validation::require;

/// Difference of longitudes the short way, degrees.
double turn(double from, double to) {
  return std::remainder(to - from, 360.0);
}

void check(MapFrame frame, const SurveyedPoint& point) {
  for (const double coordinate : point.position.coordinates) {
    require("coordinates", coordinate, true, "(-infinity, infinity)");
  }
  if (frame == MapFrame::kGeodetic) {
    require("latitude", point.position.coordinates[0],
            std::abs(point.position.coordinates[0]) <= 90.0, "[-90, 90]");
    require("longitude", point.position.coordinates[1],
            std::abs(point.position.coordinates[1]) <= 180.0, "[-180, 180]");
  }
  require("standard_deviation", point.position.standard_deviation,
          point.position.standard_deviation >= 0.0, "[0, infinity)");
  if (point.chainage) {
    require("chainage", *point.chainage, true, "(-infinity, infinity)");
  }
}

}  // namespace

double map_distance(MapFrame frame, const std::array<double, 3>& a,
                    const std::array<double, 3>& b) noexcept {
  if (frame != MapFrame::kGeodetic) {
    return std::hypot(b[0] - a[0], b[1] - a[1], b[2] - a[2]);
  }
  return geometry::straight_distance({a[0], a[1], a[2]}, {b[0], b[1], b[2]});
}

std::array<double, 3> map_between(MapFrame frame, const std::array<double, 3>& a,
                                  const std::array<double, 3>& b, double t) noexcept {
  std::array<double, 3> point{};
  for (std::size_t k = 0; k < point.size(); ++k) {
    point[k] = std::lerp(a[k], b[k], t);
  }
  if (frame == MapFrame::kGeodetic && std::abs(b[1] - a[1]) > 180.0) {
    point[1] = std::remainder(a[1] + t * turn(a[1], b[1]), 360.0);
  }
  return point;
}

void CentreLineParameters::validate() const {
  require("wander", wander, wander >= 0.0 && wander <= 10.0, "[0, 10]");
  require("chainage_noise", chainage_noise, chainage_noise >= 0.0 && chainage_noise <= 10.0,
          "[0, 10]");
}

CentreLine::CentreLine(MapFrame frame, std::vector<SurveyedPoint> points,
                       CentreLineParameters parameters)
    : frame_(frame), points_(std::move(points)), parameters_(parameters) {
  parameters_.validate();
  if (frame != MapFrame::kGeodetic && frame != MapFrame::kLocal) {
    refuse("frame: ", static_cast<int>(frame), " is neither geodetic nor local");
  }
  if (points_.size() < 2) {
    refuse("points: ", points_.size(), " are fewer than 2");
  }
  lengths_.push_back(0.0);
  for (std::size_t k = 0; k < points_.size(); ++k) {
    check(frame, points_[k]);
    if (k > 0) {
      const double step =
          map_distance(frame, points_[k - 1].position.coordinates, points_[k].position.coordinates);
      if (!(step > 0.0)) {
        refuse("points[", k, "]: coincides with the previous one");
      }
      lengths_.push_back(lengths_.back() + step);
    }
    if (points_[k].chainage) {
      if (!anchors_.empty() && !(*points_[k].chainage > *points_[anchors_.back()].chainage)) {
        refuse("points[", k, "].chainage: ", *points_[k].chainage, " is not above ",
               *points_[anchors_.back()].chainage);
      }
      anchors_.push_back(k);
    }
  }
}

std::optional<MapPosition> CentreLine::at(double chainage,
                                          double standard_deviation) const noexcept {
  double length = chainage;
  double chainage_variance = standard_deviation * standard_deviation;
  if (!anchors_.empty()) {
    const auto next = std::upper_bound(
        anchors_.begin(), anchors_.end(), chainage,
        [this](double value, std::size_t k) { return value < *points_[k].chainage; });
    const std::size_t nearest = next == anchors_.begin() ? anchors_.front() : *(next - 1);
    const double known = *points_[nearest].chainage;
    length = lengths_[nearest] + (chainage - known);
    if (next != anchors_.begin() && next != anchors_.end()) {
      const double stretch = *points_[*next].chainage - known;
      const double t = (chainage - known) / stretch;
      length = std::lerp(lengths_[nearest], lengths_[*next], t);
      const double noise = parameters_.chainage_noise;
      chainage_variance = std::min(chainage_variance, noise * noise * stretch * t * (1.0 - t));
    } else if (chainage == known) {
      chainage_variance = 0.0;
    }
  }
  if (!(length >= 0.0 && length <= lengths_.back())) {
    return std::nullopt;
  }
  const auto above = std::upper_bound(lengths_.begin() + 1, lengths_.end() - 1, length);
  const auto k = static_cast<std::size_t>(above - lengths_.begin());
  const double step = lengths_[k] - lengths_[k - 1];
  const double t = (length - lengths_[k - 1]) / step;
  const MapPosition& before = points_[k - 1].position;
  const MapPosition& after = points_[k].position;
  const double from_before = (1.0 - t) * before.standard_deviation;
  const double from_after = t * after.standard_deviation;
  const double variance = from_before * from_before + from_after * from_after +
                          parameters_.wander * parameters_.wander * step * t * (1.0 - t) +
                          chainage_variance;
  return MapPosition{.coordinates = map_between(frame_, before.coordinates, after.coordinates, t),
                     .standard_deviation = std::sqrt(variance)};
}

}  // namespace pipescout::odometry
