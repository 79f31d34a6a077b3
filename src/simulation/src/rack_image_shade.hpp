// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "pipescout/simulation/rack_image.hpp"
#include "rack_image_bodies.hpp"
#include "rack_texture_map.hpp"

namespace pipescout::simulation::internal {

/// What the bodies of a scene wear.
struct Wardrobe {
  std::vector<TextureMap> pipes;
  TextureMap ground;
  TextureMap grime;
};

/// Light from the bodies to the camera: Lambert's law for sun and sky, a highlight, shadows of the
/// cones with the penumbra of the real sun, and the sky that neighbouring pipes hide.
class Shader {
 public:
  Shader(const Bodies& bodies, const Wardrobe& wardrobe, bool shadows);

  /// `pixel_angle`: of one pixel, rad.
  void prepare(const RackLight& light, double pixel_angle);
  /// Where the rays of the next batches begin.
  void look_from(const Eigen::Vector3d& eye) noexcept { eye_ = eye.cast<float>(); }

  /// Radiance of all hits of the batch.
  void shade(const RayBatch& batch, std::array<float, kBatch>& radiance) noexcept;

 private:
  /// Affine functions of a point: where its ray to the sun passes the axis of a cone.
  struct Caster {
    Eigen::Vector3f axis, start;
    Eigen::Vector3f along;   // place on the axis
    Eigen::Vector3f beside;  // distance between ray and axis
    Eigen::Vector3f behind;  // way along the ray to the sun
    float length, radius, slope;
    bool shadow;  // not when the sun shines along the axis
  };
  /// What a lookup on the flank of a cone needs.
  struct Flank {
    Eigen::Vector3f start, axis, up, side;
    float radius, per_radius, slope, normal_scale;
    float albedo, gloss;
    const TextureMap* map;  // null: the albedo alone
    float texture_along, per_metre;
  };
  struct Surface {
    alignas(16) std::array<float, kBatch> px{}, py{}, pz{}, nx{}, ny{}, nz{};
    alignas(16) std::array<float, kBatch> albedo{}, gloss{}, sun{}, sky{};
    alignas(16) std::array<float, kBatch> footprint{}, per_length{};
  };

  void surface(const RayBatch& batch) noexcept;
  void surface_of_cone(const Flank& flank, const RayBatch& batch, std::size_t i) noexcept;
  void cast(const Caster& caster, std::size_t count) noexcept;
  void hide_sky(const Caster& caster, std::size_t count) noexcept;

  const Bodies* bodies_;
  const Wardrobe* wardrobe_;
  bool shadows_;
  std::vector<Caster> casters_;  // one per cone
  std::vector<Flank> flanks_;    // one per cone
  Surface surface_;
  Eigen::Vector3f eye_ = Eigen::Vector3f::Zero();
  Eigen::Vector3f to_sun_ = Eigen::Vector3f::UnitZ();
  float sun_ = 0;
  float sky_ = 0;
  float pixel_angle_ = 0;
};

}  // namespace pipescout::simulation::internal
