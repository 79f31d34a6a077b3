// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pipescout::simulation::internal {

/// A solid cylinder or truncated cone with flat ends. All lengths in metres, rack frame.
struct Cone {
  Eigen::Vector3d start = Eigen::Vector3d::Zero();
  Eigen::Vector3d axis = Eigen::Vector3d::UnitY();  ///< unit
  double length = 0;
  double radius = 0;         ///< at the start
  double slope = 0;          ///< change of radius per metre
  int texture = -1;          ///< of the scene's pipe textures; -1: `albedo` instead
  double texture_along = 0;  ///< where the start is on that texture, m
  double texture_step = 1;   ///< m per row of that texture
  float albedo = 0.3F;
  float gloss = 0;
};

/// A box with its edges along the axes.
struct Box {
  Eigen::Vector3d low = Eigen::Vector3d::Zero();
  Eigen::Vector3d high = Eigen::Vector3d::Zero();
  float albedo = 0.3F;
};

/// A piece of cloth: a horizontal rectangle, turned about z, whose long sides are scalloped.
struct Sheet {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double cosine = 1;  ///< of the angle from x to its `across` direction
  double sine = 0;
  double half_across = 0;
  double half_along = 0;
  float scallop = 0;  ///< m, depth of the arcs of its long sides
  float albedo = 0.3F;
};

/// Everything that rays can hit but the ground. Bodies count on from cones over boxes to sheets.
struct Bodies {
  std::vector<Cone> cones;
  std::vector<Box> boxes;
  std::vector<Sheet> sheets;
  double ground_height = -4;

  [[nodiscard]] std::size_t size() const { return cones.size() + boxes.size() + sheets.size(); }
};

/// What a ray hit: the body in the low bits, its face above them, so that two samples with equal
/// codes lie on one smooth surface.
using HitCode = std::int32_t;
inline constexpr HitCode kSky = -1;
inline constexpr HitCode kGround = 0xfff;  // a body number that no body has
inline constexpr HitCode kBodyMask = 0xfff;
inline constexpr int kFaceShift = 12;  // cones: 0 flank, 1 start, 2 end; boxes: axis
inline constexpr std::size_t kMostBodies = 0xfff;

inline constexpr std::size_t kBatch = 256;

/// Rays from one eye, rack frame, depth 1 each: t is the depth along the optical axis.
struct RayBatch {
  std::size_t count = 0;
  alignas(16) std::array<float, kBatch> dx{}, dy{}, dz{};
  alignas(16) std::array<float, kBatch> t{};
  alignas(16) std::array<HitCode, kBatch> code{};
};

/// A cone of rays, rack frame.
struct RayCone {
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  ///< unit
  double tangent = 0;                               ///< of the half angle
};

/// The bodies as one eye sees them: what does not depend on the ray is computed once a frame. Cones
/// may have moved between frames.
class BodiesFromEye {
 public:
  explicit BodiesFromEye(const Bodies& bodies);

  void look_from(const Eigen::Vector3d& eye);
  [[nodiscard]] const Eigen::Vector3d& eye() const noexcept { return eye_; }

  /// Whether any ray of the cone may hit the body: never a wrong no.
  [[nodiscard]] bool may_hit(std::size_t body, const RayCone& cone) const noexcept;

  /// Starts the hits of a batch with ground and sky.
  void trace_ground(RayBatch& batch) const noexcept;
  /// Keeps the nearer of the batch's hits and those with one body.
  void trace(std::size_t body, RayBatch& batch) const noexcept;

 private:
  struct ConeConstants {
    float ax, ay, az;  // axis
    float qx, qy, qz;  // eye - start
    float along;       // q . axis
    float radius;      // at that place
    float slope;
    float c;  // |q|^2 - along^2 - radius^2
    float length;
  };
  struct Capsule {
    Eigen::Vector3d start = Eigen::Vector3d::Zero();
    Eigen::Vector3d extent = Eigen::Vector3d::Zero();
    double radius = 0;
  };

  void trace_cone(std::size_t cone, RayBatch& batch) const noexcept;
  void trace_box(std::size_t box, RayBatch& batch) const noexcept;
  void trace_sheet(std::size_t sheet, RayBatch& batch) const noexcept;

  const Bodies* bodies_;
  std::vector<ConeConstants> cones_;
  std::vector<Capsule> capsules_;  // around all bodies
  Eigen::Vector3d eye_ = Eigen::Vector3d::Zero();
};

}  // namespace pipescout::simulation::internal
