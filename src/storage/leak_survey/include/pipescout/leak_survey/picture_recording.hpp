// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>

#include "pipescout/files/whole_file.hpp"
#include "pipescout/geometry/camera.hpp"
#include "pipescout/leak_findings/leak_findings.hpp"
#include "pipescout/leak_survey/survey_settings.hpp"
#include "pipescout/thermal_files/thermal_file.hpp"

namespace pipescout {

/// In a folder of pictures: read_thermal_settings, parse_survey_settings, parse_survey_poses.
inline constexpr const char* kThermalFile = "thermal.yaml";
inline constexpr const char* kSurveyFile = "survey.yaml";
inline constexpr const char* kPosesFile = "poses.csv";
/// In a mission folder, with the pictures that were recorded.
inline constexpr const char* kMissionPictures = "thermal_pictures";

/// Keeps the pictures of a thermal camera as they come, bit by bit, with all that `survey_leaks`
/// needs to look at them again: TIFF files whose names are in the order in which they came,
/// `thermal.yaml`, `survey.yaml` and `poses.csv`. What was added is whole and stays when the
/// process is killed. Not thread-safe.
class PictureRecording {
 public:
  /// Makes the folder and `thermal.yaml`. `survey`: without camera. Poses are recorded of the
  /// camera's optical frame, which may have moved on the robot: `findings.T_base_camera` is used
  /// where a frame does not tell its own. Throws std::system_error for a folder that cannot be made
  /// or written, and std::runtime_error for one that is not empty; both name it.
  PictureRecording(std::filesystem::path folder, const ThermalSettings& thermal,
                   SurveySettings survey);
  /// A recording without pictures leaves nothing behind.
  ~PictureRecording();
  PictureRecording(const PictureRecording&) = delete;
  PictureRecording& operator=(const PictureRecording&) = delete;

  /// The time must rise from frame to frame, and the camera be the same all along. Throws
  /// std::system_error naming the file, when the disk is full for one: the picture is then left
  /// out, and the next one may be added.
  void add(const ThermalView& picture, const leak_findings::Frame& frame,
           const geometry::CameraParameters& camera);

  [[nodiscard]] std::size_t pictures() const noexcept { return pictures_; }

 private:
  void discard() noexcept;

  std::filesystem::path folder_;
  SurveySettings survey_;
  geometry::SE3 T_base_camera_;  // where a frame does not tell
  std::optional<LineFile> poses_;
  std::size_t pictures_ = 0;
};

}  // namespace pipescout
