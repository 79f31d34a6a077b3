// SPDX-License-Identifier: Apache-2.0
#include "pipescout/geometry/camera_calibration.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <locale>
#include <sstream>
#include <stdexcept>

namespace pipescout::geometry {
namespace {

using Coefficient = double CameraParameters::*;

constexpr std::array<Coefficient, 8> kBrown{
    &CameraParameters::k1, &CameraParameters::k2, &CameraParameters::p1, &CameraParameters::p2,
    &CameraParameters::k3, &CameraParameters::k4, &CameraParameters::k5, &CameraParameters::k6};
constexpr std::array<Coefficient, 4> kEquidistant{&CameraParameters::k1, &CameraParameters::k2,
                                                  &CameraParameters::k3, &CameraParameters::k4};
constexpr std::size_t kPlumbBob = 5;  // the first of kBrown

struct Model {
  LensModel lens;
  std::span<const Coefficient> coefficients;
};

Model model_of(std::string_view name) {
  if (name.empty()) {
    return {LensModel::kBrown, {}};
  }
  if (name == "plumb_bob") {
    return {LensModel::kBrown, std::span(kBrown).first<kPlumbBob>()};
  }
  if (name == "rational_polynomial") {
    return {LensModel::kBrown, kBrown};
  }
  if (name == "equidistant") {
    return {LensModel::kEquidistant, kEquidistant};
  }
  throw std::invalid_argument("distortion_model is '" + std::string(name) +
                              "'; it must be plumb_bob, rational_polynomial or equidistant");
}

}  // namespace

void set_distortion(std::string_view distortion_model, std::span<const double> d,
                    CameraParameters& camera) {
  const Model model = model_of(distortion_model);
  for (std::size_t i = model.coefficients.size(); i < d.size(); ++i) {
    if (d[i] != 0) {
      std::ostringstream text;
      text.imbue(std::locale::classic());
      text << "d[" << i << "] is " << d[i] << "; it must be 0 with the distortion_model '"
           << distortion_model << "'";
      throw std::invalid_argument(text.str());
    }
  }
  for (const Coefficient coefficient : kBrown) {
    camera.*coefficient = 0;
  }
  camera.lens = model.lens;
  for (std::size_t i = 0; i < std::min(d.size(), model.coefficients.size()); ++i) {
    camera.*model.coefficients[i] = d[i];
  }
}

RosDistortion ros_distortion(const CameraParameters& camera) {
  const bool equidistant = camera.lens == LensModel::kEquidistant;
  const bool rational = camera.k4 != 0 || camera.k5 != 0 || camera.k6 != 0;
  RosDistortion result;
  result.model = equidistant ? "equidistant" : rational ? "rational_polynomial" : "plumb_bob";
  for (const Coefficient coefficient : model_of(result.model).coefficients) {
    result.d.push_back(camera.*coefficient);
  }
  return result;
}

void apply_region(const ImageRegion& region, CameraParameters& camera) {
  const bool cut = region.width != 0 && region.height != 0;
  if (!cut &&
      (region.width != 0 || region.height != 0 || region.x_offset != 0 || region.y_offset != 0)) {
    throw std::invalid_argument(
        "roi has no width or no height, but other values; it must have "
        "both, or only zeros");
  }
  if (region.x_offset + std::uint64_t{region.width} > static_cast<std::uint64_t>(camera.width) ||
      region.y_offset + std::uint64_t{region.height} > static_cast<std::uint64_t>(camera.height)) {
    throw std::invalid_argument("roi reaches beyond the image");
  }
  const std::uint32_t bin_u = std::max(1U, region.binning_x);
  const std::uint32_t bin_v = std::max(1U, region.binning_y);
  const std::uint32_t width = cut ? region.width : static_cast<std::uint32_t>(camera.width);
  const std::uint32_t height = cut ? region.height : static_cast<std::uint32_t>(camera.height);
  if (bin_u > width || bin_v > height) {
    throw std::invalid_argument("binning_x is " + std::to_string(bin_u) + ", binning_y " +
                                std::to_string(bin_v) + ": no pixel is left of " +
                                std::to_string(width) + " x " + std::to_string(height));
  }
  camera.width = static_cast<int>(width / bin_u);
  camera.height = static_cast<int>(height / bin_v);
  camera.focal_length /= bin_u;
  camera.aspect_ratio *= static_cast<double>(bin_u) / bin_v;
  camera.skew /= bin_u;
  camera.centre_u = (camera.centre_u - region.x_offset - 0.5 * (bin_u - 1)) / bin_u;
  camera.centre_v = (camera.centre_v - region.y_offset - 0.5 * (bin_v - 1)) / bin_v;
}

}  // namespace pipescout::geometry
