// SPDX-License-Identifier: Apache-2.0
// `pipescout estimate` on real recordings, with the column mappings in recordings/.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "pipescout/files/testing/temporary_folder.hpp"
#include "pipescout/testing/program.hpp"

namespace pipescout::estimate {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class RealRecordings : public ::testing::Test {
 protected:
  void SetUp() override {
    const char* shared = std::getenv("PIPESCOUT_SHARED_DATA");
    data_ = shared != nullptr ? shared : "";
    if (!std::filesystem::is_directory(data_ / "husky_outdoor")) {
      GTEST_SKIP() << "NOT TESTED on real recordings: PIPESCOUT_SHARED_DATA names no folder with "
                      "husky_outdoor, car_comma2k19 and lawnmower_plaza1";
    }
  }
  [[nodiscard]] auto run(const std::string& recording, const std::string& more = {},
                         const std::vector<std::string>& options = {}) {
    const auto mapping = std::filesystem::path(ESTIMATE_RECORDINGS) / (recording + ".yaml");
    std::ofstream(folder_.path() / "mapping.yaml") << testing::content(mapping) << more;
    std::filesystem::remove_all(folder_.path() / "out");  // of the run before
    std::vector<std::string> arguments{(data_ / recording).string(), "--config", "mapping.yaml",
                                       "--out", "out"};
    arguments.insert(arguments.end(), options.begin(), options.end());
    return testing::run_program(ESTIMATE_COMMAND, arguments, folder_.path());
  }

  std::filesystem::path data_;
  testing::TemporaryFolder folder_;
};

TEST_F(RealRecordings, HuskyWithItsMountingUsesImuOdometerAndGps) {
  const auto result = run("husky_outdoor", "imu: {rotation: [90, 0, -90]}\n");
  ASSERT_EQ(result.code(), 0) << result.err;
  EXPECT_THAT(result.out, AllOf(HasSubstr("with the IMU."), Not(HasSubstr("No IMU is used"))));
}

TEST_F(RealRecordings, HuskyWithoutItsMountingIsFromWheelsAndGpsAndSaysWhy) {
  const auto result = run("husky_outdoor");
  ASSERT_EQ(result.code(), 0) << result.err;
  EXPECT_THAT(result.out, AllOf(HasSubstr("No IMU is used"),
                                HasSubstr("gravity is 89 degrees off the vertical")));
}

TEST_F(RealRecordings, MountingOfTheCarsTelephoneIsFoundFromItsMotion) {
  const auto proposed = run("car_comma2k19");
  EXPECT_EQ(proposed.code(), 1);
  EXPECT_THAT(proposed.err, HasSubstr("seems to be mounted with roll 180, pitch 0, yaw 0 degrees"));
  const auto applied = run("car_comma2k19", "", {"--apply-mounting"});
  EXPECT_EQ(applied.code(), 0) << applied.err;
}

TEST_F(RealRecordings, LawnmowerIsDeadReckoned) {
  const auto result = run("lawnmower_plaza1");
  ASSERT_EQ(result.code(), 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("No GPS: the trajectory begins at the origin"));
}

}  // namespace
}  // namespace pipescout::estimate
