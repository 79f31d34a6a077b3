// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "pipescout/geometry/camera.hpp"
#include "pipescout/geometry/se3.hpp"
#include "pipescout/simulation/thermal_scene.hpp"
#include "pipescout/thermal/radiometry.hpp"

/// Images of a thermal camera that views a row of collectors, with ground truth. Radiation is
/// linear in counts; tubes and posts are cylinders, whose outlines are exact. Frames as in
/// thermal_scene.hpp and camera.hpp (optical; pixel (0, 0) is the middle of the upper left one).
namespace pipescout::simulation {

struct ThermalCameraParameters {
  geometry::CameraParameters camera{};  ///< without skew and distortion: images are rectified
  thermal::CameraConstants constants{};
  double netd = 0.08;           ///< K, [0, 5]: noise of a black body at 30 degC, white
  double fixed_pattern = 0.25;  ///< of the NETD, [0, 10]: constant noise by pixel and by column
  double exposure = 0.01;    ///< s, [0, 0.1]: over which the image moves; its middle is the stamp
  double lens_blur = 0.6;    ///< pixels, [0, 5]: standard deviation
  double dead_share = 5e-4;  ///< [0, 0.2]: share of dead pixels, with a constant value
  /// Degrees Celsius, object, (-200, 3000]: saturation temperature, for the scene's object.
  double highest = 300;
  std::uint64_t seed = 1;  ///< of noise and dead pixels

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;

  /// 320x240 and 640x512, 25 degrees wide.
  [[nodiscard]] static ThermalCameraParameters qvga();
  [[nodiscard]] static ThermalCameraParameters vga();
};

/// Planck constants of a common uncooled camera of 8 to 14 um.
[[nodiscard]] thermal::CameraConstants simulated_thermal_constants() noexcept;

struct ThermalView {
  geometry::SE3 T_map_camera{};  ///< in the middle of the exposure
  /// Velocity of the camera relative to the map, in the camera frame: [linear m/s; angular rad/s];
  /// causes motion blur.
  geometry::Vector6d velocity = geometry::Vector6d::Zero();
  std::uint64_t frame = 0;  ///< chooses the noise: the same scene, view and frame, the same bits
};

/// A straight section of a pipe in the image, between two points of its axis.
struct PipeInImage {
  Eigen::Vector2d from = Eigen::Vector2d::Zero();  ///< pixels; at the lower position along the tube
  Eigen::Vector2d to = Eigen::Vector2d::Zero();    ///< pixels
  double from_place = 0;                           ///< m
  double to_place = 0;                             ///< m
  double width = 0;                                ///< pixels, across, in the middle of it
};

struct LeakInImage {
  std::size_t leak = 0;   ///< which of the scene
  PipeInImage stretch{};  ///< cut at the border of the image
  bool whole = false;     ///< no part is beyond the border
};

struct ThermalTruth {
  /// Of the tube, between the middles of the outermost pixels; nothing when it is not in view.
  std::optional<PipeInImage> tube{};
  std::vector<LeakInImage> leaks{};
};

class ThermalRenderer {
 public:
  /// Prepares tables and all memory. Throws as the `validate` of its arguments, and
  /// std::invalid_argument when a temperature of the scene has no counts.
  ThermalRenderer(const ThermalScene& scene, const ThermalCameraParameters& camera);
  ThermalRenderer(ThermalRenderer&&) noexcept;
  ThermalRenderer& operator=(ThermalRenderer&&) noexcept;
  ~ThermalRenderer();

  /// `counts`: height * width, row-major. Motion blur along and across the tube is that at the
  /// middle of its visible part. From behind the mirrors only they are seen. Allocates nothing.
  /// Throws std::invalid_argument when `counts` has another size, or the velocity is not finite.
  void render(const ThermalView& view, std::span<std::uint16_t> counts);

  /// Overwrites `truth`, which allocates only while it grows.
  void truth(const ThermalView& view, ThermalTruth& truth) const;

  [[nodiscard]] const geometry::Camera& camera() const noexcept;
  /// Counts of the tube at an object temperature, degC, by the simulator's own model of radiation,
  /// air and sensor, which shares no code with thermal::Radiometry.
  [[nodiscard]] double counts(double temperature) const noexcept;
  /// Counts at which the camera saturates.
  [[nodiscard]] std::uint16_t highest_counts() const noexcept;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

/// 8 bits, as displayed by cameras: grey levels linear from `lowest` to `highest`, degrees Celsius;
/// pixels without a temperature are black.
class ThermalGreys {
 public:
  /// Throws std::invalid_argument unless `lowest` < `highest`.
  ThermalGreys(const thermal::Radiometry& radiometry, double lowest, double highest);
  /// Throws std::invalid_argument when the sizes differ.
  void convert(std::span<const std::uint16_t> counts, std::span<std::uint8_t> greys) const;

 private:
  std::vector<std::uint8_t> levels_;
};

/// 8-bit video with automatic gain: grey levels linear between two percentiles of the image, which
/// follow the scene with a lag. What a level means changes from image to image.
class ThermalAutomaticGain {
 public:
  /// Share of the pixels clipped at either end, and of the way to the new limits made per image.
  static constexpr double kClipped = 0.001;
  static constexpr double kFollow = 0.1;

  /// Throws std::invalid_argument when the sizes differ, or there are no pixels. Allocates once.
  void convert(std::span<const std::uint16_t> counts, std::span<std::uint8_t> greys);

 private:
  std::vector<std::uint16_t> sorted_;
  double low_ = 0;
  double high_ = 0;
  bool begun_ = false;
};

}  // namespace pipescout::simulation
