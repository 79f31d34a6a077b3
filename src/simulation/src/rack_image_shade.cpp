// SPDX-License-Identifier: Apache-2.0
#include "rack_image_shade.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "rack_texture_bake.hpp"

namespace pipescout::simulation::internal {
namespace {

constexpr float kSunWidth = 0.0093F;  // rad, across the disc of the sun
constexpr float kSkyRadiance = 0.9F;
/// A pipe hides sky from points nearer than this many radii to its axis.
constexpr float kSkyReach = 6;

/// Angle of (x, y) in turns, [-0.5, 0.5], right to 2e-5: the texture is stretched by as much,
/// always in the same way.
float turns(float y, float x) {
  const float ax = std::abs(x);
  const float ay = std::abs(y);
  const float large = std::max(std::max(ax, ay), 1e-12F);
  const float ratio = std::min(ax, ay) / large;
  const float s = ratio * ratio;
  float angle = ((-0.0464964749F * s + 0.15931422F) * s - 0.327622764F) * s * ratio + ratio;
  angle *= 0.5F * std::numbers::inv_pi_v<float>;
  angle = ay > ax ? 0.25F - angle : angle;
  angle = x < 0 ? 0.5F - angle : angle;
  return y < 0 ? -angle : angle;
}

}  // namespace

Shader::Shader(const Bodies& bodies, const Wardrobe& wardrobe, bool shadows)
    : bodies_(&bodies), wardrobe_(&wardrobe), shadows_(shadows) {
  casters_.resize(bodies.cones.size());
  for (const Cone& cone : bodies.cones) {
    // Around the axis, from as much up as can be.
    const Eigen::Vector3d hint =
        std::abs(cone.axis.z()) < 0.9 ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d::UnitX();
    const Eigen::Vector3d up = (hint - hint.dot(cone.axis) * cone.axis).normalized();
    flanks_.push_back(
        {.start = cone.start.cast<float>(),
         .axis = cone.axis.cast<float>(),
         .up = up.cast<float>(),
         .side = cone.axis.cross(up).cast<float>(),
         .radius = static_cast<float>(cone.radius),
         .per_radius = static_cast<float>(1 / cone.radius),
         .slope = static_cast<float>(cone.slope),
         .normal_scale = static_cast<float>(1 / std::sqrt(1 + cone.slope * cone.slope)),
         .albedo = cone.albedo,
         .gloss = cone.gloss,
         .map =
             cone.texture < 0 ? nullptr : &wardrobe.pipes[static_cast<std::size_t>(cone.texture)],
         .texture_along = static_cast<float>(cone.texture_along),
         .per_metre = static_cast<float>(1 / cone.texture_step)});
  }
}

void Shader::prepare(const RackLight& light, double pixel_angle) {
  to_sun_ = light.to_sun.cast<float>();
  sun_ = static_cast<float>(light.sun);
  sky_ = static_cast<float>(light.sky);
  pixel_angle_ = static_cast<float>(pixel_angle);
  for (std::size_t i = 0; i < casters_.size(); ++i) {
    const Cone& cone = bodies_->cones[i];
    Caster& caster = casters_[i];
    caster.axis = cone.axis.cast<float>();
    caster.start = cone.start.cast<float>();
    flanks_[i].start = caster.start;  // people move
    caster.length = static_cast<float>(cone.length);
    caster.radius = static_cast<float>(cone.radius);
    caster.slope = static_cast<float>(cone.slope);
    // p - start = along axis - behind to_sun + beside normal, solved for the three.
    const double c = cone.axis.dot(light.to_sun);
    const double squared_sine = 1 - c * c;
    caster.shadow = squared_sine > 1e-6;
    if (caster.shadow) {
      caster.along = ((cone.axis - c * light.to_sun) / squared_sine).cast<float>();
      caster.behind = ((c * cone.axis - light.to_sun) / squared_sine).cast<float>();
      caster.beside = cone.axis.cross(light.to_sun).normalized().cast<float>();
    }
  }
}

void Shader::surface_of_cone(const Flank& flank, const RayBatch& batch, std::size_t i) noexcept {
  Surface& s = surface_;
  const HitCode face = batch.code[i] >> kFaceShift;
  Eigen::Vector3f normal;
  s.gloss[i] = flank.gloss;
  s.albedo[i] = flank.albedo;
  if (face != 0) {
    normal = face == 1 ? Eigen::Vector3f(-flank.axis) : flank.axis;
  } else {
    const Eigen::Vector3f m = Eigen::Vector3f(s.px[i], s.py[i], s.pz[i]) - flank.start;
    const float along = m.dot(flank.axis);
    const Eigen::Vector3f radial = m - along * flank.axis;
    const float per_radius =
        flank.slope == 0 ? flank.per_radius : 1 / (flank.radius + flank.slope * along);
    normal = (radial * per_radius - flank.slope * flank.axis) * flank.normal_scale;
    if (flank.map != nullptr) {
      const auto around = static_cast<float>(flank.map->width());
      const float x = (0.5F + turns(radial.dot(flank.side), radial.dot(flank.up))) * around;
      const float y = (flank.texture_along + along) * flank.per_metre;
      const Eigen::Vector3f d(batch.dx[i], batch.dy[i], batch.dz[i]);
      const float facing = std::max(0.1F, -normal.dot(d) * s.per_length[i]);
      constexpr float kPerTurn = 0.5F * std::numbers::inv_pi_v<float>;
      const float across = s.footprint[i] * around * kPerTurn * per_radius / facing;
      const float lengthwise = s.footprint[i] * flank.per_metre;
      // Half of the foreshortening is blurred away, the rest is left to the pixel grid: blurring
      // all of it would take the texture off the flanks.
      const float level = rough_log2(std::max(1.0F, std::max(lengthwise, 0.5F * across)));
      s.albedo[i] = flank.map->at(x, y, level);
    }
  }
  s.nx[i] = normal.x();
  s.ny[i] = normal.y();
  s.nz[i] = normal.z();
}

void Shader::surface(const RayBatch& batch) noexcept {
  Surface& s = surface_;
  const auto cones = static_cast<HitCode>(bodies_->cones.size());
  const auto boxes = static_cast<HitCode>(bodies_->boxes.size());
  for (std::size_t i = 0; i < batch.count; ++i) {
    s.px[i] = eye_.x() + batch.t[i] * batch.dx[i];
    s.py[i] = eye_.y() + batch.t[i] * batch.dy[i];
    s.pz[i] = eye_.z() + batch.t[i] * batch.dz[i];
    s.footprint[i] = batch.t[i] * pixel_angle_;
    s.per_length[i] = 1 / std::sqrt(batch.dx[i] * batch.dx[i] + batch.dy[i] * batch.dy[i] +
                                    batch.dz[i] * batch.dz[i]);
    s.sun[i] = 1;
    s.sky[i] = 1;
  }
  for (std::size_t i = 0; i < batch.count; ++i) {
    const HitCode body = batch.code[i] & kBodyMask;
    s.gloss[i] = 0;
    if (batch.code[i] == kSky) {
      s.albedo[i] = 0;
      continue;
    }
    if (body < cones) {
      surface_of_cone(flanks_[static_cast<std::size_t>(body)], batch, i);
      continue;
    }
    s.nx[i] = 0;
    s.ny[i] = 0;
    s.nz[i] = 1;
    if (body == kGround) {
      constexpr float kPerMetre = 1 / kGroundTexel;
      const float level = rough_log2(std::max(1.0F, s.footprint[i] * kPerMetre));
      s.albedo[i] = wardrobe_->ground.at(s.px[i] * kPerMetre, s.py[i] * kPerMetre, level);
      continue;
    }
    constexpr float kPerMetre = 1 / kGrimeTexel;
    const float level = rough_log2(std::max(1.0F, s.footprint[i] * kPerMetre));
    float u = s.px[i];
    float v = s.py[i];
    float albedo = 0;
    if (body < cones + boxes) {
      const Box& box = bodies_->boxes[static_cast<std::size_t>(body - cones)];
      albedo = box.albedo;
      const HitCode face = batch.code[i] >> kFaceShift;
      if (face == 0) {
        s.nx[i] = batch.dx[i] > 0 ? -1.0F : 1.0F;
        s.nz[i] = 0;
        u = s.pz[i];
      } else if (face == 1) {
        s.ny[i] = batch.dy[i] > 0 ? -1.0F : 1.0F;
        s.nz[i] = 0;
        v = s.pz[i];
      } else {
        s.nz[i] = batch.dz[i] > 0 ? -1.0F : 1.0F;
      }
    } else {
      albedo = bodies_->sheets[static_cast<std::size_t>(body - cones - boxes)].albedo;
      s.nz[i] = batch.dz[i] > 0 ? -1.0F : 1.0F;
    }
    s.albedo[i] = 2 * albedo * wardrobe_->grime.at(u * kPerMetre, v * kPerMetre, level);
  }
}

void Shader::cast(const Caster& c, std::size_t count) noexcept {
  Surface& s = surface_;
  const float along0 = -c.along.dot(c.start);
  const float beside0 = -c.beside.dot(c.start);
  const float behind0 = -c.behind.dot(c.start);
  for (std::size_t i = 0; i < count; ++i) {
    const float x = s.px[i];
    const float y = s.py[i];
    const float z = s.pz[i];
    const float along = along0 + c.along.x() * x + c.along.y() * y + c.along.z() * z;
    const float beside = beside0 + c.beside.x() * x + c.beside.y() * y + c.beside.z() * z;
    const float behind = behind0 + c.behind.x() * x + c.behind.y() * y + c.behind.z() * z;
    const float width = kSunWidth * std::abs(behind) + s.footprint[i];
    const float sharpness = 1 / width;
    const float radius = c.radius + c.slope * along;
    const float beneath = (radius - std::abs(beside)) * sharpness + 0.5F;
    const float from_start = along * sharpness + 0.5F;
    const float from_end = (c.length - along) * sharpness + 0.5F;
    const float between = from_start < from_end ? from_start : from_end;
    const float covered = beneath < between ? beneath : between;
    const float above = covered > 0 ? covered : 0.0F;
    // A pipe's own lit half lies before its axis; its dark half faces away from the sun anyway.
    // A product, not a choice: the loop stays without branches.
    const float within = (above < 1 ? above : 1.0F) * (behind > 0 ? 1.0F : 0.0F);
    s.sun[i] *= 1 - within;
  }
}

void Shader::hide_sky(const Caster& c, std::size_t count) noexcept {
  Surface& s = surface_;
  for (std::size_t i = 0; i < count; ++i) {
    const float mx = s.px[i] - c.start.x();
    const float my = s.py[i] - c.start.y();
    const float mz = s.pz[i] - c.start.z();
    float along = mx * c.axis.x() + my * c.axis.y() + mz * c.axis.z();
    along = along > 0 ? along : 0.0F;
    along = along < c.length ? along : c.length;
    const float wx = along * c.axis.x() - mx;
    const float wy = along * c.axis.y() - my;
    const float wz = along * c.axis.z() - mz;
    const float distance = std::sqrt(wx * wx + wy * wy + wz * wz) + 1e-6F;
    const float inverse = 1 / distance;
    const float towards = (wx * s.nx[i] + wy * s.ny[i] + wz * s.nz[i]) * inverse;
    const float width = (c.radius + c.slope * along) * inverse - 1 / kSkyReach;
    const float hidden = 0.55F * width * (towards + 0.4F);
    float open = hidden > 0 ? 1 - hidden : 1.0F;
    // Its own surface: the normal points straight away from the axis.
    open = (width > 0) & (towards > -0.4F) ? open : 1.0F;
    s.sky[i] *= open;
  }
}

void Shader::shade(const RayBatch& batch, std::array<float, kBatch>& radiance) noexcept {
  surface(batch);
  Surface& s = surface_;
  const std::size_t count = batch.count;
  if (shadows_ && count > 0) {
    Eigen::Vector3f low = Eigen::Vector3f::Constant(1e9F);
    Eigen::Vector3f high = -low;
    for (std::size_t i = 0; i < count; ++i) {
      const Eigen::Vector3f p(s.px[i], s.py[i], s.pz[i]);
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    const Eigen::Vector3f centre = 0.5F * (low + high);
    const float reach = 0.5F * (high - low).norm();
    for (const Caster& caster : casters_) {
      const Eigen::Vector3f m = centre - caster.start;
      const float widest = std::max(caster.radius, caster.radius + caster.slope * caster.length);
      if (caster.shadow && sun_ > 0) {
        const float behind = caster.behind.dot(m);
        const float margin = widest + reach + kSunWidth * (std::abs(behind) + reach) + 0.05F;
        const float along = caster.along.dot(m);
        const float slack = margin * caster.along.norm();
        if (std::abs(caster.beside.dot(m)) < margin && behind + reach * caster.behind.norm() > 0 &&
            along > -slack && along < caster.length + slack) {
          cast(caster, count);
        }
      }
      const float along = std::clamp(m.dot(caster.axis), 0.0F, caster.length);
      if ((m - along * caster.axis).norm() < kSkyReach * widest + reach) {
        hide_sky(caster, count);
      }
    }
  }
  for (std::size_t i = 0; i < count; ++i) {
    const float x = batch.dx[i];
    const float y = batch.dy[i];
    const float z = batch.dz[i];
    const float inverse = s.per_length[i];
    float lambert = s.nx[i] * to_sun_.x() + s.ny[i] * to_sun_.y() + s.nz[i] * to_sun_.z();
    lambert = lambert > 0 ? lambert : 0.0F;
    const float hx = to_sun_.x() - x * inverse;
    const float hy = to_sun_.y() - y * inverse;
    const float hz = to_sun_.z() - z * inverse;
    const float squared_half = hx * hx + hy * hy + hz * hz + 1e-12F;
    const float facing = s.nx[i] * hx + s.ny[i] * hy + s.nz[i] * hz;
    float highlight = facing > 0 ? facing * facing / squared_half : 0.0F;
    highlight *= highlight;
    highlight *= highlight;
    highlight *= highlight;
    highlight *= highlight;  // cosine to the 32nd
    const float sun = sun_ * s.sun[i];
    const float sky = sky_ * s.sky[i] * (0.6F + 0.4F * s.nz[i]);
    const float lit = s.albedo[i] * (sun * lambert + sky) +
                      s.gloss[i] * sun * highlight * (lambert > 0 ? 1.0F : 0.0F);
    radiance[i] = batch.code[i] == kSky ? kSkyRadiance * sky_ : lit;
  }
}

}  // namespace pipescout::simulation::internal
