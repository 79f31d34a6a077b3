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

/// In a folder of images: read_thermal_settings, parse_survey_settings, parse_survey_poses.
inline constexpr const char* kThermalFile = "thermal.yaml";
inline constexpr const char* kSurveyFile = "survey.yaml";
inline constexpr const char* kPosesFile = "poses.csv";
/// Subfolder of a mission folder with recorded images.
inline constexpr const char* kMissionPictures = "thermal_pictures";

/// Records the unchanged images of a thermal camera with the input that `survey_leaks` needs to
/// process them again: TIFF files with names in the order of arrival, `thermal.yaml`, `survey.yaml`
/// and `poses.csv`. Added images are complete and survive a kill of the process. Not thread-safe.
class PictureRecording {
 public:
  /// Creates the folder and `thermal.yaml`. `survey`: without camera. Recorded poses are those of
  /// the camera's optical frame, which may move on the robot: `findings.T_base_camera` is used for
  /// frames without their own. Throws std::system_error for a folder that cannot be created or
  /// written, and std::runtime_error for one that is not empty; both name it.
  PictureRecording(std::filesystem::path folder, const ThermalSettings& thermal,
                   SurveySettings survey);
  /// A recording without images is removed.
  ~PictureRecording();
  PictureRecording(const PictureRecording&) = delete;
  PictureRecording& operator=(const PictureRecording&) = delete;

  /// Times must increase from frame to frame, and the camera must be the same. Throws
  /// std::system_error naming the file, for example when the disk is full: the image is then
  /// omitted, and the next one may be added.
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
