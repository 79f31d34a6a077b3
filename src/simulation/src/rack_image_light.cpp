// SPDX-License-Identifier: Apache-2.0
#include "pipescout/simulation/rack_image_light.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "pipescout/statistics/draw.hpp"
#include "pipescout/validation/check.hpp"

namespace pipescout::simulation {
namespace {

using validation::check_within;

constexpr std::uint64_t kCloudPurpose = 11;
constexpr std::uint64_t kSkyPurpose = 12;
constexpr std::uint64_t kGainPurpose = 13;
constexpr std::uint64_t kOffsetPurpose = 14;

Wander make_wander(double period, std::uint64_t seed, std::uint64_t purpose) {
  std::mt19937_64 engine = statistics::make_engine(seed, purpose);
  return {0.5 * period, 2 * period, engine};
}

}  // namespace

void RackLightParameters::validate() const {
  mean.validate();
  check_within("RackLightParameters.sun_turn", sun_turn, -1, 1);
  check_within("RackLightParameters.cloud_period", cloud_period, 1, 1e6);
  check_within("RackLightParameters.cloud_depth", cloud_depth, 0, 1);
  check_within("RackLightParameters.sky_change", sky_change, 0, 0.9);
  check_within("RackLightParameters.gain_change", gain_change, 0, 0.9);
  check_within("RackLightParameters.offset_change", offset_change, 0, 100);
}

ChangingRackLight::ChangingRackLight(const RackLightParameters& parameters, std::uint64_t seed)
    : parameters_((parameters.validate(), parameters)),
      cloud_(make_wander(parameters.cloud_period, seed, kCloudPurpose)),
      sky_(make_wander(parameters.cloud_period, seed, kSkyPurpose)),
      gain_(make_wander(parameters.cloud_period, seed, kGainPurpose)),
      offset_(make_wander(parameters.cloud_period, seed, kOffsetPurpose)) {}

RackLight ChangingRackLight::at(double time) const {
  const RackLightParameters& p = parameters_;
  RackLight light = p.mean;
  light.to_sun = Eigen::AngleAxisd(p.sun_turn * time, Eigen::Vector3d::UnitZ()) * light.to_sun;
  // The upper part of the wander is cloud, with steep but smooth borders.
  constexpr double kSteepness = 12;
  const double cloud = 1 / (1 + std::exp(-kSteepness * (cloud_.at(time) - 0.15)));
  light.sun *= 1 - p.cloud_depth * cloud;
  light.sky *= 1 + p.sky_change * sky_.at(time);
  light.gain *= 1 + p.gain_change * gain_.at(time);
  light.offset = std::clamp(light.offset + p.offset_change * offset_.at(time), -255.0, 255.0);
  return light;
}

}  // namespace pipescout::simulation
