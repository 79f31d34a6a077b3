// SPDX-License-Identifier: Apache-2.0
#include <bit>
#include <cstring>
#include <pipescout/rack_vision/visual_servo.hpp>
#include <stdexcept>

#include "pipescout/catalogue/topics.hpp"
#include "pipescout/message_conversions/camera.hpp"
#include "pipescout/rack_simulation/rack_simulation.hpp"
#include "pipescout/runtime/conversions.hpp"

namespace pipescout {

namespace {

constexpr const char* kThermalFrame = "thermal_optical";
constexpr std::size_t kPerHotSpot = 6;
constexpr std::size_t kPerWarmGround = 4;

void check_groups(const Parameter<std::vector<double>>& parameter, std::size_t group) {
  if (parameter.share()->size() % group != 0) {
    throw std::invalid_argument("parameter '" + parameter.name() + "' has " +
                                std::to_string(parameter.share()->size()) +
                                " values: must be a multiple of " + std::to_string(group));
  }
}

Eigen::Vector3d three_or_zero(const Parameter<std::vector<double>>& parameter) {
  const auto values = parameter.share();
  if (values->empty()) {
    return Eigen::Vector3d::Zero();
  }
  if (values->size() != 3) {
    throw std::invalid_argument("parameter '" + parameter.name() + "' has " +
                                std::to_string(values->size()) + " values: must be 3");
  }
  return {(*values)[0], (*values)[1], (*values)[2]};
}

}  // namespace

void RackSimulation::declare_thermal_parameters() {
  const simulation::RackThermalSensor sensor;
  thermal_image_rate_ = parameters().declare<double>(
      "thermal.image_rate", 0.0,
      {.description = "Hz; with every so many of the other images; 0: there is no thermal camera",
       .floating_point_range = FloatingPointRange{0.0, 200.0}});
  thermal_width_ = parameters().declare<int>(
      "thermal.width", 320, {.description = "pixels", .integer_range = IntegerRange{16, 2048}});
  thermal_height_ = parameters().declare<int>(
      "thermal.height", 240, {.description = "pixels", .integer_range = IntegerRange{16, 2048}});
  thermal_focal_length_ =
      parameters().declare<double>("thermal.focal_length", 280.0, {.description = "pixels"});
  thermal_netd_ =
      parameters().declare<double>("thermal.netd", sensor.netd,
                                   {.description = "K, noise of a black body at 30 degC",
                                    .floating_point_range = FloatingPointRange{0.0, 5.0}});
  thermal_position_ = parameters().declare<std::vector<double>>(
      "thermal.position", {},
      {.description = "m, x y z of the thermal camera in base_link; empty: at its origin"});
  thermal_roll_pitch_yaw_ = parameters().declare<std::vector<double>>(
      "thermal.roll_pitch_yaw", {},
      {.description = "rad, of the optical frame in base_link; empty: straight down, the upper "
                      "border of the image forward"});
  hot_spots_ = parameters().declare<std::vector<double>>(
      "hot_spots", {},
      {.description =
           "of each: index of the pipe; m along it; rad around it, from its top; length, "
           "m; half of the angle around the pipe, rad; K above the pipe"});
  warm_ground_ = parameters().declare<std::vector<double>>(
      "warm_ground", {},
      {.description = "of each warm place of the ground: x, y, radius, m; degC"});
}

std::optional<simulation::RackThermalParameters> RackSimulation::thermal_parameters() const {
  if (thermal_image_rate_.get() == 0.0) {
    return std::nullopt;
  }
  simulation::RackThermalParameters result;
  result.camera.width = thermal_width_.get();
  result.camera.height = thermal_height_.get();
  result.camera.focal_length = thermal_focal_length_.get();
  result.camera.centre_u = (thermal_width_.get() - 1) / 2.0;
  result.camera.centre_v = (thermal_height_.get() - 1) / 2.0;
  result.sensor.netd = thermal_netd_.get();
  const Eigen::Vector3d position = three_or_zero(thermal_position_);
  result.T_base_camera =
      thermal_roll_pitch_yaw_.share()->empty()
          ? rack_vision::downward_camera(position)
          : geometry::SE3(
                geometry::SO3::from_roll_pitch_yaw(three_or_zero(thermal_roll_pitch_yaw_)),
                position);
  check_groups(hot_spots_, kPerHotSpot);
  const auto spots = hot_spots_.share();
  for (std::size_t i = 0; i < spots->size(); i += kPerHotSpot) {
    const double* const values = spots->data() + i;
    if (!(values[0] >= 0)) {
      throw std::invalid_argument("parameter 'hot_spots': the index of a pipe is negative");
    }
    result.hot_spots.push_back({.pipe = static_cast<std::size_t>(values[0]),
                                .along = values[1],
                                .azimuth = values[2],
                                .length = values[3],
                                .half_angle = values[4],
                                .rise = values[5]});
  }
  check_groups(warm_ground_, kPerWarmGround);
  const auto ground = warm_ground_.share();
  for (std::size_t i = 0; i < ground->size(); i += kPerWarmGround) {
    const double* const values = ground->data() + i;
    result.warm_ground.push_back(
        {.middle = {values[0], values[1]}, .radius = values[2], .temperature = values[3]});
  }
  return result;
}

void RackSimulation::publish_thermal_image(Time stamp) {
  const geometry::CameraParameters& camera = thermal_->camera;
  auto info = std::make_unique<CameraInfo>(to_message(camera));
  info->header.stamp = to_message(stamp);
  info->header.frame_id = kThermalFrame;
  thermal_camera_info_publisher_.publish(std::move(info));

  std::vector<std::uint16_t> counts(static_cast<std::size_t>(camera.width) *
                                    static_cast<std::size_t>(camera.height));
  flight_->render_thermal(images_, counts);
  auto image = std::make_unique<Image>();
  image->header.stamp = to_message(stamp);
  image->header.frame_id = kThermalFrame;
  image->width = static_cast<std::uint32_t>(camera.width);
  image->height = static_cast<std::uint32_t>(camera.height);
  image->encoding = "mono16";
  image->is_bigendian = std::endian::native == std::endian::big ? 1 : 0;
  image->step = static_cast<std::uint32_t>(sizeof(std::uint16_t)) * image->width;
  image->data.resize(sizeof(std::uint16_t) * counts.size());
  std::memcpy(image->data.data(), counts.data(), image->data.size());
  thermal_image_publisher_.publish(std::move(image));
}

void RackSimulation::publish_true_leaks(Time stamp) {
  for (std::size_t i = 0; i < hot_places_.size(); ++i) {
    auto message = std::make_unique<LeakEvent>();
    message->header.stamp = to_message(stamp);
    message->header.frame_id = frame_;
    message->kind = LeakEvent::RAISED;
    message->finding.id = i + 1;
    message->finding.state = "raised";
    message->finding.probability = 1;
    message->finding.position_known = true;
    message->finding.position.x = hot_places_[i].x();
    message->finding.position.y = hot_places_[i].y();
    message->finding.position.z = hot_places_[i].z();
    message->finding.length = thermal_->hot_spots[i].length;
    message->finding.delta = thermal_->hot_spots[i].rise;
    true_leaks_publisher_.publish(std::move(message));
  }
}

}  // namespace pipescout
