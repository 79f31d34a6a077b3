// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation_study/long_drive.hpp"

#include <gtest/gtest.h>

#include <cstdio>

namespace pipescout::estimation_study {
namespace {

TEST(LongDrive, HeadingAndTiltHoldOverTheCurvedEarth) {
  for (const double latitude : {-30.0, 0.0, 55.0}) {
    const LongDriveScore score = score_long_drive({.latitude = latitude});
    std::printf("latitude %.0f: heading %.4f mrad, tilt %.4f mrad\n", latitude, 1e3 * score.heading,
                1e3 * score.tilt);
    EXPECT_LT(score.heading, 0.2e-3);
    EXPECT_LT(score.tilt, 0.1e-3);
  }
  const LongDriveScore flat = score_long_drive({.earth = false});
  std::printf("on a flat Earth at rest: heading %.4f mrad, tilt %.4f mrad\n", 1e3 * flat.heading,
              1e3 * flat.tilt);
  EXPECT_GT(flat.tilt, 1e-3);
}

}  // namespace
}  // namespace pipescout::estimation_study
