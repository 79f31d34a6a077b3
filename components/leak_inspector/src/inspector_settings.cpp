// SPDX-License-Identifier: Apache-2.0
#include "pipescout/leak_inspector/inspector_settings.hpp"

#include <array>
#include <cmath>
#include <sstream>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "pipescout/interfaces/topics.hpp"
#include "pipescout/message_conversions/mounting_parameters.hpp"
#include "pipescout/thermal/parameter_doubts.hpp"

namespace pipescout {

namespace {

using leak_findings::LeakFindingsParameters;
using leak_findings::RangeSource;
using thermal::LeakDetectorParameters;
using thermal::ObjectParameters;
using thermal::Polarity;
using thermal::TemperatureTable;
using thermal::ThresholdRule;

constexpr FloatingPointRange kSeconds{0.0, 86400.0};
constexpr FloatingPointRange kPositive{1e-9, 1e6};
constexpr FloatingPointRange kCelsius{-273.15, 2000.0};
constexpr FloatingPointRange kShare{0.0, 1.0};

constexpr std::array kRules{std::pair{ThresholdRule::kFixed, "fixed"},
                            std::pair{ThresholdRule::kScene, "scene"},
                            std::pair{ThresholdRule::kLocal, "local"}};
constexpr std::array kPolarities{std::pair{Polarity::kHot, "hot"},
                                 std::pair{Polarity::kCold, "cold"}};
constexpr std::array kRangeSources{
    std::pair{RangeSource::kNone, "none"}, std::pair{RangeSource::kDistance, "distance"},
    std::pair{RangeSource::kDiameter, "diameter"}, std::pair{RangeSource::kLine, "lines"}};

template <class Names, class Value>
std::string name_of(const Names& names, Value value) {
  for (const auto& [known, name] : names) {
    if (known == value) {
      return name;
    }
  }
  throw std::logic_error("a value without a name");
}

template <class Names>
auto value_of(const Names& names, const Parameter<std::string>& parameter) {
  const std::string text = parameter.get();
  std::string known;
  for (const auto& [value, name] : names) {
    if (text == name) {
      return value;
    }
    known += (known.empty() ? "'" : ", '") + std::string(name) + "'";
  }
  throw std::invalid_argument("parameter '" + parameter.name() + "': '" + text + "' is none of " +
                              known);
}

/// Nothing for an empty parameter.
std::optional<double> one(const Parameter<std::vector<double>>& parameter) {
  const auto values = parameter.share();
  if (values->empty()) {
    return std::nullopt;
  }
  if (values->size() != 1 || !std::isfinite(values->front())) {
    throw std::invalid_argument("parameter '" + parameter.name() +
                                "' must be empty or one finite number");
  }
  return values->front();
}

std::vector<double> as_list(const std::optional<double>& value) {
  return value ? std::vector{*value} : std::vector<double>{};
}

/// Names the parameter in what `make` throws.
template <class Make>
auto naming(const Parameter<std::vector<double>>& parameter, Make make) {
  try {
    return make();
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument("parameter '" + parameter.name() + "': " + error.what());
  }
}

}  // namespace

InspectorParameters::Preset InspectorParameters::preset(const std::string& name) {
  if (name == "collectors") {
    return {{}, {}, thermal::ibarguren2013_object(), {100.0, 300.0}};
  }
  if (name == "torresol") {
    return {
        LeakDetectorParameters::torresol(), {}, thermal::ibarguren2013_object(), {100.0, 300.0}};
  }
  if (name == "hot_pipes") {
    return {LeakDetectorParameters::adaptive(Polarity::kHot), {}, {}, {}};
  }
  if (name == "cold_pipes") {
    return {LeakDetectorParameters::adaptive(Polarity::kCold), {}, {}, {}};
  }
  throw ParameterError("preset",
                       "parameter 'preset': '" + name +
                           "' is none of 'collectors', 'torresol', 'hot_pipes', 'cold_pipes'");
}

InspectorParameters::InspectorParameters(Parameters& parameters) {
  const auto name = parameters.declare<std::string>(
      "preset", "collectors",
      {.description = "whose defaults all others have: collectors of solar plants, torresol (those "
                      "as Ibarguren and others, 2013, do it), hot_pipes or cold_pipes against any "
                      "scene",
       .read_only = true});
  defaults_ = preset(name.get());
  detector_.emplace(parameters, defaults_.detector);
  object_.emplace(parameters, defaults_.object);
  findings_.emplace(parameters, defaults_.findings);
  declare_detector(parameters);
  declare_camera(parameters);
  declare_object();
  declare_findings(parameters);
  declare_archive(parameters);
  declare_messages(parameters);
}

void InspectorParameters::declare_detector(Parameters& parameters) {
  threshold_rule_ = parameters.declare<std::string>(
      "threshold_rule", name_of(kRules, defaults_.detector.threshold_rule),
      {.description = "fixed: `threshold`; scene: between the two classes of temperatures of the "
                      "picture; local: against the mean of the surroundings"});
  polarity_ = parameters.declare<std::string>(
      "polarity", name_of(kPolarities, defaults_.detector.polarity),
      {.description = "pipes are hot or cold against what is behind them"});
  detector_->real(
      "threshold", [](auto& p) -> double& { return p.threshold; }, kCelsius,
      "degC, of the fixed rule");
  detector_->real(
      "min_contrast", [](auto& p) -> double& { return p.min_contrast; }, kPositive,
      "K, by which a pipe differs from the scene or its surroundings");
  detector_->real(
      "local_radius", [](auto& p) -> double& { return p.local_radius; }, {1e-3, 1},
      "of the shorter side of the picture, half the side of the square of the surroundings");
  detector_->real(
      "min_width", [](auto& p) -> double& { return p.min_width; }, {1, 1000},
      "px, narrower is no pipe");
  detector_->real(
      "max_width", [](auto& p) -> double& { return p.max_width; }, {1e-3, 1},
      "of the shorter side of the picture");
  detector_->real(
      "min_length", [](auto& p) -> double& { return p.min_length; }, {1e-3, 1},
      "of the longer side of the picture, of a straight section");
  detector_->real(
      "min_elongation", [](auto& p) -> double& { return p.min_elongation; }, {1, 1000},
      "its length over its width");
  detector_->real(
      "min_visible", [](auto& p) -> double& { return p.min_visible; }, kShare,
      "of its length, where it is seen as a pipe");
  detector_->real(
      "straightness", [](auto& p) -> double& { return p.straightness; }, {0.1, 100},
      "px, that the axis of a straight section may bend");
  detector_->real(
      "max_gap", [](auto& p) -> double& { return p.max_gap; }, kShare,
      "of the longer side of the picture, that is bridged where something hides the pipe");
  detector_->real(
      "profile_width", [](auto& p) -> double& { return p.profile_width; }, {1e-3, 1},
      "of the pipe's width, over which temperatures are averaged");
  detector_->real(
      "pipe_diameter", [](auto& p) -> double& { return p.pipe_diameter; }, {0, 100},
      "m, gives a picture its scale; 0: unknown, and lengths are in pixels");
  detector_->count(
      "max_pipes", [](auto& p) -> std::size_t& { return p.max_pipes; }, {1, 64},
      "the longest are kept");
  detector_->real(
      "split_delta", [](auto& p) -> double& { return p.profile.split_delta; }, kPositive,
      "K, Delta-T: the least change that divides a pipe");
  detector_->integer(
      "split_distance", [](auto& p) -> int& { return p.profile.split_distance; }, {1, 64},
      "px, between which the change is taken; 1: the paper's equation (4)");
  detector_->boolean(
      "split_creeping", [](auto& p) -> bool& { return p.profile.split_creeping; },
      "divide a part too whose temperature creeps by more than split_delta");
  detector_->real(
      "min_part_width", [](auto& p) -> double& { return p.profile.min_part_width; }, {1, 1e4},
      "px, shorter parts are joints");
  detector_->real(
      "min_part_length", [](auto& p) -> double& { return p.profile.min_part_width_m; }, {0, 100},
      "m, the same where the scale is known");
  leak_delta_ = parameters.declare<std::vector<double>>(
      "leak_delta", as_list(defaults_.detector.profile.leak_delta),
      {.description = "K, above the sound pipe, from which a part leaks; empty: not used"});
  maximum_temperature_ = parameters.declare<std::vector<double>>(
      "maximum_temperature", as_list(defaults_.detector.profile.maximum_temperature),
      {.description = "degC, above which a part leaks; empty: not used"});
  detector_->real(
      "reference_quantile", [](auto& p) -> double& { return p.profile.reference_quantile; },
      {1e-3, 0.999}, "share of its length that is as cold as the sound pipe, or colder");
  detector_->real(
      "moderate_delta", [](auto& p) -> double& { return p.severity.moderate_delta; }, kPositive,
      "K, from which a leak is moderate");
  detector_->real(
      "severe_delta", [](auto& p) -> double& { return p.severity.severe_delta; }, kPositive,
      "K, from which it is severe");
  detector_->real(
      "long_leak", [](auto& p) -> double& { return p.severity.long_leak; }, kPositive,
      "m, from which it is one severity higher");
}

void InspectorParameters::declare_camera(Parameters& parameters) {
  planck_ = parameters.declare<std::vector<double>>(
      "camera.planck", {},
      {.description = "constants R1, R2, B, F, O by which counts of mono16 are temperatures; "
                      "empty: they are not"});
  linear_ = parameters.declare<std::vector<double>>(
      "camera.linear", {},
      {.description = "K per count and degC at count 0, of cameras that give temperatures: "
                      "0.01, -273.15 for hundredths of a kelvin; empty: this one does not"});
  grey_range_ = parameters.declare<std::vector<double>>(
      "camera.grey_range", defaults_.grey_range,
      {.description = "degC of black and of white, for pictures in mono8; empty: not known"});
  camera_position_ = parameters.declare<std::vector<double>>(
      "camera.position", {},
      {.description = "m, x y z of the camera in the base frame of odometry; empty: 0 0 0"});
  camera_roll_pitch_yaw_ = parameters.declare<std::vector<double>>(
      "camera.roll_pitch_yaw", {},
      {.description = "rad, of the optical frame in the base frame; empty: looks straight down, "
                      "the upper border of the image forward"});
}

void InspectorParameters::declare_object() {
  object_->real(
      "object.emissivity", [](auto& p) -> double& { return p.emissivity; }, {1e-3, 1},
      "of the pipes");
  object_->real(
      "object.reflected_temperature", [](auto& p) -> double& { return p.reflected_temperature; },
      kCelsius, "degC, of what they reflect");
  object_->real(
      "object.distance", [](auto& p) -> double& { return p.distance; }, {0, 1e4},
      "m, from the camera");
  object_->real(
      "object.atmospheric_temperature",
      [](auto& p) -> double& { return p.atmospheric_temperature; }, {-60, 80}, "degC");
  object_->real(
      "object.relative_humidity", [](auto& p) -> double& { return p.relative_humidity; }, kShare,
      "of the air");
  object_->real(
      "object.window_temperature", [](auto& p) -> double& { return p.window_temperature; },
      kCelsius, "degC");
  object_->real(
      "object.window_transmission", [](auto& p) -> double& { return p.window_transmission; },
      {1e-3, 1}, "1: there is no window");
}

void InspectorParameters::declare_findings(Parameters& parameters) {
  range_source_ = parameters.declare<std::string>(
      "range.source", name_of(kRangeSources, defaults_.findings.range_source),
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
      "K, by which differences of temperature may be off all alike, standard");
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

std::optional<thermal::CameraConstants> InspectorParameters::camera_constants() const {
  const auto planck = planck_.share();
  if (planck->empty()) {
    return std::nullopt;
  }
  if (planck->size() != 5) {
    throw std::invalid_argument(
        "parameter 'camera.planck' must be empty or five numbers: R1, R2, B, F, O");
  }
  const std::vector<double>& p = *planck;
  return thermal::CameraConstants{
      .planck = {.r1 = p[0], .r2 = p[1], .b = p[2], .f = p[3], .o = p[4]}};
}

std::optional<TemperatureTable> InspectorParameters::counts() const {
  const auto linear = linear_.share();
  if (const auto camera = camera_constants()) {
    if (!linear->empty()) {
      throw std::invalid_argument(
          "parameters 'camera.planck' and 'camera.linear' exclude each other");
    }
    return naming(planck_,
                  [&] { return TemperatureTable(thermal::Radiometry(*camera, object_->read())); });
  }
  if (!linear->empty()) {
    if (linear->size() != 2) {
      throw std::invalid_argument(
          "parameter 'camera.linear' must be empty or two numbers: K per count, degC at count 0");
    }
    return naming(linear_, [&] { return TemperatureTable((*linear)[0], (*linear)[1]); });
  }
  return std::nullopt;
}

std::optional<TemperatureTable> InspectorParameters::grey() const {
  const auto range = grey_range_.share();
  if (range->empty()) {
    return std::nullopt;
  }
  if (range->size() != 2) {
    throw std::invalid_argument(
        "parameter 'camera.grey_range' must be empty or two numbers: degC of black and of white");
  }
  return naming(grey_range_,
                [&] { return TemperatureTable::of_grey(range->front(), range->back()); });
}

std::vector<leak_findings::PipeLine> InspectorParameters::lines() const {
  const auto values = lines_.share();
  if (values->size() % 6 != 0) {
    throw std::invalid_argument("parameter 'range.lines' must have six numbers a line, not " +
                                std::to_string(values->size()) + " in all");
  }
  std::vector<leak_findings::PipeLine> result;
  for (std::size_t i = 0; i < values->size(); i += 6) {
    result.push_back({.from = Eigen::Map<const Eigen::Vector3d>(values->data() + i),
                      .to = Eigen::Map<const Eigen::Vector3d>(values->data() + i + 3)});
  }
  return result;
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
  const ObjectParameters object = object_->read();
  std::ostringstream text;
  text << "emissivity " << object.emissivity << ", reflected " << object.reflected_temperature
       << " degC, distance " << object.distance << " m, air " << object.atmospheric_temperature
       << " degC, relative humidity " << object.relative_humidity << ", window "
       << object.window_temperature << " degC, its transmission " << object.window_transmission;
  std::ostringstream camera;
  for (const auto& [what, parameter] :
       {std::pair{"Planck R1 R2 B F O", &planck_}, std::pair{"K per count, degC at 0", &linear_},
        std::pair{"degC of black and white", &grey_range_}}) {
    if (const auto values = parameter->share(); !values->empty()) {
      camera << (camera.tellp() > 0 ? "; " : "") << what << ":";
      for (const double value : *values) {
        camera << ' ' << value;
      }
    }
  }
  std::string doubts;
  if (const auto constants = camera_constants()) {
    for (const thermal::Doubt& doubt : thermal::doubts(*constants, object)) {
      doubts += (doubts.empty() ? "" : "\n") + to_string(doubt);
    }
  }
  return {.source = std::string(topics::kThermalImage.name),
          .parameters = text.str(),
          .weather = weather_.get(),
          .calibration = camera.str(),
          .doubts = doubts};
}

InspectorSettings InspectorParameters::read() const {
  InspectorSettings result;
  result.map_frame = map_frame_.get();
  result.stamp_limits = {.maximum_age = maximum_age_.get(), .maximum_lead = maximum_lead_.get()};
  result.silent_after = silent_after_.get();
  result.detector = detector_->read();
  result.detector.threshold_rule = value_of(kRules, threshold_rule_);
  result.detector.polarity = value_of(kPolarities, polarity_);
  result.detector.profile.leak_delta = one(leak_delta_);
  result.detector.profile.maximum_temperature = one(maximum_temperature_);
  result.detector.validate();
  result.counts = counts();
  result.grey = grey();
  result.findings = findings_->read();
  result.findings.T_base_camera = camera_mounting(camera_position_, camera_roll_pitch_yaw_);
  result.findings.range_source = value_of(kRangeSources, range_source_);
  result.findings.lines = lines();
  result.findings.severity = result.detector.severity;
  if (result.detector.pipe_diameter > 0) {
    result.findings.pipe_diameter = result.detector.pipe_diameter;
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
