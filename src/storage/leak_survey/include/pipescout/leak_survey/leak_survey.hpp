// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "pipescout/leak_survey/survey_settings.hpp"

namespace pipescout {

struct LeakSurveyOptions {
  /// Of the entry `parameters` of `survey.yaml`, and of what it leaves to the preset. Must be set.
  SurveyParametersReader read_parameters;
  /// With the pictures, which are taken in the order of their names; what has another extension is
  /// passed over, and so are folders in it. `thermal.yaml` (read_thermal_settings) and
  /// `survey.yaml` (parse_survey_settings) in it count, where they are there. Or the folder of a
  /// mission that kept its pictures: PictureRecording.
  std::filesystem::path pictures;
  /// Gets leaks.sqlite, which may be there already with findings of other days, report.html,
  /// leaks.geojson, leaks.kml and leaks.csv. Made when it does not exist.
  std::filesystem::path out;
  /// CSV: parse_survey_poses. Nothing: `poses.csv` with the pictures, where it is there.
  std::optional<std::filesystem::path> poses;
  std::optional<thermal::DetectorPreset> preset;  ///< in place of that of the settings
  std::string exiftool = "exiftool";
  std::string made;                ///< when, and by what, for the report
  std::size_t most_pictures = 60;  ///< that the report shows
  /// Called before each picture, and once with `done` == `total` at the end.
  std::function<void(std::size_t done, std::size_t total)> progress;
  /// Of what a picture that cannot be used says; it is in the report too.
  std::function<void(const std::string& problem)> complain;
};

struct LeakSurveyResult {
  std::size_t pictures = 0;      ///< read
  std::size_t failed = 0;        ///< not read, or without temperatures
  std::size_t out_of_order = 0;  ///< taken before the picture before: they count for no finding
  std::size_t without_pose = 0;  ///< while others have one: leaks in them have no place
  std::size_t with_pipes = 0;
  std::size_t leak_detections = 0;
  std::size_t raised = 0;      ///< findings that are raised now, those of other days included
  std::size_t candidates = 0;  ///< for which there was too little evidence
};

/// Throws std::runtime_error where the folder, the settings, the poses, the store or the results
/// cannot be read or written, or where there is no picture in the folder. What is wrong with one
/// picture is counted and told; the next one is not affected.
LeakSurveyResult survey_leaks(const LeakSurveyOptions& options);

}  // namespace pipescout
