// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "pipescout/geometry/camera.hpp"
#include "pipescout/geometry/geodesy.hpp"
#include "pipescout/leak_findings/leak_findings.hpp"
#include "pipescout/thermal/leak_detector.hpp"

namespace YAML {
class Node;
}

namespace pipescout {

/// Description of how the images of a folder were taken.
struct SurveySettings {
  thermal::DetectorPreset preset = thermal::kDefaultPreset;
  std::optional<double> field_of_view;               ///< rad, across the whole width of an image
  std::optional<geometry::CameraParameters> camera;  ///< instead of a field of view
  double frame_rate = 9;                             ///< 1/s, of images without time
  double position_deviation = 0.2;                   ///< m per axis, of poses without it
  double orientation_deviation = 0.02;               ///< rad per axis, likewise
  /// YAML map of the parameters of component `leak_inspector` that differ from the preset; empty:
  /// none.
  std::string parameters;
  // The resulting parameters, valid:
  thermal::LeakDetectorParameters detector = thermal::LeakDetectorParameters::of(preset);
  leak_findings::LeakFindingsParameters findings;
  std::optional<geometry::GeodeticPosition> datum;
  std::string weather;
  std::string calibration;
};

/// Sets detector and findings to a preset changed by the entry `parameters` of the settings, a YAML
/// map in the file of this name. Throws std::runtime_error, "name:line: ...", for a parameter that
/// is unknown or of a wrong type, and std::invalid_argument for values that do not fit together.
/// `pipescout/thermal_parameters/survey_parameters.hpp` has the one of `leak_inspector`.
using SurveyParametersReader = std::function<void(
    const YAML::Node& parameters, const std::string& file, thermal::DetectorPreset preset,
    thermal::LeakDetectorParameters& detector, leak_findings::LeakFindingsParameters& findings)>;

/// Of YAML, every entry of which may be left out:
///
///     preset: collectors                  # torresol, hot_pipes, cold_pipes or contrast
///     field_of_view: 24.6                 # degrees, across the whole width of a picture
///     camera: {width: 640, height: 512, focal_length: 1467, centre_u: 319.5, centre_v: 255.5}
///                                         # in its place; geometry::CameraParameters
///     camera_position: [0.3, 0, 1.2]      # m, of the optical frame in the base frame
///     camera_roll_pitch_yaw: [-90, 0, 0]  # degrees
///     range: {source: distance, distance: 10, distance_deviation: 1}
///                                         # or none; diameter, pipe_diameter; lines
///                                         # and width_deviation, line_deviation
///     lines: [[[0, 8, 2], [150, 8, 2]]]   # m, axes of the pipes in the map
///     pose_deviation: {position: 0.2, orientation: 1.1}   # m, degrees
///     frame_rate: 9
///     datum: {latitude: 36.66, longitude: -5.8, altitude: 60}
///     weather: clear night, 14 degC, wind 2 m/s
///     calibration: black body at 100 degC, 2013-09-02
///     parameters: {threshold: 90.0}       # of leak_inspector, by its names and in its units; but
///                                         # for those that have an entry here or in thermal.yaml
///
/// `preset`: in place of that of the text. Throws std::runtime_error, "name:line: ...", for a name
/// that is unknown or given twice, and for a value of a wrong type or out of range.
[[nodiscard]] SurveySettings parse_survey_settings(
    const std::string& text, const std::string& name, const SurveyParametersReader& read_parameters,
    std::optional<thermal::DetectorPreset> preset = std::nullopt);

/// Read back, the same: all but the angles to the last bit.
[[nodiscard]] std::string to_yaml(const SurveySettings& settings);

}  // namespace pipescout
