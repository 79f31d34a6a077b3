// SPDX-License-Identifier: Apache-2.0
#include "pipescout/simulation/thermal_camera.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "check.hpp"
#include "thermal_background.hpp"
#include "thermal_band.hpp"
#include "thermal_sensor.hpp"
#include "thermal_tube.hpp"

namespace pipescout::simulation {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using internal::BandSample;
using internal::CylinderView;

constexpr std::size_t kTubeSamples = 2048;
constexpr std::size_t kPostSamples = 1024;
constexpr double kMirrorImageRadius = 0.8;  // of the tube's
constexpr double kMirrorImageBehind = 0.6;  // m
constexpr double kSeamSpacing = 1.7;        // m, of mirrors
constexpr double kSeamHalfWidth = 0.012;    // m
constexpr double kGapHalfWidth = 0.08;      // m, of the mirrors where there is a post
constexpr double kSupportBefore = 0.12;     // m, before the tube
constexpr double kSupportAbove = 0.3;       // m, above the tube
constexpr double kSwivelFoot = 0.4;         // m, height at which the pipe from a swivel joint ends
constexpr double kSwivelCooler = 8;         // K, than the tube

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
  using internal::check_above;
  using internal::check_within;
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
        radiometry_(parameters.constants, scene.parameters().object),
        highest_(static_cast<std::uint16_t>(
            std::clamp(std::lround(radiometry_.counts(parameters.highest)), 0L, 65535L))),
        tube_(scene_, radiometry_),
        background_(scene.parameters(), parameters.constants.planck, parameters.camera.width),
        sensor_(parameters, static_cast<float>(highest_)),
        painter_(parameters.camera.height) {
    plane_.width = parameters.camera.width;
    plane_.height = parameters.camera.height;
    plane_.values.resize(static_cast<std::size_t>(plane_.width) *
                         static_cast<std::size_t>(plane_.height));
    hot_.reserve(scene.parameters().decoys.size());
    const thermal::PlanckConstants& planck = parameters.constants.planck;
    cold_post_ = static_cast<float>(planck.counts(scene.parameters().ground_temperature + 1));
    seam_ = static_cast<float>(planck.counts(scene.parameters().ground_temperature));
    gap_ = static_cast<float>(planck.counts(scene.parameters().sky_temperature));
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
    const Vector3d place = eye.T_camera_row.inverse().translation();
    background_.paint(eye, plane_);
    paint_mirrors(eye);
    paint_behind(eye, place);
    paint_tube(eye, place);
    paint_posts(eye, place);
    find_hot_pixels(place);
    sensor_.read(plane_, view.frame, hot_, counts);
  }

  void truth(const ThermalView& view, ThermalTruth& truth) const {
    const ThermalSceneParameters& p = scene_.parameters();
    const internal::ThermalEye eye = eye_of(view);
    const auto cylinder =
        internal::view_cylinder(eye, tube_point(), Vector3d::UnitX(), p.tube_radius);
    truth.tube.reset();
    truth.leaks.clear();
    if (!cylinder) {
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
  [[nodiscard]] const thermal::Radiometry& radiometry() const noexcept { return radiometry_; }
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

  /// What a length of the lens's and the pixel's blur is on a pipe, as a box of equal variance
  /// together with that of motion.
  static double whole_blur(const internal::ThermalEye& eye, double motion, double metres_a_pixel) {
    constexpr double kPerVariance = 12;
    const double still =
        metres_a_pixel * std::sqrt(kPerVariance * eye.lens_blur * eye.lens_blur + 1);
    return std::hypot(motion, still);
  }

  void paint_tube(const internal::ThermalEye& eye, const Vector3d& place) {
    const Vector3d along = Vector3d::UnitX();
    const auto view =
        internal::view_cylinder(eye, tube_point(), along, scene_.parameters().tube_radius);
    const auto axis = internal::axis_in_image(eye, tube_point(), along, -kBeyond,
                                              scene_.parameters().length + kBeyond);
    if (!view || !axis) {
      return;
    }
    const Vector2d middle = (axis->from + axis->to) / 2;
    const internal::BandBlur blur =
        internal::band_blur(eye, *view, tube_point(), along, view->place_at(middle));
    if (!painter_.see(eye, *view, blur.across)) {
      return;
    }
    const double length = std::max(1.0, (axis->to - axis->from).norm());
    const double metres_a_pixel = (view->place_at(axis->to) - view->place_at(axis->from)) / length;
    const double distance = std::hypot(place.y(), place.z() - scene_.parameters().tube_height);
    tube_.sample(painter_.least(), painter_.most(), whole_blur(eye, blur.along, metres_a_pixel),
                 place.x(), distance, painter_.samples(kTubeSamples));
    painter_.paint(plane_);
  }

  /// A straight cylinder that looks the same all along, from `from` on its axis to `to`.
  void paint_cylinder(const internal::ThermalEye& eye, const Vector3d& from, const Vector3d& to,
                      double radius, float counts) {
    const double length = (to - from).norm();
    const Vector3d direction = (to - from) / length;
    // Most of them are out of view: found out before anything else.
    const auto axis = internal::axis_in_image(eye, from, direction, -radius, length + radius);
    const auto view = internal::view_cylinder(eye, from, direction, radius);
    if (!view || !(axis || is_near(eye, from, to, radius))) {
      return;
    }
    const double middle = axis ? view->place_at((axis->from + axis->to) / 2) : length / 2;
    const internal::BandBlur blur = internal::band_blur(eye, *view, from, direction, middle);
    if (!painter_.see(eye, *view, blur.across)) {
      return;
    }
    const double metres_a_pixel =
        (eye.T_camera_row * (from + middle * direction)).norm() / eye.K(0, 0);
    const double width = whole_blur(eye, blur.along, metres_a_pixel);
    const std::span<BandSample> samples = painter_.samples(kPostSamples);
    const double step =
        (painter_.most() - painter_.least()) / static_cast<double>(samples.size() - 1);
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const double place = painter_.least() + step * static_cast<double>(i);
      samples[i] = {.counts = counts,
                    .cover = static_cast<float>(internal::box_share(place, width, 0, length))};
    }
    painter_.paint(plane_);
  }

  /// Whether a cylinder whose axis is beside the image may reach into it.
  [[nodiscard]] bool is_near(const internal::ThermalEye& eye, const Vector3d& from,
                             const Vector3d& to, double radius) const {
    const Vector3d a = eye.T_camera_row * from;
    const Vector3d b = eye.T_camera_row * to;
    if (std::min(a.z(), b.z()) <= radius) {
      return false;
    }
    const Vector2d first = (eye.K * a).hnormalized();
    const Vector2d last = (eye.K * b).hnormalized();
    const double reach = 2 + 1.5 * radius * eye.K(0, 0) / std::min(a.z(), b.z());
    const Vector2d least = first.cwiseMin(last);
    const Vector2d most = first.cwiseMax(last);
    return least.x() < eye.width + reach && most.x() > -reach && least.y() < eye.height + reach &&
           most.y() > -reach;
  }

  void paint_mirrors(const internal::ThermalEye& eye) {
    const ThermalSceneParameters& p = scene_.parameters();
    const Vector3d foot(0, internal::kMirrorBehind, p.tube_height - internal::kMirrorHalfHeight);
    const Vector3d top(0, internal::kMirrorBehind, p.tube_height + internal::kMirrorHalfHeight);
    const auto seen =
        internal::axis_in_image(eye, Vector3d(0, internal::kMirrorBehind, p.tube_height),
                                Vector3d::UnitX(), -kBeyond, p.length + kBeyond);
    if (!seen) {
      return;
    }
    const auto view = internal::view_cylinder(
        eye, Vector3d(0, internal::kMirrorBehind, p.tube_height), Vector3d::UnitX(), 0.01);
    if (!view) {
      return;
    }
    constexpr int kMostSeams = 40;  // further ones are seen from too far aside to matter
    const double least = view->place_at(seen->from);
    const double most = view->place_at(seen->to);
    double place = std::ceil((least - 1) / kSeamSpacing) * kSeamSpacing;
    for (int i = 0; i < kMostSeams && place < most + 1; ++i, place += kSeamSpacing) {
      const Vector3d along(place, 0, 0);
      paint_cylinder(eye, foot + along, top + along, kSeamHalfWidth, seam_);
    }
    for (const double support : scene_.supports()) {
      if (support > least - 1 && support < most + 1) {
        const Vector3d along(support, 0, 0);
        paint_cylinder(eye, foot + along, top + along, kGapHalfWidth, gap_);
      }
    }
    const Vector3d image(0, kMirrorImageBehind, p.tube_height + p.mirror_image_offset);
    paint_cylinder(eye, image, image + Vector3d(p.length, 0, 0), kMirrorImageRadius * p.tube_radius,
                   tube_.counts(p.mirror_image));
  }

  [[nodiscard]] static bool is_seen(const ThermalDecoy& decoy, const Vector3d& place) {
    return std::abs(place.x() - decoy.place) < decoy.reach / 2;
  }

  [[nodiscard]] float counts_of(const ThermalDecoy& decoy) const {
    return tube_.counts(scene_.tube_temperature(decoy.place) + decoy.rise);
  }

  void paint_behind(const internal::ThermalEye& eye, const Vector3d& place) {
    const ThermalSceneParameters& p = scene_.parameters();
    for (const ThermalDecoy& decoy : p.decoys) {
      if (decoy.kind == ThermalDecoyKind::kHotBody && is_seen(decoy, place)) {
        const Vector3d foot(decoy.place, decoy.behind + decoy.size / 2, decoy.foot);
        paint_cylinder(eye, foot, foot + Vector3d(0, 0, decoy.height), decoy.size / 2,
                       counts_of(decoy));
      }
    }
    if (p.swivel_joints) {
      for (const double end : {0.0, p.length}) {
        const float counts = tube_.counts(scene_.tube_temperature(end) - kSwivelCooler);
        paint_cylinder(eye, Vector3d(end, 0, kSwivelFoot), Vector3d(end, 0, p.tube_height),
                       p.tube_radius, counts);
      }
    }
  }

  void paint_posts(const internal::ThermalEye& eye, const Vector3d& place) {
    const ThermalSceneParameters& p = scene_.parameters();
    const auto paint = [&](double at, double width, float counts) {
      paint_cylinder(eye, Vector3d(at, -kSupportBefore, 0),
                     Vector3d(at, -kSupportBefore, p.tube_height + kSupportAbove), width / 2,
                     counts);
    };
    for (const double support : scene_.supports()) {
      paint(support, p.support_width, cold_post_);
    }
    for (const ThermalDecoy& decoy : p.decoys) {
      if (decoy.kind == ThermalDecoyKind::kWarmSupport && is_seen(decoy, place)) {
        paint(decoy.place, decoy.size, counts_of(decoy));
      }
    }
  }

  void find_hot_pixels(const Vector3d& place) {
    hot_.clear();
    for (const ThermalDecoy& decoy : scene_.parameters().decoys) {
      if (decoy.kind == ThermalDecoyKind::kHotPixels && is_seen(decoy, place)) {
        hot_.push_back({.x = static_cast<int>(decoy.pixel.x() * (plane_.width - 1)),
                        .y = static_cast<int>(decoy.pixel.y() * (plane_.height - 1)),
                        .size = static_cast<int>(decoy.size),
                        .counts = counts_of(decoy)});
      }
    }
  }

  static constexpr double kBeyond = 1000;  // m

  ThermalCameraParameters parameters_;
  ThermalScene scene_;
  geometry::Camera camera_;
  thermal::Radiometry radiometry_;
  std::uint16_t highest_;
  internal::ThermalTube tube_;
  internal::ThermalBackground background_;
  internal::ThermalSensor sensor_;
  internal::BandPainter painter_;
  internal::CountPlane plane_;
  std::vector<internal::HotSquare> hot_;
  float cold_post_ = 0;
  float seam_ = 0;
  float gap_ = 0;
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

const thermal::Radiometry& ThermalRenderer::radiometry() const noexcept {
  return implementation_->radiometry();
}

std::uint16_t ThermalRenderer::highest_counts() const noexcept {
  return implementation_->highest();
}

ThermalGreys::ThermalGreys(const thermal::Radiometry& radiometry, double lowest, double highest) {
  if (!(lowest < highest)) {
    throw std::invalid_argument("lowest: " + std::to_string(lowest) + " is not below highest, " +
                                std::to_string(highest));
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

}  // namespace pipescout::simulation
