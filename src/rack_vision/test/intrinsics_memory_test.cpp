// SPDX-License-Identifier: Apache-2.0
#include "intrinsics_memory.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <optional>

namespace pipescout::rack_vision {
namespace {

constexpr double kFocalSigma = 10;
constexpr double kCentreSigma = 6;

class IntrinsicsMemoryTest : public ::testing::Test {
 protected:
  /// What an image with this information, px^-2, makes of the belief when the truth is as given.
  [[nodiscard]] IntrinsicsBelief image(const Eigen::Vector3d& truth, double information) const {
    const Eigen::Matrix3d prior = memory_.belief().covariance.inverse();
    const Eigen::Matrix3d data = information * Eigen::Matrix3d::Identity();
    const Eigen::Matrix3d covariance = (prior + data).inverse();
    return {memory_.belief().mean + covariance * data * (truth - memory_.belief().mean),
            covariance};
  }

  geometry::Camera camera_;
  IntrinsicsMemory memory_{camera_, kFocalSigma, kCentreSigma};
  const Eigen::Vector3d calibrated_{630, 360, 240};
};

TEST_F(IntrinsicsMemoryTest, BeginsWithTheCalibration) {
  EXPECT_EQ(memory_.belief().mean, calibrated_);
  EXPECT_EQ(memory_.belief().covariance.diagonal(), Eigen::Vector3d(100, 36, 36));
  EXPECT_FALSE(memory_.improved().has_value());
}

TEST_F(IntrinsicsMemoryTest, ImagesAddUpSlowlyToTheTruth) {
  const Eigen::Vector3d truth(641, 357, 243);
  memory_.learn(image(truth, 0.1));
  const double first = (memory_.belief().mean - truth).norm();
  EXPECT_LT(first, (calibrated_ - truth).norm());
  EXPECT_GT(first, 0.5 * (calibrated_ - truth).norm());
  for (int i = 0; i < 400; ++i) {
    memory_.learn(image(truth, 0.1));
  }
  EXPECT_LT((memory_.belief().mean - truth).norm(), 0.5);
  // 400 images of which one in twenty counts.
  EXPECT_NEAR(memory_.belief().covariance(0, 0), 1 / (401 * 0.1 / 20 + 0.01), 1e-6);
}

TEST_F(IntrinsicsMemoryTest, AnImageThatKnowsLessThanNothingChangesNothing) {
  const IntrinsicsBelief before = memory_.belief();
  memory_.learn({calibrated_ + Eigen::Vector3d::Constant(3), 4 * before.covariance});
  EXPECT_TRUE(memory_.belief().mean.isApprox(before.mean));
  EXPECT_TRUE(memory_.belief().covariance.isApprox(before.covariance));
}

TEST_F(IntrinsicsMemoryTest, DoesNotBelieveWhatTheCalibrationRulesOut) {
  for (int i = 0; i < 1000; ++i) {
    memory_.learn(image(Eigen::Vector3d(900, 360, 240), 0.1));
  }
  EXPECT_LE(memory_.belief().mean(0), 630 + 4 * kFocalSigma);
  const Eigen::Vector3d before = memory_.belief().mean;
  IntrinsicsBelief none = memory_.belief();
  none.mean(0) = std::nan("");
  memory_.learn(none);
  none = {before, Eigen::Matrix3d::Constant(std::nan(""))};
  memory_.learn(none);
  EXPECT_EQ(memory_.belief().mean, before);
}

TEST_F(IntrinsicsMemoryTest, GivesABetterCameraOnceItIsWorthIt) {
  const Eigen::Vector3d truth(636, 362, 239);
  int images = 0;
  std::optional<geometry::Camera> camera;
  while (!camera && images < 100) {
    memory_.learn(image(truth, 0.01));
    camera = memory_.improved();
    ++images;
  }
  ASSERT_TRUE(camera.has_value());
  EXPECT_GT(images, 1);
  EXPECT_EQ(camera->parameters().focal_length, memory_.belief().mean(0));
  EXPECT_EQ(memory_.in_use(), memory_.belief().mean);
  EXPECT_FALSE(memory_.improved().has_value());
  memory_.reset();
  EXPECT_EQ(memory_.in_use(), calibrated_);
}

TEST_F(IntrinsicsMemoryTest, TimeWidensTheBelief) {
  const double before = memory_.belief().covariance(1, 1);
  memory_.predict(100);
  EXPECT_GT(memory_.belief().covariance(1, 1), before);
}

}  // namespace
}  // namespace pipescout::rack_vision
