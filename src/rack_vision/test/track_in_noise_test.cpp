// SPDX-License-Identifier: Apache-2.0
// Images whose noise is far above that of a camera by day.
#include <gtest/gtest.h>

#include <tuple>

#include "drawn_rack.hpp"
#include "pipescout/rack_vision/rack_tracker.hpp"

namespace pipescout::rack_vision {
namespace {

using test::draw;
using test::drawn_camera;
using test::drawn_pose;
using test::drawn_rack;

geometry::SE3 flight(int k) {
  return drawn_pose(0.78 + 0.006 * k, 4.0 + 0.008 * k, 2.8 - 0.002 * k, 0.10 + 0.002 * k);
}

/// Contrast of the texture, and sigma of the noise.
class TrackInNoise : public ::testing::TestWithParam<std::tuple<double, double>> {};

TEST_P(TrackInNoise, StartsAndTracks) {
  const auto [contrast, sigma] = GetParam();
  const geometry::Camera camera = drawn_camera();
  RackTracker tracker(drawn_rack(), camera);
  geometry::Vector6d deviations;
  deviations << 0.01, 0.01, 0.01, 0.005, 0.005, 0.005;
  ASSERT_TRUE(tracker.set_pose(flight(0), geometry::Matrix6d(deviations.cwiseAbs2().asDiagonal())));
  constexpr int kImages = 12;
  for (int k = 0; k < kImages; ++k) {
    const test::DrawnImage image = test::noisy(draw(drawn_rack(), camera, flight(k), 1.0, contrast),
                                               sigma, static_cast<std::uint64_t>(100 + k));
    const RackTrackerResult result = tracker.track(image.view(), 0.04 * k);
    ASSERT_EQ(result.status, TrackStatus::kTracking) << k << ": " << result.reason;
    const Eigen::Vector3d error = result.T_rack_camera.translation() - flight(k).translation();
    EXPECT_LT(std::hypot(error.x(), error.z()), 0.03) << k;
  }
}

INSTANTIATE_TEST_SUITE_P(PlainAndTextured, TrackInNoise,
                         ::testing::Combine(::testing::Values(0.0, 1.0),
                                            ::testing::Values(0.0, 3.0, 10.0, 20.0)));

}  // namespace
}  // namespace pipescout::rack_vision
