// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "pipescout/leak_findings/leak_findings.hpp"
#include "pipescout/runtime/parameters.hpp"
#include "pipescout/thermal/leak_detector.hpp"

namespace YAML {
class Node;
}

/// Parameters of `leak_inspector` in the settings of a survey of recorded images: only those that
/// define a leak. The others (preset, camera, object, range) have separate entries there.
namespace pipescout {

/// A preset changed by these parameters, a YAML map in `file`. Throws std::runtime_error,
/// "file:line: ...", for a name that is unknown or has a separate entry, and for a value of a wrong
/// type or out of range; std::invalid_argument for values that do not fit together.
void read_survey_parameters(const YAML::Node& parameters, const std::string& file,
                            thermal::DetectorPreset preset,
                            thermal::LeakDetectorParameters& detector,
                            leak_findings::LeakFindingsParameters& findings);

/// Such a map with the parameters of a `leak_inspector` that differ from its preset.
[[nodiscard]] std::string survey_parameters(const Parameters& inspector);

}  // namespace pipescout
