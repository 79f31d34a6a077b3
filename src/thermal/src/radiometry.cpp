// SPDX-License-Identifier: Apache-2.0
#include "pipescout/thermal/radiometry.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "pipescout/validation/check.hpp"

namespace pipescout::thermal {
namespace {

using validation::refuse;
using validation::require;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kLeastDistance = 1e-3;  // m, where derivatives are taken at the least
constexpr double kLeastHumidity = 1e-4;

// FLIR's fit: g/m^3 of saturated air is the exponential of a cubic in degC.
constexpr double kWater0 = 1.5587;
constexpr double kWater1 = 6.939e-2;
constexpr double kWater2 = -2.7816e-4;
constexpr double kWater3 = 6.8455e-7;

void require_temperature(const char* field, double value) {
  require(field, value, value > -kZeroCelsius && value < 2000, "(-273.15, 2000) degC");
}

/// Transmission of a stretch of air, and its derivatives.
struct AirDerivatives {
  double distance = 0;
  double temperature = 0;
  double humidity = 0;
};

AirDerivatives derivatives_of_air(const AtmosphereConstants& a, double distance, double temperature,
                                  double humidity) {
  const double d = std::max(distance, kLeastDistance);
  const double h = std::max(humidity, kLeastHumidity);
  const double root_d = std::sqrt(d);
  const double water = water_content(temperature, h);
  const double root_w = std::sqrt(water);
  const double first = a.x * std::exp(-root_d * (a.alpha1 + a.beta1 * root_w));
  const double second = (1 - a.x) * std::exp(-root_d * (a.alpha2 + a.beta2 * root_w));
  const double by_root_d =
      -first * (a.alpha1 + a.beta1 * root_w) - second * (a.alpha2 + a.beta2 * root_w);
  const double by_water = -root_d * (first * a.beta1 + second * a.beta2) / (2 * root_w);
  const double water_by_temperature =
      water * (kWater1 + temperature * (2 * kWater2 + temperature * 3 * kWater3));
  return {.distance = by_root_d / (2 * root_d),
          .temperature = by_water * water_by_temperature,
          .humidity = by_water * water / h};
}

}  // namespace

std::string_view to_string(AirPath path) noexcept {
  switch (path) {
    case AirPath::kBeforeWindow:
      return "before_window";
    case AirPath::kWindowMidway:
      return "window_midway";
  }
  return "unknown";
}

void PlanckConstants::validate() const {
  require("planck.r1", r1, r1 > 0, "(0, inf)");
  require("planck.r2", r2, r2 > 0, "(0, inf)");
  require("planck.b", b, b >= 100 && b <= 10000, "[100, 10000] K");
  require("planck.f", f, f >= 0.1 && f <= 10, "[0.1, 10]");
  require("planck.o", o, true, "(-inf, inf)");
}

double PlanckConstants::counts(double temperature) const noexcept {
  const double kelvin = temperature + kZeroCelsius;
  if (!(kelvin > 0)) {
    return kNaN;
  }
  const double denominator = std::exp(b / kelvin) - f;
  return denominator > 0 ? r1 / (r2 * denominator) - o : kNaN;
}

double PlanckConstants::slope(double temperature) const noexcept {
  const double kelvin = temperature + kZeroCelsius;
  if (!(kelvin > 0)) {
    return kNaN;
  }
  const double exponential = std::exp(b / kelvin);
  const double denominator = exponential - f;
  if (!(denominator > 0)) {
    return kNaN;
  }
  // Ordered so that the square of a large exponential does not overflow.
  return r1 / (r2 * denominator) * (exponential / denominator) * (b / (kelvin * kelvin));
}

double PlanckConstants::temperature(double black_body_counts) const noexcept {
  const double signal = black_body_counts + o;
  if (!(signal > 0) || !std::isfinite(signal)) {
    return kNaN;
  }
  const double logarithm = std::log(r1 / (r2 * signal) + f);
  return logarithm > 0 ? b / logarithm - kZeroCelsius : kNaN;
}

void AtmosphereConstants::validate() const {
  require("atmosphere.alpha1", alpha1, true, "(-inf, inf)");
  require("atmosphere.alpha2", alpha2, true, "(-inf, inf)");
  require("atmosphere.beta1", beta1, true, "(-inf, inf)");
  require("atmosphere.beta2", beta2, true, "(-inf, inf)");
  require("atmosphere.x", x, true, "(-inf, inf)");
}

void CameraConstants::validate() const {
  planck.validate();
  atmosphere.validate();
  if (to_string(path) == "unknown") {
    refuse("path: ", static_cast<int>(path), " is not an enumerator");
  }
}

void ObjectParameters::validate() const {
  require("emissivity", emissivity, emissivity > 0 && emissivity <= 1, "(0, 1]");
  require_temperature("reflected_temperature", reflected_temperature);
  require("distance", distance, distance >= 0 && distance <= 10000, "[0, 10000] m");
  require("atmospheric_temperature", atmospheric_temperature,
          atmospheric_temperature >= -60 && atmospheric_temperature <= 80, "[-60, 80] degC");
  require("relative_humidity", relative_humidity, relative_humidity >= 0 && relative_humidity <= 1,
          "[0, 1]");
  require_temperature("window_temperature", window_temperature);
  require("window_transmission", window_transmission,
          window_transmission > 0 && window_transmission <= 1, "(0, 1]");
}

ObjectParameters ibarguren2013_object() noexcept {
  return {.emissivity = 0.04,
          .reflected_temperature = 10,
          .distance = 10,
          .atmospheric_temperature = 10,
          .relative_humidity = 0.5,
          .window_temperature = 10,
          .window_transmission = 1};
}

double water_content(double atmospheric_temperature, double relative_humidity) noexcept {
  const double t = atmospheric_temperature;
  return relative_humidity * std::exp(kWater0 + t * (kWater1 + t * (kWater2 + t * kWater3)));
}

double air_transmission(const AtmosphereConstants& a, double distance,
                        double atmospheric_temperature, double relative_humidity) noexcept {
  const double root_d = std::sqrt(distance);
  const double root_w = std::sqrt(water_content(atmospheric_temperature, relative_humidity));
  return a.x * std::exp(-root_d * (a.alpha1 + a.beta1 * root_w)) +
         (1 - a.x) * std::exp(-root_d * (a.alpha2 + a.beta2 * root_w));
}

Radiometry::Radiometry(const CameraConstants& camera, const ObjectParameters& object)
    : camera_(camera), object_(object) {
  camera_.validate();
  object_.validate();
  const bool midway = camera_.path == AirPath::kWindowMidway;
  air_ = air_transmission(camera_.atmosphere, midway ? object_.distance / 2 : object_.distance,
                          object_.atmospheric_temperature, object_.relative_humidity);
  // Rounding alone takes dry air over no distance past 1.
  if (!(air_ > 0) || air_ > 1 + 1e-9) {
    refuse("distance: over ", object_.distance, " m of air of ", object_.atmospheric_temperature,
           " degC and humidity ", object_.relative_humidity, " the share that passes, ", air_,
           ", is outside (0, 1]");
  }
  air_ = std::min(air_, 1.0);
  const PlanckConstants& planck = camera_.planck;
  const double reflected = planck.counts(object_.reflected_temperature);
  const double air = planck.counts(object_.atmospheric_temperature);
  const double window = planck.counts(object_.window_temperature);
  require("reflected_temperature", object_.reflected_temperature, std::isfinite(reflected),
          "what has counts with these Planck constants");
  require("atmospheric_temperature", object_.atmospheric_temperature, std::isfinite(air),
          "what has counts with these Planck constants");
  require("window_temperature", object_.window_temperature, std::isfinite(window),
          "what has counts with these Planck constants");
  const double e = object_.emissivity;
  const double w = object_.window_transmission;
  const double behind = midway ? air_ : 1;
  emitted_ = behind * w * e * air_;
  background_ = behind * (w * ((1 - e) * air_ * reflected + (1 - air_) * air) + (1 - w) * window) +
                (1 - behind) * air;
}

double Radiometry::temperature(double counts) const noexcept {
  return camera_.planck.temperature((counts - background_) / emitted_);
}

double Radiometry::counts(double temperature) const noexcept {
  return emitted_ * camera_.planck.counts(temperature) + background_;
}

double Radiometry::slope(double temperature) const noexcept {
  return emitted_ * camera_.planck.slope(temperature);
}

double Radiometry::floor_counts() const noexcept {
  return background_ - emitted_ * camera_.planck.o;
}

double Radiometry::transmission() const noexcept {
  return emitted_ / object_.emissivity;
}

Sensitivity Radiometry::sensitivity(double counts) const noexcept {
  const PlanckConstants& planck = camera_.planck;
  const bool midway = camera_.path == AirPath::kWindowMidway;
  const double object = (counts - background_) / emitted_;
  const double reflected = planck.counts(object_.reflected_temperature);
  const double air = planck.counts(object_.atmospheric_temperature);
  const double window = planck.counts(object_.window_temperature);
  const double e = object_.emissivity;
  const double w = object_.window_transmission;
  const double t = air_;
  const double behind = midway ? t : 1;
  const double from_object = e * object + (1 - e) * reflected;
  const double before_window = t * from_object + (1 - t) * air;

  // Of the signal, the temperature of the object held.
  double by_air = behind * w * (from_object - air);
  if (midway) {
    by_air += w * before_window + (1 - w) * window - air;
  }
  const AirDerivatives of_air =
      derivatives_of_air(camera_.atmosphere, midway ? object_.distance / 2 : object_.distance,
                         object_.atmospheric_temperature, object_.relative_humidity);
  const double share_of_air = behind * w * (1 - t) + (1 - behind);
  Sensitivity signal;
  signal.counts = -1;
  signal.emissivity = behind * w * t * (object - reflected);
  signal.reflected_temperature =
      behind * w * (1 - e) * t * planck.slope(object_.reflected_temperature);
  signal.distance = by_air * of_air.distance * (midway ? 0.5 : 1);
  signal.atmospheric_temperature =
      by_air * of_air.temperature + share_of_air * planck.slope(object_.atmospheric_temperature);
  signal.relative_humidity = by_air * of_air.humidity;
  signal.window_temperature = behind * (1 - w) * planck.slope(object_.window_temperature);
  signal.window_transmission = behind * (before_window - window);

  // The counts are what they are: the temperature makes up for what the parameter changes.
  const double per_count = -1 / slope(temperature(counts));
  return {.counts = per_count * signal.counts,
          .emissivity = per_count * signal.emissivity,
          .reflected_temperature = per_count * signal.reflected_temperature,
          .distance = per_count * signal.distance,
          .atmospheric_temperature = per_count * signal.atmospheric_temperature,
          .relative_humidity = per_count * signal.relative_humidity,
          .window_temperature = per_count * signal.window_temperature,
          .window_transmission = per_count * signal.window_transmission};
}

Radiometry apparent_radiometry(const CameraConstants& camera) {
  return {camera, {.emissivity = 1, .distance = 0}};
}

}  // namespace pipescout::thermal
