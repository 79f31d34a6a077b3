// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>

#include "pipescout/estimation_study/car_recording.hpp"
#include "pipescout/estimation_study/husky_recording.hpp"
#include "pipescout/estimation_study/lawnmower_recording.hpp"

namespace pipescout::estimation_study {
namespace {

using ::testing::HasSubstr;

/// Skips the test, loudly, where there is no such file.
class Recordings : public ::testing::Test {
 protected:
  void SetUp() override {
    const char* shared = std::getenv("PIPESCOUT_SHARED_DATA");
    folder_ = shared != nullptr ? shared : "";
    if (!std::filesystem::is_directory(folder_ / "car_comma2k19")) {
      GTEST_SKIP() << "NOT TESTED on real recordings: PIPESCOUT_SHARED_DATA names no folder with "
                      "car_comma2k19 and lawnmower_plaza2";
    }
  }
  [[nodiscard]] std::string text(const char* file) const {
    std::ifstream stream(folder_ / file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }

  std::filesystem::path folder_;
};

TEST_F(Recordings, CarKeepsItsWayWithoutGps) {
  const std::string accelerometer = text("car_comma2k19/accelerometer.csv");
  const std::string gyro = text("car_comma2k19/gyro.csv");
  const std::string wheels = text("car_comma2k19/wheel_speed.csv");
  const std::string gnss = text("car_comma2k19/gnss_ublox_live.csv");
  const std::string reference = text("car_comma2k19/reference_pose_20hz.csv");
  const CarRecording car = read_car({.accelerometer = accelerometer,
                                     .gyro = gyro,
                                     .wheel_speed = wheels,
                                     .gnss = gnss,
                                     .reference = reference});
  const CarScore score = score_car(car);
  EXPECT_LT(score.started, 10);
  EXPECT_LT(score.position, 1.5);  // receiver and reference differ by more than 1 m on average
  EXPECT_LT(score.speed, 0.2);
  EXPECT_LT(score.course, 0.01);
  double ours = 0;
  double dead_reckoned = 0;
  for (double begin = 15; begin + 20 < 59; begin += 5) {
    const CarOutage outage = score_car_outage(car, car.events.front().arrival + begin, 20);
    EXPECT_GT(outage.way, 250);
    EXPECT_LT(outage.error, outage.dead_reckoned) << begin;
    ours += outage.error;
    dead_reckoned += outage.dead_reckoned;
  }
  EXPECT_LE(ours, 0.5 * dead_reckoned);
}

TEST_F(Recordings, LawnmowerKnowsTheBiasOfItsGyroFromStanding) {
  const LawnmowerScore score =
      score_lawnmower(text("lawnmower_plaza2/Plaza2_DR.txt"),
                      text("lawnmower_plaza2/Plaza2_GT.csv"), ReferenceHeading::kBackwards);
  EXPECT_NEAR(score.way, 1354, 1);
  EXPECT_LT(score.estimator.rms, 0.5 * score.summed.rms);
  EXPECT_LT(score.estimator.largest, 0.5 * score.summed.largest);
  // It knows the gyro's bias from the standstill, from which it differs on the way.
  EXPECT_LT(score.estimator.rms, 1.2 * score.less_standing.rms);
  EXPECT_LT(score.less_best.rms, 0.3 * score.less_standing.rms);
}

TEST_F(Recordings, ASlowGyroWithoutBiasIsBelieved) {
  if (!std::filesystem::is_directory(folder_ / "lawnmower_plaza1")) {
    GTEST_SKIP() << "NOT TESTED on Plaza1: there is no folder lawnmower_plaza1";
  }
  const LawnmowerScore score =
      score_lawnmower(text("lawnmower_plaza1/Plaza1_DR.txt"),
                      text("lawnmower_plaza1/Plaza1_GT.csv"), ReferenceHeading::kForwards);
  EXPECT_NEAR(score.way, 1861, 1);
  EXPECT_LT(score.estimator.rms, 5);  // 0.3 % of the way; 31 m when its turns were taken for spikes
  EXPECT_GT(score.covered_share, 0.9);
}

TEST_F(Recordings, HuskyIsNotLockedOutOfGpsWhoseErrorsLast) {
  if (!std::filesystem::is_directory(folder_ / "husky_outdoor")) {
    GTEST_SKIP() << "NOT TESTED on the Husky: there is no folder husky_outdoor";
  }
  const std::string imu = text("husky_outdoor/husky_imu.csv");
  const std::string odom = text("husky_outdoor/husky_odom.csv");
  const std::string fix = text("husky_outdoor/husky_fix.csv");
  const HuskyScore score = score_husky(read_husky({.imu = imu, .odom = odom, .fix = fix}));
  EXPECT_LT(score.started, 20);
  EXPECT_LT(score.rms, 3);  // the receiver wanders by as much
  EXPECT_LT(score.largest, 8);
  EXPECT_EQ(score.held_out, 0U);
}

std::string fault_of(const CarFiles& files) {
  try {
    (void)read_car(files);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

TEST(Recording, MalformedFilesAreNamed) {
  CarFiles files{
      .accelerometer = "t,x,y,z\n0,0,0,-9.8\n",
      .gyro = "t,x,y,z\n0,0,0,0\n",
      .wheel_speed = "t,a,b,c,d\n0,1,1,1,1\n",
      .gnss = "t,lat,lon,v,utc,alt,bearing\n0,37,-122,1,0,30,0\n",
      .reference =
          "t,week,tow,x,y,z,vx,vy,vz,qw,qx,qy,qz\n0,0,0,-2.7e6,-4.26e6,3.88e6,1,1,1,1,0,0,0\n"};
  EXPECT_EQ(fault_of(files), "");
  CarFiles broken = files;
  broken.gyro = "t,x,y,z\n0,0,0,0\n1,0,north,0\n";
  EXPECT_THAT(fault_of(broken), HasSubstr("gyro.csv:3: column 'y': 'north' is not a number"));
  broken = files;
  broken.wheel_speed = "t,a,b,c,d\n0,1,1,1\n";
  EXPECT_THAT(fault_of(broken), HasSubstr("wheel_speed.csv:2: 4 cells in a table of 5 columns"));
  broken = files;
  broken.reference = "";
  EXPECT_THAT(fault_of(broken), HasSubstr("reference_pose_20hz.csv: is empty"));
  EXPECT_THROW((void)score_lawnmower("1 2\n", "t,x,y,h\n", ReferenceHeading::kForwards),
               std::runtime_error);
}

}  // namespace
}  // namespace pipescout::estimation_study
