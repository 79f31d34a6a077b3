// SPDX-License-Identifier: Apache-2.0
#include "pipescout/simulation/rack_flight.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace pipescout::simulation {

namespace {

constexpr std::uint64_t kStepsPerGust = 10;

RackScene seeded_scene(const RackFlightParameters& parameters) {
  RackScene scene = parameters.scene;
  scene.seed = parameters.seed;
  return scene;
}

DrydenWindParameters sampled_wind(const RackFlightParameters& parameters) {
  DrydenWindParameters wind = parameters.wind;
  wind.period = static_cast<double>(kStepsPerGust) * Uav::kStep;
  return wind;
}

Eigen::Vector3d mean_wind(const RackFlightParameters& parameters) {
  const double speed = dryden_model(parameters.wind).mean_speed;
  const double direction = parameters.wind.direction;
  return speed * Eigen::Vector3d(std::cos(direction), std::sin(direction), 0);
}

}  // namespace

RackFlight::RackFlight(const RackFlightParameters& parameters)
    : T_base_camera_(parameters.T_base_camera),
      wind_(sampled_wind(parameters), parameters.seed),
      uav_(parameters.uav, parameters.start_position, parameters.start_yaw, mean_wind(parameters),
           parameters.seed),
      light_(parameters.light, parameters.seed),
      renderer_(seeded_scene(parameters), geometry::Camera(parameters.camera), parameters.sensor) {
  if (parameters.thermal) {
    const RackThermalParameters& thermal = *parameters.thermal;
    RackThermalScene scene;
    scene.model = parameters.scene.model;
    scene.ground_height = parameters.scene.ground_height;
    scene.hot_spots = thermal.hot_spots;
    scene.warm_ground = thermal.warm_ground;
    scene.seed = parameters.seed;
    T_base_thermal_ = thermal.T_base_camera;
    thermal_.emplace(scene, geometry::Camera(thermal.camera), thermal.sensor);
  }
  if (parameters.imu) {
    steps_per_sample_ = static_cast<std::uint64_t>(
        std::max(1LL, std::llround(parameters.imu->period / Uav::kStep)));
    ImuParameters sampled = *parameters.imu;
    sampled.period = static_cast<double>(steps_per_sample_) * Uav::kStep;
    imu_.emplace(sampled, parameters.seed);
  }
}

void RackFlight::fly_until(double time) {
  const auto wanted = static_cast<std::int64_t>(std::llround(time / Uav::kStep));
  while (static_cast<std::int64_t>(steps_) < wanted) {
    if (steps_ % kStepsPerGust == 0) {
      gust_ = wind_.next();
    }
    uav_.step(gust_);
    ++steps_;
    if (imu_ && steps_ % steps_per_sample_ == 0) {
      const UavState& state = uav_.state();
      imu_samples_.push_back({.time = state.time,
                              .reading = imu_->measure({.angular_rate = state.angular_rate,
                                                        .specific_force = state.specific_force})});
    }
  }
}

std::vector<RackFlight::ImuSample> RackFlight::take_imu_samples() {
  return std::exchange(imu_samples_, {});
}

void RackFlight::render(std::uint64_t frame, std::span<std::uint8_t> grey) {
  renderer_.render({.T_camera_rack = T_rack_camera().inverse(),
                    .velocity = camera_velocity(),
                    .light = light_.at(uav_.state().time),
                    .frame = frame},
                   grey);
}

void RackFlight::render_thermal(std::uint64_t frame, std::span<std::uint16_t> counts) {
  thermal_.value().render(uav_.state().T_rack_body * T_base_thermal_, frame, counts);
}

geometry::SE3 RackFlight::T_rack_camera() const {
  return uav_.state().T_rack_body * T_base_camera_;
}

geometry::Vector6d RackFlight::camera_velocity() const {
  const UavState& state = uav_.state();
  const geometry::SO3 R_camera_base = T_base_camera_.rotation().inverse();
  geometry::Vector6d velocity;
  velocity << R_camera_base * (state.T_rack_body.rotation().inverse() * state.velocity +
                               state.angular_rate.cross(T_base_camera_.translation())),
      R_camera_base * state.angular_rate;
  return velocity;
}

}  // namespace pipescout::simulation
