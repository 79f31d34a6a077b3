// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "pipescout/geometry/se3.hpp"
#include "pipescout/thermal/radiometry.hpp"

/// A row of parabolic-trough collectors at night, with leaks and with features that resemble leaks.
///
/// Frame `row`: on level ground, the origin below the beginning of the absorber tube, x along it, z
/// up. The tube is straight, at z = `tube_height`; the collectors face the side of negative y,
/// where the camera is, with their mirrors behind the tube. A `place` is a position x in the row,
/// m.
///
/// Two scales of temperature, degrees Celsius both. *Object*: with the camera's parameters for the
/// tube (`ThermalSceneParameters::object`), used for the tube, leaks, joints, swivel joints and
/// reflections in the tube. *Apparent*: of a black body with the same radiance, used for everything
/// else.
namespace pipescout::simulation {

struct ThermalLeak {
  double place = 0;        ///< m, of its middle, along the tube
  double length = 0.3;     ///< m, [0.05, 50]: section that is hotter by more than half of `rise`
  double rise = 75;        ///< K, object, (0, 2000]: above the tube
  double shoulder = 0.05;  ///< m, [0, length]: length of the transition at either end
};

enum class ThermalDecoyKind : std::uint8_t {
  kBrightJoint,        ///< a joint of the tube that is brighter and wider than others
  kPassingReflection,  ///< a bright section of the tube that moves with the observer
  kHotPixels,          ///< of the camera: fixed in the image
  kWarmSupport,        ///< a post in front of the tube
  kSunGlint,           ///< a reflection too bright to measure, for a few frames
  kHotBody,            ///< a warm box behind the tube
};
inline constexpr std::size_t kThermalDecoyKinds = 6;

/// A hot feature that is not a leak. Visible while the camera is within `reach` / 2 of `place`
/// along the row.
struct ThermalDecoy {
  ThermalDecoyKind kind = ThermalDecoyKind::kBrightJoint;
  double place = 0;    ///< m; kBrightJoint: of the joint nearest to it
  double size = 0.15;  ///< m, [0.005, 5]: along the row; kHotPixels: pixels, [1, 5], to a side
  double rise = 100;   ///< K, object, [-200, 2000]: above the tube, on either scale
  double reach = 1e6;  ///< m, (0, 1e6]
  /// kPassingReflection, kSunGlint: motion per metre of camera motion, [0, 1].
  double follow = 0;
  /// kHotPixels: position in the image as shares of its width and height, [0, 1].
  Eigen::Vector2d pixel = Eigen::Vector2d(0.5, 0.5);
  /// kHotBody: distance of its front behind the tube, m, [0.2, 50]; its height, m, (0, 10]; and the
  /// height of its foot above the ground, m, [0, 10].
  double behind = 4;
  double height = 1;
  double foot = 0;
};

/// m, from one joint of the tube to the next: as of 4.06 m long absorber tubes.
inline constexpr double kAbsorberLength = 4.06;

struct ThermalSceneParameters {
  geometry::SE3 T_map_row{};
  double length = 150;            ///< m, [1, 5000]: of the tube, half a loop
  double tube_height = 3;         ///< m, [0.5, 10]
  double tube_radius = 0.06;      ///< m, [0.01, 0.5]: of its glass
  double tube_temperature = 150;  ///< object, [20, 500]: mean
  double tube_change = 5;   ///< K, object, [0, 100]: from the middle of the tube to either end
  double tube_grain = 2.5;  ///< K, object, [0, 50]: standard deviation, over some 0.3 m

  double joint_spacing = kAbsorberLength;  ///< m, [0.5, 100]
  double joint_width = 0.12;               ///< m, [0, 1]: mean; each is within a quarter of it
  double joint_least = -20;                ///< K, object, [-200, 1000]: smallest rise of a joint
  double joint_most = 120;  ///< K, object, [joint_least, 1000]. Changes with the angle of view
  double support_spacing = 12.18;  ///< m, [1, 1000]: of posts in front of the tube
  double support_width = 0.14;     ///< m, [0, 1]; 0: none
  bool swivel_joints = true;       ///< at both ends: a hot pipe from the tube to the ground
  /// Object, [-50, 500]: of the tube's image in the mirror, a band next to the tube. Not visible
  /// where it is below the mirror.
  double mirror_image = 70;
  double mirror_image_offset = 0.45;  ///< m, [-5, 5]: above the tube

  double sky_temperature = -30;     ///< apparent, [-80, 60]: of the sky overhead
  double ground_temperature = 5;    ///< apparent, [-60, 80]
  double ground_grain = 1;          ///< K, apparent, [0, 20]: standard deviation
  double mirror_temperature = -12;  ///< apparent, [-80, 80]: of what the mirror reflects, mean
  double mirror_change = 8;         ///< K, apparent, [0, 50]: from its middle to either rim

  thermal::ObjectParameters object = thermal::ibarguren2013_object();
  std::vector<ThermalLeak> leaks{};
  std::vector<ThermalDecoy> decoys{};
  std::uint64_t seed = 1;  ///< of grain and joints

  /// Throws std::invalid_argument naming the field, the value and the range; leaks and kinds of
  /// decoys that are on the tube must be on it.
  void validate() const;
};

/// A joint of the tube.
struct ThermalJoint {
  double place = 0;  ///< m, of its middle
  double width = 0;  ///< m
  double rise = 0;   ///< K, object: the mean over the angles of view
  double swing = 0;  ///< K, object: its variation with them
  double phase = 0;  ///< rad
};

/// Quantities derived from the parameters. The same parameters give the same bits.
class ThermalScene {
 public:
  /// Throws as ThermalSceneParameters::validate.
  explicit ThermalScene(const ThermalSceneParameters& parameters);

  [[nodiscard]] const ThermalSceneParameters& parameters() const noexcept { return parameters_; }
  [[nodiscard]] const std::vector<ThermalJoint>& joints() const noexcept { return joints_; }
  /// Of the posts, m.
  [[nodiscard]] const std::vector<double>& supports() const noexcept { return supports_; }
  /// Position of a point of the tube in the map, m.
  [[nodiscard]] Eigen::Vector3d on_tube(double place) const noexcept;
  /// Whether a point of the map is before the mirrors: from behind they hide the tube.
  [[nodiscard]] bool faces(const Eigen::Vector3d& point) const noexcept;
  /// Object temperature of the tube at a position, without joints and moving features; constant
  /// beyond its ends. Not limited to the camera's range.
  [[nodiscard]] double tube_temperature(double place) const noexcept;
  /// Rise of a leak at a position, K.
  [[nodiscard]] static double rise_of(const ThermalLeak& leak, double place) noexcept;

 private:
  ThermalSceneParameters parameters_;
  std::vector<ThermalJoint> joints_;
  std::vector<double> supports_;
  std::vector<float> grain_;  // K, along the tube
};

}  // namespace pipescout::simulation
