// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <pipescout/rack_vision/rack_model.hpp>
#include <string>
#include <vector>

#include "pipescout/geometry/geodesy.hpp"
#include "pipescout/geometry/se3.hpp"
#include "pipescout/leak_findings/leak_findings.hpp"
#include "pipescout/leak_store/leak_store.hpp"
#include "pipescout/leak_survey/survey_settings.hpp"
#include "pipescout/message_conversions/camera_mount.hpp"
#include "pipescout/runtime/bound_parameters.hpp"
#include "pipescout/runtime/parameters.hpp"
#include "pipescout/runtime/stamp_limits.hpp"
#include "pipescout/thermal/temperature_interval.hpp"
#include "pipescout/thermal_files/thermal_settings.hpp"
#include "pipescout/thermal_parameters/detection_parameters.hpp"
#include "pipescout/thermal_parameters/findings_parameters.hpp"

namespace pipescout {

/// Configuration of the component.
struct InspectorSettings {
  std::string map_frame;
  StampLimits stamp_limits;
  double silent_after = 0;  ///< s
  DetectionSettings detection;
  /// Of pictures of counts; nothing: the camera is not described by its constants.
  std::optional<thermal::TemperatureErrors> errors;
  /// The same with the contrast rule, instead of `errors`.
  std::optional<thermal::RadiometryPosterior> posterior;
  CameraMount mount{geometry::SE3()};
  leak_findings::LeakFindingsParameters findings;  ///< valid
  /// Its pipes are the first lines of `findings`.
  std::optional<rack_vision::RackModel> rack;
  std::string store;            ///< file; empty: none
  std::string report_folder;    ///< empty: none
  std::string pictures_folder;  ///< empty: none
  ConditionRecord conditions;
  std::optional<geometry::GeodeticPosition> datum;
  // The same, as pictures that are kept tell it:
  ThermalSettings thermal_settings;
  SurveySettings survey_settings;  ///< without the camera, which `camera_info` tells
};

/// The parameters of the component: docs/components/leak_inspector.md.
class InspectorParameters {
 public:
  /// Declares them. Throws as DetectionParameters.
  explicit InspectorParameters(Parameters& parameters);

  /// Throws std::invalid_argument naming the parameter.
  /// YamlError for the rack file.
  [[nodiscard]] InspectorSettings read(Node& node) const;

 private:
  void declare_deviations(Parameters& parameters);
  [[nodiscard]] thermal::PipeTemperatureRange pipe_temperature() const;
  void declare_archive(Parameters& parameters);
  void declare_messages(Parameters& parameters);
  [[nodiscard]] ConditionRecord conditions() const;
  [[nodiscard]] std::optional<geometry::GeodeticPosition> datum() const;
  [[nodiscard]] ThermalSettings thermal_settings() const;
  [[nodiscard]] SurveySettings survey_settings(const InspectorSettings& settings) const;

  const Parameters* parameters_;
  DetectionParameters detection_;
  BoundParameters<thermal::ParameterDeviations> deviations_;
  Parameter<std::vector<double>> pipe_temperature_;
  CameraMountParameters mount_;
  FindingsParameters findings_;
  Parameter<std::string> rack_;
  Parameter<std::string> store_;
  Parameter<std::string> report_folder_;
  Parameter<std::string> pictures_folder_;
  Parameter<std::string> weather_;
  Parameter<std::vector<double>> datum_;
  Parameter<std::string> map_frame_;
  Parameter<double> maximum_age_;
  Parameter<double> maximum_lead_;
  Parameter<double> silent_after_;
};

}  // namespace pipescout
