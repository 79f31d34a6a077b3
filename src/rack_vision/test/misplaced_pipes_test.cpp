// SPDX-License-Identifier: Apache-2.0
// Pipes that lie elsewhere than the model has them: centimetres, with nothing said of it, or
// decimetres, with as much said.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <array>
#include <vector>

#include "drawn_rack.hpp"
#include "pipescout/rack_vision/rack_tracker.hpp"
#include "pipescout/statistics/chi_square.hpp"

namespace pipescout::rack_vision {
namespace {

using test::DrawnImage;

geometry::SE3 flight(int k) {
  return test::drawn_pose(0.78 + 0.006 * k, 4.0 + 0.008 * k, 2.8 - 0.002 * k, 0.10 + 0.002 * k);
}

constexpr int kImages = 25;

const std::vector<DrawnImage>& images() {
  static const std::vector<DrawnImage> drawn = [] {
    std::vector<DrawnImage> result;
    for (int k = 0; k < kImages; ++k) {
      result.push_back(test::noisy(test::draw(test::drawn_rack(), test::drawn_camera(), flight(k)),
                                   1.5, static_cast<std::uint64_t>(100 + k)));
    }
    return result;
  }();
  return drawn;
}

/// Offsets of the model's pipes from their true places, m, and what is said of them.
struct Misplacement {
  std::array<double, 3> by;
  double stated_sigma;
};

class MisplacedPipes : public ::testing::TestWithParam<Misplacement> {};

TEST_P(MisplacedPipes, AreFoundAndGiveNoWrongPoseThatIsDenied) {
  const geometry::Camera camera = test::drawn_camera();
  RackModel model = test::drawn_rack();
  for (std::size_t i = 0; i < 3; ++i) {
    model.pipes[i + 1].start.x() += GetParam().by[i];
  }
  RackTrackerParameters parameters;
  parameters.offset_sigma = GetParam().stated_sigma;
  RackTracker tracker(model, camera, parameters);
  geometry::Vector6d deviations;
  deviations << 0.01, 0.01, 0.01, 0.005, 0.005, 0.005;
  const geometry::SE3 first(geometry::SO3::about_y(0.004) * flight(0).rotation(),
                            flight(0).translation() + Eigen::Vector3d(0.007, -0.008, 0.01));
  ASSERT_TRUE(tracker.set_pose(first, geometry::Matrix6d(deviations.cwiseAbs2().asDiagonal())));
  const double pose_99 = statistics::chi_square_quantile(0.99, 6);
  for (int k = 0; k < kImages; ++k) {
    const RackTrackerResult result =
        tracker.track(images()[static_cast<std::size_t>(k)].view(), 0.04 * k);
    ASSERT_EQ(result.status, TrackStatus::kTracking) << k << ": " << result.reason;
    geometry::Vector6d error;
    error << result.T_rack_camera.translation() - flight(k).translation(),
        (result.T_rack_camera.rotation() * flight(k).rotation().inverse()).log();
    EXPECT_LT(error.dot(result.covariance.ldlt().solve(error)), pose_99) << k;
    if (k + 1 == kImages) {
      for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_NEAR(result.offsets[i + 1], -GetParam().by[i], 0.012) << i;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Racks, MisplacedPipes,
                         ::testing::Values(Misplacement{{0, 0, 0}, 0.01},
                                           Misplacement{{0.02, 0.03, 0.03}, 0.01},
                                           Misplacement{{-0.02, -0.03, -0.03}, 0.01},
                                           Misplacement{{0.03, 0.045, 0.045}, 0.01},
                                           Misplacement{{0.04, -0.04, 0.03}, 0.01},
                                           Misplacement{{-0.05, 0, 0.06}, 0.035},
                                           Misplacement{{0.05, 0.15, 0.20}, 0.1},
                                           Misplacement{{0.05, 0.15, 0.20}, 0.2}));

}  // namespace
}  // namespace pipescout::rack_vision
