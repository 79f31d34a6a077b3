// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "pipescout/leak_survey/survey_settings.hpp"

namespace pipescout {

struct LeakSurveyOptions {
  /// Reader of the entry `parameters` of `survey.yaml`, with the preset as default. Must be set.
  SurveyParametersReader read_parameters;
  /// Folder of the images, which are processed in the order in which they were taken, as far as
  /// poses and files tell, and otherwise in the natural order of their names; sequences frame by
  /// frame. Subfolders and files with other extensions are ignored, but recordings of thermal
  /// cameras in formats that are not read are named and counted. `thermal.yaml`
  /// (read_thermal_settings) and `survey.yaml` (parse_survey_settings) in it are optional. Or the
  /// folder of a mission with recorded images: PictureRecording.
  std::filesystem::path pictures;
  /// Folder of leaks.sqlite, which may exist with findings of other days, report.html,
  /// leaks.geojson, leaks.kml and leaks.csv. Created when it does not exist.
  std::filesystem::path out;
  /// CSV: parse_survey_poses. Nothing: `poses.csv` in the folder of the images, if it exists.
  std::optional<std::filesystem::path> poses;
  std::optional<thermal::DetectorPreset> preset;  ///< instead of that of the settings
  std::string exiftool = "exiftool";
  std::string made;                ///< time and program, for the report
  std::size_t most_pictures = 60;  ///< largest number shown in the report
  /// Called before each image, and once with `done` == `total` at the end.
  std::function<void(std::size_t done, std::size_t total)> progress;
  /// Called with the problem of an unusable image, which is in the report too.
  std::function<void(const std::string& problem)> complain;
};

struct LeakSurveyResult {
  std::size_t pictures = 0;      ///< read
  std::size_t failed = 0;        ///< not read, or without temperatures; unread recordings too
  std::size_t out_of_order = 0;  ///< taken before the previous image: they do not update findings
  std::size_t same_time = 0;     ///< with the time of the previous one, which they follow
  std::size_t without_pose = 0;  ///< while others have one: leaks in them have no position
  std::size_t levels = 0;        ///< of automatic gain, without degrees
  std::string degrees;           ///< how sure they are: degrees_text
  /// What to do about images that could not be used, or about images without pipes: sentences.
  std::vector<std::string> advice;
  std::size_t with_pipes = 0;
  std::size_t leak_detections = 0;
  std::size_t raised = 0;      ///< findings that are raised now, including those of other days
  std::size_t candidates = 0;  ///< with insufficient evidence
};

/// Throws std::runtime_error where the folder, the settings, the poses, the store or the results
/// cannot be read or written, or when the folder contains no image. Problems of single images are
/// counted and reported; the next one is not affected.
LeakSurveyResult survey_leaks(const LeakSurveyOptions& options);

}  // namespace pipescout
