// SPDX-License-Identifier: Apache-2.0
#include "pipescout/thermal_parameters/survey_parameters.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string_view>
#include <utility>
#include <vector>

#include "pipescout/runtime/parameter_yaml.hpp"
#include "pipescout/thermal_parameters/detection_parameters.hpp"
#include "pipescout/thermal_parameters/findings_parameters.hpp"

namespace pipescout {
namespace {

/// Whether something else in the folder says what this parameter of the inspector does.
bool told_elsewhere(std::string_view parameter) {
  constexpr std::array kElsewhere{"preset", "camera.", "object.", "range."};
  return std::any_of(kElsewhere.begin(), kElsewhere.end(),
                     [&](const char* begin) { return parameter.starts_with(begin); });
}

/// Parameters of the inspector that tell what a leak is.
struct Declared {
  Declared(thermal::DetectorPreset preset, std::vector<ParameterOverride> overrides)
      : parameters(with(preset, std::move(overrides))),
        detection(parameters),
        findings(parameters) {}

  Parameters parameters;
  DetectionParameters detection;
  FindingsParameters findings;

 private:
  static std::vector<ParameterOverride> with(thermal::DetectorPreset preset,
                                             std::vector<ParameterOverride> overrides) {
    overrides.push_back({.name = "preset", .value = to_string(preset)});
    return overrides;
  }
};

}  // namespace

void read_survey_parameters(const YAML::Node& parameters, const std::string& file,
                            thermal::DetectorPreset preset,
                            thermal::LeakDetectorParameters& detector,
                            leak_findings::LeakFindingsParameters& findings) {
  std::vector<ParameterOverride> overrides = read_parameter_map(parameters, file);
  for (const ParameterOverride& told : overrides) {
    if (told_elsewhere(told.name)) {
      throw std::runtime_error(told.source + ": parameter '" + told.name +
                               "' has a separate entry, here or in thermal.yaml");
    }
  }
  const Declared declared(preset, std::move(overrides));
  for (const UnusedOverride& unused : declared.parameters.unused_overrides()) {
    throw std::runtime_error(to_string(unused));
  }
  detector = declared.detection.read().detector;
  findings = declared.findings.read(detector);
}

std::string survey_parameters(const Parameters& inspector) {
  const std::string preset = inspector.get("preset").get<std::string>();
  const Declared standard(thermal::detector_preset(preset).value(), {});
  YAML::Emitter text;
  text << YAML::Flow << YAML::BeginMap;
  for (const NamedParameter& known : standard.parameters.all()) {
    const ParameterValue value = inspector.get(known.name);
    if (!told_elsewhere(known.name) && value != known.value) {
      text << YAML::Key << known.name << YAML::Value << YAML::Load(to_yaml(value));
    }
  }
  text << YAML::EndMap;
  return text.c_str();
}

}  // namespace pipescout
