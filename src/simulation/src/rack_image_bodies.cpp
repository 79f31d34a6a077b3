// SPDX-License-Identifier: Apache-2.0
#include "rack_image_bodies.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace pipescout::simulation::internal {
namespace {

/// Rays this close to parallel to a pipe do not meet its flank within the rack.
constexpr float kLeastAcross = 1e-9F;

}  // namespace

BodiesFromEye::BodiesFromEye(const Bodies& bodies) : bodies_(&bodies) {
  cones_.resize(bodies.cones.size());
  for (const Cone& cone : bodies.cones) {
    const double widest = std::max(cone.radius, cone.radius + cone.slope * cone.length);
    capsules_.push_back({cone.start, cone.length * cone.axis, widest});
  }
  for (const Box& box : bodies.boxes) {
    const Eigen::Vector3d size = box.high - box.low;
    int longest = 0;
    size.maxCoeff(&longest);
    Eigen::Vector3d across = size;
    across[longest] = 0;
    capsules_.push_back({box.low + 0.5 * across, size - across, 0.5 * across.norm()});
  }
  for (const Sheet& sheet : bodies.sheets) {
    const double reach = std::hypot(sheet.half_across, sheet.half_along);
    capsules_.push_back({sheet.centre, Eigen::Vector3d::Zero(), reach});
  }
}

void BodiesFromEye::look_from(const Eigen::Vector3d& eye) {
  eye_ = eye;
  for (std::size_t i = 0; i < cones_.size(); ++i) {
    const Cone& cone = bodies_->cones[i];
    capsules_[i].start = cone.start;
    const Eigen::Vector3d q = eye - cone.start;
    const double along = q.dot(cone.axis);
    const double radius = cone.radius + cone.slope * along;
    const double c = q.squaredNorm() - along * along - radius * radius;
    const Eigen::Vector3f a = cone.axis.cast<float>();
    const Eigen::Vector3f f = q.cast<float>();
    cones_[i] = {.ax = a.x(),
                 .ay = a.y(),
                 .az = a.z(),
                 .qx = f.x(),
                 .qy = f.y(),
                 .qz = f.z(),
                 .along = static_cast<float>(along),
                 .radius = static_cast<float>(radius),
                 .slope = static_cast<float>(cone.slope),
                 .c = static_cast<float>(c),
                 .length = static_cast<float>(cone.length)};
  }
}

bool BodiesFromEye::may_hit(std::size_t body, const RayCone& cone) const noexcept {
  // Along the capsule's axis, distance from the cone's axis minus the cone's radius is a convex
  // function: its least value has a closed form.
  const Capsule& capsule = capsules_[body];
  const Eigen::Vector3d w = capsule.start - eye_;
  const double depth = w.dot(cone.axis);
  const double deeper = capsule.extent.dot(cone.axis);
  const Eigen::Vector3d beside = w - depth * cone.axis;
  const Eigen::Vector3d sideways = capsule.extent - deeper * cone.axis;
  const double a = sideways.squaredNorm();
  const double k = deeper * cone.tangent;
  double s = k > 0 ? 1.0 : 0.0;
  if (a > k * k) {
    const double nearest = -beside.dot(sideways) / a;
    const double h2 = std::max(0.0, beside.squaredNorm() - a * nearest * nearest);
    s = std::clamp(nearest + k * std::sqrt(h2 / (a * (a - k * k))), 0.0, 1.0);
  }
  const double distance = (beside + s * sideways).norm() - (depth + s * deeper) * cone.tangent;
  return distance <= capsule.radius * std::sqrt(1 + cone.tangent * cone.tangent) + 1e-6;
}

void BodiesFromEye::trace_ground(RayBatch& batch) const noexcept {
  constexpr float kFarthest = 500;  // m; beyond, ground and sky are one haze
  const auto below = static_cast<float>(bodies_->ground_height - eye_.z());
  for (std::size_t i = 0; i < batch.count; ++i) {
    const float t = below / batch.dz[i];
    const bool hit = t > 0 && t < kFarthest;
    batch.t[i] = hit ? t : kFarthest;
    batch.code[i] = hit ? kGround : kSky;
  }
}

void BodiesFromEye::trace(std::size_t body, RayBatch& batch) const noexcept {
  const std::size_t cones = bodies_->cones.size();
  const std::size_t boxes = bodies_->boxes.size();
  if (body < cones) {
    trace_cone(body, batch);
  } else if (body < cones + boxes) {
    trace_box(body - cones, batch);
  } else {
    trace_sheet(body - cones - boxes, batch);
  }
}

void BodiesFromEye::trace_cone(std::size_t cone, RayBatch& batch) const noexcept {
  const ConeConstants c = cones_[cone];
  const auto code = static_cast<HitCode>(cone);
  const float stretch = 1 + c.slope * c.slope;
  for (std::size_t i = 0; i < batch.count; ++i) {
    const float x = batch.dx[i];
    const float y = batch.dy[i];
    const float z = batch.dz[i];
    const float da = x * c.ax + y * c.ay + z * c.az;
    const float a = x * x + y * y + z * z - stretch * da * da;
    const float b = x * c.qx + y * c.qy + z * c.qz - da * (c.along + c.slope * c.radius);
    const float discriminant = b * b - a * c.c;
    const float root = std::sqrt(discriminant > 0 ? discriminant : 0.0F);
    const float t = (-b - root) / (a > kLeastAcross ? a : kLeastAcross);
    const float along = c.along + t * da;
    const bool hit = (discriminant > 0) & (a > kLeastAcross) & (t > 0) & (along >= 0) &
                     (along <= c.length) & (t < batch.t[i]);
    batch.t[i] = hit ? t : batch.t[i];
    batch.code[i] = hit ? code : batch.code[i];
  }
  // Only one of the flat ends can face the eye.
  const bool before = c.along < 0;
  if (!before && c.along <= c.length) {
    return;
  }
  const float place = before ? 0.0F : c.length;
  const float ahead = place - c.along;
  const float radius = c.radius + c.slope * ahead;
  const float limit = radius * radius;
  const HitCode end_code = code | ((before ? 1 : 2) << kFaceShift);
  for (std::size_t i = 0; i < batch.count; ++i) {
    const float x = batch.dx[i];
    const float y = batch.dy[i];
    const float z = batch.dz[i];
    const float t = ahead / (x * c.ax + y * c.ay + z * c.az);
    const float wx = c.qx + t * x - place * c.ax;
    const float wy = c.qy + t * y - place * c.ay;
    const float wz = c.qz + t * z - place * c.az;
    const bool hit = (t > 0) & (wx * wx + wy * wy + wz * wz <= limit) & (t < batch.t[i]);
    batch.t[i] = hit ? t : batch.t[i];
    batch.code[i] = hit ? end_code : batch.code[i];
  }
}

void BodiesFromEye::trace_box(std::size_t box, RayBatch& batch) const noexcept {
  const Box& b = bodies_->boxes[box];
  const Eigen::Vector3f low = (b.low - eye_).cast<float>();
  const Eigen::Vector3f high = (b.high - eye_).cast<float>();
  const auto code = static_cast<HitCode>(bodies_->cones.size() + box);
  for (std::size_t i = 0; i < batch.count; ++i) {
    const float ix = 1 / batch.dx[i];
    const float iy = 1 / batch.dy[i];
    const float iz = 1 / batch.dz[i];
    const float x0 = low.x() * ix;
    const float x1 = high.x() * ix;
    const float y0 = low.y() * iy;
    const float y1 = high.y() * iy;
    const float z0 = low.z() * iz;
    const float z1 = high.z() * iz;
    const float near_x = x0 < x1 ? x0 : x1;
    const float near_y = y0 < y1 ? y0 : y1;
    const float near_z = z0 < z1 ? z0 : z1;
    const float far_x = x0 < x1 ? x1 : x0;
    const float far_y = y0 < y1 ? y1 : y0;
    const float far_z = z0 < z1 ? z1 : z0;
    const float near_xy = near_x > near_y ? near_x : near_y;
    const float enter = near_xy > near_z ? near_xy : near_z;
    const float far_xy = far_x < far_y ? far_x : far_y;
    const float leave = far_xy < far_z ? far_xy : far_z;
    const HitCode face_xy = near_x > near_y ? 0 : (1 << kFaceShift);
    const HitCode face = near_xy > near_z ? face_xy : (2 << kFaceShift);
    const bool hit = (enter <= leave) & (enter > 0) & (enter < batch.t[i]);
    batch.t[i] = hit ? enter : batch.t[i];
    batch.code[i] = hit ? (code | face) : batch.code[i];
  }
}

void BodiesFromEye::trace_sheet(std::size_t sheet, RayBatch& batch) const noexcept {
  const Sheet& s = bodies_->sheets[sheet];
  const Eigen::Vector3f centre = (s.centre - eye_).cast<float>();
  const auto cosine = static_cast<float>(s.cosine);
  const auto sine = static_cast<float>(s.sine);
  const auto across = static_cast<float>(s.half_across);
  const auto along = static_cast<float>(s.half_along);
  const float arcs = 3 / along;
  const auto code = static_cast<HitCode>(bodies_->cones.size() + bodies_->boxes.size() + sheet);
  for (std::size_t i = 0; i < batch.count; ++i) {
    const float t = centre.z() / batch.dz[i];
    const float x = t * batch.dx[i] - centre.x();
    const float y = t * batch.dy[i] - centre.y();
    const float u = std::abs(cosine * x + sine * y);
    const float v = cosine * y - sine * x;
    // Position within an arc, -1 to 1; the cast rounds towards zero, so it starts from positive.
    const float arc = (v + along) * arcs + 8;
    const float within = 2 * (arc - static_cast<float>(static_cast<int>(arc))) - 1;
    const float edge = across - s.scallop * within * within;
    const bool hit = (t > 0) & (u < edge) & (std::abs(v) < along) & (t < batch.t[i]);
    batch.t[i] = hit ? t : batch.t[i];
    batch.code[i] = hit ? code : batch.code[i];
  }
}

}  // namespace pipescout::simulation::internal
