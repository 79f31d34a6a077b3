// SPDX-License-Identifier: Apache-2.0
// Accuracy on the simulated sensor stream `fusion_stream`, whose SOURCE.txt has the figures of
// GTSAM on the same numbers. The folder of the data sets comes from the environment variable
// PIPESCOUT_SHARED_DATA; without it these tests say that they are skipped.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <numbers>

#include "fusion_stream.hpp"

namespace pipescout::estimation {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

class FusionStreamTest : public testing::Test {
 protected:
  void SetUp() override {
    // NOLINTNEXTLINE(concurrency-mt-unsafe): there is no other thread.
    const char* const shared = std::getenv("PIPESCOUT_SHARED_DATA");
    if (shared != nullptr) {
      stream_ =
          test::read_fusion_stream(std::filesystem::path(shared) / "fusion_stream" / "stream.csv");
    }
    if (stream_.truth.empty()) {
      GTEST_SKIP() << "no fusion_stream below PIPESCOUT_SHARED_DATA: ACCURACY ON THE STREAM THAT "
                      "GTSAM WAS MEASURED ON NOT TESTED";
    }
  }

  test::StreamScore run(const char* name, const test::StreamSensors& use) {
    FixedLagSmoother smoother(test::fusion_stream_parameters());
    auto score = test::run_fusion_stream(stream_, use, smoother);
    auto& ms = score.update_ms;
    std::sort(ms.begin(), ms.end());
    std::printf(
        "%s: %.4f m, %.3f deg, %.4f m/s, NEES %.1f of 15; an update %.4f ms, 99 %% %.4f ms, "
        "at most %.4f ms\n",
        name, score.position, score.rotation / kDegree, score.velocity, score.nees,
        ms[ms.size() / 2], ms[ms.size() * 99 / 100], ms.back());
    return score;
  }

  test::FusionStream stream_;
};

TEST_F(FusionStreamTest, AllSensors) {
  const auto score = run("all sensors", {});
  EXPECT_LE(score.position, 0.0142);
  EXPECT_LE(score.rotation, 0.096 * kDegree);
}

TEST_F(FusionStreamTest, WithoutVision) {
  EXPECT_LE(run("no vision", {.vision = false}).position, 0.0328);
}

TEST_F(FusionStreamTest, ImuAndVision) {
  EXPECT_LE(run("IMU and vision", {.gps = false, .odometry = false}).position, 0.0335);
}

}  // namespace
}  // namespace pipescout::estimation
