// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation/pipe_centre_line.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "pipescout/validation/check.hpp"

namespace pipescout::estimation {

using validation::require;

PipeCentreLine::PipeCentreLine(std::vector<Eigen::Vector3d> points, double first_chainage)
    : points_(std::move(points)) {
  constexpr double kNearest = 1e-6;
  require("points.size()", static_cast<double>(points_.size()), points_.size() >= 2,
          "[2, infinity)");
  require("first_chainage", first_chainage, true, "the finite numbers");
  chainages_.push_back(first_chainage);
  for (std::size_t i = 0; i < points_.size(); ++i) {
    if (!points_[i].allFinite()) {
      throw std::invalid_argument("points: one is not finite");
    }
    if (i > 0) {
      const double length = (points_[i] - points_[i - 1]).norm();
      require("length of a segment", length, length >= kNearest, "[1e-6, infinity)");
      chainages_.push_back(chainages_.back() + length);
    }
  }
}

std::optional<PipeCentreLine::Place> PipeCentreLine::at(double chainage) const noexcept {
  if (!(chainage >= first_chainage() && chainage <= last_chainage())) {
    return std::nullopt;
  }
  const auto after = std::upper_bound(chainages_.begin(), chainages_.end(), chainage);
  const auto end =
      static_cast<std::size_t>(after == chainages_.end() ? chainages_.end() - chainages_.begin() - 1
                                                         : after - chainages_.begin());
  const Eigen::Vector3d direction = (points_[end] - points_[end - 1]).normalized();
  return Place{.position = points_[end - 1] + (chainage - chainages_[end - 1]) * direction,
               .direction = direction};
}

double PipeCentreLine::chainage_of(const Eigen::Vector3d& position, double nearby) const noexcept {
  constexpr int kSteps = 4;
  double chainage = std::clamp(nearby, first_chainage(), last_chainage());
  for (int i = 0; i < kSteps; ++i) {
    const auto place = at(chainage);
    if (!place) {
      break;
    }
    chainage = std::clamp(chainage + place->direction.dot(position - place->position),
                          first_chainage(), last_chainage());
  }
  return chainage;
}

std::optional<WeldMeasurement> PipeCentreLine::weld(double time, double chainage,
                                                    double along_deviation, double across_deviation,
                                                    const Eigen::Vector3d& sensor) const noexcept {
  const auto place = at(chainage);
  if (!place) {
    return std::nullopt;
  }
  return WeldMeasurement{.time = time,
                         .position = place->position,
                         .direction = place->direction,
                         .along_deviation = along_deviation,
                         .across_deviation = across_deviation,
                         .sensor = sensor};
}

}  // namespace pipescout::estimation
