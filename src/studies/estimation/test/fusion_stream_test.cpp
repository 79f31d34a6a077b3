// SPDX-License-Identifier: Apache-2.0
// Accuracy on the simulated sensor stream `fusion_stream`, whose SOURCE.txt has the figures of
// GTSAM on the same numbers. The folder of the data sets comes from the environment variable
// PIPESCOUT_SHARED_DATA; without it these tests say that they are skipped.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <numbers>
#include <stdexcept>
#include <string>

#include "pipescout/estimation_study/fusion_stream.hpp"

namespace pipescout::estimation_study {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

class FusionStreamTest : public testing::Test {
 protected:
  void SetUp() override {
    // NOLINTNEXTLINE(concurrency-mt-unsafe): there is no other thread.
    const char* const shared = std::getenv("PIPESCOUT_SHARED_DATA");
    if (shared != nullptr) {
      std::ifstream file(std::filesystem::path(shared) / "fusion_stream" / "stream.csv");
      stream_ = parse_fusion_stream(std::string{std::istreambuf_iterator<char>(file), {}});
    }
    if (stream_.truth.empty()) {
      GTEST_SKIP() << "no fusion_stream below PIPESCOUT_SHARED_DATA: ACCURACY ON THE STREAM THAT "
                      "GTSAM WAS MEASURED ON NOT TESTED";
    }
  }

  [[nodiscard]] StreamScore run(const StreamSensors& use) const {
    estimation::FixedLagSmoother smoother(fusion_stream_parameters());
    return run_fusion_stream(stream_, use, smoother);
  }

  FusionStream stream_;
};

TEST_F(FusionStreamTest, AllSensors) {
  const auto score = run({});
  EXPECT_LE(score.position, 0.0142);
  EXPECT_LE(score.rotation, 0.096 * kDegree);
}

TEST_F(FusionStreamTest, WithoutVision) {
  EXPECT_LE(run({.vision = false}).position, 0.0328);
}

TEST_F(FusionStreamTest, ImuAndVision) {
  EXPECT_LE(run({.gps = false, .odometry = false}).position, 0.0335);
}

std::string fault_of(const std::string& text) {
  try {
    (void)parse_fusion_stream(text);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

TEST(FusionStream, MalformedRowsAreNamed) {
  EXPECT_EQ(fault_of("# text\n\ngps,0,1,2,3,0.2\n"), "");
  EXPECT_NE(fault_of("# text\nsonar,1,2\n").find("stream.csv:2"), std::string::npos);
  EXPECT_NE(fault_of("gps,0,1,2,3\n").find("line 1"), std::string::npos);
  EXPECT_NE(fault_of("gps,0,1,2,x,0.2\n").find("'x' is not a number"), std::string::npos);
  EXPECT_NE(fault_of("gps\n").find("is empty"), std::string::npos);
}

}  // namespace
}  // namespace pipescout::estimation_study
