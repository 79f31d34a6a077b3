// SPDX-License-Identifier: Apache-2.0
#include "pipescout/simulation/rack_image_light.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace pipescout::simulation {
namespace {

TEST(ChangingRackLight, StaysWithinItsBoundsAndUsesThem) {
  const RackLightParameters parameters;
  double darkest = 10;
  double brightest = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const ChangingRackLight light(parameters, seed);
    for (double time = 0; time < 120; time += 0.1) {
      const RackLight now = light.at(time);
      EXPECT_NO_THROW(now.validate());
      const double share = now.sun / parameters.mean.sun;
      EXPECT_GE(share, 1 - parameters.cloud_depth - 1e-12);
      EXPECT_LE(share, 1);
      EXPECT_NEAR(now.sky / parameters.mean.sky, 1, parameters.sky_change);
      EXPECT_NEAR(now.gain / parameters.mean.gain, 1, parameters.gain_change);
      EXPECT_NEAR(now.offset, parameters.mean.offset, parameters.offset_change);
      darkest = std::min(darkest, share);
      brightest = std::max(brightest, share);
    }
  }
  EXPECT_LT(darkest, 0.4);
  EXPECT_GT(brightest, 0.95);
}

TEST(ChangingRackLight, ChangesSmoothlyAndTheSunTurns) {
  const RackLightParameters parameters{.sun_turn = 0.01};
  const ChangingRackLight light(parameters, 3);
  for (double time = 0; time < 60; time += 0.04) {
    // From one frame to the next at 25 Hz.
    EXPECT_NEAR(light.at(time).sun, light.at(time + 0.04).sun, 0.05 * parameters.mean.sun);
  }
  const Eigen::Vector3d before = light.at(0).to_sun;
  const Eigen::Vector3d after = light.at(60).to_sun;
  EXPECT_NEAR(before.z(), after.z(), 1e-12);
  EXPECT_NEAR(before.head<2>().dot(after.head<2>()) / before.head<2>().squaredNorm(), std::cos(0.6),
              1e-9);
}

TEST(ChangingRackLight, IsAFunctionOfSeedAndTime) {
  const ChangingRackLight one({}, 5);
  const ChangingRackLight other({}, 5);
  EXPECT_EQ(one.at(12.5).sun, other.at(12.5).sun);
  EXPECT_NE(one.at(12.5).sky, ChangingRackLight({}, 6).at(12.5).sky);
}

TEST(ChangingRackLight, RefusesBadParameters) {
  RackLightParameters parameters;
  parameters.cloud_depth = 1.2;
  EXPECT_THROW(ChangingRackLight(parameters, 1), std::invalid_argument);
  parameters = {};
  parameters.mean.to_sun.setZero();
  EXPECT_THROW(ChangingRackLight(parameters, 1), std::invalid_argument);
}

}  // namespace
}  // namespace pipescout::simulation
