// SPDX-License-Identifier: Apache-2.0
#include "pipescout/leak_study/campaign.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

namespace pipescout::leak_study {
namespace {

using simulation::ThermalDecoyKind;

TEST(Campaign, HoldsWhatIsAskedForAndApart) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const auto plans = plan_campaign({}, seed);
    ASSERT_EQ(plans.size(), 60U);
    std::size_t faint = 0;
    std::size_t leaks = 0;
    std::array<std::size_t, simulation::kThermalDecoyKinds> decoys{};
    std::size_t grey = 0;
    std::size_t large = 0;
    for (const SequencePlan& plan : plans) {
      const auto& scene = plan.patrol.scene;
      EXPECT_NO_THROW(plan.patrol.validate());
      faint += plan.faint_leaks;
      leaks += scene.leaks.size();
      grey += plan.grey ? 1 : 0;
      large += plan.patrol.camera.camera.width == 640 ? 1 : 0;
      EXPECT_GE(plan.patrol.camera.netd, 0.05);
      EXPECT_LE(plan.patrol.camera.netd, 0.12);
      EXPECT_GE(scene.tube_temperature, 130);
      EXPECT_LE(scene.tube_temperature, 180);
      for (std::size_t i = 0; i < scene.leaks.size(); ++i) {
        const auto& leak = scene.leaks[i];
        EXPECT_EQ(leak.rise < 92, i < plan.faint_leaks);
        EXPECT_GE(leak.length, 0.3);
        EXPECT_GE(leak.place - leak.length / 2, 4);
        EXPECT_LE(leak.place + leak.length / 2, 146);
        for (const auto& decoy : scene.decoys) {
          EXPECT_GT(std::abs(decoy.place - leak.place), 4 + leak.length / 2);
        }
      }
      for (const auto& decoy : scene.decoys) {
        ++decoys[static_cast<std::size_t>(decoy.kind)];
      }
    }
    EXPECT_EQ(faint, 6U);
    EXPECT_EQ(leaks, 13U);
    EXPECT_EQ(grey, 12U);
    EXPECT_EQ(large, 30U);
    EXPECT_EQ(decoys, (std::array<std::size_t, 6>{7, 7, 7, 7, 6, 6}));
  }
}

TEST(Campaign, DrawsWhatTheCameraIsNotTold) {
  const thermal::ObjectParameters told = thermal::ibarguren2013_object();
  std::size_t near = 0;
  for (const SequencePlan& plan : plan_campaign({.near_leaks = 6, .drawn_radiometry = true}, 2)) {
    const thermal::ObjectParameters& object = plan.patrol.scene.object;
    EXPECT_NO_THROW(plan.patrol.validate());
    EXPECT_FALSE(plan.grey);
    EXPECT_GE(object.emissivity, 0.02);
    EXPECT_LE(object.emissivity, 0.1);
    EXPECT_LE(std::abs(object.reflected_temperature - told.reflected_temperature), 10);
    EXPECT_LE(std::abs(object.distance / told.distance - 1), 0.3);
    EXPECT_EQ(plan.patrol.distance, object.distance);
    near += plan.near_leaks;
    const simulation::ThermalScene scene(plan.patrol.scene);
    const auto& leaks = plan.patrol.scene.leaks;
    for (std::size_t i = leaks.size() - plan.near_leaks; i < leaks.size(); ++i) {
      const auto beside = [&](double place) {
        return std::abs(place - leaks[i].place) <= leaks[i].length / 2 + 0.4;
      };
      EXPECT_TRUE(std::ranges::any_of(scene.supports(), beside) ||
                  std::ranges::any_of(scene.joints(),
                                      [&](const auto& joint) { return beside(joint.place); }));
    }
  }
  EXPECT_EQ(near, 6U);
}

TEST(Campaign, FaintLeaksAreClearOfJointsAndPosts) {
  for (const SequencePlan& plan : plan_campaign({}, 3)) {
    const simulation::ThermalScene scene(plan.patrol.scene);
    for (std::size_t i = 0; i < plan.faint_leaks; ++i) {
      const auto& leak = plan.patrol.scene.leaks[i];
      for (const auto& joint : scene.joints()) {
        EXPECT_GT(std::abs(joint.place - leak.place), leak.length / 2 + 0.3);
      }
      for (const double support : scene.supports()) {
        EXPECT_GT(std::abs(support - leak.place), leak.length / 2 + 0.3);
      }
    }
  }
}

TEST(Campaign, IsTheSameForTheSameSeed) {
  const auto first = plan_campaign({}, 7);
  const auto again = plan_campaign({}, 7);
  const auto other = plan_campaign({}, 8);
  EXPECT_EQ(first[5].patrol.scene.tube_temperature, again[5].patrol.scene.tube_temperature);
  EXPECT_NE(first[5].patrol.scene.tube_temperature, other[5].patrol.scene.tube_temperature);
}

TEST(Campaign, RefusesWhatCannotBe) {
  EXPECT_THROW(static_cast<void>(plan_campaign({.sequences = 0}, 1)), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(plan_campaign({.netd_least = 1}, 1)), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(plan_campaign({.apart = 50}, 1)), std::invalid_argument);
  EXPECT_THROW(
      static_cast<void>(plan_campaign(
          {.sequences = 1, .faint_leaks = 1, .other_leaks = 10, .decoys = 10, .length = 30}, 1)),
      std::runtime_error);
}

}  // namespace
}  // namespace pipescout::leak_study
