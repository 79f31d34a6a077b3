// SPDX-License-Identifier: Apache-2.0
#include "pipescout/thermal/temperature_interval.hpp"

#include <cmath>

#include "pipescout/statistics/normal.hpp"
#include "pipescout/validation/check.hpp"

namespace pipescout::thermal {
namespace {

using validation::require;

double square(double value) {
  return value * value;
}

/// Variance from all parameters but the counts.
double shared_variance(const Sensitivity& s, const ParameterDeviations& d) {
  return square(s.emissivity * d.emissivity) +
         square(s.reflected_temperature * d.reflected_temperature) +
         square(s.distance * d.distance) +
         square(s.atmospheric_temperature * d.atmospheric_temperature) +
         square(s.relative_humidity * d.relative_humidity) +
         square(s.window_temperature * d.window_temperature) +
         square(s.window_transmission * d.window_transmission);
}

TemperatureInterval around(double mean, double variance) {
  const double deviation = std::sqrt(variance);
  return {.mean = mean,
          .deviation = deviation,
          .low = mean - statistics::kNormal95 * deviation,
          .high = mean + statistics::kNormal95 * deviation};
}

Sensitivity less(const Sensitivity& a, const Sensitivity& b) {
  return {.counts = a.counts - b.counts,
          .emissivity = a.emissivity - b.emissivity,
          .reflected_temperature = a.reflected_temperature - b.reflected_temperature,
          .distance = a.distance - b.distance,
          .atmospheric_temperature = a.atmospheric_temperature - b.atmospheric_temperature,
          .relative_humidity = a.relative_humidity - b.relative_humidity,
          .window_temperature = a.window_temperature - b.window_temperature,
          .window_transmission = a.window_transmission - b.window_transmission};
}

}  // namespace

void ParameterDeviations::validate() const {
  const auto deviation = [](const char* field, double value) {
    require(field, value, value >= 0, "[0, inf)");
  };
  deviation("deviations.counts", counts);
  deviation("deviations.calibration", calibration);
  deviation("deviations.emissivity", emissivity);
  deviation("deviations.reflected_temperature", reflected_temperature);
  deviation("deviations.distance", distance);
  deviation("deviations.atmospheric_temperature", atmospheric_temperature);
  deviation("deviations.relative_humidity", relative_humidity);
  deviation("deviations.window_temperature", window_temperature);
  deviation("deviations.window_transmission", window_transmission);
}

TemperatureInterval temperature_interval(const Radiometry& radiometry, double counts,
                                         const ParameterDeviations& deviations) {
  deviations.validate();
  const Sensitivity s = radiometry.sensitivity(counts);
  return around(radiometry.temperature(counts), square(s.counts * deviations.counts) +
                                                    square(deviations.calibration) +
                                                    shared_variance(s, deviations));
}

TemperatureInterval difference_interval(const Radiometry& radiometry, double counts,
                                        double base_counts, const ParameterDeviations& deviations) {
  deviations.validate();
  const Sensitivity s = radiometry.sensitivity(counts);
  const Sensitivity base = radiometry.sensitivity(base_counts);
  return around(radiometry.temperature(counts) - radiometry.temperature(base_counts),
                (square(s.counts) + square(base.counts)) * square(deviations.counts) +
                    shared_variance(less(s, base), deviations));
}

double TemperatureErrors::of_difference(double temperature, double base) const {
  return difference_interval(radiometry, radiometry.counts(temperature), radiometry.counts(base),
                             deviations)
      .deviation;
}

}  // namespace pipescout::thermal
