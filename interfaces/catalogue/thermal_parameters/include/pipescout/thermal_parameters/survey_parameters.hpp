// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "pipescout/leak_findings/leak_findings.hpp"
#include "pipescout/runtime/parameters.hpp"
#include "pipescout/thermal/leak_detector.hpp"

namespace YAML {
class Node;
}

/// Parameters of `leak_inspector` in the settings of a survey of recorded pictures: only those that
/// tell what a leak is. The others (preset, camera, object, range) have entries of their own there.
namespace pipescout {

/// What a preset comes to with these parameters, a YAML map in `file`. Throws std::runtime_error,
/// "file:line: ...", for a name that is not known or has an entry of its own and for a value of a
/// wrong type or out of its range; std::invalid_argument for values that do not fit together.
void read_survey_parameters(const YAML::Node& parameters, const std::string& file,
                            thermal::DetectorPreset preset,
                            thermal::LeakDetectorParameters& detector,
                            leak_findings::LeakFindingsParameters& findings);

/// Such a map of the parameters of a `leak_inspector` that are not as its preset has them.
[[nodiscard]] std::string survey_parameters(const Parameters& inspector);

}  // namespace pipescout
