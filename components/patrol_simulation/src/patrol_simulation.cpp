// SPDX-License-Identifier: Apache-2.0
#include "pipescout/patrol_simulation/patrol_simulation.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <string>
#include <utility>

#include "pipescout/interfaces/conversions.hpp"
#include "pipescout/interfaces/register_component.hpp"
#include "pipescout/interfaces/topics.hpp"
#include "pipescout/message_conversions/camera.hpp"
#include "pipescout/message_conversions/geometry.hpp"
#include "pipescout/message_conversions/motion.hpp"

namespace pipescout {
namespace {

using simulation::GroundRobot;
namespace fix_constants = sensor_msgs::msg::NavSatFix_Constants;
namespace status_constants = sensor_msgs::msg::NavSatStatus_Constants;

/// Of the simulated clock: a stamp of zero means "no time" to some.
constexpr Time kStart{std::chrono::seconds(1000)};
constexpr const char* kMapFrame = "map";
constexpr const char* kBaseFrame = "base_link";
constexpr const char* kCameraFrame = "thermal_optical";
constexpr std::array kWheelNames{"front_left", "front_right", "rear_left", "rear_right"};
constexpr double kOdometerDeviation = 0.01;  // m, stated of a reading

Time at(double seconds) {
  return kStart + from_seconds(seconds);
}

}  // namespace

PatrolSimulation::PatrolSimulation(ComponentOptions options)
    : Component(std::move(options)), patrol_parameters_(parameters()) {
  rate_ = parameters().declare<double>(
      "rate", 1.0,
      {.description = "largest speed of the simulation, as a multiple of real time",
       .floating_point_range = FloatingPointRange{1e-2, 1e3}});
  wait_for_subscribers_ = parameters().declare<int>(
      "wait_for_subscribers", 1,
      {.description = "nothing is published before so many subscriptions of thermal/image_raw and "
                      "of thermal/camera_info are matched",
       .integer_range = IntegerRange{0, 1000}});
}

PatrolSimulation::~PatrolSimulation() {
  close();
}

CallbackReturn PatrolSimulation::on_configure() {
  const PatrolDriveParameters parameters = patrol_parameters_.drive();
  grey_ = patrol_parameters_.grey();
  const std::vector<double> range = patrol_parameters_.grey_range();
  frame_.emplace(patrol_parameters_.datum());
  drive_.emplace(parameters);
  greys_.emplace(drive_->patrol().renderer().radiometry(), range[0], range[1]);
  const geometry::CameraParameters& camera = parameters.patrol.camera.camera;
  counts_.assign(static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height),
                 0);
  image_period_ =
      std::round(1 / patrol_parameters_.image_rate() / GroundRobot::kStep) * GroundRobot::kStep;
  real_period_ = from_seconds(image_period_ / rate_.get());
  wanted_subscribers_ = static_cast<std::size_t>(wait_for_subscribers_.get());
  const double way = parameters.patrol.end - parameters.patrol.begin;
  expected_images_ = static_cast<std::uint64_t>(
      std::ceil((parameters.standing + way / parameters.patrol.speed) / image_period_));
  images_ = 0;
  complete_ = false;
  const auto matched = [this](std::size_t) { start_if_heard(); };
  clock_publisher_ = create_publisher(topics::kClock);
  true_leaks_publisher_ = create_publisher(topics::kTrueLeaks);
  true_odometry_publisher_ = create_publisher(topics::kTrueOdometry);
  imu_publisher_ = create_publisher(topics::kImu);
  fix_publisher_ = create_publisher(topics::kGpsFix);
  readings_publisher_ = create_publisher(topics::kOdometerReadings);
  camera_info_publisher_ = create_publisher(topics::kThermalCameraInfo, {.matched = matched});
  image_publisher_ = create_publisher(topics::kThermalImage, {.matched = matched});
  return CallbackReturn::kSuccess;
}

CallbackReturn PatrolSimulation::on_activate() {
  active_ = true;
  if (images_ == 0) {
    report_progress(0, expected_images_,
                    "waits for subscriptions of thermal/image_raw and thermal/camera_info");
  }
  start_if_heard();
  return CallbackReturn::kSuccess;
}

CallbackReturn PatrolSimulation::on_deactivate() {
  active_ = false;
  timer_.reset();
  return CallbackReturn::kSuccess;
}

CallbackReturn PatrolSimulation::on_cleanup() {
  active_ = false;
  timer_.reset();
  clock_publisher_ = {};
  true_leaks_publisher_ = {};
  true_odometry_publisher_ = {};
  imu_publisher_ = {};
  fix_publisher_ = {};
  readings_publisher_ = {};
  camera_info_publisher_ = {};
  image_publisher_ = {};
  drive_.reset();
  return CallbackReturn::kSuccess;
}

void PatrolSimulation::start_if_heard() {
  const bool heard = image_publisher_ && camera_info_publisher_ &&
                     image_publisher_.subscription_count() >= wanted_subscribers_ &&
                     camera_info_publisher_.subscription_count() >= wanted_subscribers_;
  if (active_ && heard && !timer_) {
    next_image_not_before_ = steady_now();
    schedule();
  }
}

void PatrolSimulation::schedule() {
  timer_.reset();
  if (complete_) {
    return;
  }
  const Duration left = next_image_not_before_ - steady_now();
  timer_ = create_timer(std::max(left, Duration(1)), [this] {
    timer_.reset();
    next_image();
  });
}

void PatrolSimulation::next_image() {
  const double time = static_cast<double>(images_) * image_period_;
  drive_->drive_until(time);
  const Time stamp = at(time);
  next_image_not_before_ = steady_now() + real_period_;
  Clock clock;
  clock.clock(to_message(stamp));
  clock_publisher_.publish(std::move(clock));
  if (images_ == 0) {
    publish_true_leaks();
  }
  publish_imu();
  publish_odometers();
  publish_fixes();
  publish_true_odometry(stamp);
  publish_image(stamp);
  ++images_;
  complete_ = drive_->arrived();
  if (complete_) {
    report_complete("the robot has gone " +
                    std::to_string(std::lround(drive_->patrol().robot().distance())) + " m");
  } else if (images_ < expected_images_ &&
             images_ * 100 / expected_images_ != (images_ - 1) * 100 / expected_images_) {
    report_progress(images_, expected_images_);
  }
  schedule();
}

void PatrolSimulation::publish_imu() {
  for (const PatrolDrive::ImuSample& sample : drive_->take_imu_samples()) {
    auto message = std::make_unique<Imu>(
        imu_message(sample.reading.angular_rate, sample.reading.specific_force));
    message->header().stamp(to_message(at(sample.time)));
    message->header().frame_id(kBaseFrame);
    imu_publisher_.publish(std::move(message));
  }
}

void PatrolSimulation::publish_odometers() {
  for (const PatrolDrive::OdometerSample& sample : drive_->take_odometer_samples()) {
    auto message = std::make_unique<Readings>();
    message->header().stamp(to_message(at(sample.time)));
    message->header().frame_id(kBaseFrame);
    message->name().assign(kWheelNames.begin(), kWheelNames.end());
    message->distance().assign(sample.distances.begin(), sample.distances.end());
    message->standard_deviation().assign(kWheelNames.size(), kOdometerDeviation);
    message->valid().assign(kWheelNames.size(), true);
    readings_publisher_.publish(std::move(message));
  }
}

void PatrolSimulation::publish_fixes() {
  for (const simulation::GpsFix& fix : drive_->take_fixes()) {
    const geometry::GeodeticPosition place = frame_->geodetic(fix.position);
    const Eigen::Matrix3d axes = frame_->axes_at(place);
    const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> covariance =
        axes.transpose() * fix.covariance * axes;
    auto message = std::make_unique<Fix>();
    message->header().stamp(to_message(at(fix.time)));
    message->header().frame_id(kBaseFrame);
    message->status().status(status_constants::STATUS_FIX);
    message->status().service(status_constants::SERVICE_GPS);
    message->latitude(place.latitude);
    message->longitude(place.longitude);
    message->altitude(place.altitude);
    std::copy_n(covariance.data(), covariance.size(), message->position_covariance().begin());
    message->position_covariance_type(fix_constants::COVARIANCE_TYPE_KNOWN);
    fix_publisher_.publish(std::move(message));
  }
}

void PatrolSimulation::publish_true_leaks() {
  const simulation::ThermalScene& scene = drive_->patrol().scene();
  std::uint64_t id = 0;
  for (const simulation::ThermalLeak& leak : scene.parameters().leaks) {
    const Eigen::Vector3d place = scene.on_tube(leak.place);
    auto message = std::make_unique<pipescout_msgs::msg::LeakEvent>();
    message->header().stamp(to_message(kStart));
    message->header().frame_id(kMapFrame);
    message->kind(pipescout_msgs::msg::LeakEvent_Constants::RAISED);
    message->finding().id(++id);
    message->finding().state("raised");
    message->finding().probability(1);
    message->finding().position_known(true);
    message->finding().position().x(place.x());
    message->finding().position().y(place.y());
    message->finding().position().z(place.z());
    message->finding().length(leak.length);
    message->finding().delta(leak.rise);
    true_leaks_publisher_.publish(std::move(message));
  }
}

void PatrolSimulation::publish_true_odometry(Time stamp) {
  const simulation::BodyMotion& motion = drive_->motion();
  const Eigen::Vector3d velocity = motion.T_map_body.rotation().inverse() * motion.velocity;
  auto message = std::make_unique<Odometry>();
  message->header().stamp(to_message(stamp));
  message->header().frame_id(kMapFrame);
  message->child_frame_id(kBaseFrame);
  message->pose().pose(to_message(motion.T_map_body));
  message->twist().twist(twist_message(velocity, motion.angular_rate));
  true_odometry_publisher_.publish(std::move(message));
}

void PatrolSimulation::publish_image(Time stamp) {
  const geometry::CameraParameters& camera = drive_->patrol().renderer().camera().parameters();
  auto info = std::make_unique<CameraInfo>(to_message(camera));
  info->header().stamp(to_message(stamp));
  info->header().frame_id(kCameraFrame);
  camera_info_publisher_.publish(std::move(info));

  drive_->patrol().render(images_, counts_);
  auto image = std::make_unique<Image>();
  image->header().stamp(to_message(stamp));
  image->header().frame_id(kCameraFrame);
  image->width(static_cast<std::uint32_t>(camera.width));
  image->height(static_cast<std::uint32_t>(camera.height));
  image->encoding(grey_ ? "mono8" : "mono16");
  image->is_bigendian(std::endian::native == std::endian::big ? 1 : 0);
  const std::size_t pixel = grey_ ? 1 : sizeof(std::uint16_t);
  image->step(static_cast<std::uint32_t>(pixel * static_cast<std::size_t>(camera.width)));
  image->data().resize(pixel * counts_.size());
  if (grey_) {
    greys_->convert(counts_, image->data());
  } else {
    std::memcpy(image->data().data(), counts_.data(), image->data().size());
  }
  image_publisher_.publish(std::move(image));
}

}  // namespace pipescout

PIPESCOUT_REGISTER_COMPONENT(pipescout::PatrolSimulation)
