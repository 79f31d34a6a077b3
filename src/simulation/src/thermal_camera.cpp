// SPDX-License-Identifier: Apache-2.0
#include "pipescout/simulation/thermal_camera.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

#include "pipescout/validation/check.hpp"
#include "pipescout/validation/number_text.hpp"
#include "thermal_background.hpp"
#include "thermal_band.hpp"
#include "thermal_bodies.hpp"
#include "thermal_radiation.hpp"
#include "thermal_sensor.hpp"

namespace pipescout::simulation {
namespace {

using Eigen::Vector3d;
using internal::CylinderView;

ThermalCameraParameters of_size(int width, int height) {
  constexpr double kHalfWidth = 12.5 * std::numbers::pi / 180;
  ThermalCameraParameters result;
  result.constants = simulated_thermal_constants();
  result.camera.width = width;
  result.camera.height = height;
  result.camera.focal_length = width / 2.0 / std::tan(kHalfWidth);
  result.camera.centre_u = (width - 1) / 2.0;
  result.camera.centre_v = (height - 1) / 2.0;
  return result;
}

}  // namespace

thermal::CameraConstants simulated_thermal_constants() noexcept {
  return {.planck = {.r1 = 21106.77, .r2 = 0.012545258, .b = 1501, .f = 1, .o = -7340}};
}

ThermalCameraParameters ThermalCameraParameters::qvga() {
  return of_size(320, 240);
}

ThermalCameraParameters ThermalCameraParameters::vga() {
  return of_size(640, 512);
}

void ThermalCameraParameters::validate() const {
  using validation::check_above;
  using validation::check_within;
  camera.validate();
  if (camera.skew != 0 || geometry::Camera(camera).has_distortion()) {
    throw std::invalid_argument("camera: skew and distortion must be 0: images are rectified");
  }
  constants.validate();
  check_within("netd", netd, 0, 5);
  check_within("fixed_pattern", fixed_pattern, 0, 10);
  check_within("exposure", exposure, 0, 0.1);
  check_within("lens_blur", lens_blur, 0, 5);
  check_within("dead_share", dead_share, 0, 0.2);
  check_above("highest", highest, -200, 3000);
}

class ThermalRenderer::Implementation {
 public:
  Implementation(const ThermalScene& scene, const ThermalCameraParameters& parameters)
      : parameters_(checked(parameters)),
        scene_(scene),
        camera_(parameters.camera),
        radiation_(parameters.constants, scene.parameters().object),
        highest_(static_cast<std::uint16_t>(
            std::clamp(std::lround(radiation_.object(parameters.highest)), 0L, 65535L))),
        bodies_(scene_, radiation_, parameters.camera.height),
        background_(scene.parameters(), radiation_, parameters.camera.width),
        sensor_(parameters, radiation_, static_cast<float>(highest_)) {
    plane_.width = parameters.camera.width;
    plane_.height = parameters.camera.height;
    plane_.values.resize(static_cast<std::size_t>(plane_.width) *
                         static_cast<std::size_t>(plane_.height));
    hot_.reserve(scene.parameters().decoys.size());
  }

  void render(const ThermalView& view, std::span<std::uint16_t> counts) {
    if (counts.size() != plane_.values.size()) {
      throw std::invalid_argument("counts: " + std::to_string(counts.size()) + " pixels: must be " +
                                  std::to_string(plane_.values.size()));
    }
    if (!view.velocity.allFinite()) {
      throw std::invalid_argument("velocity: not finite");
    }
    const internal::ThermalEye eye = eye_of(view);
    background_.paint(eye, plane_);
    if (scene_.faces(view.T_map_camera.translation())) {
      bodies_.paint(eye, plane_);
    }
    find_hot_pixels(eye);
    sensor_.read(plane_, view.frame, hot_, counts);
  }

  void truth(const ThermalView& view, ThermalTruth& truth) const {
    const ThermalSceneParameters& p = scene_.parameters();
    const internal::ThermalEye eye = eye_of(view);
    const auto cylinder =
        internal::view_cylinder(eye, tube_point(), Vector3d::UnitX(), p.tube_radius);
    truth.tube.reset();
    truth.leaks.clear();
    if (!cylinder || !scene_.faces(view.T_map_camera.translation())) {
      return;
    }
    if (const auto seen = stretch(eye, *cylinder, 0, p.length)) {
      truth.tube = seen->stretch;
    }
    for (std::size_t i = 0; i < p.leaks.size(); ++i) {
      const ThermalLeak& leak = p.leaks[i];
      if (auto seen =
              stretch(eye, *cylinder, leak.place - leak.length / 2, leak.place + leak.length / 2)) {
        seen->leak = i;
        truth.leaks.push_back(*seen);
      }
    }
  }

  [[nodiscard]] const geometry::Camera& camera() const noexcept { return camera_; }
  [[nodiscard]] double counts(double temperature) const noexcept {
    return radiation_.object(temperature);
  }
  [[nodiscard]] std::uint16_t highest() const noexcept { return highest_; }

 private:
  static const ThermalCameraParameters& checked(const ThermalCameraParameters& parameters) {
    parameters.validate();
    return parameters;
  }

  [[nodiscard]] Vector3d tube_point() const { return {0, 0, scene_.parameters().tube_height}; }

  [[nodiscard]] internal::ThermalEye eye_of(const ThermalView& view) const {
    return {.T_camera_row = view.T_map_camera.inverse() * scene_.parameters().T_map_row,
            .velocity = view.velocity,
            .K = camera_.matrix(),
            .K_inverse = camera_.inverse_matrix(),
            .exposure = parameters_.exposure,
            .lens_blur = parameters_.lens_blur,
            .width = plane_.width,
            .height = plane_.height};
  }

  std::optional<LeakInImage> stretch(const internal::ThermalEye& eye, const CylinderView& cylinder,
                                     double from, double to) const {
    const auto axis = internal::axis_in_image(eye, tube_point(), Vector3d::UnitX(), from, to);
    if (!axis) {
      return std::nullopt;
    }
    LeakInImage seen;
    seen.whole = axis->whole;
    seen.stretch = {.from = axis->from,
                    .to = axis->to,
                    .from_place = cylinder.place_at(axis->from),
                    .to_place = cylinder.place_at(axis->to),
                    .width = cylinder.width_at((axis->from + axis->to) / 2)};
    return seen;
  }

  void find_hot_pixels(const internal::ThermalEye& eye) {
    hot_.clear();
    for (const ThermalDecoy& decoy : scene_.parameters().decoys) {
      if (decoy.kind == ThermalDecoyKind::kHotPixels && bodies_.is_seen(decoy, eye)) {
        hot_.push_back({.x = static_cast<int>(decoy.pixel.x() * (plane_.width - 1)),
                        .y = static_cast<int>(decoy.pixel.y() * (plane_.height - 1)),
                        .size = static_cast<int>(decoy.size),
                        .counts = bodies_.counts_of(decoy)});
      }
    }
  }

  ThermalCameraParameters parameters_;
  ThermalScene scene_;
  geometry::Camera camera_;
  internal::ThermalRadiation radiation_;
  std::uint16_t highest_;
  internal::ThermalBodies bodies_;
  internal::ThermalBackground background_;
  internal::ThermalSensor sensor_;
  internal::CountPlane plane_;
  std::vector<internal::HotSquare> hot_;
};

ThermalRenderer::ThermalRenderer(const ThermalScene& scene, const ThermalCameraParameters& camera)
    : implementation_(std::make_unique<Implementation>(scene, camera)) {}
ThermalRenderer::ThermalRenderer(ThermalRenderer&&) noexcept = default;
ThermalRenderer& ThermalRenderer::operator=(ThermalRenderer&&) noexcept = default;
ThermalRenderer::~ThermalRenderer() = default;

void ThermalRenderer::render(const ThermalView& view, std::span<std::uint16_t> counts) {
  implementation_->render(view, counts);
}

void ThermalRenderer::truth(const ThermalView& view, ThermalTruth& truth) const {
  implementation_->truth(view, truth);
}

const geometry::Camera& ThermalRenderer::camera() const noexcept {
  return implementation_->camera();
}

double ThermalRenderer::counts(double temperature) const noexcept {
  return implementation_->counts(temperature);
}

std::uint16_t ThermalRenderer::highest_counts() const noexcept {
  return implementation_->highest();
}

ThermalGreys::ThermalGreys(const thermal::Radiometry& radiometry, double lowest, double highest) {
  if (!(lowest < highest)) {
    throw std::invalid_argument("lowest: " + validation::number_text(lowest) +
                                " is not below highest, " + validation::number_text(highest));
  }
  constexpr std::size_t kCounts = 65536;
  constexpr double kLevels = 255;
  levels_.resize(kCounts);
  for (std::size_t i = 0; i < kCounts; ++i) {
    const double temperature = radiometry.temperature(static_cast<double>(i));
    const double level = kLevels * (temperature - lowest) / (highest - lowest);
    // Written so that NaN is black.
    levels_[i] = static_cast<std::uint8_t>(level > 0 ? std::lround(std::min(level, kLevels)) : 0);
  }
}

void ThermalGreys::convert(std::span<const std::uint16_t> counts,
                           std::span<std::uint8_t> greys) const {
  if (counts.size() != greys.size()) {
    throw std::invalid_argument("greys: " + std::to_string(greys.size()) + " pixels: must be " +
                                std::to_string(counts.size()));
  }
  std::ranges::transform(counts, greys.begin(),
                         [this](std::uint16_t each) { return levels_[each]; });
}

void ThermalAutomaticGain::convert(std::span<const std::uint16_t> counts,
                                   std::span<std::uint8_t> greys) {
  if (counts.empty() || counts.size() != greys.size()) {
    throw std::invalid_argument("greys: " + std::to_string(greys.size()) + " pixels: must be " +
                                std::to_string(counts.size()) + ", and some");
  }
  sorted_.assign(counts.begin(), counts.end());
  const auto clipped = static_cast<std::ptrdiff_t>(kClipped * static_cast<double>(counts.size()));
  const auto low = sorted_.begin() + clipped;
  std::nth_element(sorted_.begin(), low, sorted_.end());
  const double darkest = *low;  // the next call moves it
  const auto high = sorted_.end() - 1 - clipped;
  std::nth_element(low, high, sorted_.end());
  const double follow = begun_ ? kFollow : 1;
  low_ += follow * (darkest - low_);
  high_ += follow * (*high - high_);
  begun_ = true;
  constexpr double kLevels = 255;
  const double gain = kLevels / std::max(high_ - low_, 1.0);
  std::ranges::transform(counts, greys.begin(), [&](std::uint16_t each) {
    return static_cast<std::uint8_t>(std::lround(std::clamp(gain * (each - low_), 0.0, kLevels)));
  });
}

}  // namespace pipescout::simulation
