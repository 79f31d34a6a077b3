// SPDX-License-Identifier: Apache-2.0
// The rack benchmark compares trackers that both track.
#include <gtest/gtest.h>

#include <cstdint>
#include <numbers>
#include <stdexcept>

#include "pipescout/rack_vision/rack_tracker.hpp"
#include "rack_inputs.hpp"
#include "visp_rack.hpp"
#include "visp_tracker.hpp"

namespace pipescout::benchmarks {
namespace {

using geometry::SE3;

const RackFlight& flight() {
  constexpr std::size_t kImages = 12;
  constexpr std::uint64_t kSeed = 2;
  static const RackFlight images = rack_flight(kSeed, true, kImages);
  return images;
}

void expect_near_truth(const SE3& T_rack_camera, std::size_t index) {
  const SE3& truth = flight().T_rack_camera[index];
  EXPECT_LT((T_rack_camera.translation() - truth.translation()).norm(), 0.05)
      << "m, image " << index;
  EXPECT_LT((T_rack_camera.rotation().inverse() * truth.rotation()).log().norm(),
            std::numbers::pi / 180.0)
      << "rad, image " << index;
}

TEST(RackTrackers, OursFollowsTheCamera) {
  rack_vision::RackTracker tracker(benchmark_rack(), flight().camera);
  ASSERT_TRUE(
      tracker.set_pose(flight().T_rack_camera.front(), 1e-4 * geometry::Matrix6d::Identity()));
  for (std::size_t i = 0; i < flight().size(); ++i) {
    const auto result = tracker.track(flight().image(i), kImagePeriod * static_cast<double>(i));
    ASSERT_EQ(result.status, rack_vision::TrackStatus::kTracking) << result.reason;
    expect_near_truth(result.T_rack_camera, i);
  }
}

TEST(RackTrackers, ThePeerFollowsTheCamera) {
  VispTracker tracker(rack_cao(benchmark_rack()), visp_camera(flight().camera));
  tracker.start(flight().image(0).pixels, flight().T_rack_camera.front().inverse().matrix());
  for (std::size_t i = 1; i < flight().size(); ++i) {
    const auto pose = tracker.track(flight().image(i).pixels);
    ASSERT_TRUE(pose) << "image " << i;
    expect_near_truth(SE3::from_matrix(*pose).inverse(), i);
  }
}

TEST(RackCao, HasTheEndsOfTheAxesAndTheRadii) {
  rack_vision::RackModel model;
  model.pipes.push_back({.name = "a",
                         .start = {0.5, 1.0, 0.25},
                         .radii = {{0.0, 0.25}, {8.0, 0.25}},
                         .movable = false});
  EXPECT_EQ(rack_cao(model), "V1\n2\n0.5 1 0.25\n0.5 9 0.25\n0\n0\n0\n1\n0 1 0.25\n0\n");
}

TEST(RackCao, RefusesWhatItHasNoBodyFor) {
  rack_vision::RackModel model = benchmark_rack();
  model.pipes[1].radii.back().radius *= 0.5;
  EXPECT_THROW((void)rack_cao(model), std::invalid_argument);
}

}  // namespace
}  // namespace pipescout::benchmarks
