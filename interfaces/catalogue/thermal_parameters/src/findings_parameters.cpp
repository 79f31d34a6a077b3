// SPDX-License-Identifier: Apache-2.0
#include "pipescout/thermal_parameters/findings_parameters.hpp"

#include <stdexcept>
#include <utility>

#include "pipescout/thermal_parameters/pipe_lines.hpp"

namespace pipescout {

namespace {

using leak_findings::LeakFindingsParameters;
using leak_findings::RangeSource;

constexpr FloatingPointRange kSeconds{0.0, 86400.0};
constexpr FloatingPointRange kPositive{1e-9, 1e6};

RangeSource range_source(const Parameter<std::string>& parameter) {
  const std::string name = parameter.get();
  if (const auto source = leak_findings::range_source(name)) {
    return *source;
  }
  std::string known;
  for (const RangeSource source : leak_findings::kRangeSources) {
    known += (known.empty() ? "'" : ", '") + std::string(to_string(source)) + "'";
  }
  throw std::invalid_argument("parameter '" + parameter.name() + "': '" + name +
                              "' is not one of " + known);
}

}  // namespace

FindingsParameters::FindingsParameters(Parameters& parameters)
    : fields_(parameters, LeakFindingsParameters{}) {
  range_source_ = parameters.declare<std::string>(
      "range.source", std::string(to_string(LeakFindingsParameters{}.range_source)),
      {.description =
           "source of the range of the pipes: none (only the robot's motion), distance, diameter "
           "(from their width in the image) or lines (from their position in the map)"});
  fields_.real(
      "range.distance", [](auto& p) -> double& { return p.distance; }, kPositive,
      "m, range of the pipes along the camera's axis");
  fields_.real(
      "range.distance_deviation", [](auto& p) -> double& { return p.distance_deviation; },
      kPositive, "m, standard");
  fields_.real(
      "range.width_deviation", [](auto& p) -> double& { return p.width_deviation; }, {1e-6, 0.999},
      "share, standard deviation of the width in the image");
  lines_ = parameters.declare<std::vector<double>>(
      "range.lines", {},
      {.description = "m, in the map: x y z of one end and of the other end of each pipe's axis"});
  fields_.real(
      "range.line_deviation", [](auto& p) -> double& { return p.line_deviation; }, kPositive,
      "m, standard deviation of the pipes from these lines");
  fields_.real(
      "pixel_deviation", [](auto& p) -> double& { return p.pixel_deviation; }, kPositive,
      "px, standard deviation of the middle of a leak");
  fields_.real(
      "attitude_jitter", [](auto& p) -> double& { return p.attitude_jitter; }, {0, 1},
      "rad, standard deviation of the white noise of the pose");
  fields_.real(
      "position_jitter", [](auto& p) -> double& { return p.position_jitter; }, {0, 100},
      "m, the same");
  fields_.real(
      "pose_correlation_time", [](auto& p) -> double& { return p.pose_correlation_time; },
      kPositive, "s, correlation time of the errors of the pose");
  fields_.real(
      "temperature_deviation", [](auto& p) -> double& { return p.delta_deviation; }, {0, 1000},
      "K, standard deviation of the common error of temperature differences, without camera.planck "
      "and deviations.*");
  fields_.real(
      "prior_probability", [](auto& p) -> double& { return p.prior_probability; }, {1e-9, 0.999},
      "probability that a warm section detected once is a leak");
  fields_.real(
      "detection_probability", [](auto& p) -> double& { return p.detection_probability; },
      {1e-3, 0.999999}, "probability of detecting a leak in view");
  fields_.real(
      "clutter_probability", [](auto& p) -> double& { return p.clutter_probability; },
      {1e-6, 0.999}, "probability of a repeated false detection");
  fields_.real(
      "raise_probability", [](auto& p) -> double& { return p.raise_probability; }, {1e-6, 0.999999},
      "probability from which a leak is raised");
  fields_.real(
      "clear_probability", [](auto& p) -> double& { return p.clear_probability; }, {1e-6, 0.999999},
      "probability below which it is cleared");
  fields_.real(
      "pass_gap", [](auto& p) -> double& { return p.pass_gap; }, kPositive,
      "s without detection after which another pass begins");
  fields_.real(
      "update_interval", [](auto& p) -> double& { return p.update_interval; }, kSeconds,
      "s between two updates of one finding on leak/events");
}

LeakFindingsParameters FindingsParameters::read(const thermal::LeakDetectorParameters& detector,
                                                std::vector<leak_findings::PipeLine> lines) const {
  LeakFindingsParameters result = fields_.read();
  result.range_source = range_source(range_source_);
  result.lines = std::move(lines);
  for (const leak_findings::PipeLine& line : pipe_lines(lines_)) {
    result.lines.push_back(line);
  }
  result.severity = detector.severity;
  if (detector.pipe_diameter > 0) {
    result.pipe_diameter = detector.pipe_diameter;
  } else if (result.range_source == RangeSource::kDiameter) {
    throw std::invalid_argument(
        "parameter 'pipe_diameter' is 0; 'range.source' is 'diameter', which needs it");
  }
  result.validate();
  return result;
}

}  // namespace pipescout
