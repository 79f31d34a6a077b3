// SPDX-License-Identifier: Apache-2.0
#include "pipescout/leak_inspector/inspector_settings.hpp"

#include <cmath>
#include <locale>
#include <sstream>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "pipescout/catalogue/topics.hpp"
#include "pipescout/leak_findings/rack_lines.hpp"
#include "pipescout/message_conversions/mounting_parameters.hpp"
#include "pipescout/rack_file/rack_file.hpp"
#include "pipescout/thermal/parameter_doubts.hpp"
#include "pipescout/thermal_parameters/named_values.hpp"
#include "pipescout/thermal_parameters/survey_parameters.hpp"

namespace pipescout {

namespace {

using thermal::ObjectParameters;

constexpr FloatingPointRange kSeconds{0.0, 86400.0};
constexpr FloatingPointRange kPositive{1e-9, 1e6};
constexpr FloatingPointRange kDeviation{0.0, 1e4};

}  // namespace

InspectorParameters::InspectorParameters(Parameters& parameters)
    : parameters_(&parameters),
      detection_(parameters),
      deviations_(parameters, thermal::ParameterDeviations{}),
      mount_(parameters),
      findings_(parameters) {
  declare_deviations(parameters);
  declare_archive(parameters);
  declare_messages(parameters);
}

void InspectorParameters::declare_deviations(Parameters& parameters) {
  deviations_.real(
      "deviations.emissivity", [](auto& d) -> double& { return d.emissivity; }, {0, 1},
      "standard deviation of object.emissivity");
  deviations_.real(
      "deviations.reflected_temperature",
      [](auto& d) -> double& { return d.reflected_temperature; }, kDeviation,
      "K, standard deviation of object.reflected_temperature");
  deviations_.real(
      "deviations.distance", [](auto& d) -> double& { return d.distance; }, kDeviation,
      "m, standard deviation of object.distance");
  deviations_.real(
      "deviations.atmospheric_temperature",
      [](auto& d) -> double& { return d.atmospheric_temperature; }, kDeviation,
      "K, standard deviation of object.atmospheric_temperature");
  deviations_.real(
      "deviations.relative_humidity", [](auto& d) -> double& { return d.relative_humidity; },
      {0, 1}, "standard deviation of object.relative_humidity");
  deviations_.real(
      "deviations.window_temperature", [](auto& d) -> double& { return d.window_temperature; },
      kDeviation, "K, standard deviation of object.window_temperature");
  deviations_.real(
      "deviations.window_transmission", [](auto& d) -> double& { return d.window_transmission; },
      {0, 1}, "standard deviation of object.window_transmission");
  const thermal::PipeTemperatureRange collectors = thermal::collector_temperatures();
  pipe_temperature_ = parameters.declare<std::vector<double>>(
      "pipe_temperature", {collectors.least, collectors.most},
      {.description =
           "degC, least and most that the sound pipes may have; with the contrast rule it "
           "narrows what emissivity and reflected temperature may be"});
}

thermal::PipeTemperatureRange InspectorParameters::pipe_temperature() const {
  const auto values = pipe_temperature_.share();
  if (values->size() != 2) {
    throw std::invalid_argument(
        "parameter 'pipe_temperature' must be two numbers: degC, least and most");
  }
  const thermal::PipeTemperatureRange range{values->front(), values->back()};
  naming(pipe_temperature_, [&] { range.validate(); });
  return range;
}

void InspectorParameters::declare_archive(Parameters& parameters) {
  rack_ = parameters.declare<std::string>(
      "rack", "",
      {.description = "rack file whose pipes are lines of range.source 'lines', with the offsets "
                      "that rack/state tells; the map is the rack frame. Empty: none"});
  store_ = parameters.declare<std::string>(
      "store", "",
      {.description = "SQLite file with the findings of all days; empty: they are not stored"});
  report_folder_ = parameters.declare<std::string>(
      "report_folder", "",
      {.description = "folder to which report.html, leaks.geojson, leaks.kml and leaks.csv are "
                      "written when the component is deactivated; empty: no report"});
  pictures_folder_ = parameters.declare<std::string>(
      "pictures_folder", "",
      {.description = "folder for the recorded images with poses and parameters, for `pipescout "
                      "inspect leaks`; new, or without files; empty name: no images are recorded"});
  weather_ =
      parameters.declare<std::string>("weather", "", {.description = "recorded with the findings"});
  datum_ = parameters.declare<std::vector<double>>(
      "datum", {},
      {.description = "latitude and longitude in degrees and altitude in m of the origin of the "
                      "map, for GeoJSON and KML; empty: unknown"});
}

void InspectorParameters::declare_messages(Parameters& parameters) {
  map_frame_ =
      parameters.declare<std::string>("map_frame", "map", {.description = "frame of the findings"});
  maximum_age_ = parameters.declare<double>(
      "maximum_age", 2.0,
      {.description = "s, images with an older stamp are refused; 0: any age is accepted",
       .floating_point_range = kSeconds});
  maximum_lead_ = parameters.declare<double>(
      "maximum_lead", 0.1,
      {.description = "s, messages with a stamp further ahead of the clock are refused",
       .floating_point_range = kSeconds});
  silent_after_ = parameters.declare<double>(
      "silent_after", 2.0,
      {.description = "s without an image after which image.silent is counted",
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
  text.imbue(std::locale::classic());
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

ThermalSettings InspectorParameters::thermal_settings() const {
  ThermalSettings result;
  result.object = ObjectChanges::to(detection_.object());
  result.deviations = deviations_.read();
  if (const auto camera = detection_.camera_constants()) {
    result.planck = camera->planck;
  }
  if (const auto linear = detection_.linear(); !linear.empty()) {
    result.scale = {.gain = linear[0], .offset = linear[1]};
  }
  if (const auto grey = detection_.grey_range(); !grey.empty()) {
    result.grey = {.black = grey[0], .white = grey[1]};
  } else {
    result.automatic_gain = detection_.read().levels;
  }
  result.pipe_temperature = pipe_temperature();
  return result;
}

SurveySettings InspectorParameters::survey_settings(const InspectorSettings& settings) const {
  SurveySettings result;
  result.preset = thermal::detector_preset(parameters_->get("preset").get<std::string>()).value();
  result.parameters = survey_parameters(*parameters_);
  result.detector = settings.detection.detector;
  result.findings = settings.findings;
  result.datum = settings.datum;
  result.weather = weather_.get();
  return result;
}

InspectorSettings InspectorParameters::read(Node& node) const {
  InspectorSettings result;
  result.map_frame = map_frame_.get();
  result.stamp_limits = {.maximum_age = maximum_age_.get(), .maximum_lead = maximum_lead_.get()};
  result.silent_after = silent_after_.get();
  result.detection = detection_.read();
  if (const auto camera = detection_.camera_constants()) {
    if (result.detection.detector.threshold_rule == thermal::ThresholdRule::kContrast) {
      result.posterior.emplace(*camera, detection_.object(), deviations_.read(),
                               pipe_temperature());
    } else {
      result.errors.emplace(thermal::Radiometry(*camera, detection_.object()), deviations_.read());
    }
  }
  std::vector<leak_findings::PipeLine> lines;
  if (!rack_.get().empty()) {
    result.rack = read_rack(rack_.get());
    lines = leak_findings::rack_lines(*result.rack, {});
  }
  result.findings = findings_.read(result.detection.detector, std::move(lines));
  if (result.rack && result.findings.range_source != leak_findings::RangeSource::kLine) {
    throw std::invalid_argument("parameter 'rack' is given, but 'range.source' is not 'lines'");
  }
  result.findings.T_base_camera = mount_.T_base_camera();
  result.mount = mount_.read(node);
  result.store = store_.get();
  result.report_folder = report_folder_.get();
  result.pictures_folder = pictures_folder_.get();
  if (result.rack && !result.pictures_folder.empty()) {
    throw std::invalid_argument(
        "parameter 'pictures_folder' is given, and 'rack' too: images over a rack are not "
        "recorded");
  }
  result.datum = datum();
  result.thermal_settings = thermal_settings();
  result.survey_settings = survey_settings(result);
  result.conditions = conditions();
  return result;
}

}  // namespace pipescout
