// SPDX-License-Identifier: Apache-2.0
#include "pipescout/leak_study/rack_inspection.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "pipescout/rack_study/image_scene.hpp"

namespace pipescout::leak_study {
namespace {

using ::testing::Each;
using ::testing::Le;

TEST(DrawHotSpots, AreApartWithinTheFlightAndNotHidden) {
  const rack_vision::RackModel rack = rack_study::rack_on_beams();
  std::size_t all_round = 0;
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    const auto spots = draw_hot_spots(rack, 8, seed);
    ASSERT_EQ(spots.size(), 8U);
    for (std::size_t i = 0; i < spots.size(); ++i) {
      const Eigen::Vector3d place = place_of(spots[i], rack);
      EXPECT_GT(place.y(), 2.3);
      EXPECT_LT(place.y(), 7.7);
      if (spots[i].pipe < 4) {
        EXPECT_GT(std::abs(place.y() - rack.pipes[4].start.y()),
                  rack.pipes[4].largest_radius() + spots[i].length / 2);
      }
      for (std::size_t k = 0; k < i; ++k) {
        EXPECT_TRUE(spots[k].pipe != spots[i].pipe ||
                    std::abs(spots[k].along - spots[i].along) > 0.6);
      }
      all_round += spots[i].half_angle == std::numbers::pi ? 1 : 0;
    }
  }
  EXPECT_GT(all_round, 100U);
  EXPECT_LT(all_round, 300U);
}

TEST(PositionError, OfAWarmPipeIsThatFromItsRing) {
  const rack_vision::RackModel rack = rack_study::rack_on_beams();
  simulation::HotSpot spot{.pipe = 1, .along = 4, .azimuth = 0, .half_angle = 0.8};
  const Eigen::Vector3d top = place_of(spot, rack);
  const Eigen::Vector3d side =
      rack.pipes[1].start + 4 * Eigen::Vector3d::UnitY() + 0.15 * Eigen::Vector3d::UnitX();
  EXPECT_NEAR(position_error(spot, rack, top).norm(), 0, 1e-9);
  EXPECT_NEAR(position_error(spot, rack, side).norm(), 0.15 * std::sqrt(2), 1e-9);
  spot.half_angle = std::numbers::pi;
  EXPECT_NEAR(position_error(spot, rack, top).norm(), 0, 1e-9);
  EXPECT_NEAR(position_error(spot, rack, side).norm(), 0, 1e-9);
  const Eigen::Vector3d off(0.02, 0.03, 0);
  EXPECT_LT((position_error(spot, rack, side + off) - off).norm(), 1e-9);
}

TEST(InspectRack, FindsTheHotSpotsOfAFlightAndNothingElse) {
  const RackInspectionScore score = inspect_rack({}, 3);
  EXPECT_EQ(score.hot_spots, 3U);
  EXPECT_EQ(score.found, 3U);
  EXPECT_EQ(score.false_findings, 0U);
  EXPECT_THAT(score.position_errors, Each(Le(0.10)));
  EXPECT_EQ(score.with_pose, score.images);
  EXPECT_GT(score.placed, score.thermal_images * 9 / 10);
  EXPECT_TRUE(score.complete);
}

TEST(InspectRack, RefusesSettingsOutOfRange) {
  EXPECT_THROW((void)inspect_rack({.hot_spots = 9}, 1), std::invalid_argument);
  EXPECT_THROW((void)inspect_rack({.offset_deviation = 0.06}, 1), std::invalid_argument);
  EXPECT_THROW((void)inspect_rack({.wind_at_20_feet = -1}, 1), std::invalid_argument);
  EXPECT_THROW((void)inspect_rack({.longest = std::nan("")}, 1), std::invalid_argument);
}

}  // namespace
}  // namespace pipescout::leak_study
