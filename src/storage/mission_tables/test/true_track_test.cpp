// SPDX-License-Identifier: Apache-2.0
#include "pipescout/mission_tables/true_track.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <functional>
#include <vector>

namespace pipescout {
namespace {

using geometry::SE3;
using geometry::SO3;

std::chrono::nanoseconds seconds_long(double seconds) {
  return std::chrono::nanoseconds(std::llround(seconds * 1e9));
}

Stamp at(double seconds) {
  return Stamp{} + seconds_long(seconds);
}

SE3 place(double x, double yaw = 0.0) {
  return {SO3::about_z(yaw), {x, 0.0, 0.0}};
}

TEST(TrueTrack, BetweenTwoPlaces) {
  TrueTrack track;
  EXPECT_FALSE(track.at(at(1.0)));
  EXPECT_TRUE(track.add(at(1.0), place(2.0, 3.1)));
  EXPECT_TRUE(track.add(at(1.1), place(3.0, -3.1)));
  ASSERT_TRUE(track.at(at(1.05)));
  EXPECT_NEAR(track.at(at(1.05))->translation().x(), 2.5, 1e-12);
  EXPECT_NEAR(
      (SO3::about_z(3.14159265358979).inverse() * track.at(at(1.05))->rotation()).log().norm(), 0.0,
      1e-9)
      << "the short way round";
  EXPECT_NEAR(track.at(at(1.1))->translation().x(), 3.0, 1e-12);
  EXPECT_FALSE(track.at(at(0.999)));
  EXPECT_FALSE(track.at(at(1.101)));
}

TEST(TrueTrack, DoesNotGuessAcrossAGap) {
  TrueTrack track;
  track.add(at(1.0), place(0.0));
  track.add(at(1.3), place(3.0));
  EXPECT_FALSE(track.at(at(1.1)));
  EXPECT_TRUE(track.at(at(1.3)));
}

TEST(TrueTrack, ForgetsATimeBeforeAndWhatIsLongAgo) {
  TrueTrack track;
  track.add(at(100.0), place(0.0));
  EXPECT_FALSE(track.add(at(1.0), place(0.0)));
  EXPECT_FALSE(track.at(at(100.0)));
  for (int k = 1; k <= 5000; ++k) {
    track.add(at(1.0 + 0.01 * k), place(k));
  }
  EXPECT_FALSE(track.at(at(1.0)));
  EXPECT_TRUE(track.at(at(51.0)));
}

struct Estimate {
  Stamp stamp{};
};

class Pairing : public ::testing::Test {
 protected:
  void estimate(double time) { pairing_.add_estimate({at(time)}, use_); }
  void truth(double time) { pairing_.add_truth(at(time), place(time), use_); }

  std::vector<double> used_;

 private:
  TruthPairing<Estimate> pairing_;
  std::function<void(const Estimate&, const SE3&)> use_ = [this](const Estimate& estimate,
                                                                 const SE3& truth) {
    EXPECT_NEAR(truth.translation().x(),
                std::chrono::duration<double>(estimate.stamp.time_since_epoch()).count(), 1e-9);
    used_.push_back(std::chrono::duration<double>(estimate.stamp.time_since_epoch()).count());
  };
};

TEST_F(Pairing, InWhateverOrderTheyCome) {
  truth(1.0);
  estimate(1.05);
  estimate(0.5);
  EXPECT_TRUE(used_.empty());
  truth(1.1);
  EXPECT_EQ(used_, std::vector{1.05}) << "that of 0.5 s has no truth";
  estimate(1.025);
  truth(1.2);
  EXPECT_EQ(used_, (std::vector{1.05, 1.025})) << "each once";
}

TEST_F(Pairing, EstimatesOfATimeBeforeAreForgotten) {
  truth(100.0);
  estimate(100.05);
  truth(1.0);
  truth(1.1);
  EXPECT_TRUE(used_.empty());
}

TEST_F(Pairing, OnlyTheLastOnesWait) {
  for (int k = 0; k < 3000; ++k) {
    estimate(1.0 + 0.05 * k);
  }
  for (int k = 0; k < 3000; ++k) {
    truth(1.0 + 0.05 * k);
  }
  EXPECT_EQ(used_.size(), 1024U);
}

}  // namespace
}  // namespace pipescout
