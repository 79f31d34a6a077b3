// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "pipescout/leak_store/leak_store.hpp"
#include "pipescout/leak_survey/survey_settings.hpp"
#include "pipescout/thermal/leak_detector.hpp"
#include "pipescout/thermal_files/thermal_file.hpp"

/// What the report says of a picture.
namespace pipescout {

/// "640 x 512, flir, 15.9 to 59.7 degC; 1 pipe (640 pixels long), 1 leak (+85.3 +- 4.1 K)", with
/// what is to be added to and taken off Delta-T for 95 % where Planck constants are known.
[[nodiscard]] std::string picture_summary(const ThermalPicture& picture,
                                          const thermal::Detections& detections);

/// Why a frame without detections has none, in words; empty for FrameFault::kNone.
[[nodiscard]] std::string fault_text(thermal::FrameFault fault);

/// With what the picture was looked at.
[[nodiscard]] ConditionRecord condition_record(const ThermalPicture& picture,
                                               const ThermalSettings& thermal,
                                               const SurveySettings& survey, double time,
                                               const std::string& source);

/// The lines, one below the other.
[[nodiscard]] std::string joined_lines(const std::vector<std::string>& lines);

}  // namespace pipescout
