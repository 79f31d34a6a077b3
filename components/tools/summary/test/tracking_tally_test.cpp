// SPDX-License-Identifier: Apache-2.0
#include "tables/tracking_tally.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "pipescout/runtime/conversions.hpp"

namespace pipescout::summary {
namespace {

using pipescout_msgs::msg::ArmState;
using pipescout_msgs::msg::PipeTrack;

PipeTrack truth(double seconds, double v, bool whole = true) {
  PipeTrack message;
  message.header.stamp = to_message(Time{} + from_seconds(seconds));
  message.state = PipeTrack::STATE_LOCKED;
  message.track = 1;
  message.width = 320;
  message.height = 240;
  message.estimate.u = 159.5;
  message.estimate.v = v;
  message.estimate.length = 320;
  message.whole_width = whole;
  return message;
}

PipeTrack track(double seconds, double v, double angle) {
  PipeTrack message = truth(seconds, v);
  message.estimate.angle = angle;
  message.best_particle = message.estimate;
  message.best_particle.length = 317;
  return message;
}

TEST(TrackingTally, ErrorsAreThoseOfPicturesOfTheSameTime) {
  TrackingTally tally;
  tally.add_truth(truth(1, 100));
  tally.add_truth(truth(2, 110));
  tally.add(track(1, 103, std::numbers::pi));
  tally.add(track(2, 109, 0.01));
  tally.add(track(2.5, 0, 0));
  auto figures = tally.section("p_").figures;
  EXPECT_DOUBLE_EQ(figures.at("p_track_estimate_position_px"), 2);
  EXPECT_NEAR(figures.at("p_track_estimate_angle_deg"), 0.005 * 180 / std::numbers::pi, 1e-9)
      << "an axis has no head and tail";
  EXPECT_DOUBLE_EQ(figures.at("p_track_best_particle_length_px"), 3);
}

TEST(TrackingTally, InViewIsWhatIsWholeOfPicturesBesideThePipe) {
  TrackingTally tally;
  tally.add_truth(truth(1, 119.5));
  tally.add_truth(truth(2, 2.5, false));
  PipeTrack away = truth(3, 0, false);
  away.state = PipeTrack::STATE_LOST;
  tally.add_truth(away);
  tally.add_truth(truth(4, 119.5));
  PipeTrack before = away;
  before.track = 0;
  tally.add_truth(before);
  const auto figures = tally.section("").figures;
  EXPECT_DOUBLE_EQ(figures.at("track_in_view_percent"), 50);
  EXPECT_NEAR(figures.at("track_image_error_rms_px"), 117 / std::sqrt(3.0), 1e-9);
}

TEST(TrackingTally, CountsLossesAndWhatTheArmDid) {
  TrackingTally tally;
  for (const auto state :
       {PipeTrack::STATE_DETECTING, PipeTrack::STATE_LOCKED, PipeTrack::STATE_COASTING,
        PipeTrack::STATE_LOST, PipeTrack::STATE_LOST, PipeTrack::STATE_LOCKED}) {
    PipeTrack message = track(1, 0, 0);
    message.state = state;
    tally.add(message);
  }
  ArmState arm;
  arm.state = ArmState::STATE_TRACKING;
  tally.add(arm);
  arm.state = ArmState::STATE_FAULT;
  arm.limited = {"elbow_joint velocity"};
  tally.add(arm);
  const auto figures = tally.section("").figures;
  EXPECT_EQ(figures.at("track_lost"), 1);
  EXPECT_EQ(figures.at("tracks"), 1);
  EXPECT_NEAR(figures.at("track_locked_percent"), 100.0 / 3, 1e-3);
  EXPECT_EQ(figures.at("arm_tracking_percent"), 50);
  EXPECT_EQ(figures.at("arm_fault_cycles"), 1);
  EXPECT_EQ(figures.at("arm_limited_percent"), 50);
  EXPECT_EQ(figures.count("track_in_view_percent"), 0U);
}

}  // namespace
}  // namespace pipescout::summary
