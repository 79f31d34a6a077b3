// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pipescout/thermal/radiometry.hpp"

namespace pipescout::thermal {

/// Standard deviations of what a temperature is computed from. All finite and not negative.
struct ParameterDeviations {
  double counts = 0;  ///< noise of a pixel, or of the mean that is given in its place
  /// K, of the camera's calibration; the same for all pixels. The default takes the +-2 K of the
  /// usual data sheet for 95 %.
  double calibration = 1;
  double emissivity = 0.02;
  double reflected_temperature = 3;  ///< K
  double distance = 0.5;             ///< m
  double atmospheric_temperature = 3;
  double relative_humidity = 0.1;
  double window_temperature = 3;
  double window_transmission = 0;
  void validate() const;
};

/// A temperature, or a difference of two, with what is known of it.
struct TemperatureInterval {
  double mean = 0;       ///< degC or K; NaN where the counts have no temperature
  double deviation = 0;  ///< K, standard
  /// The mean, and 1.96 deviations to either side: 95 % where all is normal and small.
  double low = 0;
  double high = 0;
};

/// To first order, all parameters independent of each other. Far from small deviations it is only a
/// guide: of an emissivity of 0.04 +- 0.02, half is missing.
[[nodiscard]] TemperatureInterval temperature_interval(const Radiometry& radiometry, double counts,
                                                       const ParameterDeviations& deviations);

/// Of the temperature at `counts` less that at `base_counts`, one object and one image: errors of
/// the parameters and of the calibration are shared, noise is not.
[[nodiscard]] TemperatureInterval difference_interval(const Radiometry& radiometry, double counts,
                                                      double base_counts,
                                                      const ParameterDeviations& deviations);

/// What the temperatures of a picture were computed by, and how far that may be off.
struct TemperatureErrors {
  Radiometry radiometry;
  ParameterDeviations deviations{};

  /// K, standard, of a difference of two temperatures in that picture, degC, as
  /// `difference_interval`; NaN where one of them has no counts.
  [[nodiscard]] double of_difference(double temperature, double base) const;
};

}  // namespace pipescout::thermal
