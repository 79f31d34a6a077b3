// SPDX-License-Identifier: Apache-2.0
#include "pipescout/thermal_tracker/tracker_settings.hpp"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <utility>

#include "pipescout/thermal_parameters/named_values.hpp"
#include "pipescout/thermal_parameters/pipe_lines.hpp"

namespace pipescout {

namespace {

using tracking::PipeShape;
using tracking::PipeTrackerParameters;
using tracking::Resampling;
using State = tracking::ShapeState<PipeShape>;

constexpr FloatingPointRange kPositive{1e-9, 1e6};
constexpr FloatingPointRange kSeconds{0.0, 1000.0};
constexpr FloatingPointRange kProbability{1e-6, 0.999999};

constexpr std::array kFollowedShapes{std::pair{FollowedShape::kPipe, "pipe"},
                                     std::pair{FollowedShape::kValve, "valve"},
                                     std::pair{FollowedShape::kVessel, "vessel"}};
constexpr std::array kResamplings{std::pair{Resampling::kSystematic, "systematic"},
                                  std::pair{Resampling::kMultinomial, "multinomial"}};

std::vector<double> as_list(const State& state) {
  return {state.begin(), state.end()};
}

State as_state(const Parameter<std::vector<double>>& parameter) {
  const auto values = parameter.share();
  if (values->size() != PipeShape::kSize) {
    throw std::invalid_argument("parameter '" + parameter.name() + "' has " +
                                std::to_string(values->size()) +
                                " values: must be four, for x, y, length and angle");
  }
  return Eigen::Map<const State>(values->data());
}

}  // namespace

TrackerParameters::TrackerParameters(Parameters& parameters)
    : detection_(parameters),
      mount_(parameters),
      regions_(parameters, tracking::HotRegionParameters{}),
      shape_(parameters, PipeShape{}),
      tracker_(parameters, PipeTrackerParameters{}) {
  declare_followed(parameters);
  declare_shape();
  declare_filter(parameters);
  declare_life();
  declare_range(parameters);
  declare_messages(parameters);
}

void TrackerParameters::declare_followed(Parameters& parameters) {
  followed_ = parameters.declare<std::string>(
      "shape", name_of(kFollowedShapes, FollowedShape::kPipe),
      {.description =
           "what is tracked: 'pipe', 'valve' (seen as a circle) or 'vessel' (seen as a "
           "rectangle); of valves and vessels the parameters of the pipe's detector, its "
           "weights and deviations are not used"});
  regions_.real(
      "region.threshold", [](auto& p) -> double& { return p.threshold; }, {-273, 2000},
      "degrees Celsius, of valves and vessels: pixels above are of them");
  regions_.count(
      "region.least_pixels", [](auto& p) -> std::size_t& { return p.least_pixels; }, {5, 1000000},
      "of valves and vessels: smaller regions are ignored");
  regions_.real(
      "region.least_fill", [](auto& p) -> double& { return p.least_fill; }, {0, 1},
      "of valves and vessels: pixels of a region over those of the fitted shape");
}

void TrackerParameters::declare_shape() {
  shape_.real(
      "lambda", [](auto& p) -> double& { return p.lambda; }, kPositive,
      "1/px, weight of the position in the distance of a particle from a region");
  shape_.real(
      "beta", [](auto& p) -> double& { return p.beta; }, kPositive, "1/px^2, weight of the length");
  shape_.real(
      "gamma", [](auto& p) -> double& { return p.gamma; }, kPositive,
      "1/rad^2, weight of the angle");
  shape_.real(
      "edge_deviation", [](auto& p) -> double& { return p.edge_deviation; }, kPositive,
      "px, standard deviation of the visible outline of a pipe");
  shape_.real(
      "end_deviation", [](auto& p) -> double& { return p.end_deviation; }, kPositive,
      "px, standard deviation of an end along the axis");
  shape_.real(
      "border", [](auto& p) -> double& { return p.border; }, {0, 1000},
      "px, an end this close to the border of the image is cut by it");
  shape_.real(
      "least_piece", [](auto& p) -> double& { return p.least_piece; }, {0, 0.5},
      "share of the image's longer side: smallest length of a detected piece of a pipe");
}

void TrackerParameters::declare_filter(Parameters& parameters) {
  const PipeTrackerParameters defaults;
  tracker_.count(
      "particles", [](auto& p) -> std::size_t& { return p.filter.particles; }, {10, 1000000},
      "of the particle filter");
  tracker_.real(
      "resample_share", [](auto& p) -> double& { return p.filter.resample_share; }, {1e-6, 1},
      "share of the particles: resampled when the effective sample size is below it");
  tracker_.count(
      "best_particles", [](auto& p) -> std::size_t& { return p.filter.best_particles; },
      {1, 1000000}, "of the robust mean");
  resampling_ = parameters.declare<std::string>(
      "resampling", name_of(kResamplings, defaults.filter.resampling),
      {.description =
           "systematic: one draw for all; multinomial: one draw for each, as in the paper"});
  start_deviation_ = parameters.declare<std::vector<double>>(
      "start_deviation", as_list(defaults.filter.start_deviation),
      {.description =
           "px px px rad, initial standard deviations of particles: x, y, length, angle"});
  process_deviation_ = parameters.declare<std::vector<double>>(
      "process_deviation", as_list(defaults.filter.process_deviation),
      {.description = "the same units, process noise per square root of a second"});
  rate_walk_ = parameters.declare<std::vector<double>>(
      "rate_walk", as_list(defaults.rate_walk),
      {.description = "px/s px/s px/s rad/s, random walk of the rates per square root of a second "
                      "if the motion of the camera is unknown"});
  seed_ = parameters.declare<std::int64_t>(
      "seed", 1,
      {.description = "seed of the particle filter; the same images and seed give the same track",
       .integer_range = IntegerRange{0, 1'000'000'000}});
}

void TrackerParameters::declare_life() {
  tracker_.real(
      "motion_share", [](auto& p) -> double& { return p.motion_share; }, {1e-6, 1},
      "share of rate_walk used if the motion of the camera is known");
  tracker_.real(
      "rate_memory", [](auto& p) -> double& { return p.rate_memory; }, {1e-6, 100},
      "s, time constant with which unconfirmed rates decay");
  tracker_.real(
      "gate", [](auto& p) -> double& { return p.gate; }, {1, 20},
      "standard deviations, gate of the association of a region with the pipe");
  tracker_.real(
      "detection", [](auto& p) -> double& { return p.detection; }, kProbability,
      "probability of detecting a visible pipe");
  tracker_.real(
      "clutter", [](auto& p) -> double& { return p.clutter; }, {1e-6, 100},
      "expected number of false regions in an image");
  tracker_.real(
      "doubt", [](auto& p) -> double& { return p.doubt; }, kProbability,
      "probability that the end of a region is caused by an object in front of the pipe");
  tracker_.count(
      "confirm", [](auto& p) -> std::size_t& { return p.confirm; }, {1, 100},
      "number of images in which a pipe must be detected to lock");
  tracker_.real(
      "confidence_time", [](auto& p) -> double& { return p.confidence_time; }, {1e-6, 1000},
      "s, time constant with which the confidence decays without detection");
  tracker_.real(
      "max_coast", [](auto& p) -> double& { return p.max_coast; }, {1e-6, 1000},
      "s without detection after which the pipe is lost");
  tracker_.real(
      "max_lost", [](auto& p) -> double& { return p.max_lost; }, kSeconds,
      "s after the loss from which any pipe starts another track");
  tracker_.real(
      "max_back", [](auto& p) -> double& { return p.max_back; }, kSeconds,
      "s, a stamp that goes back by more restarts the track");
  tracker_.count(
      "max_regions", [](auto& p) -> std::size_t& { return p.max_regions; }, {1, 100000},
      "largest number of regions in an image; with more it is treated as empty");
  tracker_.real(
      "guard_distance", [](auto& p) -> double& { return p.guard_distance; }, kPositive,
      "distance from the particles within which a region is accepted after a jump of the pipe");
}

void TrackerParameters::declare_range(Parameters& parameters) {
  distance_ = parameters.declare<double>(
      "range.distance", 10.0,
      {.description =
           "m, range of the pipes along the camera's axis, without range.lines and pipe_diameter",
       .floating_point_range = kPositive});
  lines_ = parameters.declare<std::vector<double>>(
      "range.lines", {},
      {.description = "m, in the map: x y z of one end and of the other end of each pipe's axis"});
  line_deviation_ = parameters.declare<double>(
      "range.line_deviation", leak_findings::LeakFindingsParameters{}.line_deviation,
      {.description = "m, standard deviation of the pipes from these lines",
       .floating_point_range = kPositive});
}

void TrackerParameters::declare_messages(Parameters& parameters) {
  published_particles_ = parameters.declare<std::size_t>(
      "published_particles", 200,
      {.description = "largest number of particles published on track/particles, evenly chosen",
       .integer_range = IntegerRange{0, 100000}});
  map_frame_ = parameters.declare<std::string>(
      "map_frame", "map", {.description = "frame of the odometry and of the lines"});
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

PipeTrackerParameters TrackerParameters::tracker() const {
  PipeTrackerParameters result = tracker_.read();
  result.filter.resampling = value_of(kResamplings, resampling_);
  result.filter.start_deviation = as_state(start_deviation_);
  result.filter.process_deviation = as_state(process_deviation_);
  result.rate_walk = as_state(rate_walk_);
  result.validate();
  return result;
}

TrackerSettings TrackerParameters::read(Node& node) const {
  TrackerSettings result;
  result.map_frame = map_frame_.get();
  result.stamp_limits = {.maximum_age = maximum_age_.get(), .maximum_lead = maximum_lead_.get()};
  result.silent_after = silent_after_.get();
  result.detection = detection_.read();
  result.mount = mount_.read(node);
  result.followed = value_of(kFollowedShapes, followed_);
  result.regions = regions_.read();
  result.regions.validate();
  result.shape = shape_.read();
  result.shape.validate();
  result.tracker = tracker();
  result.seed = static_cast<std::uint64_t>(seed_.get());
  result.distance = distance_.get();
  result.lines = pipe_lines(lines_);
  result.line_deviation = line_deviation_.get();
  result.published_particles = published_particles_.get();
  return result;
}

}  // namespace pipescout
