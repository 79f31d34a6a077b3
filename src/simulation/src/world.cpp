// SPDX-License-Identifier: Apache-2.0
#include "pipescout/simulation/world.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "pipescout/statistics/draw.hpp"
#include "pipescout/validation/check.hpp"

namespace pipescout::simulation {
namespace {

void check_range(const std::string& name, const Range& range, double low, double high) {
  validation::check_within(name + ".least", range.least, low, high);
  validation::check_within(name + ".most", range.most, range.least, high);
}

}  // namespace

void WorldRanges::validate() const {
  check_range("gps_correlation_time", gps_correlation_time, 0, 1e5);
  check_range("gps_correlated_share", gps_correlated_share, 0, 1);
  check_range("imu_noise", imu_noise, 0.01, 100);
  check_range("stamp_offset", stamp_offset, -1, 1);
  check_range("wheel_scale", wheel_scale, -0.2, 0.2);
  check_range("slip", slip, 0.01, 100);
  check_range("side_slip", side_slip, 0, 1);
  check_range("heights_missing", heights_missing, 0, 1);
  check_range("lost", lost, 0, 0.9);
}

World draw_world(const WorldRanges& ranges, std::uint64_t seed) {
  constexpr std::uint64_t kPurpose = 21;  // no other simulator draws from this stream
  constexpr double kLeastTime = 0.01;     // s
  ranges.validate();
  auto engine = statistics::make_engine(seed, kPurpose);
  const auto draw = [&](const Range& range) {
    return statistics::uniform(engine, range.least, range.most);
  };
  World world;
  world.gps_correlation_time = std::max(draw(ranges.gps_correlation_time), kLeastTime);
  world.gps_correlated_share = draw(ranges.gps_correlated_share);
  world.imu_noise =
      std::exp(draw({std::log(ranges.imu_noise.least), std::log(ranges.imu_noise.most)}));
  world.gps_stamp_offset = draw(ranges.stamp_offset);
  world.odometer_stamp_offset = draw(ranges.stamp_offset);
  world.camera_stamp_offset = draw(ranges.stamp_offset);
  world.wheel_scale = draw(ranges.wheel_scale);
  world.slip = draw(ranges.slip);
  world.side_slip = draw(ranges.side_slip);
  world.heights_missing = draw(ranges.heights_missing);
  world.lost = draw(ranges.lost);
  return world;
}

}  // namespace pipescout::simulation
