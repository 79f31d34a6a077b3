// SPDX-License-Identifier: Apache-2.0
#include "thermal_radiation.hpp"

#include <cmath>
#include <limits>

namespace pipescout::simulation::internal {
namespace {

constexpr double kIcePoint = 273.15;  // K
/// 1/m and m^2/g: extinction of dry air, and of water vapour, from 8 to 14 um. Chosen so that 10 m
/// of air of 10 degC and humidity 0.5 pass 98.5 %.
constexpr double kDryExtinction = 8e-4;
constexpr double kWaterExtinction = 1.5065e-4;

/// g/m^3: Magnus' formula (WMO No. 8, annex 4.B) and the gas law.
double absolute_humidity(double temperature, double relative) {
  const double saturation = 6.112 * std::exp(17.62 * temperature / (243.12 + temperature));  // hPa
  constexpr double kGasFactor = 216.68;  // g K / (hPa m^3)
  return kGasFactor * relative * saturation / (temperature + kIcePoint);
}

}  // namespace

ThermalRadiation::ThermalRadiation(const thermal::CameraConstants& camera,
                                   const thermal::ObjectParameters& object)
    : gain_(camera.planck.r1 / camera.planck.r2),
      wave_(camera.planck.b),
      bias_(camera.planck.o),
      shape_(camera.planck.f) {
  const double extinction =
      kDryExtinction + kWaterExtinction * absolute_humidity(object.atmospheric_temperature,
                                                            object.relative_humidity);
  const double air = std::exp(-extinction * object.distance);
  const double window = object.window_transmission;
  const double reflected = (1 - object.emissivity) * black_body(object.reflected_temperature);
  const double haze = (1 - air) * black_body(object.atmospheric_temperature);
  of_object_ = window * air * object.emissivity;
  of_others_ =
      window * (air * reflected + haze) + (1 - window) * black_body(object.window_temperature);
}

double ThermalRadiation::black_body(double temperature) const noexcept {
  const double kelvin = temperature + kIcePoint;
  return kelvin > 0 ? gain_ / (std::exp(wave_ / kelvin) - shape_) - bias_
                    : std::numeric_limits<double>::quiet_NaN();
}

double ThermalRadiation::slope(double temperature) const noexcept {
  constexpr double kStep = 0.01;  // K
  return (black_body(temperature + kStep) - black_body(temperature - kStep)) / (2 * kStep);
}

double ThermalRadiation::object(double temperature) const noexcept {
  return of_object_ * black_body(temperature) + of_others_;
}

}  // namespace pipescout::simulation::internal
