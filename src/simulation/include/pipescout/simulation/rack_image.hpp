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

/// Images of a camera over a rack of pipes, with ground truth: a ray caster with shaded, rusty
/// cylinders and cones, their supports, the ground below, shadows, clutter, lens and sensor.
///
/// It shares no geometry with the tracker that is tested on its images: silhouettes come from rays
/// that hit or miss, not from contours. Frames are those of rack_model.hpp (`rack`) and
/// camera.hpp (optical, pixel (0, 0) is the middle of the upper left one); lengths in metres, times
/// in seconds, angles in radians. Light is linear: radiance 1 is a white sheet in an irradiance of
/// 1, and a grey level is  offset + 255 gain radiance, as from a camera without gamma.
namespace pipescout::simulation {

/// The surface of a pipe.
struct PipeFinish {
  double albedo = 0.4;    ///< of its paint, [0.02, 0.95]
  double rust = 0.25;     ///< share of the surface covered by rust, [0, 1]
  double contrast = 1.0;  ///< of the texture; 0: plain paint; [0, 1.5]
  double gloss = 0.15;    ///< radiance of the highlight at an irradiance of 1, [0, 2]
};

/// Interval along rack y in which pipes have plain paint without texture.
struct PlainStretch {
  double from = 0.0;
  double to = 0.0;  ///< at least `from`
};

/// A cylinder with flat ends.
struct SceneCylinder {
  Eigen::Vector3d start = Eigen::Vector3d::Zero();       ///< of its axis, rack frame, m
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();  ///< unit
  double length = 0;                                     ///< m, > 0
  double radius = 0;                                     ///< m, > 0
  double albedo = 0.4;                                   ///< [0.02, 0.95]
};

/// A box with its edges along the axes of the rack frame.
struct SceneBox {
  Eigen::Vector3d lowest_corner = Eigen::Vector3d::Zero();  ///< m
  Eigen::Vector3d highest_corner = Eigen::Vector3d::Zero();
  double albedo = 0.4;  ///< [0.02, 0.95]
};

/// What lies on and beside a rack and is no pipe or support of its model: flanges, lagging, valves,
/// cable trays. Bodies may run through pipes and each other. Cylinders cast shadows.
struct SceneBodies {
  std::vector<SceneCylinder> cylinders{};
  std::vector<SceneBox> boxes{};

  /// Throws std::invalid_argument naming the field, the value and the range: more than 1000 bodies,
  /// none with an extent below 0.1 mm.
  void validate() const;
};

/// A person is an upright cylinder.
inline constexpr double kPersonHeight = 1.75;  ///< m
inline constexpr double kPersonRadius = 0.22;  ///< m
inline constexpr std::size_t kMostPeople = 8;

struct RackScene {
  rack_vision::RackModel model;  ///< true positions of the pipes
  SceneBodies bodies{};
  std::size_t people = 0;              ///< at most kMostPeople; each view says where they stand
  std::vector<PipeFinish> finishes{};  ///< one per pipe; empty: random, dark and bright ones
  std::vector<PlainStretch> plain{};
  double ground_height = -4.0;  ///< rack z, m, [-100, -0.5]: gravel, slabs, stripes
  double ground_albedo = 0.3;   ///< mean, [0.02, 0.95]
  /// Share of the contours of the pipes that tarpaulins hide and cables imitate, as seen from
  /// above, [0, 0.8].
  double clutter_share = 0.0;
  bool shadows = true;  ///< those that pipes cast on each other and on what is below them
  std::uint64_t seed = 1;

  /// Throws std::invalid_argument naming the field, the value and the range; for the model as
  /// rack_vision::RackModel::validate.
  void validate() const;
};

/// Lens and sensor.
struct ImageSensor {
  double exposure = 0.004;  ///< s, [0, 0.1]; the pose is that of its middle
  /// s, [0, 1e-4], from the exposure of one row to that of the next below (rolling shutter); the
  /// pose is that of the middle of the image. It changes every 16 rows, by the camera's velocity.
  double row_time = 0;
  double lens_blur = 0.7;    ///< pixels, standard deviation of a Gaussian, [0, 5]
  double vignetting = 0.25;  ///< light lost at the corner farthest from the centre, [0, 0.9]
  double electrons_per_level = 40.0;  ///< shot noise: variance = level / this; 0: none; [0, 1e6]
  double read_noise = 1.0;            ///< grey levels, standard deviation, [0, 50]

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

/// No blur, no vignetting, no noise, only the quantisation to 8 bits.
[[nodiscard]] ImageSensor perfect_image_sensor();

struct RackLight {
  Eigen::Vector3d to_sun = Eigen::Vector3d(0.35, 0.25, 0.9).normalized();  ///< unit, rack frame
  double sun = 0.75;    ///< irradiance on a surface that faces the sun, [0, 10]
  double sky = 0.35;    ///< irradiance on a surface that faces the open sky, [0, 10]
  double gain = 1.1;    ///< of the camera, [0, 100]
  double offset = 6.0;  ///< grey level of black, [-255, 255]

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

struct RackView {
  geometry::SE3 T_camera_rack;  ///< in the middle of the exposure
  /// Velocity of the camera relative to the rack, in the camera frame: [linear m/s; angular rad/s];
  /// causes motion blur, and what a rolling shutter does.
  geometry::Vector6d velocity = geometry::Vector6d::Zero();
  RackLight light{};
  std::uint64_t frame = 0;  ///< chooses the noise: the same scene, view and frame, the same bits
  /// Where the people of the scene stand, rack frame, m: as many as there are. They stand still
  /// during the exposure.
  std::span<const Eigen::Vector3d> people{};
};

class RackImageRenderer {
 public:
  /// Prepares textures (0.3 to 0.5 s) and all memory. Throws as the `validate` of its arguments.
  RackImageRenderer(const RackScene& scene, const geometry::Camera& camera,
                    const ImageSensor& sensor = {});
  RackImageRenderer(RackImageRenderer&&) noexcept;
  RackImageRenderer& operator=(RackImageRenderer&&) noexcept;
  ~RackImageRenderer();

  /// `grey`: height * width, row-major. Motion blur is that of the plane through the axes of the
  /// pipes. Only working memory is kept between calls, and none is allocated. Throws
  /// std::invalid_argument when `grey` has another size, the light is not valid, the velocity not
  /// finite, or the number of people is not that of the scene.
  void render(const RackView& view, std::span<std::uint8_t> grey);

  [[nodiscard]] const geometry::Camera& camera() const noexcept;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace pipescout::simulation
