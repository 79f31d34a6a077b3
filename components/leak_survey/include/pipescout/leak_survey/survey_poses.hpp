// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <string>

#include "pipescout/leak_findings/leak_findings.hpp"
#include "pipescout/leak_survey/survey_settings.hpp"

namespace pipescout {

/// Where the robot was when a picture was taken.
struct PicturePose {
  std::optional<double> time;  ///< s since 1970 UTC
  leak_findings::FramePose pose;
};

/// By the name of the picture's file, of CSV with the columns
///   file, x, y, z, qx, qy, qz, qw            m; orientation of the base in the map
///   time                                     s since 1970 UTC; may be missing
///   x_deviation, y_deviation, z_deviation    m; may be missing: the settings' then
///   rotation_x_deviation, ...                rad, about the axes of the map; likewise
/// in any order. Throws CsvError for a column that is missing, a file that is named twice, and what
/// is no number, no rotation or no deviation.
[[nodiscard]] std::map<std::string, PicturePose> parse_survey_poses(const std::string& text,
                                                                    const std::string& path,
                                                                    const SurveySettings& settings);

}  // namespace pipescout
