// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "pipescout/leak_findings/leak_findings.hpp"
#include "pipescout/leak_survey/survey_settings.hpp"

namespace pipescout {

/// Pose of the robot at the time of an image.
struct PicturePose {
  std::optional<double> time;  ///< s since 1970 UTC
  std::optional<leak_findings::FramePose> pose;
};

struct SurveyPoses {
  std::map<std::string, PicturePose> by_file;  ///< by the file name of the image, or "rec.seq#3"
  /// What was guessed of the table, and that its last line is truncated, as by a full disk, and
  /// ignored.
  std::vector<std::string> notes;
};

/// Of CSV with the columns
///   file, x, y, z, qx, qy, qz, qw            m; orientation of the base in the map; all
///                                            empty: not known
///   time                                     s since 1970 UTC; may be missing
///   x_deviation, y_deviation, z_deviation    m; may be missing: the settings' then
///   rotation_x_deviation, ...                rad, about the axes of the map; likewise
/// in any order, read by CsvReader: times may be dates and times, or in another unit. Throws
/// CsvError for a column that is missing, a file that is named twice, and what is not a number, no
/// rotation or no deviation.
[[nodiscard]] SurveyPoses parse_survey_poses(const std::string& text, const std::string& path,
                                             const SurveySettings& settings);

/// Such a text. `file` is the last column: a line that is cut short is told by its missing.
[[nodiscard]] std::string survey_pose_header();
/// A line of it, without its end. Of the covariance only the standard deviations.
[[nodiscard]] std::string survey_pose_line(const std::string& file, const PicturePose& picture);

}  // namespace pipescout
