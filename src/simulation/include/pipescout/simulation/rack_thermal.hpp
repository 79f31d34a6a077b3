// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "pipescout/geometry/camera.hpp"
#include "pipescout/geometry/se3.hpp"
#include "pipescout/rack_vision/rack_model.hpp"

/// Thermal images of a camera over a rack of insulated pipes, with ground truth: a ray caster with
/// cylinders, cones, boxes and the ground, of grey bodies below a cold sky.
///
/// Radiometry of its own: Planck's law, integrated over the band of 8 to 14 um, with emission and
/// reflection by the angle of view and the absorption of the air. The camera outputs the
/// temperature of the black body with the same radiance, as cameras with a temperature-linear
/// output do. Frames as in rack_model.hpp (`rack`) and camera.hpp (optical); metres, radians,
/// degrees Celsius.
namespace pipescout::simulation {

/// Where the surface of a pipe is too warm: broken insulation, with an `half_angle` below pi, or
/// a pipe that is too warm all round, with one of pi.
struct HotSpot {
  std::size_t pipe = 0;     ///< index in the model
  double along = 0;         ///< m from the start of the pipe, of its middle
  double azimuth = 0;       ///< rad, of its middle, from the top of the pipe about the flow
  double length = 0.3;      ///< m, [0.05, 50]: along the pipe, where the rise is half
  double half_angle = 0.9;  ///< rad, (0, pi]: around the pipe, where the rise is half
  double rise = 25;         ///< K, (0, 500]: above the pipe
};

/// A warm place of the ground, which is no part of a pipe.
struct WarmGround {
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();  ///< m, rack x and y
  double radius = 0.3;                               ///< m, (0, 100]
  double temperature = 40;                           ///< [-50, 500]
};

struct RackThermalScene {
  rack_vision::RackModel model;  ///< true positions of the pipes
  /// One per pipe, [-50, 500], of its surface; empty: random, 30 to 60.
  std::vector<double> pipe_temperatures{};
  std::vector<HotSpot> hot_spots{};
  std::vector<WarmGround> warm_ground{};
  double pipe_change = 1.0;          ///< K, [0, 50]: amplitude along a pipe, over some metres
  double emissivity = 0.92;          ///< [0.1, 1], of all surfaces that are looked at squarely
  double ground_height = -4.0;       ///< rack z, m, [-100, -0.5]
  double ground_temperature = 12.0;  ///< [-50, 100], of supports too
  double ground_grain = 0.8;         ///< K, [0, 20]: standard deviation, over some 0.1 m
  double sky_temperature = -20.0;    ///< [-80, 60]: of the black body that radiates as the sky
  double air_temperature = 12.0;     ///< [-50, 60]
  double air_absorption = 0.004;     ///< 1/m, [0, 0.1]
  std::uint64_t seed = 1;

  /// Throws std::invalid_argument naming the field, the value and the range; for the model as
  /// rack_vision::RackModel::validate.
  void validate() const;
};

struct RackThermalSensor {
  double netd = 0.06;          ///< K, [0, 5]: noise of a black body at 30 degC, white
  double fixed_pattern = 0.3;  ///< of the NETD, [0, 10]: constant noise by pixel
  double lens_blur = 0.6;      ///< pixels, [0, 3]: standard deviation

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

/// K per count, and degrees Celsius at count 0.
inline constexpr double kRackThermalGain = 0.01;
inline constexpr double kRackThermalOffset = -273.15;

/// On the surface of the pipe, in the rack frame. `spot` must be of `model`.
[[nodiscard]] Eigen::Vector3d place_of(const HotSpot& spot, const rack_vision::RackModel& model);

/// Not thread-safe.
class RackThermalRenderer {
 public:
  /// Throws as the `validate` of its arguments.
  RackThermalRenderer(const RackThermalScene& scene, const geometry::Camera& camera,
                      const RackThermalSensor& sensor = {});
  RackThermalRenderer(RackThermalRenderer&&) noexcept;
  RackThermalRenderer& operator=(RackThermalRenderer&&) noexcept;
  ~RackThermalRenderer();

  /// `counts`: height * width, row-major. `frame` chooses the noise: the same scene, pose and frame
  /// give the same bits. Throws std::invalid_argument when `counts` has another
  /// size.
  void render(const geometry::SE3& T_rack_camera, std::uint64_t frame,
              std::span<std::uint16_t> counts);

  [[nodiscard]] const geometry::Camera& camera() const noexcept;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace pipescout::simulation
