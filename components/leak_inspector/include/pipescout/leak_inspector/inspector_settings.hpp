// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "pipescout/geometry/geodesy.hpp"
#include "pipescout/geometry/se3.hpp"
#include "pipescout/interfaces/bound_parameters.hpp"
#include "pipescout/interfaces/parameters.hpp"
#include "pipescout/interfaces/stamp_limits.hpp"
#include "pipescout/leak_findings/leak_findings.hpp"
#include "pipescout/leak_store/leak_store.hpp"
#include "pipescout/thermal/leak_detector.hpp"
#include "pipescout/thermal/radiometry.hpp"
#include "pipescout/thermal/temperature_table.hpp"

namespace pipescout {

/// What the component is configured with.
struct InspectorSettings {
  std::string map_frame;
  StampLimits stamp_limits;
  double silent_after = 0;                   ///< s
  thermal::LeakDetectorParameters detector;  ///< valid
  /// degC of the counts of `mono16` pictures; nothing: the camera is not described.
  std::optional<thermal::TemperatureTable> counts;
  /// degC of the grey levels of `mono8` pictures; nothing: not described.
  std::optional<thermal::TemperatureTable> grey;
  leak_findings::LeakFindingsParameters findings;  ///< valid
  std::string store;                               ///< file; empty: none
  std::string report_folder;                       ///< empty: none
  ConditionRecord conditions;
  std::optional<geometry::GeodeticPosition> datum;
};

/// The parameters of the component: docs/components/leak_inspector.md.
class InspectorParameters {
 public:
  /// Declares them, with the defaults of the preset that parameter `preset` names. Throws
  /// ParameterError for a preset that there is not.
  explicit InspectorParameters(Parameters& parameters);

  /// Throws std::invalid_argument naming the parameter.
  [[nodiscard]] InspectorSettings read() const;

 private:
  struct Preset {
    thermal::LeakDetectorParameters detector;
    leak_findings::LeakFindingsParameters findings;
    thermal::ObjectParameters object;
    std::vector<double> grey_range;
  };
  [[nodiscard]] static Preset preset(const std::string& name);

  void declare_detector(Parameters& parameters);
  void declare_camera(Parameters& parameters);
  void declare_object();
  void declare_findings(Parameters& parameters);
  void declare_archive(Parameters& parameters);
  void declare_messages(Parameters& parameters);
  [[nodiscard]] std::optional<thermal::CameraConstants> camera_constants() const;
  [[nodiscard]] std::optional<thermal::TemperatureTable> counts() const;
  [[nodiscard]] std::optional<thermal::TemperatureTable> grey() const;
  [[nodiscard]] std::vector<leak_findings::PipeLine> lines() const;
  [[nodiscard]] ConditionRecord conditions() const;
  [[nodiscard]] std::optional<geometry::GeodeticPosition> datum() const;

  Preset defaults_;
  std::optional<BoundParameters<thermal::LeakDetectorParameters>> detector_;
  std::optional<BoundParameters<thermal::ObjectParameters>> object_;
  std::optional<BoundParameters<leak_findings::LeakFindingsParameters>> findings_;
  Parameter<std::string> threshold_rule_;
  Parameter<std::string> polarity_;
  Parameter<std::vector<double>> leak_delta_;
  Parameter<std::vector<double>> maximum_temperature_;
  Parameter<std::vector<double>> planck_;
  Parameter<std::vector<double>> linear_;
  Parameter<std::vector<double>> grey_range_;
  Parameter<std::string> range_source_;
  Parameter<std::vector<double>> lines_;
  Parameter<std::string> store_;
  Parameter<std::string> report_folder_;
  Parameter<std::string> weather_;
  Parameter<std::vector<double>> datum_;
  Parameter<std::string> map_frame_;
  Parameter<std::vector<double>> camera_position_;
  Parameter<std::vector<double>> camera_roll_pitch_yaw_;
  Parameter<double> maximum_age_;
  Parameter<double> maximum_lead_;
  Parameter<double> silent_after_;
};

}  // namespace pipescout
