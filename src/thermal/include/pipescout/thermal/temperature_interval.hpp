// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pipescout/thermal/radiometry.hpp"

namespace pipescout::thermal {

/// Standard deviations of the inputs of a temperature. All finite and not negative.
struct ParameterDeviations {
  double counts = 0;  ///< noise of a pixel, or of a mean given instead
  /// K, of the camera's calibration; the same for all pixels. The default interprets the usual +-2
  /// K of data sheets as 95 %.
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

/// A temperature, or a difference of two, with its uncertainty.
struct TemperatureInterval {
  double mean = 0;       ///< degC or K; NaN where the counts have no temperature
  double deviation = 0;  ///< K, standard
  /// The mean, and 1.96 standard deviations to either side: 95 % for small normal errors.
  double low = 0;
  double high = 0;
};

/// To first order, all parameters independent of each other. For large deviations, such as an
/// emissivity of 0.04 +- 0.02, it is only approximate.
[[nodiscard]] TemperatureInterval temperature_interval(const Radiometry& radiometry, double counts,
                                                       const ParameterDeviations& deviations);

/// Of the difference of the temperatures at `counts` and at `base_counts`, for one object and one
/// image: errors of the parameters and of the calibration are common, noise is not.
[[nodiscard]] TemperatureInterval difference_interval(const Radiometry& radiometry, double counts,
                                                      double base_counts,
                                                      const ParameterDeviations& deviations);

/// Conditions of the conversion of an image, and their uncertainty.
struct TemperatureErrors {
  Radiometry radiometry;
  ParameterDeviations deviations{};

  /// K, standard, of a difference of two temperatures in that picture, degC, as
  /// `difference_interval`; NaN where one of them has no counts.
  [[nodiscard]] double of_difference(double temperature, double base) const;
};

}  // namespace pipescout::thermal
