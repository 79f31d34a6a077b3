// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <numbers>
#include <optional>
#include <string_view>

namespace pipescout::geometry {

using Matrix23d = Eigen::Matrix<double, 2, 3>;

/// How the point (x, y) of the plane z = 1, r^2 = x^2 + y^2, is distorted; as OpenCV's calib3d.
enum class LensModel : std::uint8_t {
  /// Brown's model with a radial factor
  /// (1 + k1 r^2 + k2 r^4 + k3 r^6) / (1 + k4 r^2 + k5 r^4 + k6 r^6) and the tangential p1, p2:
  /// `plumb_bob` of ROS where k4, k5 and k6 are 0, else `rational_polynomial`.
  kBrown,
  /// `equidistant` of ROS, OpenCV's fisheye model: the angle theta = atan(r) off the axis is shown
  /// at the radius theta (1 + k1 theta^2 + k2 theta^4 + k3 theta^6 + k4 theta^8).
  kEquidistant,
};

inline constexpr std::array kLensModels{LensModel::kBrown, LensModel::kEquidistant};

/// "brown", "equidistant"; "unknown" for any other value.
[[nodiscard]] std::string_view to_string(LensModel lens) noexcept;

/// Off the axis, rad: what an equidistant lens shows beyond is not used, since its ideal pixels
/// are too far away.
inline constexpr double kWidestEquidistantAngle = 80 * std::numbers::pi / 180;

/// Pinhole camera with skew and aspect ratio (Lippiello and Cacace, equation 1) behind a lens.
/// Pixel (0, 0) is the middle of the upper left one; u to the right, v down. Camera frames are
/// optical: x right, y down, z forward.
struct CameraParameters {
  int width = 720;                ///< pixels
  int height = 480;               ///< pixels
  double focal_length = 630;      ///< f_c, pixels, > 0
  double aspect_ratio = 1;        ///< r_c, > 0: the focal length along v is r_c f_c
  double skew = 0;                ///< s_c, pixels
  double centre_u = 360;          ///< u_0, pixels
  double centre_v = 240;          ///< v_0, pixels
  double k1 = 0, k2 = 0, k3 = 0;  ///< radial distortion
  double p1 = 0, p2 = 0;          ///< tangential distortion
  double k4 = 0, k5 = 0, k6 = 0;  ///< see LensModel
  LensModel lens = LensModel::kBrown;

  /// Throws std::invalid_argument naming the field, the value and the range. The distortion must
  /// be invertible over the whole image; that of an equidistant lens, up to its image's border or
  /// kWidestEquidistantAngle, whichever is nearer to the axis.
  void validate() const;
};

class Camera {
 public:
  Camera() : Camera(CameraParameters{}) {}
  /// Throws as CameraParameters::validate.
  explicit Camera(const CameraParameters& parameters);

  [[nodiscard]] const CameraParameters& parameters() const noexcept { return parameters_; }
  [[nodiscard]] bool has_distortion() const noexcept { return has_distortion_; }
  /// Radius on the plane z = 1 up to which points are projected; without distortion beyond any.
  [[nodiscard]] double largest_radius() const noexcept;
  /// K of equation (1).
  [[nodiscard]] const Eigen::Matrix3d& matrix() const noexcept { return matrix_; }
  [[nodiscard]] const Eigen::Matrix3d& inverse_matrix() const noexcept { return inverse_matrix_; }

  /// Distorted pixel of the point (camera frame, m). It may lie outside the image: see `contains`.
  /// Nothing when the point is not in front of the camera (z below 1e-6 m), or so far outside the
  /// image that the distortion model is not valid there, and for NaN.
  [[nodiscard]] std::optional<Eigen::Vector2d> project(const Eigen::Vector3d& point) const noexcept;
  /// The same, with the derivative of the pixel with respect to the point, pixels per metre.
  [[nodiscard]] std::optional<Eigen::Vector2d> project(const Eigen::Vector3d& point,
                                                       Matrix23d& derivative) const noexcept;
  /// Derivative of the pixel of a fixed point with respect to (focal_length, centre_u, centre_v),
  /// pixels per pixel, at constant aspect ratio. Valid for ideal and for distorted pixels.
  [[nodiscard]] Matrix23d derivative_to_intrinsics(const Eigen::Vector2d& pixel) const noexcept;
  /// The ray (x, y, 1) of a distorted pixel in the camera frame. Nothing outside the range in which
  /// the distortion can be inverted, and for NaN.
  [[nodiscard]] std::optional<Eigen::Vector3d> ray(const Eigen::Vector2d& pixel) const noexcept;

  /// Conversion of a distorted pixel to that of an ideal camera with the same K, and back. Nothing
  /// in the cases of `ray` and `project`.
  [[nodiscard]] std::optional<Eigen::Vector2d> undistort(
      const Eigen::Vector2d& pixel) const noexcept;
  [[nodiscard]] std::optional<Eigen::Vector2d> distort(
      const Eigen::Vector2d& ideal_pixel) const noexcept;

  /// Whether the pixel lies between the middles of the outermost pixels, at least `margin` pixels
  /// from them. False for NaN.
  [[nodiscard]] bool contains(const Eigen::Vector2d& pixel, double margin = 0) const noexcept;

 private:
  friend struct CameraParameters;  // its validation uses the camera
  struct Unchecked {};
  Camera(const CameraParameters& parameters, Unchecked unchecked);
  /// On the plane z = 1, before distortion; nothing in the cases of `project`.
  [[nodiscard]] std::optional<Eigen::Vector2d> plane_point(
      const Eigen::Vector3d& point) const noexcept;
  [[nodiscard]] Eigen::Vector2d to_pixel(const Eigen::Vector2d& plane) const noexcept;

  CameraParameters parameters_;
  Eigen::Matrix3d matrix_;
  Eigen::Matrix3d inverse_matrix_;
  bool has_distortion_ = false;
  /// Squared radius on the plane z = 1 up to which the radial distortion is monotonic and valid.
  double largest_squared_radius_ = 0;
};

}  // namespace pipescout::geometry
