// SPDX-License-Identifier: Apache-2.0
#include "limb_pair.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

#include "limb_profile.hpp"

namespace pipescout::rack_vision {
namespace {

constexpr double kBlur = 0.88;  // px

using Profile = std::array<float, kLimbWindow>;

struct Scene {
  double contour = 0;  ///< px outwards from the middle
  double border = 0;
  double at_contour = -40;  ///< grey levels: just within, less just outside
  double at_border = -50;   ///< just inside of the border, less the background
  double root = 6;          ///< of the shading
  double ramp = 0.5;
};

Profile profile_of(const Scene& scene) {
  Profile profile;
  for (int i = 0; i < kLimbWindow; ++i) {
    const double at = i - kLimbInside;
    const double within = scene.contour - at;
    profile[static_cast<std::size_t>(i)] = static_cast<float>(
        150 + scene.at_border * blurred_step(scene.border - at, kBlur) +
        scene.at_contour * blurred_step(within, kBlur) + scene.root * blurred_root(within, kBlur) +
        scene.ramp * blurred_ramp(within, kBlur));
  }
  return profile;
}

TEST(LimbPair, TellsAContourFromTheShadowBesideIt) {
  const LimbProfile alone(kBlur);
  const LimbPair pair(kBlur);
  for (const double contour : {-2.1, -1.5, -0.8, -0.3}) {
    for (const double gap : {1.75, 2.25, 2.75}) {
      const Profile profile = profile_of({.contour = contour, .border = contour + gap});
      const auto one = alone.fit(profile);
      const auto two = pair.fit(profile, one.left);
      ASSERT_TRUE(two) << contour << ", " << gap;
      EXPECT_NEAR(two->contour, contour, 0.15) << gap;
      EXPECT_NEAR(two->border, contour + gap, 0.4);
      EXPECT_GT(std::abs(one.place - contour), 0.4) << "nothing to tell apart: " << gap;
      EXPECT_GT(two->sigma, 0);
    }
  }
}

TEST(LimbPair, IsNoneWhereAContourAloneExplainsTheWindow) {
  const LimbProfile alone(kBlur);
  const LimbPair pair(kBlur);
  std::mt19937_64 engine(7);
  std::normal_distribution<float> noise(0, 2.5F);
  int found = 0;
  for (int trial = 0; trial < 500; ++trial) {
    Scene scene{.contour = 0.002 * trial - 0.5, .at_border = 0, .ramp = 0};
    scene.at_contour = trial % 2 == 0 ? 60 : -60;
    Profile profile = profile_of(scene);
    for (float& value : profile) {
      value += noise(engine);
    }
    found += pair.fit(profile, alone.fit(profile).left) ? 1 : 0;
  }
  EXPECT_LE(found, 5) << "of 500";
}

TEST(LimbPair, IsNoneWithoutContrast) {
  const LimbPair pair(kBlur);
  Profile flat;
  flat.fill(128);
  EXPECT_FALSE(pair.fit(flat, 0.25));
  EXPECT_FALSE(pair.fit(flat, 10));
}

}  // namespace
}  // namespace pipescout::rack_vision
