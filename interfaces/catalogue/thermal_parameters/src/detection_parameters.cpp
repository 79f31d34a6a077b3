// SPDX-License-Identifier: Apache-2.0
#include "pipescout/thermal_parameters/detection_parameters.hpp"

#include <array>
#include <cmath>
#include <sstream>
#include <type_traits>
#include <utility>
#include <variant>

#include "pipescout/thermal_parameters/named_values.hpp"

namespace pipescout {

namespace {

using thermal::DetectorPreset;
using thermal::LeakDetectorParameters;
using thermal::Polarity;
using thermal::TemperatureTable;
using thermal::ThresholdRule;

constexpr FloatingPointRange kPositive{1e-9, 1e6};
constexpr FloatingPointRange kCelsius{-273.15, 2000.0};
constexpr FloatingPointRange kShare{0.0, 1.0};

constexpr std::array kRules{std::pair{ThresholdRule::kFixed, "fixed"},
                            std::pair{ThresholdRule::kScene, "scene"},
                            std::pair{ThresholdRule::kLocal, "local"}};
constexpr std::array kPolarities{std::pair{Polarity::kHot, "hot"},
                                 std::pair{Polarity::kCold, "cold"}};

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

}  // namespace

DetectionParameters::Preset DetectionParameters::preset(const std::string& name) {
  const auto preset = thermal::detector_preset(name);
  if (!preset) {
    std::string known;
    for (const DetectorPreset other : thermal::kDetectorPresets) {
      known += (known.empty() ? "'" : ", '") + std::string(to_string(other)) + "'";
    }
    throw ParameterError("preset", "parameter 'preset': '" + name + "' is none of " + known);
  }
  const LeakDetectorParameters detector = LeakDetectorParameters::of(*preset);
  if (*preset == DetectorPreset::kCollectors || *preset == DetectorPreset::kTorresol) {
    return {detector, thermal::ibarguren2013_object(), {100.0, 300.0}};
  }
  return {detector, {}, {}};
}

DetectionParameters::DetectionParameters(Parameters& parameters) {
  const auto name = parameters.declare<std::string>(
      "preset", "collectors",
      {.description = "whose defaults all others have: collectors of solar plants, torresol (those "
                      "as Ibarguren and others, 2013, do it), hot_pipes or cold_pipes against any "
                      "scene",
       .read_only = true});
  defaults_ = preset(name.get());
  detector_.emplace(parameters, defaults_.detector);
  object_.emplace(parameters, defaults_.object);
  declare_detector(parameters);
  declare_camera(parameters);
  declare_object();
}

void DetectionParameters::declare_detector(Parameters& parameters) {
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

void DetectionParameters::declare_camera(Parameters& parameters) {
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
}

void DetectionParameters::declare_object() {
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

std::optional<thermal::CameraConstants> DetectionParameters::camera_constants() const {
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

std::optional<TemperatureTable> DetectionParameters::counts() const {
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

std::optional<TemperatureTable> DetectionParameters::grey() const {
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

std::string DetectionParameters::calibration_text() const {
  std::ostringstream text;
  for (const auto& [what, parameter] :
       {std::pair{"Planck R1 R2 B F O", &planck_}, std::pair{"K per count, degC at 0", &linear_},
        std::pair{"degC of black and white", &grey_range_}}) {
    if (const auto values = parameter->share(); !values->empty()) {
      text << (text.tellp() > 0 ? "; " : "") << what << ":";
      for (const double value : *values) {
        text << ' ' << value;
      }
    }
  }
  return text.str();
}

DetectionSettings DetectionParameters::read() const {
  DetectionSettings result;
  result.detector = detector_->read();
  result.detector.threshold_rule = value_of(kRules, threshold_rule_);
  result.detector.polarity = value_of(kPolarities, polarity_);
  result.detector.profile.leak_delta = one(leak_delta_);
  result.detector.profile.maximum_temperature = one(maximum_temperature_);
  result.detector.validate();
  result.counts = counts();
  result.grey = grey();
  return result;
}

std::span<const float> DetectionSettings::celsius_of(
    const ThermalImageReader::View& picture) const {
  if (std::holds_alternative<thermal::CountView>(picture)) {
    if (!counts) {
      throw UndescribedPicture("image.counts_without_camera",
                               "pictures of counts come, and neither parameter 'camera.planck' nor "
                               "'camera.linear' tells what they mean");
    }
    return counts->degrees();
  }
  if (std::holds_alternative<thermal::GreyView>(picture)) {
    if (!grey) {
      throw UndescribedPicture("image.grey_without_range",
                               "pictures of grey levels come, and parameter 'camera.grey_range' "
                               "does not tell what they mean");
    }
    return grey->degrees();
  }
  return {};
}

const thermal::Detections& detect(thermal::LeakDetector& detector,
                                  const ThermalImageReader::View& picture,
                                  std::span<const float> celsius,
                                  const thermal::FrameConditions& conditions) {
  return std::visit(
      [&](const auto& image) -> const thermal::Detections& {
        if constexpr (std::is_same_v<std::decay_t<decltype(image)>, thermal::TemperatureView>) {
          return detector.detect(image, conditions);
        } else {
          return detector.detect(image, celsius, conditions);
        }
      },
      picture);
}

}  // namespace pipescout
