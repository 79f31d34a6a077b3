// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation/track_witness.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace pipescout::estimation {
namespace {

using Eigen::Vector3d;

constexpr double kGate = 16;
constexpr double kShare = 0.01;
constexpr double kFloor = 0.5;  // m

/// 2 m/s along x of odom, which is turned by `yaw` from the map; `off` m across it in the map.
TrackPair pair(double time, double yaw, double off = 0) {
  TrackPair pair;
  pair.time = time;
  pair.reckoned = Vector3d(2 * time, 0, 0);
  pair.measured = 2 * time * Vector3d(std::cos(yaw), std::sin(yaw), 0) + Vector3d(0, off, 0);
  pair.deviation = 0.3;
  pair.way = 2 * time;
  return pair;
}

TEST(TrackWitnessTest, NothingBearsOutBeforeAnythingWasBelieved) {
  EXPECT_FALSE(TrackWitness().bears_out(pair(1, 0), 0, kGate, kShare, kFloor).has_value());
  EXPECT_EQ(TrackWitness().parts_by(10), 0);
}

TEST(TrackWitnessTest, WhatGoesOnIsBorneOutWhereverTheMapIsTurned) {
  for (const double yaw : {0.0, 1.0, -2.5}) {
    TrackWitness witness;
    for (double time = 0; time < 100; time += 0.5) {
      witness.learn(pair(time, yaw), yaw);
    }
    EXPECT_EQ(witness.bears_out(pair(100, yaw), yaw, kGate, kShare, kFloor), true);
    EXPECT_EQ(witness.bears_out(pair(100, yaw, 10), yaw, kGate, kShare, kFloor), false);
    EXPECT_EQ(witness.bears_out(pair(100, yaw), yaw + 0.3, kGate, kShare, kFloor), false);
  }
}

TEST(TrackWitnessTest, LearnsByHowMuchBothPart) {
  TrackWitness witness;
  for (int i = 0; i < 4000; ++i) {
    witness.learn(pair(0.5 * i, 0, i % 2 == 0 ? 2 : -2), 0);
  }
  // Half of the pairs part by 4 m along y, the others do not.
  EXPECT_NEAR(witness.parts_by(8), 2, 0.2);
  EXPECT_EQ(witness.bears_out(pair(2000, 0, 8), 0, kGate, kShare, kFloor), true);
  witness.forget();
  EXPECT_EQ(witness.parts_by(8), 0);
}

TEST(TrackWitnessTest, ADriftIsContradictedOverLongSpans) {
  TrackWitness witness;
  double time = 0;
  for (; time < 300; time += 0.5) {
    witness.learn(pair(time, 0), 0);
  }
  double off = 0;
  while (off < 50 && witness.bears_out(pair(time, 0, off), 0, kGate, kShare, kFloor).value()) {
    witness.learn(pair(time, 0, off), 0);
    time += 0.5;
    off += 0.25;  // half a metre per second
  }
  EXPECT_LT(off, 20);
}

TEST(TrackWitnessTest, OneJumpIsNotWhatIsUsual) {
  TrackWitness witness;
  for (int i = 0; i < 200; ++i) {
    witness.learn(pair(0.5 * i, 0, i % 2 == 0 ? 0.1 : -0.1), 0);
  }
  const double before = witness.parts_by(4);
  witness.learn(pair(100, 0, 700), 0);
  EXPECT_LT(witness.parts_by(4), 2 * before);
}

TEST(TrackWitnessTest, PairsThatAreNotNewerAreIgnored) {
  TrackWitness witness;
  witness.learn(pair(10, 0), 0);
  witness.learn(pair(5, 0, 100), 0);
  EXPECT_EQ(witness.bears_out(pair(11, 0), 0, kGate, kShare, kFloor), true);
}

}  // namespace
}  // namespace pipescout::estimation
