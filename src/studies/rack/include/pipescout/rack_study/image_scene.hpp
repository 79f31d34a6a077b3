// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "pipescout/geometry/se3.hpp"
#include "pipescout/rack_vision/rack_model.hpp"
#include "pipescout/rack_vision/way_points.hpp"
#include "pipescout/simulation/rack_image.hpp"
#include "pipescout/simulation/rack_image_light.hpp"

/// Racks, way-points and motions for the studies on rendered images.
namespace pipescout::rack_study {

/// Which of the two renderers, which share no code, makes the images.
enum class World : std::uint8_t { kRayCaster, kMesh };

/// The paper's rack, `paper_rack(5)`, on six beams: as racks stand in a plant. Beams, ends, the
/// reducer and the pipe across tell where along the pipes the camera is.
[[nodiscard]] rack_vision::RackModel rack_on_beams();

/// Four parallel pipes of `length` m without beams, the radii those of the paper's rack. Away from
/// their ends nothing but texture tells motion along them.
[[nodiscard]] rack_vision::RackModel rack_without_beams(double length);

/// The paper's way-points (`paper_flight`), then others above the rack of 10 m, 2.5 to 3 m high, as
/// the seed draws them, until the path takes `duration` s.
[[nodiscard]] std::vector<rack_vision::WayPoint> inspection_way_points(double duration,
                                                                       std::uint64_t seed);

/// From one place to another along the middle of `rack_without_beams`, 2.9 m high.
[[nodiscard]] std::vector<rack_vision::WayPoint> way_points_along(double from, double to);

/// The truth about one image.
struct CameraMotion {
  double time = 0;  ///< s, a multiple of 1 ms
  geometry::SE3 T_camera_rack;
  /// Of the camera against the rack, camera frame: [linear m/s; angular rad/s].
  geometry::Vector6d velocity = geometry::Vector6d::Zero();
};

/// What the camera sees then, for the renderer; `frame` chooses the noise.
[[nodiscard]] simulation::RackView view_of(const CameraMotion& motion,
                                           const simulation::ChangingRackLight& light,
                                           std::uint64_t frame);

struct CameraFlightSettings {
  double duration = 60;            ///< s, > 0
  double frame_rate = 25;          ///< 1/s, (0, 1000]
  double largest_speed = 0.4;      ///< m/s, along the path
  double largest_yaw_rate = 0.16;  ///< rad/s
  double wind_at_20_feet = 5.0;    ///< W20 of MIL-F-8785C, m/s
};

/// A simulated quadrotor follows the way-points in Dryden gusts, with a camera at its origin that
/// looks straight down and tilts with it (`rack_vision::downward_camera`). One entry per image. The
/// same arguments give the same bits.
[[nodiscard]] std::vector<CameraMotion> fly_camera(
    const std::vector<rack_vision::WayPoint>& way_points, const CameraFlightSettings& settings,
    std::uint64_t seed);

}  // namespace pipescout::rack_study
