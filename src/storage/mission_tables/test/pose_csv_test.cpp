// SPDX-License-Identifier: Apache-2.0
#include "pipescout/mission_tables/pose_csv.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

namespace pipescout {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

auto columns(const std::string& line) {
  return std::count(line.begin(), line.end(), ',') + 1;
}

TEST(PoseCsv, Pose) {
  const geometry::SE3 pose(geometry::SO3::about_x(0.5), {1.0, 2.0, 3.0});
  const std::string line = pose_csv_line({}, pose).text();
  EXPECT_EQ(columns(line), columns(pose_csv_header()));
  EXPECT_THAT(line, StartsWith("0.000000000,1,2,3,0.247"));
}

TEST(PoseCsv, UncertainPose) {
  const geometry::SE3 pose(geometry::SO3(), {1.5, -2.0, 3.0});
  geometry::Matrix6d covariance = geometry::Matrix6d::Identity() * 0.25;
  covariance(0, 1) = covariance(1, 0) = 0.125;
  const std::string line =
      uncertain_pose_csv_line(Stamp{} + std::chrono::milliseconds(12500), pose, covariance).text();
  EXPECT_EQ(columns(line), columns(uncertain_pose_csv_header()));
  EXPECT_THAT(uncertain_pose_csv_header(),
              HasSubstr(",rotation_z_standard_deviation,x_y_correlation,"));
  EXPECT_THAT(line,
              StartsWith("12.500000000,1.5,-2,3,0,0,0,1,0,0,0,0.5,0.5,0.5,0.5,0.5,0.5,0.5,0,"));
}

}  // namespace
}  // namespace pipescout
