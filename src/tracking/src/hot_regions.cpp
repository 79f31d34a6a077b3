// SPDX-License-Identifier: Apache-2.0
#include "pipescout/tracking/hot_regions.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

#include "pipescout/validation/check.hpp"

namespace pipescout::tracking {

namespace {

/// A square pixel has this second moment of its own, px^2.
constexpr double kPixelMoment = 1.0 / 12.0;

/// Sums over the pixels of a region, from which its moments follow.
struct RegionSums {
  double count = 0;
  Eigen::Vector2d first = Eigen::Vector2d::Zero();
  Eigen::Matrix2d second = Eigen::Matrix2d::Zero();

  void add(double x, double y) {
    const Eigen::Vector2d pixel(x, y);
    count += 1;
    first += pixel;
    second += pixel * pixel.transpose();
  }
  [[nodiscard]] HotRegion region() const {
    HotRegion result;
    result.pixels = static_cast<std::size_t>(count);
    result.middle = first / count;
    result.second_moment = second / count - result.middle * result.middle.transpose() +
                           kPixelMoment * Eigen::Matrix2d::Identity();
    return result;
  }
};

}  // namespace

void HotRegionParameters::validate() const {
  validation::require("threshold", threshold, true, "(-inf, inf)");
  validation::check_within("least_pixels", static_cast<double>(least_pixels), 5, 1e6);
  validation::check_within("least_fill", least_fill, 0, 1);
  validation::check_within("most_regions", static_cast<double>(most_regions), 1, 1e5);
}

HotRegionFinder::HotRegionFinder(const HotRegionParameters& parameters) : parameters_(parameters) {
  parameters_.validate();
}

const std::vector<HotRegion>& HotRegionFinder::find(std::span<const float> celsius,
                                                    const ImageSize& image) {
  regions_.clear();
  const auto width = static_cast<std::size_t>(std::max(image.width, 0));
  const auto height = static_cast<std::size_t>(std::max(image.height, 0));
  if (celsius.size() != width * height) {
    throw std::invalid_argument("celsius: " + std::to_string(celsius.size()) +
                                " temperatures: must be " + std::to_string(width * height));
  }
  open_.resize(celsius.size());
  const auto threshold = static_cast<float>(parameters_.threshold);
  std::ranges::transform(celsius, open_.begin(), [threshold](float value) {
    return static_cast<unsigned char>(value > threshold ? 1 : 0);
  });
  for (std::size_t seed = 0; seed < open_.size() && regions_.size() < parameters_.most_regions;
       ++seed) {
    if (open_[seed] == 0) {
      continue;
    }
    RegionSums sums;
    bool whole = true;
    const auto take = [this](std::size_t pixel) {
      if (open_[pixel] != 0) {
        open_[pixel] = 0;
        stack_.push_back(pixel);
      }
    };
    take(seed);
    while (!stack_.empty()) {
      const std::size_t pixel = stack_.back();
      stack_.pop_back();
      const std::size_t x = pixel % width;
      const std::size_t y = pixel / width;
      sums.add(static_cast<double>(x), static_cast<double>(y));
      if (x == 0 || y == 0 || x + 1 == width || y + 1 == height) {
        whole = false;
      }
      if (x > 0) {
        take(pixel - 1);
      }
      if (x + 1 < width) {
        take(pixel + 1);
      }
      if (y > 0) {
        take(pixel - width);
      }
      if (y + 1 < height) {
        take(pixel + width);
      }
    }
    if (whole && sums.count >= static_cast<double>(parameters_.least_pixels)) {
      regions_.push_back(sums.region());
    }
  }
  return regions_;
}

/// A disc of radius r has the second moments r^2 / 4 along any direction; those of the area that a
/// region covers are larger the less it is one.
std::vector<ValveShape::Region> HotRegionFinder::valves() const {
  std::vector<ValveShape::Region> result;
  for (const HotRegion& region : regions_) {
    const auto area = static_cast<double>(region.pixels);
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(region.second_moment);
    // Of the circle about the longer axis.
    const double circle = std::numbers::pi * 4 * axes.eigenvalues()[1];
    if (area >= parameters_.least_fill * circle) {
      result.push_back({region.middle.x(), region.middle.y(), std::sqrt(area / std::numbers::pi)});
    }
  }
  return result;
}

/// A rectangle of the sides a and b has the second moments a^2 / 12 and b^2 / 12 along them.
std::vector<VesselShape::Region> HotRegionFinder::vessels() const {
  std::vector<VesselShape::Region> result;
  for (const HotRegion& region : regions_) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(region.second_moment);
    const double width = std::sqrt(12 * axes.eigenvalues()[0]);
    const double length = std::sqrt(12 * axes.eigenvalues()[1]);
    if (static_cast<double>(region.pixels) < parameters_.least_fill * length * width) {
      continue;
    }
    const Eigen::Vector2d axis = axes.eigenvectors().col(1);
    VesselShape::Region vessel;
    vessel << region.middle, length, width, std::atan2(axis.y(), axis.x());
    result.push_back(VesselShape::state_of(vessel));
  }
  return result;
}

}  // namespace pipescout::tracking
