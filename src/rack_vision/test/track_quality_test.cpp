// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_vision/track_quality.hpp"

#include <gtest/gtest.h>

namespace pipescout::rack_vision {
namespace {

TrackEvidence good() {
  TrackEvidence evidence;
  evidence.edge_samples = 200;
  evidence.edge_samples_found = 160;
  evidence.edges = 10;
  evidence.points = 60;
  evidence.points_matched = 50;
  evidence.proven_points = 40;
  evidence.proven_matched = 35;
  return evidence;
}

TEST(TrackQuality, IsHighWhenEdgesAndPointsAgree) {
  EXPECT_GT(track_quality(good()), 0.9);
}

TEST(TrackQuality, IsNothingWithoutEvidence) {
  EXPECT_EQ(track_quality({}), 0);
  TrackEvidence evidence = good();
  evidence.edge_samples = 10;
  evidence.edge_samples_found = 10;
  evidence.proven_points = 0;
  EXPECT_EQ(track_quality(evidence), 0);
}

TEST(TrackQuality, FallsWithEachKindOfEvidence) {
  TrackEvidence points_fail = good();
  points_fail.proven_matched = 1;
  EXPECT_LT(track_quality(points_fail), 0.35);
  TrackEvidence edges_fail = good();
  edges_fail.edge_samples_found = 10;
  EXPECT_LT(track_quality(edges_fail), 0.5);
}

TEST(TrackQuality, BearsClutterOverMostEdgesWherePointsAreFound) {
  TrackEvidence cluttered = good();
  cluttered.edge_samples_found = 80;
  EXPECT_GT(track_quality(cluttered), 0.5);
}

TEST(TrackQuality, PlainPipesNeedEdgesOnly) {
  TrackEvidence plain = good();
  plain.points = 3;
  plain.points_matched = 0;
  EXPECT_GT(track_quality(plain), 0.9);
}

}  // namespace
}  // namespace pipescout::rack_vision
