// SPDX-License-Identifier: Apache-2.0
#include "thermal_bodies.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "thermal_background.hpp"

namespace pipescout::simulation::internal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

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

constexpr double kBeyond = 1000;  // m, that a line is followed beyond the tube's ends

Vector3d tube_point(const ThermalScene& scene) {
  return {0, 0, scene.parameters().tube_height};
}

Vector3d place_of(const ThermalEye& eye) {
  return eye.T_camera_row.inverse().translation();
}

/// What a length of the lens's and the pixel's blur is on a pipe, as a box of equal variance
/// together with that of motion.
double whole_blur(const ThermalEye& eye, double motion, double metres_a_pixel) {
  constexpr double kPerVariance = 12;
  const double still = metres_a_pixel * std::sqrt(kPerVariance * eye.lens_blur * eye.lens_blur + 1);
  return std::hypot(motion, still);
}

/// Where on its axis a pipe is blurred as all of it: nearest to the middle of the image.
struct BlurPlace {
  double place = 0;           // m
  double metres_a_pixel = 0;  // along it
};
BlurPlace blur_place(const ThermalEye& eye, const CylinderView& view) {
  const Vector2d centre((eye.width - 1) / 2.0, (eye.height - 1) / 2.0);
  const Vector2d normal = view.axis.head<2>();
  const Vector2d foot = centre - view.axis.dot(centre.homogeneous()) * normal;
  const Vector2d next = foot + Vector2d(-normal.y(), normal.x());
  const double place = view.place_at(foot);
  return {.place = place, .metres_a_pixel = std::abs(view.place_at(next) - place)};
}

/// Places along the row between which there is something to see, from the tube to the mirrors.
struct PlaceRange {
  double least = std::numeric_limits<double>::infinity();
  double most = -std::numeric_limits<double>::infinity();

  [[nodiscard]] bool contains(double place) const { return place > least && place < most; }
};
PlaceRange places_in_view(const ThermalEye& eye) {
  constexpr double kMargin = 1;  // m: half of what is widest
  const Vector3d camera = place_of(eye);
  const auto R_row_camera = eye.T_camera_row.rotation().inverse();
  PlaceRange range;
  for (const double u : {0.0, eye.width - 1.0}) {
    for (const double v : {0.0, eye.height - 1.0}) {
      const Vector3d ray = R_row_camera * (eye.K_inverse * Vector3d(u, v, 1));
      for (const double y : {0.0, kMirrorBehind}) {
        const double along = (y - camera.y()) / ray.y();
        const double place = along > 0 ? camera.x() + along * ray.x() : ray.x() * kBeyond;
        range.least = std::min(range.least, std::max(place, camera.x() - kBeyond) - kMargin);
        range.most = std::max(range.most, std::min(place, camera.x() + kBeyond) + kMargin);
      }
    }
  }
  return range;
}

}  // namespace

ThermalBodies::ThermalBodies(const ThermalScene& scene, const ThermalRadiation& radiation,
                             int height)
    : scene_(scene),
      tube_(scene, radiation),
      painter_(height),
      cold_post_(
          static_cast<float>(radiation.black_body(scene.parameters().ground_temperature + 1))),
      seam_(static_cast<float>(radiation.black_body(scene.parameters().ground_temperature))),
      gap_(static_cast<float>(radiation.black_body(scene.parameters().sky_temperature))) {}

void ThermalBodies::paint(const ThermalEye& eye, CountPlane& plane) {
  paint_mirrors(eye, plane);
  paint_behind(eye, plane);
  paint_tube(eye, plane);
  paint_posts(eye, plane);
}

bool ThermalBodies::is_seen(const ThermalDecoy& decoy, const ThermalEye& eye) {
  return std::abs(place_of(eye).x() - decoy.place) < decoy.reach / 2;
}

float ThermalBodies::counts_of(const ThermalDecoy& decoy) const {
  return tube_.counts(scene_.tube_temperature(decoy.place) + decoy.rise);
}

void ThermalBodies::paint_tube(const ThermalEye& eye, CountPlane& plane) {
  const Vector3d along = Vector3d::UnitX();
  const auto view = view_cylinder(eye, tube_point(scene_), along, scene_.parameters().tube_radius);
  if (!view) {
    return;
  }
  const BlurPlace middle = blur_place(eye, *view);
  const BandBlur blur = band_blur(eye, *view, tube_point(scene_), along, middle.place);
  if (!painter_.see(eye, *view, blur.across)) {
    return;
  }
  const Vector3d place = place_of(eye);
  const double distance = std::hypot(place.y(), place.z() - scene_.parameters().tube_height);
  tube_.sample(painter_.least(), painter_.most(),
               whole_blur(eye, blur.along, middle.metres_a_pixel), place.x(), distance,
               painter_.samples(kTubeSamples));
  painter_.paint(plane);
}

void ThermalBodies::paint_cylinder(const ThermalEye& eye, const Vector3d& from, const Vector3d& to,
                                   double radius, float counts, CountPlane& plane) {
  const double length = (to - from).norm();
  const Vector3d direction = (to - from) / length;
  const auto view = view_cylinder(eye, from, direction, radius);
  if (!view) {
    return;
  }
  const BlurPlace middle = blur_place(eye, *view);
  const BandBlur blur = band_blur(eye, *view, from, direction, middle.place);
  if (!painter_.see(eye, *view, blur.across)) {
    return;
  }
  const double width = whole_blur(eye, blur.along, middle.metres_a_pixel);
  const std::span<BandSample> samples = painter_.samples(kPostSamples);
  const double step =
      (painter_.most() - painter_.least()) / static_cast<double>(samples.size() - 1);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double place = painter_.least() + step * static_cast<double>(i);
    samples[i] = {.counts = counts,
                  .cover = static_cast<float>(box_share(place, width, 0, length))};
  }
  painter_.paint(plane);
}

void ThermalBodies::paint_mirrors(const ThermalEye& eye, CountPlane& plane) {
  const ThermalSceneParameters& p = scene_.parameters();
  const Vector3d foot(0, kMirrorBehind, p.tube_height - kMirrorHalfHeight);
  const Vector3d top(0, kMirrorBehind, p.tube_height + kMirrorHalfHeight);
  const PlaceRange range = places_in_view(eye);
  constexpr int kMostSeams = 40;  // further ones are seen from too far aside to matter
  double place = std::ceil(range.least / kSeamSpacing) * kSeamSpacing;
  for (int i = 0; i < kMostSeams && place < range.most; ++i, place += kSeamSpacing) {
    const Vector3d along(place, 0, 0);
    paint_cylinder(eye, foot + along, top + along, kSeamHalfWidth, seam_, plane);
  }
  for (const double support : scene_.supports()) {
    if (range.contains(support)) {
      const Vector3d along(support, 0, 0);
      paint_cylinder(eye, foot + along, top + along, kGapHalfWidth, gap_, plane);
    }
  }
  const Vector3d image(0, kMirrorImageBehind, p.tube_height + p.mirror_image_offset);
  paint_cylinder(eye, image, image + Vector3d(p.length, 0, 0), kMirrorImageRadius * p.tube_radius,
                 tube_.counts(p.mirror_image), plane);
}

void ThermalBodies::paint_behind(const ThermalEye& eye, CountPlane& plane) {
  const ThermalSceneParameters& p = scene_.parameters();
  for (const ThermalDecoy& decoy : p.decoys) {
    if (decoy.kind == ThermalDecoyKind::kHotBody && is_seen(decoy, eye)) {
      const Vector3d foot(decoy.place, decoy.behind + decoy.size / 2, decoy.foot);
      paint_cylinder(eye, foot, foot + Vector3d(0, 0, decoy.height), decoy.size / 2,
                     counts_of(decoy), plane);
    }
  }
  if (p.swivel_joints) {
    const PlaceRange range = places_in_view(eye);
    for (const double end : {0.0, p.length}) {
      if (!range.contains(end)) {
        continue;
      }
      const float counts = tube_.counts(scene_.tube_temperature(end) - kSwivelCooler);
      paint_cylinder(eye, Vector3d(end, 0, kSwivelFoot), Vector3d(end, 0, p.tube_height),
                     p.tube_radius, counts, plane);
    }
  }
}

void ThermalBodies::paint_posts(const ThermalEye& eye, CountPlane& plane) {
  const ThermalSceneParameters& p = scene_.parameters();
  const auto paint = [&](double at, double width, float counts) {
    paint_cylinder(eye, Vector3d(at, -kSupportBefore, 0),
                   Vector3d(at, -kSupportBefore, p.tube_height + kSupportAbove), width / 2, counts,
                   plane);
  };
  const PlaceRange range = places_in_view(eye);
  for (const double support : scene_.supports()) {
    if (range.contains(support)) {
      paint(support, p.support_width, cold_post_);
    }
  }
  for (const ThermalDecoy& decoy : p.decoys) {
    if (decoy.kind == ThermalDecoyKind::kWarmSupport && is_seen(decoy, eye)) {
      paint(decoy.place, decoy.size, counts_of(decoy));
    }
  }
}

}  // namespace pipescout::simulation::internal
