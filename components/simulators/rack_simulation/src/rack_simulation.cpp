// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_simulation/rack_simulation.hpp"

#include <algorithm>
#include <cmath>
#include <pipescout/rack_vision/visual_servo.hpp>
#include <stdexcept>
#include <utility>

#include "pipescout/catalogue/topics.hpp"
#include "pipescout/message_conversions/camera.hpp"
#include "pipescout/message_conversions/geometry.hpp"
#include "pipescout/message_conversions/motion.hpp"
#include "pipescout/rack_file/rack_file.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "pipescout/runtime/register_component.hpp"

namespace pipescout {

namespace {

using simulation::Uav;

/// Of the simulated clock: a stamp of zero means "no time" to some.
constexpr Time kStart{std::chrono::seconds(1000)};
constexpr const char* kCameraFrame = "camera_optical";
constexpr const char* kBaseFrame = "base_link";
constexpr std::size_t kDistortionCoefficients = 5;

constexpr FloatingPointRange kShare{0.0, 0.8};

Time at(double seconds) {
  return kStart + from_seconds(seconds);
}

void check_count(const char* parameter, const std::vector<double>& values, std::size_t wanted) {
  if (values.size() != wanted) {
    throw std::invalid_argument("parameter '" + std::string(parameter) + "' has " +
                                std::to_string(values.size()) + " values: must be " +
                                std::to_string(wanted));
  }
}

Eigen::Vector3d vector(const char* parameter, const std::vector<double>& values) {
  check_count(parameter, values, 3);
  return {values[0], values[1], values[2]};
}

}  // namespace

RackSimulation::RackSimulation(ComponentOptions options) : Component(std::move(options)) {
  declare_run_parameters();
  declare_flight_parameters();
  declare_imu_parameters();
  declare_camera_parameters();
  declare_thermal_parameters();
}

RackSimulation::~RackSimulation() = default;

void RackSimulation::declare_run_parameters() {
  rack_file_ = parameters().declare<std::string>(
      "rack", "", {.description = "YAML file with the rack, see docs/rack_file.md"});
  seed_ = parameters().declare<std::int64_t>(
      "seed", 1,
      {.description = "seed of all random numbers; the same seed and commands give the same run",
       .integer_range = IntegerRange{0, 1'000'000'000}});
  duration_ = parameters().declare<double>("duration", 60.0,
                                           {.description = "s of simulated time until completion",
                                            .floating_point_range = FloatingPointRange{0.1, 1e5}});
  latency_ = parameters().declare<double>(
      "latency", 0.03,
      {.description = "s of simulated time from an image to when its command takes effect; at most "
                      "until the next image",
       .floating_point_range = FloatingPointRange{0.0, 10.0}});
}

void RackSimulation::declare_flight_parameters() {
  const simulation::RackScene scene;
  const simulation::DrydenWindParameters wind;
  const simulation::UavParameters uav;
  start_position_ = parameters().declare<std::vector<double>>(
      "start.position", {1.0, 5.0, 3.0}, {.description = "m, x y z of the UAV in the rack frame"});
  start_yaw_ =
      parameters().declare<double>("start.yaw", 0.0,
                                   {.description = "rad, from rack x towards rack y",
                                    .floating_point_range = FloatingPointRange{-7.0, 7.0}});
  frame_id_ = parameters().declare<std::string>("frame_id", "rack",
                                                {.description = "frame of the true poses"});
  offsets_ = parameters().declare<std::vector<double>>(
      "offsets", {},
      {.description =
           "m along rack x, one per pipe: true offsets relative to the rack file; empty: none",
       .floating_point_range = FloatingPointRange{-1.0, 1.0}});
  plain_ = parameters().declare<std::vector<double>>(
      "plain", {},
      {.description =
           "from, to, from, to ... along rack y, m: intervals in which the pipes have no texture"});
  clutter_share_ = parameters().declare<double>(
      "clutter_share", scene.clutter_share,
      {.description = "share of the contours that are hidden or imitated",
       .floating_point_range = kShare});
  ground_height_ = parameters().declare<double>(
      "ground_height", scene.ground_height,
      {.description = "m, rack z of the ground; also the height reference of the wind",
       .floating_point_range = FloatingPointRange{-100.0, -0.5}});
  wind_speed_ = parameters().declare<double>(
      "wind.speed", wind.speed_at_20_feet,
      {.description = "m/s, mean wind at 20 feet above the ground; it scales the gusts",
       .floating_point_range = FloatingPointRange{0.0, 40.0}});
  wind_direction_ = parameters().declare<double>(
      "wind.direction", wind.direction,
      {.description = "rad: direction in which it blows, from rack x towards rack y",
       .floating_point_range = FloatingPointRange{-7.0, 7.0}});
  velocity_error_ = parameters().declare<double>(
      "velocity_error", uav.velocity_error,
      {.description = "m/s, standard deviation of the autopilot's velocity error",
       .floating_point_range = FloatingPointRange{0.0, 1.0}});
}

void RackSimulation::declare_imu_parameters() {
  imu_ = parameters().declare<std::string>(
      "imu", "industrial",
      {.description =
           "errors of the IMU at base_link: tactical, industrial or consumer; none: no IMU"});
  imu_rate_ =
      parameters().declare<double>("imu_rate", 200.0,
                                   {.description = "Hz; the period is rounded to ms",
                                    .floating_point_range = FloatingPointRange{10.0, 1000.0}});
}

void RackSimulation::declare_camera_parameters() {
  const geometry::CameraParameters camera;
  const simulation::ImageSensor sensor;
  image_rate_ =
      parameters().declare<double>("image_rate", 25.0,
                                   {.description = "Hz; the period is rounded to ms",
                                    .floating_point_range = FloatingPointRange{0.5, 200.0}});
  width_ =
      parameters().declare<int>("camera.width", camera.width,
                                {.description = "pixels", .integer_range = IntegerRange{16, 4096}});
  height_ =
      parameters().declare<int>("camera.height", camera.height,
                                {.description = "pixels", .integer_range = IntegerRange{16, 4096}});
  focal_length_ = parameters().declare<double>("camera.focal_length", camera.focal_length,
                                               {.description = "pixels"});
  centre_ = parameters().declare<std::vector<double>>(
      "camera.centre", {},
      {.description = "pixels, u v of the principal point; empty: the middle of the image"});
  distortion_ = parameters().declare<std::vector<double>>(
      "camera.distortion", {}, {.description = "k1 k2 p1 p2 k3 of plumb_bob; empty: none"});
  camera_position_ = parameters().declare<std::vector<double>>(
      "camera.position", {},
      {.description = "m, x y z of the camera in base_link; empty: at its origin"});
  camera_roll_pitch_yaw_ = parameters().declare<std::vector<double>>(
      "camera.roll_pitch_yaw", {},
      {.description = "rad, of the optical frame in base_link; empty: straight down, the upper "
                      "border of the image forward"});
  exposure_ = parameters().declare<double>("camera.exposure", sensor.exposure,
                                           {.description = "s, causes motion blur",
                                            .floating_point_range = FloatingPointRange{0.0, 0.1}});
  read_noise_ =
      parameters().declare<double>("camera.read_noise", sensor.read_noise,
                                   {.description = "grey levels, standard deviation",
                                    .floating_point_range = FloatingPointRange{0.0, 50.0}});
}

simulation::RackFlightParameters RackSimulation::flight_parameters() const {
  simulation::RackFlightParameters result;
  const std::string file = rack_file_.get();
  if (file.empty()) {
    throw std::invalid_argument("parameter 'rack' is empty: a YAML file with a rack is needed");
  }
  result.seed = static_cast<std::uint64_t>(seed_.get());
  result.scene.model = read_rack(file);
  if (const auto offsets = offsets_.share(); !offsets->empty()) {
    check_count("offsets", *offsets, result.scene.model.pipes.size());
    for (std::size_t i = 0; i < offsets->size(); ++i) {
      result.scene.model.pipes[i].start.x() += (*offsets)[i];
    }
  }
  const auto plain = plain_.share();
  if (plain->size() % 2 != 0) {
    throw std::invalid_argument("parameter 'plain' has " + std::to_string(plain->size()) +
                                " values: must be pairs");
  }
  for (std::size_t i = 0; i < plain->size(); i += 2) {
    result.scene.plain.push_back({.from = (*plain)[i], .to = (*plain)[i + 1]});
  }
  result.scene.clutter_share = clutter_share_.get();
  result.scene.ground_height = ground_height_.get();
  result.start_position = vector("start.position", start_position_.get());
  result.start_yaw = start_yaw_.get();
  result.wind.speed_at_20_feet = wind_speed_.get();
  result.wind.direction = wind_direction_.get();
  result.wind.height = result.start_position.z() - ground_height_.get();
  result.uav.velocity_error = velocity_error_.get();
  if (const std::string grade = imu_.get(); grade != "none") {
    result.imu = simulation::ImuParameters::of_grade(grade);
    result.imu->period = 1.0 / imu_rate_.get();
  }

  result.camera.width = width_.get();
  result.camera.height = height_.get();
  result.camera.focal_length = focal_length_.get();
  result.camera.centre_u = width_.get() / 2.0;
  result.camera.centre_v = height_.get() / 2.0;
  if (const auto centre = centre_.share(); !centre->empty()) {
    check_count("camera.centre", *centre, 2);
    result.camera.centre_u = (*centre)[0];
    result.camera.centre_v = (*centre)[1];
  }
  if (const auto distortion = distortion_.share(); !distortion->empty()) {
    check_count("camera.distortion", *distortion, kDistortionCoefficients);
    result.camera.k1 = (*distortion)[0];
    result.camera.k2 = (*distortion)[1];
    result.camera.p1 = (*distortion)[2];
    result.camera.p2 = (*distortion)[3];
    result.camera.k3 = (*distortion)[4];
  }
  const Eigen::Vector3d position = camera_position_.share()->empty()
                                       ? Eigen::Vector3d::Zero()
                                       : vector("camera.position", camera_position_.get());
  result.T_base_camera =
      camera_roll_pitch_yaw_.share()->empty()
          ? rack_vision::downward_camera(position)
          : geometry::SE3(geometry::SO3::from_roll_pitch_yaw(
                              vector("camera.roll_pitch_yaw", camera_roll_pitch_yaw_.get())),
                          position);
  result.sensor.exposure = exposure_.get();
  result.sensor.read_noise = read_noise_.get();
  result.thermal = thermal_parameters();
  return result;
}

CallbackReturn RackSimulation::on_configure() {
  const simulation::RackFlightParameters flight = flight_parameters();
  flight_.emplace(flight);
  camera_ = flight.camera;
  frame_ = frame_id_.get();
  image_period_ = std::round(1.0 / image_rate_.get() / Uav::kStep) * Uav::kStep;
  latency_of_commands_ = std::min(latency_.get(), image_period_);
  total_images_ = static_cast<std::uint64_t>(std::ceil(duration_.get() / image_period_));
  images_ = 0;
  answer_.reset();
  thermal_ = flight.thermal;
  hot_places_.clear();
  const auto matched = run_steps_.on_matched();
  clock_publisher_ = create_publisher(topics::kClock);
  truth_publisher_ = create_publisher(topics::kTrueRackPose, {.events = {.matched = matched}});
  true_odometry_publisher_ =
      create_publisher(topics::kTrueOdometry, {.events = {.matched = matched}});
  imu_publisher_ = create_publisher(topics::kImu, {.events = {.matched = matched}});
  camera_info_publisher_ = create_publisher(topics::kCameraInfo, {.events = {.matched = matched}});
  image_publisher_ = create_publisher(topics::kCameraImage, {.events = {.matched = matched}});
  if (thermal_) {
    images_per_thermal_image_ = static_cast<std::uint64_t>(
        std::max(1LL, std::llround(1.0 / (thermal_image_rate_.get() * image_period_))));
    for (const simulation::HotSpot& spot : thermal_->hot_spots) {
      hot_places_.push_back(place_of(spot, flight.scene.model));
    }
    thermal_image_publisher_ =
        create_publisher(topics::kThermalImage, {.events = {.matched = matched}});
    thermal_camera_info_publisher_ =
        create_publisher(topics::kThermalCameraInfo, {.events = {.matched = matched}});
    true_leaks_publisher_ = create_publisher(topics::kTrueLeaks, {.events = {.matched = matched}});
  }
  command_subscription_ = create_subscription(
      topics::kVelocityCommand, [this](const Twist& message) { on_command(message); });
  run_steps_.configure(
      *clock_publisher_.untyped(),
      {image_publisher_.untyped(), camera_info_publisher_.untyped(), imu_publisher_.untyped(),
       truth_publisher_.untyped(), true_odometry_publisher_.untyped(),
       thermal_image_publisher_.untyped(), thermal_camera_info_publisher_.untyped(),
       true_leaks_publisher_.untyped()},
      from_seconds(image_period_), [this] { return next_image(); },
      [this](std::string_view counter, std::string_view text) { report_fault(counter, text); });
  return CallbackReturn::kSuccess;
}

CallbackReturn RackSimulation::on_activate() {
  if (!run_steps_.all_there()) {
    report_progress(0, total_images_, "waiting for the subscriptions of " + run_steps_.missing());
  }
  run_steps_.activate();
  return CallbackReturn::kSuccess;
}

CallbackReturn RackSimulation::on_deactivate() {
  run_steps_.deactivate();
  return CallbackReturn::kSuccess;
}

CallbackReturn RackSimulation::on_cleanup() {
  run_steps_.clean_up();
  command_subscription_ = {};
  clock_publisher_ = {};
  truth_publisher_ = {};
  true_odometry_publisher_ = {};
  imu_publisher_ = {};
  camera_info_publisher_ = {};
  image_publisher_ = {};
  thermal_image_publisher_ = {};
  thermal_camera_info_publisher_ = {};
  true_leaks_publisher_ = {};
  flight_.reset();
  return CallbackReturn::kSuccess;
}

bool RackSimulation::next_image() {
  if (answer_) {
    flight_->fly_until(to_seconds(last_stamp_ - kStart) + latency_of_commands_);
    flight_->command(*answer_);
    answer_.reset();
  } else if (images_ > 0) {
    report_fault("command.missing", "no command has answered an image");
  }
  const double time = static_cast<double>(images_) * image_period_;
  flight_->fly_until(time);
  last_stamp_ = at(time);
  publish_image(last_stamp_);
  ++images_;
  // At most a hundred reports.
  if (images_ * 100 / total_images_ != (images_ - 1) * 100 / total_images_) {
    report_progress(images_, total_images_);
  }
  if (images_ < total_images_) {
    return true;
  }
  report_complete("the UAV has flown " + std::to_string(std::lround(time)) + " s");
  return false;
}

void RackSimulation::publish_image(Time stamp) {
  Clock clock;
  clock.clock = to_message(stamp);
  clock_publisher_.publish(std::move(clock));
  publish_imu();
  publish_true_odometry(stamp);
  if (thermal_ && images_ == 0) {
    publish_true_leaks(stamp);
  }
  if (thermal_ && images_ % images_per_thermal_image_ == 0) {
    publish_thermal_image(stamp);
  }

  auto truth = std::make_unique<Pose>();
  truth->header.stamp = to_message(stamp);
  truth->header.frame_id = frame_;
  truth->pose = to_message(flight_->T_rack_camera());
  truth_publisher_.publish(std::move(truth));

  auto info = std::make_unique<CameraInfo>(to_message(camera_));
  info->header.stamp = to_message(stamp);
  info->header.frame_id = kCameraFrame;
  camera_info_publisher_.publish(std::move(info));

  auto image = std::make_unique<Image>();
  image->header.stamp = to_message(stamp);
  image->header.frame_id = kCameraFrame;
  image->width = static_cast<std::uint32_t>(camera_.width);
  image->height = static_cast<std::uint32_t>(camera_.height);
  image->encoding = "mono8";
  image->step = static_cast<std::uint32_t>(camera_.width);
  image->data.resize(static_cast<std::size_t>(camera_.width) *
                     static_cast<std::size_t>(camera_.height));
  flight_->render(images_, image->data);
  image_publisher_.publish(std::move(image));
}

void RackSimulation::publish_imu() {
  for (const simulation::RackFlight::ImuSample& sample : flight_->take_imu_samples()) {
    auto message = std::make_unique<Imu>(
        imu_message(sample.reading.angular_rate, sample.reading.specific_force));
    message->header.stamp = to_message(at(sample.time));
    message->header.frame_id = kBaseFrame;
    imu_publisher_.publish(std::move(message));
  }
}

void RackSimulation::publish_true_odometry(Time stamp) {
  const simulation::UavState& state = flight_->uav();
  const Eigen::Vector3d velocity = state.T_rack_body.rotation().inverse() * state.velocity;
  auto message = std::make_unique<Odometry>();
  message->header.stamp = to_message(stamp);
  message->header.frame_id = frame_;
  message->child_frame_id = kBaseFrame;
  message->pose.pose = to_message(state.T_rack_body);
  message->twist.twist = twist_message(velocity, state.angular_rate);
  true_odometry_publisher_.publish(std::move(message));
}

void RackSimulation::on_command(const Twist& message) {
  const auto& linear = message.twist.linear;
  const auto& angular = message.twist.angular;
  const simulation::UavCommand command{.velocity = {linear.x, linear.y, linear.z},
                                       .yaw_rate = angular.z};
  if (!command.velocity.allFinite() || !std::isfinite(command.yaw_rate)) {
    report_fault("command.not_a_number", "a command is not finite: ignored");
    return;
  }
  answer_ = command;
}

}  // namespace pipescout

PIPESCOUT_REGISTER_COMPONENT(pipescout::RackSimulation)
