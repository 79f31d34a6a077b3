// SPDX-License-Identifier: Apache-2.0
#include "pipescout/crawler_simulation/crawler_simulation.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "pipescout/catalogue/topics.hpp"
#include "pipescout/crawler_simulation/route_file.hpp"
#include "pipescout/message_conversions/geometry.hpp"
#include "pipescout/message_conversions/motion.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "pipescout/runtime/register_component.hpp"

namespace pipescout {

namespace {

using simulation::WheelParameters;

/// s of simulated time that one turn of the executor makes.
constexpr double kStep = 0.05;
/// Of the simulated clock: a stamp of zero means "no time" to some.
constexpr Time kStart{std::chrono::seconds(1000)};

constexpr const char* kBaseFrame = "base_link";

constexpr FloatingPointRange kShare{0.0, 1.0};
constexpr FloatingPointRange kNotNegative{0.0, 1e6};
constexpr FloatingPointRange kPositive{1e-9, 1e6};

Time at(double seconds) {
  return kStart + from_seconds(seconds);
}

template <class Value, class Assign>
void assign_each(const char* parameter, const std::vector<Value>& values,
                 std::vector<WheelParameters>& wheels, Assign assign) {
  if (values.empty()) {
    return;
  }
  if (values.size() != wheels.size()) {
    throw std::invalid_argument("parameter '" + std::string(parameter) + "' has " +
                                std::to_string(values.size()) + " values for " +
                                std::to_string(wheels.size()) + " wheels");
  }
  for (std::size_t i = 0; i < wheels.size(); ++i) {
    assign(wheels[i], values[i]);
  }
}

bool is_incremental(const std::string& kind) {
  if (kind != "absolute" && kind != "increment") {
    throw std::invalid_argument("parameter 'kinds': '" + kind +
                                "' must be 'absolute' or 'increment'");
  }
  return kind == "increment";
}

}  // namespace

CrawlerSimulation::CrawlerSimulation(ComponentOptions options) : Component(std::move(options)) {
  tally_ = parameters().declare<std::string>(
      "tally", "",
      {.description = "CSV file with the joints of the pipe, see docs/weld_ledger.md"});
  seed_ = parameters().declare<std::int64_t>(
      "seed", 1,
      {.description = "seed of all random numbers; the same seed gives the same run",
       .integer_range = IntegerRange{0, 1'000'000'000}});
  declare_wheel_parameters();
  declare_drive_parameters();
  declare_imu_parameters();
  declare_signal_parameters();
}

CrawlerSimulation::~CrawlerSimulation() = default;

void CrawlerSimulation::declare_wheel_parameters() {
  const WheelParameters wheel;
  const simulation::CrawlerParameters crawler;
  wheels_ = parameters().declare<std::vector<std::string>>(
      "wheels", {"wheel_1", "wheel_2", "wheel_3"}, {.description = "names of the odometers"});
  kinds_ = parameters().declare<std::vector<std::string>>(
      "kinds", {},
      {.description = "one per wheel: 'absolute' counter or 'increment' since the previous sample; "
                      "empty: all absolute"});
  periods_ = parameters().declare<std::vector<double>>(
      "periods", {},
      {.description = "s between samples, one per wheel; empty: " + std::to_string(wheel.period),
       .floating_point_range = FloatingPointRange{1e-3, 60.0}});
  scale_errors_ = parameters().declare<std::vector<double>>(
      "scale_errors", {},
      {.description = "error of the radius as a share, one per wheel; empty: none",
       .floating_point_range = FloatingPointRange{-0.3, 0.3}});
  wear_ = parameters().declare<std::vector<double>>(
      "wear_per_metre", {},
      {.description = "1/m, change of the scale by wear, one per wheel; empty: none",
       .floating_point_range = FloatingPointRange{-1e-3, 1e-3}});
  clocks_ = parameters().declare<std::vector<double>>(
      "clocks", {},
      {.description = "rad around the axis from the top of the crawler, clockwise looking forward, "
                      "one per wheel, for pipe_radius; empty: evenly around",
       .floating_point_range =
           FloatingPointRange{-2.0 * std::numbers::pi, 2.0 * std::numbers::pi}});
  pipe_radius_ = parameters().declare<double>(
      "pipe_radius", 0.0,
      {.description = "m, from the axis to where the wheels touch the wall: in the bends of the "
                      "route each goes its own way; 0: all go as far as the axis",
       .floating_point_range = FloatingPointRange{0.0, 10.0}});
  resolution_ = parameters().declare<double>(
      "resolution", wheel.resolution,
      {.description = "m per encoder count", .floating_point_range = kPositive});
  noise_ = parameters().declare<double>(
      "noise_per_sqrt_metre", 0.004,
      {.description = "m per square root of metre, random walk of each wheel",
       .floating_point_range = kNotNegative});
  dropped_share_ = parameters().declare<double>(
      "dropped_share", 0.0,
      {.description = "share of the samples that are dropped", .floating_point_range = kShare});
  nan_share_ = parameters().declare<double>(
      "nan_share", 0.0,
      {.description = "share of the samples that are NaN", .floating_point_range = kShare});
  slip_spacing_ = parameters().declare<double>(
      "slip.spacing", crawler.slip_spacing,
      {.description = "m, mean path between bursts of slip of one wheel; 0: none",
       .floating_point_range = kNotNegative});
  slip_most_ = parameters().declare<double>(
      "slip.most", crawler.slip_most,
      {.description = "largest share of the distance lost in a slip",
       .floating_point_range = FloatingPointRange{crawler.slip_least, 1.0}});
  slip_together_ = parameters().declare<double>(
      "slip.together_share", crawler.slip_together_share,
      {.description = "share of the bursts in which two wheels slip equally",
       .floating_point_range = kShare});
  stick_spacing_ = parameters().declare<double>(
      "stick_spacing", crawler.stick_spacing,
      {.description = "m, mean path between times that a wheel is stuck; 0: never",
       .floating_point_range = kNotNegative});
  gravity_slip_ = parameters().declare<double>(
      "gravity_slip", wheel.gravity_slip,
      {.description = "share of the distance that all wheels lose on a vertical climb",
       .floating_point_range = FloatingPointRange{0.0, 0.5}});
}

void CrawlerSimulation::declare_drive_parameters() {
  const simulation::InspectionParameters motion;
  start_joint_ = parameters().declare<std::int64_t>(
      "start_joint", 0,
      {.description = "index of the joint at whose first weld the crawler starts",
       .integer_range = IntegerRange{0, 1'000'000}});
  length_ = parameters().declare<double>(
      "length", 1e6,
      {.description = "m, distance to travel, limited to the end of the pipe",
       .floating_point_range = FloatingPointRange{0.1, 1e6}});
  speed_ = parameters().declare<double>(
      "speed", motion.speed,
      {.description = "m/s", .floating_point_range = FloatingPointRange{1e-3, 10.0}});
  stop_spacing_ = parameters().declare<double>(
      "stop_spacing", motion.stop_spacing,
      {.description = "m, mean distance between stops", .floating_point_range = kPositive});
  reverse_share_ = parameters().declare<double>(
      "reverse_share", motion.reverse_share,
      {.description = "share of the stops after which the crawler first reverses",
       .floating_point_range = FloatingPointRange{0.0, 0.9}});
  joint_error_ = parameters().declare<double>(
      "joint_error", 0.01,
      {.description = "m, standard deviation of the true joint lengths from the tally",
       .floating_point_range = FloatingPointRange{0.0, 0.5}});
}

void CrawlerSimulation::declare_imu_parameters() {
  route_ = parameters().declare<std::string>(
      "route", "",
      {.description = "CSV file with the bends of the pipe, see docs/components/"
                      "crawler_simulation.md; empty: straight and level"});
  imu_ = parameters().declare<std::string>(
      "imu", "industrial",
      {.description =
           "errors of the IMU at the probe: tactical, industrial or consumer; none: no IMU"});
  imu_rate_ = parameters().declare<double>(
      "imu_rate", 100.0,
      {.description = "Hz", .floating_point_range = FloatingPointRange{10.0, 1000.0}});
  standing_ =
      parameters().declare<double>("standing", 3.0,
                                   {.description = "s of standstill before the start",
                                    .floating_point_range = FloatingPointRange{0.0, 3600.0}});
}

void CrawlerSimulation::declare_signal_parameters() {
  const simulation::EddyCurrentParameters signal;
  const simulation::PipeParameters pipe;
  sample_rate_ = parameters().declare<double>(
      "sample_rate", signal.sample_rate,
      {.description = "Hz, of the probe", .floating_point_range = FloatingPointRange{20.0, 1e5}});
  peak_snr_ = parameters().declare<double>(
      "peak_snr", signal.peak_snr,
      {.description = "dB, peak of a weld over the noise of one channel",
       .floating_point_range = FloatingPointRange{-20.0, 400.0}});
  const FloatingPointRange per_km{0.0, 100.0};
  valves_ = parameters().declare<double>(
      "valves_per_km", pipe.valves_per_km,
      {.description = "features that resemble many welds at once", .floating_point_range = per_km});
  bends_ = parameters().declare<double>(
      "bends_per_km", pipe.bends_per_km,
      {.description = "features that lift the coil off", .floating_point_range = per_km});
  dents_ = parameters().declare<double>(
      "dents_per_km", pipe.dents_per_km,
      {.description = "features that resemble wide welds", .floating_point_range = per_km});
}

SimulatedRunParameters CrawlerSimulation::run_parameters() const {
  SimulatedRunParameters result;
  auto& wheels = result.crawler.wheels;
  wheels.resize(wheels_.share()->size());
  for (WheelParameters& wheel : wheels) {
    wheel.resolution = resolution_.get();
    wheel.noise_per_sqrt_metre = noise_.get();
    wheel.dropped_share = dropped_share_.get();
    wheel.nan_share = nan_share_.get();
    wheel.gravity_slip = gravity_slip_.get();
  }
  assign_each("kinds", *kinds_.share(), wheels, [](auto& wheel, const std::string& kind) {
    wheel.incremental = is_incremental(kind);
  });
  assign_each("periods", *periods_.share(), wheels,
              [](auto& wheel, double value) { wheel.period = value; });
  assign_each("scale_errors", *scale_errors_.share(), wheels,
              [](auto& wheel, double value) { wheel.scale_error = value; });
  for (std::size_t i = 0; i < wheels.size(); ++i) {
    wheels[i].clock =
        2.0 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(wheels.size());
  }
  assign_each("clocks", *clocks_.share(), wheels,
              [](auto& wheel, double clock) { wheel.clock = clock; });
  result.pipe_radius = pipe_radius_.get();
  assign_each("wear_per_metre", *wear_.share(), wheels,
              [](auto& wheel, double value) { wheel.wear_per_metre = value; });
  result.crawler.slip_spacing = slip_spacing_.get();
  result.crawler.slip_most = slip_most_.get();
  result.crawler.slip_together_share = slip_together_.get();
  result.crawler.stick_spacing = stick_spacing_.get();
  result.motion.length = length_.get();
  result.motion.speed = speed_.get();
  result.motion.stop_spacing = stop_spacing_.get();
  result.motion.reverse_share = reverse_share_.get();
  result.pipe.tally_sigma = joint_error_.get();
  result.signal.sample_rate = sample_rate_.get();
  result.signal.peak_snr = peak_snr_.get();
  result.features.valves_per_km = valves_.get();
  result.features.bends_per_km = bends_.get();
  result.features.dents_per_km = dents_.get();
  result.start_joint = static_cast<std::size_t>(start_joint_.get());
  if (const std::string file = route_.get(); !file.empty()) {
    result.route = read_route(file);
  }
  if (const std::string grade = imu_.get(); grade != "none") {
    result.imu = simulation::ImuParameters::of_grade(grade);
    result.imu->period = 1.0 / imu_rate_.get();
  }
  result.seed = static_cast<std::uint64_t>(seed_.get());
  return result;
}

CallbackReturn CrawlerSimulation::on_configure() {
  const std::string file = tally_.get();
  if (file.empty()) {
    throw std::invalid_argument("parameter 'tally' is empty: a CSV file with joints is needed");
  }
  names_ = wheels_.get();
  const Tally tally = read_tally(file);
  for (const std::string& note : tally.notes) {
    logger().info(note);
  }
  run_.emplace(run_parameters(), tally);
  steps_ = 0;
  standing_steps_ = static_cast<std::uint64_t>(std::ceil(standing_.get() / kStep));
  total_steps_ = standing_steps_ + static_cast<std::uint64_t>(std::ceil(run_->duration() / kStep));
  const auto matched = run_steps_.on_matched();
  clock_publisher_ = create_publisher(topics::kClock);
  truth_publisher_ = create_publisher(topics::kTruePipePosition, {.events = {.matched = matched}});
  true_odometry_publisher_ =
      create_publisher(topics::kTrueOdometry, {.events = {.matched = matched}});
  imu_publisher_ = create_publisher(topics::kImu, {.events = {.matched = matched}});
  readings_publisher_ =
      create_publisher(topics::kOdometerReadings, {.events = {.matched = matched}});
  samples_publisher_ = create_publisher(topics::kEddyCurrent, {.events = {.matched = matched}});
  run_steps_.configure(
      *clock_publisher_.untyped(),
      {readings_publisher_.untyped(), samples_publisher_.untyped(), imu_publisher_.untyped(),
       truth_publisher_.untyped(), true_odometry_publisher_.untyped()},
      from_seconds(kStep), [this] { return step(); },
      [this](std::string_view counter, std::string_view text) { report_fault(counter, text); });
  logger().info("a run of " + std::to_string(std::lround(run_->duration())) + " s");
  return CallbackReturn::kSuccess;
}

CallbackReturn CrawlerSimulation::on_activate() {
  if (!run_steps_.all_there()) {
    report_progress(steps_, total_steps_,
                    "waiting for the subscriptions of " + run_steps_.missing());
  }
  run_steps_.activate();
  return CallbackReturn::kSuccess;
}

CallbackReturn CrawlerSimulation::on_deactivate() {
  run_steps_.deactivate();
  return CallbackReturn::kSuccess;
}

CallbackReturn CrawlerSimulation::on_cleanup() {
  run_steps_.clean_up();
  clock_publisher_ = {};
  truth_publisher_ = {};
  true_odometry_publisher_ = {};
  imu_publisher_ = {};
  readings_publisher_ = {};
  samples_publisher_ = {};
  run_.reset();
  return CallbackReturn::kSuccess;
}

bool CrawlerSimulation::step() {
  const double until =
      kStep * (static_cast<double>(++steps_) - static_cast<double>(standing_steps_));
  Clock clock;
  clock.clock = to_message(at(until));
  clock_publisher_.publish(std::move(clock));
  publish_truth(until);
  publish_imu(until);
  publish_readings(until);
  publish_samples(until);
  // At most a hundred reports.
  if (steps_ == total_steps_ || steps_ * 100 / total_steps_ != (steps_ - 1) * 100 / total_steps_) {
    report_progress(steps_, total_steps_);
  }
  if (steps_ < total_steps_) {
    return true;
  }
  report_complete("the crawler has travelled " +
                  std::to_string(std::lround(run_->position(until).distance)) + " m");
  return false;
}

void CrawlerSimulation::publish_readings(double until) {
  for (SimulatedRun::Readings& readings : run_->readings_until(until)) {
    auto message = std::make_unique<Readings>();
    message->header.stamp = to_message(at(readings.time));
    message->header.frame_id = kBaseFrame;
    for (const std::size_t wheel : readings.wheels) {
      message->name.push_back(names_[wheel]);
      message->valid.push_back(true);
    }
    message->distance = std::move(readings.values);
    readings_publisher_.publish(std::move(message));
  }
}

void CrawlerSimulation::publish_samples(double until) {
  const double first = run_->next_sample_time();
  const auto samples = run_->samples_until(until);
  if (samples.empty()) {
    return;
  }
  auto message = std::make_unique<Samples>();
  message->header.stamp = to_message(at(first));
  message->header.frame_id = "eddy_current_probe";
  message->sample_interval = run_->sample_interval();
  message->channels = 1;
  for (const auto& sample : samples) {
    message->x.push_back(sample.real());
    message->y.push_back(sample.imag());
  }
  samples_publisher_.publish(std::move(message));
}

void CrawlerSimulation::publish_truth(double time) {
  const SimulatedRun::Position position = run_->position(time);
  auto message = std::make_unique<Position>();
  message->header.stamp = to_message(at(time));
  message->header.frame_id = "eddy_current_probe";
  message->known = true;
  message->locked = true;
  message->joint = static_cast<std::uint32_t>(position.joint);
  message->joint_probability = 1.0;
  message->distance_into_joint = position.into_joint;
  message->chainage = position.chainage;
  message->scale = 1.0;
  message->odometer_distance = position.distance;
  truth_publisher_.publish(std::move(message));

  const simulation::BodyMotion motion = run_->body_motion(time);
  auto odometry = std::make_unique<Odometry>();
  odometry->header.stamp = to_message(at(time));
  odometry->header.frame_id = "map";
  odometry->child_frame_id = kBaseFrame;
  odometry->pose.pose = to_message(motion.T_map_body);
  odometry->twist.twist =
      twist_message(motion.T_map_body.rotation().inverse() * motion.velocity, motion.angular_rate);
  true_odometry_publisher_.publish(std::move(odometry));
}

void CrawlerSimulation::publish_imu(double until) {
  for (const SimulatedRun::ImuSample& sample : run_->imu_samples_until(until)) {
    auto message = std::make_unique<Imu>(
        imu_message(sample.reading.angular_rate, sample.reading.specific_force));
    message->header.stamp = to_message(at(sample.time));
    message->header.frame_id = kBaseFrame;
    imu_publisher_.publish(std::move(message));
  }
}

}  // namespace pipescout

PIPESCOUT_REGISTER_COMPONENT(pipescout::CrawlerSimulation)
