// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <yaml-cpp/yaml.h>

#include <string>

#include "pipescout/leak_survey/survey_settings.hpp"

namespace pipescout::test {

/// A SurveyParametersReader in place of the one of component `leak_inspector`: knows `threshold`.
inline void read_threshold(const YAML::Node& parameters, const std::string& file,
                           thermal::DetectorPreset preset,
                           thermal::LeakDetectorParameters& detector,
                           leak_findings::LeakFindingsParameters& findings) {
  detector = thermal::LeakDetectorParameters::of(preset);
  findings = {};
  for (const auto& entry : parameters) {
    if (entry.first.as<std::string>() != "threshold") {
      throw std::runtime_error(file + ":" + std::to_string(entry.first.Mark().line + 1) +
                               ": only threshold is known");
    }
    detector.threshold = entry.second.as<double>();
  }
  detector.validate();
}

}  // namespace pipescout::test
