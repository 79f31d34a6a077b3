// SPDX-License-Identifier: Apache-2.0
#include "pipescout/leak_store/evidence.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "example_findings.hpp"

namespace pipescout {
namespace {

cv::Mat decoded(const Thumbnail& thumbnail) {
  return cv::imdecode(thumbnail.png, cv::IMREAD_UNCHANGED);
}

TEST(MakeEvidence, ShowsTheLeak) {
  const test::ExamplePicture picture;
  ASSERT_EQ(picture.detections.leaks.size(), 1U);
  const Evidence e =
      make_evidence(picture.view(), picture.detections, 0, picture.parameters.profile, 3, "x");
  const cv::Mat image = decoded(e.thumbnail);
  EXPECT_EQ(image.cols, e.thumbnail.width);
  EXPECT_EQ(image.rows, e.thumbnail.height);
  EXPECT_NEAR(e.thumbnail.coldest, 15, 1e-3);
  EXPECT_NEAR(e.thumbnail.hottest, 230, 1e-3);
  // Inside the mark it is brightest, and just outside it is the pipe.
  const Eigen::Vector2d middle = 0.5 * (e.leak.start + e.leak.end);
  const auto at = [&image](const Eigen::Vector2d& p) {
    return image.at<cv::Vec3b>(static_cast<int>(p.y()), static_cast<int>(p.x()));
  };
  EXPECT_EQ(at(middle), cv::Vec3b(225, 255, 255));
  const Eigen::Vector2d along = (e.leak.end - e.leak.start).normalized();
  EXPECT_EQ(at(e.leak.start + 6 * along), cv::Vec3b(225, 255, 255));
  EXPECT_NE(at(e.leak.start - 10 * along), cv::Vec3b(225, 255, 255));
}

TEST(MakeEvidence, KeepsTheProfile) {
  const test::ExamplePicture picture;
  const Evidence e =
      make_evidence(picture.view(), picture.detections, 0, picture.parameters.profile, 3, "x");
  EXPECT_GT(e.profile.size(), 150U);
  EXPECT_DOUBLE_EQ(e.metres_per_sample, 0.02);
  EXPECT_NEAR(e.leak_to - e.leak_from, 40, 3);
  EXPECT_DOUBLE_EQ(e.split_delta, 70);
  EXPECT_EQ(e.split_distance, 1);
  bool leaks = false;
  for (const ProfilePart& part : e.parts) {
    leaks = leaks || (part.kind == thermal::PartKind::kLeak && std::abs(part.mean - 230) < 5);
  }
  EXPECT_TRUE(leaks);
}

TEST(MakeEvidence, RefusesWhatDoesNotBelongTogether) {
  const test::ExamplePicture picture;
  const auto make = [&](const thermal::TemperatureView& view, std::size_t leak) {
    (void)make_evidence(view, picture.detections, leak, picture.parameters.profile, 3, "x");
  };
  EXPECT_THROW(make(picture.view(), 1), std::invalid_argument);
  EXPECT_THROW(make({picture.degrees.data(), 80, 60, 160}, 0), std::invalid_argument);
  EXPECT_THROW(make({nullptr, 160, 120, 160}, 0), std::invalid_argument);
}

TEST(MakeOverview, IsAsLargeAsWanted) {
  const test::ExamplePicture picture;
  const Overview small = make_overview(picture.view(), picture.detections, 40);
  EXPECT_EQ(small.thumbnail.width, 40);
  EXPECT_EQ(small.thumbnail.height, 30);
  ASSERT_EQ(small.leaks.size(), 1U);
  EXPECT_NEAR(0.5 * (small.leaks[0].start + small.leaks[0].end).x(), 30, 1);
  const Overview large = make_overview(picture.view(), picture.detections, 320);
  EXPECT_EQ(large.thumbnail.width, 320);
  EXPECT_EQ(decoded(large.thumbnail).rows, 240);
}

TEST(MakeOverview, WhatHasNoTemperatureIsGrey) {
  const std::vector<float> degrees(64 * 64, NAN);
  thermal::Detections none;
  none.width = none.height = 64;
  const Overview overview = make_overview({degrees.data(), 64, 64, 64}, none, 64);
  EXPECT_TRUE(std::isnan(overview.thumbnail.hottest));
  EXPECT_EQ(decoded(overview.thumbnail).at<cv::Vec3b>(3, 3), cv::Vec3b(90, 90, 90));
}

}  // namespace
}  // namespace pipescout
