// SPDX-License-Identifier: Apache-2.0
#include "pipescout/thermal_parameters/detection_parameters.hpp"

#include <array>
#include <cmath>
#include <locale>
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

constexpr std::array kRules{
    std::pair{ThresholdRule::kFixed, "fixed"}, std::pair{ThresholdRule::kScene, "scene"},
    std::pair{ThresholdRule::kLocal, "local"}, std::pair{ThresholdRule::kContrast, "contrast"}};
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
    throw ParameterError("preset", "parameter 'preset': '" + name + "' is not one of " + known);
  }
  const LeakDetectorParameters detector = LeakDetectorParameters::of(*preset);
  if (*preset == DetectorPreset::kContrast) {
    return {detector, thermal::ibarguren2013_object(), {}};
  }
  if (*preset == DetectorPreset::kCollectors || *preset == DetectorPreset::kTorresol) {
    return {detector, thermal::ibarguren2013_object(), {100.0, 300.0}};
  }
  return {detector, {}, {}};
}

DetectionParameters::DetectionParameters(Parameters& parameters) {
  const auto name = parameters.declare<std::string>(
      "preset", std::string(to_string(thermal::kDefaultPreset)),
      {.description =
           "default values of the other parameters: collectors of solar plants, torresol (the "
           "same, exactly as in Ibarguren and others, 2013), hot_pipes or cold_pipes in any scene, "
           "contrast: tubes of solar plants whose radiometry is uncertain, or 8-bit video with "
           "automatic gain",
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
                      "image; local: relative to the mean of the surroundings; contrast: relative "
                      "to the longest straight ridge of the image, in apparent temperatures or "
                      "grey levels"});
  polarity_ = parameters.declare<std::string>(
      "polarity", name_of(kPolarities, defaults_.detector.polarity),
      {.description = "pipes are hotter or colder than the background"});
  detector_->real(
      "threshold", [](auto& p) -> double& { return p.threshold; }, kCelsius,
      "degC, of the fixed rule");
  detector_->real(
      "min_contrast", [](auto& p) -> double& { return p.min_contrast; }, kPositive,
      "K, smallest difference of a pipe from the scene or its surroundings");
  detector_->real(
      "local_radius", [](auto& p) -> double& { return p.local_radius; }, {1e-3, 1},
      "share of the shorter side of the image, half the side of the square of the surroundings");
  detector_->real(
      "contrast_level", [](auto& p) -> double& { return p.contrast_level; }, {1e-3, 0.999},
      "share of the way from the surroundings to the tube, of the contrast rule");
  detector_->real(
      "min_width", [](auto& p) -> double& { return p.min_width; }, {1, 1000},
      "px, smallest width of a pipe");
  detector_->real(
      "max_width", [](auto& p) -> double& { return p.max_width; }, {1e-3, 1},
      "share of the shorter side of the image");
  detector_->real(
      "min_length", [](auto& p) -> double& { return p.min_length; }, {1e-3, 1},
      "share of the longer side of the image, length of a straight section");
  detector_->real(
      "min_elongation", [](auto& p) -> double& { return p.min_elongation; }, {1, 1000},
      "its length over its width");
  detector_->real(
      "min_visible", [](auto& p) -> double& { return p.min_visible; }, kShare,
      "share of its length that is visible as a pipe");
  detector_->real(
      "straightness", [](auto& p) -> double& { return p.straightness; }, {0.1, 100},
      "px, largest deviation of the axis of a straight section from a line");
  detector_->real(
      "max_gap", [](auto& p) -> double& { return p.max_gap; }, kShare,
      "share of the longer side of the image, largest hidden gap that is bridged");
  detector_->real(
      "profile_width", [](auto& p) -> double& { return p.profile_width; }, {1e-3, 1},
      "share of the pipe's width over which temperatures are averaged");
  detector_->real(
      "pipe_diameter", [](auto& p) -> double& { return p.pipe_diameter; }, {0, 100},
      "m, gives the image a metric scale; 0: unknown, and lengths are in pixels");
  detector_->count(
      "max_pipes", [](auto& p) -> std::size_t& { return p.max_pipes; }, {1, 64},
      "largest number of pipes; the longest are used");
  detector_->real(
      "split_delta", [](auto& p) -> double& { return p.profile.split_delta; }, kPositive,
      "K, Delta-T: smallest change that splits a pipe");
  detector_->integer(
      "split_distance", [](auto& p) -> int& { return p.profile.split_distance; }, {1, 64},
      "px, distance over which the change is computed; 1: the paper's equation (4)");
  detector_->boolean(
      "split_creeping", [](auto& p) -> bool& { return p.profile.split_creeping; },
      "also split a part whose temperature changes gradually by more than split_delta");
  detector_->real(
      "min_part_width", [](auto& p) -> double& { return p.profile.min_part_width; }, {1, 1e4},
      "px, shorter parts are joints");
  detector_->real(
      "min_part_length", [](auto& p) -> double& { return p.profile.min_part_width_m; }, {0, 100},
      "m, the same if the scale is known");
  leak_delta_ = parameters.declare<std::vector<double>>(
      "leak_delta", as_list(defaults_.detector.profile.leak_delta),
      {.description = "K above the sound pipe from which a part is a leak; empty: not used"});
  detector_->real(
      "leak_spreads", [](auto& p) -> double& { return p.profile.leak_spreads; }, {0, 1e4},
      "standard deviations of the sound pipe along its length that a leak rises by at least; 0: "
      "not "
      "used");
  detector_->real(
      "leak_share", [](auto& p) -> double& { return p.profile.leak_share; }, {0, 100},
      "share of the pipe's contrast to its surroundings that a leak rises by at least; 0: not "
      "used");
  maximum_temperature_ = parameters.declare<std::vector<double>>(
      "maximum_temperature", as_list(defaults_.detector.profile.maximum_temperature),
      {.description = "degC above which a part is a leak; empty: not used"});
  detector_->real(
      "reference_quantile", [](auto& p) -> double& { return p.profile.reference_quantile; },
      {1e-3, 0.999}, "quantile of the temperature over the length that is the sound pipe's");
  detector_->real(
      "moderate_delta", [](auto& p) -> double& { return p.severity.moderate_delta; }, kPositive,
      "K, from which a leak is moderate");
  detector_->real(
      "severe_delta", [](auto& p) -> double& { return p.severity.severe_delta; }, kPositive,
      "K, from which a leak is severe");
  detector_->real(
      "long_leak", [](auto& p) -> double& { return p.severity.long_leak; }, kPositive,
      "m, length from which the severity is one level higher");
}

void DetectionParameters::declare_camera(Parameters& parameters) {
  planck_ = parameters.declare<std::vector<double>>(
      "camera.planck", {},
      {.description =
           "constants R1, R2, B, F, O that convert mono16 counts to temperatures; empty: unknown"});
  linear_ = parameters.declare<std::vector<double>>(
      "camera.linear", {},
      {.description = "K per count and degC at count 0, for cameras that output temperatures: "
                      "0.01, -273.15 for hundredths of a kelvin; empty: not used"});
  grey_range_ = parameters.declare<std::vector<double>>(
      "camera.grey_range", defaults_.grey_range,
      {.description = "degC of black and of white, for mono8 images; empty: unknown"});
}

void DetectionParameters::declare_object() {
  object_->real(
      "object.emissivity", [](auto& p) -> double& { return p.emissivity; }, {1e-3, 1},
      "of the pipes");
  object_->real(
      "object.reflected_temperature", [](auto& p) -> double& { return p.reflected_temperature; },
      kCelsius, "degC, reflected");
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
      {1e-3, 1}, "1: no window");
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

bool DetectionParameters::by_contrast() const {
  return value_of(kRules, threshold_rule_) == ThresholdRule::kContrast;
}

std::optional<TemperatureTable> DetectionParameters::counts() const {
  const auto linear = linear_.share();
  if (const auto camera = camera_constants()) {
    if (!linear->empty()) {
      throw std::invalid_argument(
          "parameters 'camera.planck' and 'camera.linear' exclude each other");
    }
    return naming(planck_, [&] {
      const thermal::Radiometry told(*camera, object_->read());
      return TemperatureTable(by_contrast() ? thermal::apparent_radiometry(*camera) : told);
    });
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
  if (range->empty() && by_contrast()) {
    return TemperatureTable::of_grey(0, thermal::kGreyLevels);
  }
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
  text.imbue(std::locale::classic());
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
  result.levels = by_contrast() && grey_range_.share()->empty();
  return result;
}

std::span<const float> DetectionSettings::celsius_of(
    const ThermalImageReader::View& picture) const {
  if (std::holds_alternative<thermal::CountView>(picture)) {
    if (!counts) {
      throw UndescribedPicture("image.counts_without_camera",
                               "images of counts arrive, and neither parameter 'camera.planck' nor "
                               "'camera.linear' converts them");
    }
    return counts->degrees();
  }
  if (std::holds_alternative<thermal::GreyView>(picture)) {
    if (!grey) {
      throw UndescribedPicture(
          "image.grey_without_range",
          "images of grey levels arrive, and parameter 'camera.grey_range' is not set");
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
