// SPDX-License-Identifier: Apache-2.0
#include "pipescout/leak_inspector/inspector_settings.hpp"

#include <cmath>
#include <sstream>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "pipescout/interfaces/topics.hpp"
#include "pipescout/message_conversions/mounting_parameters.hpp"
#include "pipescout/thermal/parameter_doubts.hpp"
#include "pipescout/thermal_parameters/named_values.hpp"
#include "pipescout/thermal_parameters/pipe_lines.hpp"

namespace pipescout {

namespace {

using leak_findings::LeakFindingsParameters;
using leak_findings::RangeSource;
using thermal::ObjectParameters;

constexpr FloatingPointRange kSeconds{0.0, 86400.0};
constexpr FloatingPointRange kPositive{1e-9, 1e6};
constexpr FloatingPointRange kDeviation{0.0, 1e4};

RangeSource range_source(const Parameter<std::string>& parameter) {
  const std::string name = parameter.get();
  if (const auto source = leak_findings::range_source(name)) {
    return *source;
  }
  std::string known;
  for (const RangeSource source : leak_findings::kRangeSources) {
    known += (known.empty() ? "'" : ", '") + std::string(to_string(source)) + "'";
  }
  throw std::invalid_argument("parameter '" + parameter.name() + "': '" + name + "' is none of " +
                              known);
}

}  // namespace

InspectorParameters::InspectorParameters(Parameters& parameters)
    : detection_(parameters), mount_(parameters) {
  deviations_.emplace(parameters, thermal::ParameterDeviations{});
  findings_.emplace(parameters, LeakFindingsParameters{});
  declare_deviations();
  declare_findings(parameters);
  declare_archive(parameters);
  declare_messages(parameters);
}

void InspectorParameters::declare_deviations() {
  deviations_->real(
      "deviations.emissivity", [](auto& d) -> double& { return d.emissivity; }, {0, 1},
      "of object.emissivity, standard");
  deviations_->real(
      "deviations.reflected_temperature",
      [](auto& d) -> double& { return d.reflected_temperature; }, kDeviation,
      "K, of object.reflected_temperature, standard");
  deviations_->real(
      "deviations.distance", [](auto& d) -> double& { return d.distance; }, kDeviation,
      "m, of object.distance, standard");
  deviations_->real(
      "deviations.atmospheric_temperature",
      [](auto& d) -> double& { return d.atmospheric_temperature; }, kDeviation,
      "K, of object.atmospheric_temperature, standard");
  deviations_->real(
      "deviations.relative_humidity", [](auto& d) -> double& { return d.relative_humidity; },
      {0, 1}, "of object.relative_humidity, standard");
  deviations_->real(
      "deviations.window_temperature", [](auto& d) -> double& { return d.window_temperature; },
      kDeviation, "K, of object.window_temperature, standard");
  deviations_->real(
      "deviations.window_transmission", [](auto& d) -> double& { return d.window_transmission; },
      {0, 1}, "of object.window_transmission, standard");
}

void InspectorParameters::declare_findings(Parameters& parameters) {
  range_source_ = parameters.declare<std::string>(
      "range.source", std::string(to_string(LeakFindingsParameters{}.range_source)),
      {.description = "what tells how far the pipes are: none (only the robot's motion), distance, "
                      "diameter (by how wide they look) or lines (where they are in the map)"});
  findings_->real(
      "range.distance", [](auto& p) -> double& { return p.distance; }, kPositive,
      "m, of the pipes before the camera, along its axis");
  findings_->real(
      "range.distance_deviation", [](auto& p) -> double& { return p.distance_deviation; },
      kPositive, "m, standard");
  findings_->real(
      "range.width_deviation", [](auto& p) -> double& { return p.width_deviation; }, {1e-6, 0.999},
      "share, of the width that is seen, standard");
  lines_ = parameters.declare<std::vector<double>>(
      "range.lines", {},
      {.description = "m, in the map: x y z of one end and of the other end of each pipe's axis"});
  findings_->real(
      "range.line_deviation", [](auto& p) -> double& { return p.line_deviation; }, kPositive,
      "m, of the pipes from these lines, standard");
  findings_->real(
      "pixel_deviation", [](auto& p) -> double& { return p.pixel_deviation; }, kPositive,
      "px, of the middle of a leak, standard");
  findings_->real(
      "attitude_jitter", [](auto& p) -> double& { return p.attitude_jitter; }, {0, 1},
      "rad, of the pose from picture to picture, standard");
  findings_->real(
      "position_jitter", [](auto& p) -> double& { return p.position_jitter; }, {0, 100},
      "m, the same");
  findings_->real(
      "pose_correlation_time", [](auto& p) -> double& { return p.pose_correlation_time; },
      kPositive, "s, within which errors of the pose do not average out");
  findings_->real(
      "temperature_deviation", [](auto& p) -> double& { return p.delta_deviation; }, {0, 1000},
      "K, by which differences of temperature may be off all alike, standard, where camera.planck "
      "does not tell it with deviations.*");
  findings_->real(
      "prior_probability", [](auto& p) -> double& { return p.prior_probability; }, {1e-9, 0.999},
      "that a warm stretch which is seen once is a leak");
  findings_->real(
      "detection_probability", [](auto& p) -> double& { return p.detection_probability; },
      {1e-3, 0.999999}, "of a leak that is in view");
  findings_->real(
      "clutter_probability", [](auto& p) -> double& { return p.clutter_probability; },
      {1e-6, 0.999}, "that what was warm and is no leak is so again");
  findings_->real(
      "raise_probability", [](auto& p) -> double& { return p.raise_probability; }, {1e-6, 0.999999},
      "from which a leak is raised");
  findings_->real(
      "clear_probability", [](auto& p) -> double& { return p.clear_probability; }, {1e-6, 0.999999},
      "below which it is cleared");
  findings_->real(
      "pass_gap", [](auto& p) -> double& { return p.pass_gap; }, kPositive,
      "s without being seen, after which it is another pass");
  findings_->real(
      "update_interval", [](auto& p) -> double& { return p.update_interval; }, kSeconds,
      "s between two updates of one finding on leak/events");
}

void InspectorParameters::declare_archive(Parameters& parameters) {
  store_ = parameters.declare<std::string>(
      "store", "",
      {.description = "SQLite file of the findings of all days; empty: they are forgotten"});
  report_folder_ = parameters.declare<std::string>(
      "report_folder", "",
      {.description = "gets report.html, leaks.geojson, leaks.kml and leaks.csv when the component "
                      "is deactivated; empty: no report"});
  weather_ = parameters.declare<std::string>(
      "weather", "", {.description = "as the operator saw it, for the log"});
  datum_ = parameters.declare<std::vector<double>>(
      "datum", {},
      {.description = "latitude and longitude in degrees and altitude in m of the origin of the "
                      "map, for maps; empty: not known"});
}

void InspectorParameters::declare_messages(Parameters& parameters) {
  map_frame_ =
      parameters.declare<std::string>("map_frame", "map", {.description = "frame of findings"});
  maximum_age_ = parameters.declare<double>(
      "maximum_age", 2.0,
      {.description = "s, pictures with an older stamp are refused; 0: any age is right",
       .floating_point_range = kSeconds});
  maximum_lead_ = parameters.declare<double>(
      "maximum_lead", 0.1,
      {.description = "s, messages with a stamp further ahead of the clock are refused",
       .floating_point_range = kSeconds});
  silent_after_ =
      parameters.declare<double>("silent_after", 2.0,
                                 {.description = "s without a picture, after which that is counted",
                                  .floating_point_range = kPositive});
}

std::optional<geometry::GeodeticPosition> InspectorParameters::datum() const {
  const auto values = three(datum_);
  if (!values) {
    return std::nullopt;
  }
  const geometry::GeodeticPosition result{values->x(), values->y(), values->z()};
  naming(datum_, [&] { result.validate(); });
  return result;
}

ConditionRecord InspectorParameters::conditions() const {
  const ObjectParameters object = detection_.object();
  std::ostringstream text;
  text << "emissivity " << object.emissivity << ", reflected " << object.reflected_temperature
       << " degC, distance " << object.distance << " m, air " << object.atmospheric_temperature
       << " degC, relative humidity " << object.relative_humidity << ", window "
       << object.window_temperature << " degC, its transmission " << object.window_transmission;
  std::string doubts;
  if (const auto constants = detection_.camera_constants()) {
    for (const thermal::Doubt& doubt : thermal::doubts(*constants, object)) {
      doubts += (doubts.empty() ? "" : "\n") + to_string(doubt);
    }
  }
  return {.source = std::string(topics::kThermalImage.name),
          .parameters = text.str(),
          .weather = weather_.get(),
          .calibration = detection_.calibration_text(),
          .doubts = doubts};
}

InspectorSettings InspectorParameters::read() const {
  InspectorSettings result;
  result.map_frame = map_frame_.get();
  result.stamp_limits = {.maximum_age = maximum_age_.get(), .maximum_lead = maximum_lead_.get()};
  result.silent_after = silent_after_.get();
  result.detection = detection_.read();
  if (const auto camera = detection_.camera_constants()) {
    result.errors.emplace(thermal::Radiometry(*camera, detection_.object()), deviations_->read());
  }
  result.findings = findings_->read();
  result.findings.T_base_camera = mount_.T_base_camera();
  result.mount = mount_.read();
  result.findings.range_source = range_source(range_source_);
  result.findings.lines = pipe_lines(lines_);
  result.findings.severity = result.detection.detector.severity;
  if (result.detection.detector.pipe_diameter > 0) {
    result.findings.pipe_diameter = result.detection.detector.pipe_diameter;
  } else if (result.findings.range_source == RangeSource::kDiameter) {
    throw std::invalid_argument(
        "parameter 'pipe_diameter' is 0; 'range.source' is 'diameter', which needs it");
  }
  result.findings.validate();
  result.store = store_.get();
  result.report_folder = report_folder_.get();
  result.datum = datum();
  result.conditions = conditions();
  return result;
}

}  // namespace pipescout
