// SPDX-License-Identifier: Apache-2.0
#include "thermal_sensor.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "pipescout/statistics/draw.hpp"

namespace pipescout::simulation::internal {
namespace {

constexpr std::size_t kNormals = std::size_t{1} << 18U;
constexpr double kNetdTemperature = 30;  // degC

}  // namespace

ThermalSensor::ThermalSensor(const ThermalCameraParameters& parameters,
                             const ThermalRadiation& radiation, float highest)
    : seed_(parameters.seed), highest_(highest) {
  const auto width = static_cast<std::size_t>(parameters.camera.width);
  const auto height = static_cast<std::size_t>(parameters.camera.height);
  deviation_ = static_cast<float>(parameters.netd * radiation.slope(kNetdTemperature));
  std::mt19937_64 engine = statistics::make_engine(seed_, 0x7c);
  normals_.resize(kNormals + width);
  for (std::size_t i = 0; i < kNormals; ++i) {
    normals_[i] = static_cast<float>(statistics::normal(engine));
  }
  // A row may begin anywhere in the table.
  std::copy_n(normals_.begin(), width, normals_.begin() + kNormals);

  // Half of its variance is that of columns.
  const auto fixed =
      deviation_ * static_cast<float>(parameters.fixed_pattern / std::numbers::sqrt2);
  std::vector<float> columns(width);
  std::ranges::generate(columns,
                        [&] { return fixed * static_cast<float>(statistics::normal(engine)); });
  pattern_.resize(width * height);
  for (std::size_t i = 0; i < pattern_.size(); ++i) {
    pattern_[i] = columns[i % width] + fixed * static_cast<float>(statistics::normal(engine));
  }
  const auto dead = static_cast<std::size_t>(
      std::lround(parameters.dead_share * static_cast<double>(pattern_.size())));
  for (std::size_t i = 0; i < dead; ++i) {
    DeadPixel pixel;
    pixel.index = static_cast<std::size_t>(statistics::uniform(engine) *
                                           static_cast<double>(pattern_.size()));
    // As often black as bright.
    const double shown =
        statistics::uniform(engine) < 0.5 ? 0 : statistics::uniform(engine, 0.8, 1);
    pixel.counts = static_cast<std::uint16_t>(shown * static_cast<double>(highest));
    dead_.push_back(pixel);
  }
}

void ThermalSensor::read(CountPlane& plane, std::uint64_t frame, std::span<const HotSquare> hot,
                         std::span<std::uint16_t> counts) const noexcept {
  for (const HotSquare& square : hot) {
    for (int y = std::max(0, square.y); y < std::min(plane.height, square.y + square.size); ++y) {
      for (int x = std::max(0, square.x); x < std::min(plane.width, square.x + square.size); ++x) {
        plane.row(y)[x] = std::max(plane.row(y)[x], square.counts);
      }
    }
  }
  // One word of seed, unlike make_engine: that one allocates.
  std::mt19937_64 engine(seed_ * 0x9e3779b97f4a7c15U + frame);
  for (int y = 0; y < plane.height; ++y) {
    const float* in = plane.row(y);
    const float* normals = normals_.data() + (engine() & (kNormals - 1));
    const std::ptrdiff_t begin = static_cast<std::ptrdiff_t>(y) * plane.width;
    const float* pattern = pattern_.data() + begin;
    std::uint16_t* out = counts.data() + begin;
    for (int x = 0; x < plane.width; ++x) {
      const float level = in[x] + pattern[x] + deviation_ * normals[x] + 0.5F;
      const float above = level > 0 ? level : 0.0F;
      out[x] = static_cast<std::uint16_t>(static_cast<int>(above < highest_ ? above : highest_));
    }
  }
  for (const DeadPixel& pixel : dead_) {
    counts[pixel.index] = pixel.counts;
  }
}

}  // namespace pipescout::simulation::internal
