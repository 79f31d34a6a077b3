// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "pipescout/thermal/radiometry.hpp"
#include "pipescout/thermal/radiometry_posterior.hpp"
#include "pipescout/thermal/temperature_interval.hpp"
#include "pipescout/thermal/temperature_table.hpp"

/// Settings for reading the thermal images of a folder, which supplement or override the metadata
/// of the files.
namespace pipescout {

/// Object parameters that override others.
struct ObjectChanges {
  std::optional<double> emissivity;
  std::optional<double> reflected_temperature;
  std::optional<double> distance;
  std::optional<double> atmospheric_temperature;
  std::optional<double> relative_humidity;
  std::optional<double> window_temperature;
  std::optional<double> window_transmission;

  /// All of them.
  [[nodiscard]] static ObjectChanges to(const thermal::ObjectParameters& object);
  [[nodiscard]] thermal::ObjectParameters apply(thermal::ObjectParameters object) const;
};

/// degC = gain * count + offset.
struct LinearScale {
  double gain = 0;
  double offset = 0;
};

/// degC of grey level 0 and of 255.
struct GreyScale {
  double black = 0;
  double white = 0;
};

enum class TemperatureUnit : std::uint8_t { kCelsius, kKelvin };

/// A rectangle whose object differs from the rest of the image.
struct RegionChanges {
  int x = 0;
  int y = 0;
  int width = 0;
  int height = 0;
  ObjectChanges object;
};

struct ThermalSettings {
  std::optional<LinearScale> scale;                ///< of 16-bit pictures
  std::optional<thermal::PlanckConstants> planck;  ///< of 16-bit images, instead of a scale
  std::optional<GreyScale> grey;                   ///< of 8-bit pictures
  /// 8-bit pictures are of automatic gain: their levels mean no temperatures.
  bool automatic_gain = false;
  TemperatureUnit float_unit = TemperatureUnit::kCelsius;  ///< of 32-bit pictures
  thermal::AirPath air_path = thermal::AirPath::kBeforeWindow;
  ObjectChanges object;
  std::vector<RegionChanges> regions;
  std::optional<thermal::CountRange> range;  ///< range outside which the sensor is saturated
  thermal::ParameterDeviations deviations;
  /// Of the sound pipes, with the contrast rule.
  thermal::PipeTemperatureRange pipe_temperature = thermal::collector_temperatures();
};

/// Of a YAML file, every entry of which may be left out:
///
///     preset: ibarguren2013         # all object parameters; `object` changes them further
///     object: {emissivity: 0.9, reflected_temperature: 5, distance: 12, ...}
///     regions:
///       - {x: 10, y: 20, width: 30, height: 40, object: {emissivity: 0.3}}
///     deviations: {emissivity: 0.05, calibration: 1, ...}
///     scale: {gain: 0.01, offset: -273.15}
///     planck: {r1: 21106.77, r2: 0.012545, b: 1501, f: 1, o: -7340}
///     grey: {black: 100, white: 300} # or automatic_gain
///     pipe_temperature: {least: 100, most: 400}
///     float_unit: celsius           # or kelvin
///     air_path: before_window       # or window_midway
///     range: {least: 0, most: 65535}
///
/// Throws std::runtime_error naming the file, and the line if applicable, for a file that cannot be
/// read, a name that is unknown or given twice, and a value of a wrong type or out of range.
[[nodiscard]] ThermalSettings read_thermal_settings(const std::filesystem::path& file);

/// The same of a text; `name` is for messages.
[[nodiscard]] ThermalSettings parse_thermal_settings(const std::string& text,
                                                     const std::string& name);

/// Read back, the same bits.
[[nodiscard]] std::string to_yaml(const ThermalSettings& settings);

}  // namespace pipescout
