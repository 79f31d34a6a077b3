// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>

/// Radiometry of a thermal camera: conversion between counts of its sensor and temperatures of an
/// object. Temperatures in degrees Celsius, distances in metres, humidity and transmissions as
/// fractions. All functions are pure. An invalid parameter raises std::invalid_argument naming the
/// field, the value and the range.
namespace pipescout::thermal {

inline constexpr double kZeroCelsius = 273.15;  ///< K
/// degC: no body in view of a thermal camera is as hot; larger values mark missing data.
inline constexpr double kHottestBody = 2000;

/// Factory calibration of a camera: a black body of T kelvin gives r1 / (r2 (exp(b / T) - f)) - o
/// counts.
struct PlanckConstants {
  double r1 = 0;  ///< positive
  double r2 = 0;  ///< positive
  double b = 0;   ///< K, in [100, 10000]
  double f = 1;   ///< in [0.1, 10]
  double o = 0;   ///< counts
  void validate() const;
  /// Counts of a black body; NaN where undefined: at or below absolute zero, or at the pole of the
  /// camera's curve (f > 1).
  [[nodiscard]] double counts(double temperature) const noexcept;
  /// Derivative of the counts, 1/K; NaN where `counts` is.
  [[nodiscard]] double slope(double temperature) const noexcept;
  /// The inverse of `counts`; NaN for a signal outside the range of a black body.
  [[nodiscard]] double temperature(double black_body_counts) const noexcept;
};

/// Transmission of the air, with w grams of water per cubic metre, over d metres: x exp(-sqrt(d)
/// (alpha1 + beta1 sqrt(w))) + (1 - x) exp(-sqrt(d) (alpha2 + beta2 sqrt(w))). The defaults are
/// those in the files of FLIR's cameras.
struct AtmosphereConstants {
  double alpha1 = 0.006569;
  double alpha2 = 0.01262;
  double beta1 = -0.002276;
  double beta2 = -0.00667;
  double x = 1.9;
  void validate() const;  ///< all finite
};

/// Position of the air relative to a window, which determines how often the formula above is
/// applied.
enum class AirPath : std::uint8_t {
  /// All air between object and window, the window at the lens. As in FLIR's software, whose
  /// exports are reproduced to their last digit.
  kBeforeWindow,
  /// Half the distance before the window, half behind it: tau(d/2)^2 in place of tau(d). Common in
  /// free software; for a metre of air the error is 0.03 K at 35 degC.
  kWindowMidway,
};

/// "before_window", "window_midway"; "unknown" for any other value.
[[nodiscard]] std::string_view to_string(AirPath path) noexcept;

/// Factory parameters of a camera.
struct CameraConstants {
  PlanckConstants planck;
  AtmosphereConstants atmosphere{};
  AirPath path = AirPath::kBeforeWindow;
  void validate() const;
};

/// Parameters of the object and of the air and window in between.
struct ObjectParameters {
  double emissivity = 0.95;             ///< in (0, 1]
  double reflected_temperature = 20;    ///< degC, apparent; above absolute zero, below 2000
  double distance = 1;                  ///< m, in [0, 10000]
  double atmospheric_temperature = 20;  ///< degC, in [-60, 80]: the fit of the water content holds
  double relative_humidity = 0.5;       ///< in [0, 1]
  double window_temperature = 20;       ///< degC, as the reflected one
  double window_transmission = 1;       ///< in (0, 1]
  void validate() const;
};

/// Section 5 of Ibarguren et al. 2013 (Sensors 13, 13560): absorber tubes behind glass, emissivity
/// 0.04, reflected temperature 10 degC, distance 10 m. The paper does not give air temperature and
/// humidity: the air has the reflected temperature, humidity 0.5, no window.
[[nodiscard]] ObjectParameters ibarguren2013_object() noexcept;

/// Grams of water in a cubic metre of air (FLIR's fit).
[[nodiscard]] double water_content(double atmospheric_temperature,
                                   double relative_humidity) noexcept;

/// Transmission of `distance` metres of air.
[[nodiscard]] double air_transmission(const AtmosphereConstants& atmosphere, double distance,
                                      double atmospheric_temperature,
                                      double relative_humidity) noexcept;

/// Sensitivity of a temperature, or of the signal, to each parameter, in K per unit of the
/// parameter.
struct Sensitivity {
  double counts = 0;
  double emissivity = 0;
  double reflected_temperature = 0;
  double distance = 0;
  double atmospheric_temperature = 0;
  double relative_humidity = 0;
  double window_temperature = 0;
  double window_transmission = 0;
};

/// A camera with one set of object parameters. The signal, in counts, is
///   w (e t P(T) + (1 - e) t P(T_reflected) + (1 - t) P(T_air)) + (1 - w) P(T_window)
/// with P the black body's counts, e the emissivity, t the transmission of the air and w that of
/// the window, for AirPath::kBeforeWindow; for kWindowMidway, with t that of half the distance,
///   t (w (e t P(T) + (1 - e) t P(T_reflected) + (1 - t) P(T_air)) + (1 - w) P(T_window))
///     + (1 - t) P(T_air).
class Radiometry {
 public:
  /// Throws std::invalid_argument when a parameter is out of range, when the transmission of the
  /// air is not in (0, 1] (outside the range of the fit), and when a given temperature has no
  /// counts.
  Radiometry(const CameraConstants& camera, const ObjectParameters& object);

  /// degC; NaN where the counts are below the signal of reflection, air and window alone, or of a
  /// black body at absolute zero, so that no temperature corresponds to them. Also NaN where `f` of
  /// the Planck constants is less than 1 and the counts exceed those of any black body.
  [[nodiscard]] double temperature(double counts) const noexcept;
  /// The inverse; NaN where the black body's is. Neither rounded nor limited to the sensor's range.
  [[nodiscard]] double counts(double temperature) const noexcept;
  /// Counts per kelvin, of an object of this temperature.
  [[nodiscard]] double slope(double temperature) const noexcept;
  /// Derivatives of the temperature of these counts; all NaN where it is NaN. Those with respect to
  /// distance and humidity, which are infinite at 0, are taken at no less than 1e-3 m and 1e-4.
  [[nodiscard]] Sensitivity sensitivity(double counts) const noexcept;

  /// Largest counts without a temperature.
  [[nodiscard]] double floor_counts() const noexcept;
  /// Transmission from the object to the camera: air and window.
  [[nodiscard]] double transmission() const noexcept;

  [[nodiscard]] const CameraConstants& camera() const noexcept { return camera_; }
  [[nodiscard]] const ObjectParameters& object() const noexcept { return object_; }

 private:
  CameraConstants camera_;
  ObjectParameters object_;
  double air_ = 1;         // transmission of one section of air: all of it, or half
  double emitted_ = 1;     // share of P(T) in the signal
  double background_ = 0;  // counts that do not depend on the object's temperature
};

/// For apparent temperatures: of a black body before the lens. They need nothing but the camera.
[[nodiscard]] Radiometry apparent_radiometry(const CameraConstants& camera);

}  // namespace pipescout::thermal
