// SPDX-License-Identifier: Apache-2.0
#include "pipescout/tracking_study/recording.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "pipescout/tracking_study/tracking_score.hpp"

namespace pipescout::tracking_study {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

Recording short_recording(RecordingSettings settings, std::uint64_t seed) {
  settings.frames = 40;
  return record(plan_patrols(1, settings, seed).front(), settings, seed);
}

TEST(Recording, TheSameSeedGivesTheSame) {
  const Recording a = short_recording({}, 1);
  const Recording b = short_recording({}, 1);
  ASSERT_EQ(a.pictures.size(), 40U);
  ASSERT_EQ(a.regions.size(), b.regions.size());
  EXPECT_EQ(a.regions.back().start, b.regions.back().start);
  EXPECT_EQ(a.pictures.back().velocity, b.pictures.back().velocity);
}

TEST(Recording, RegionsLieOnTheTube) {
  const Recording recording = short_recording({.gap = 0}, 2);
  std::size_t near = 0;
  std::size_t shown = 0;
  for (const RecordedPicture& picture : recording.pictures) {
    if (!picture.truth || (*picture.truth)[2] < TrackingSettings::kLeastLength) {
      continue;
    }
    ++shown;
    const auto regions = recording.of(picture);
    near += std::ranges::any_of(regions, [&](const tracking::PipeRegion& region) {
      const tracking::PipeShape::State error =
          tracking::PipeShape::state_of(region) - *picture.truth;
      return error.head<2>().norm() < 4;
    });
  }
  EXPECT_GT(shown, 30U);
  EXPECT_GE(near + 3, shown);
}

TEST(Recording, WithoutErrorsTheVelocityCarriesTheTruthAlong) {
  const Recording recording = short_recording({.frame_rate = 50,
                                               .gap = 0,
                                               .velocity_deviation = 0,
                                               .angular_deviation = 0,
                                               .depth_deviation = 0},
                                              3);
  for (std::size_t i = 1; i < recording.pictures.size(); ++i) {
    const auto& before = recording.pictures[i - 1];
    const auto& now = recording.pictures[i];
    const auto motion = tracking::image_motion(recording.camera, before.truth->head<2>(),
                                               recording.depth, now.velocity);
    const tracking::PipeShape::State carried =
        *before.truth + 0.02 * tracking::PipeShape::moved_by(*before.truth, *motion);
    const auto view = tracking::PipeShape::in_view(carried, recording.image());
    // Across the pipe; along it the border cuts it off.
    EXPECT_NEAR(view.shape.y(), now.truth->y(), 0.5) << i;
    EXPECT_NEAR(view.shape[3], (*now.truth)[3], 0.003) << i;
  }
}

TEST(Recording, GapsAreEmpty) {
  const Recording recording = short_recording({.gap_spacing = 0.5}, 4);
  std::size_t gaps = 0;
  for (const RecordedPicture& picture : recording.pictures) {
    gaps += picture.gap ? 1 : 0;
    EXPECT_TRUE(!picture.gap || picture.regions == 0);
  }
  EXPECT_GT(gaps, 5U);
}

TEST(Recording, BadSettingsAreNamed) {
  EXPECT_THAT([] { RecordingSettings{.frame_rate = 0}.validate(); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("frame_rate")));
  EXPECT_THAT([] { RecordingSettings{.gap = -1}.validate(); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("gap")));
  const RecordingSettings few{.frames = 10};
  EXPECT_THAT([few] { (void)record(plan_patrols(1, few, 1).front(), {.frames = 5000}, 1); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("too short for 5000")));
}

}  // namespace
}  // namespace pipescout::tracking_study
