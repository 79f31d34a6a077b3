// SPDX-License-Identifier: Apache-2.0
#include "pipescout/odometry/weld_positioning.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "fingerprint.hpp"

namespace pipescout::odometry {
namespace {

using test::at_joint;
using test::fingerprint;
using testing::DoubleNear;

double weld_place(const std::vector<TallyJoint>& pipe, std::ptrdiff_t weld) {
  return std::accumulate(pipe.begin(), pipe.begin() + weld, 0.0,
                         [](double sum, const TallyJoint& joint) { return sum + joint.length; });
}

/// Drives a crawler along a pipe without noise; welds are sighted where they are.
class Drive {
 public:
  Drive(std::vector<TallyJoint> pipe, WeldPositioning& positioning, double place,
        double scale = 1.0, double facing = 1.0)
      : positioning_(positioning), place_(place), scale_(scale), facing_(facing) {
    welds_.push_back(0.0);
    for (const auto& joint : pipe) {
      welds_.push_back(welds_.back() + joint.length);
    }
  }

  /// To a true place, seeing all welds but those at `unseen`.
  void to(double place, const std::vector<double>& unseen = {}) {
    while (std::abs(place - place_) > 1e-9) {
      const double step = std::clamp(place - place_, -0.25, 0.25);
      const double before = place_;
      place_ += step;
      positioning_.add_increment({facing_ * step / scale_, 1e-6});
      note();
      for (std::size_t i = 0; i < welds_.size(); ++i) {
        const double weld = welds_[i];
        const bool passed = (before < weld) != (place_ < weld);
        const bool seen = std::none_of(unseen.begin(), unseen.end(), [weld](double hidden) {
          return std::abs(hidden - weld) < 0.1;
        });
        if (passed && seen) {
          sight(weld);
        }
      }
    }
  }

  void sight(double place) {
    positioning_.add_weld(
        {positioning_.odometer_distance() - facing_ * (place_ - place) / scale_, 0.01});
    note();
  }

  /// The odometer says more than was gone.
  void slip(double metres) {
    positioning_.add_increment({facing_ * metres, 1e-6});
    note();
  }

  [[nodiscard]] double weld(std::size_t i) const { return welds_[i]; }
  [[nodiscard]] double place() const { return place_; }
  [[nodiscard]] int slips() const { return slips_; }
  [[nodiscard]] int tally_errors() const { return tally_errors_; }
  [[nodiscard]] double last_error() const { return last_error_; }

 private:
  void note() {
    const auto& estimate = positioning_.estimate();
    slips_ += estimate.double_slip_detected ? 1 : 0;
    tally_errors_ += estimate.tally_error_detected ? 1 : 0;
    if (estimate.spacing_error != 0.0) {
      last_error_ = estimate.spacing_error;
    }
  }

  WeldPositioning& positioning_;
  std::vector<double> welds_;
  double place_;
  double scale_;
  double facing_;
  int slips_ = 0;
  int tally_errors_ = 0;
  double last_error_ = 0.0;
};

void expect_place(const WeldPositioning& positioning, const Drive& drive, double tolerance = 0.02) {
  const auto& estimate = positioning.estimate();
  EXPECT_TRUE(estimate.locked);
  EXPECT_THAT(estimate.chainage, DoubleNear(drive.place(), tolerance));
  EXPECT_THAT(drive.weld(estimate.joint) + estimate.distance_into_joint,
              DoubleNear(drive.place(), tolerance));
  EXPECT_LE(std::abs(estimate.chainage - drive.place()),
            3.0 * std::sqrt(estimate.covariance(0, 0)));
}

TEST(WeldPositioning, AnswersFromAKnownStartBeforeAnyWeld) {
  const auto tally = fingerprint(10);
  WeldPositioning positioning({.initial_scale_standard_deviation = 0.01}, tally, at_joint(3, 2.0));
  positioning.add_increment({1.5, 0.0004});
  const auto& estimate = positioning.estimate();
  EXPECT_TRUE(estimate.known);
  EXPECT_EQ(estimate.joint, 3U);
  EXPECT_DOUBLE_EQ(estimate.distance_into_joint, 3.5);
  // Start, scale over 1.5 m, odometer.
  EXPECT_NEAR(estimate.covariance(0, 0), 0.0025 + 0.01 * 0.01 * 1.5 * 1.5 + 0.0004, 1e-7);
  EXPECT_NEAR(estimate.covariance(0, 1), 1.5 * 0.01 * 0.01, 1e-7);
  EXPECT_NEAR(estimate.covariance(1, 1), 0.0001, 1e-7);
  EXPECT_EQ(estimate.covariance(1, 0), estimate.covariance(0, 1));
}

TEST(WeldPositioning, OneWeldIsTheKalmanUpdate) {
  const std::vector<TallyJoint> tally(3, {12.0, 0.02});
  WeldPositioning positioning(
      {.initial_scale_standard_deviation = 0.01, .scale_drift = 0.0, .noise_adaptation = 0.0},
      tally, at_joint(0, 2.0));
  positioning.add_increment({10.1, 0.01});
  positioning.add_weld({10.1, 0.03});
  // Prior of the distance from weld 1: 0.1 m.
  const double p00 = 0.0025 + 10.1 * 10.1 * 1e-4 + 0.01 + 0.0004;
  const double p01 = 10.1 * 1e-4;
  const double total = p00 + 0.0009;
  const auto& estimate = positioning.estimate();
  EXPECT_EQ(estimate.joint, 1U);
  EXPECT_NEAR(estimate.distance_into_joint, 0.1 * 0.0009 / total, 2e-4);
  EXPECT_NEAR(estimate.scale, 1.0 - 0.1 * p01 / total, 1e-4);
  EXPECT_NEAR(estimate.covariance(0, 0), p00 * 0.0009 / total, 1e-4);
  EXPECT_NEAR(estimate.covariance(1, 1), 1e-4 - p01 * p01 / total, 2e-6);
}

TEST(WeldPositioning, KeepsItsPlaceForwardAndBackward) {
  const auto tally = fingerprint(60);
  for (const double facing : {1.0, -1.0}) {
    const auto orientation = facing > 0.0 ? Orientation::kForward : Orientation::kBackward;
    WeldPositioning positioning({}, tally, at_joint(30, 1.0, orientation));
    Drive drive(tally, positioning, weld_place(tally, 30) + 1.0, 1.013, facing);
    drive.to(drive.weld(45) + 5.0);
    expect_place(positioning, drive);
    drive.to(drive.weld(10) + 3.0);
    expect_place(positioning, drive, 0.05);
    EXPECT_EQ(positioning.estimate().orientation, orientation);
    EXPECT_NEAR(positioning.estimate().scale, 1.013, 0.002);
    EXPECT_EQ(drive.slips() + drive.tally_errors(), 0);
  }
}

TEST(WeldPositioning, FindsJointAndOrientationFromNothing) {
  const auto tally = fingerprint(300);
  for (const double facing : {1.0, -1.0}) {
    WeldPositioning positioning({}, tally, {.orientation = Orientation::kUnknown});
    EXPECT_FALSE(positioning.estimate().known);
    EXPECT_EQ(positioning.estimate().probability, 0.0);
    Drive drive(tally, positioning, weld_place(tally, 150) + 4.0, 0.985, facing);
    const double end = drive.weld(facing > 0.0 ? 162 : 139) + 2.0;
    drive.to(end);
    expect_place(positioning, drive, 0.05);
    EXPECT_EQ(positioning.estimate().orientation,
              facing > 0.0 ? Orientation::kForward : Orientation::kBackward);
  }
}

TEST(WeldPositioning, EqualJointsNeverLock) {
  const std::vector<TallyJoint> tally(50, {12.0, 0.01});
  WeldPositioning positioning({}, tally, {});
  Drive drive(tally, positioning, 5.0);
  drive.to(20.0 * 12.0);
  EXPECT_FALSE(positioning.estimate().locked);
  EXPECT_LT(positioning.estimate().probability, 0.2);
}

TEST(WeldPositioning, MissedWeldsDoNotDisturb) {
  const auto tally = fingerprint(40);
  WeldPositioning positioning({}, tally, at_joint(0, 1.0));
  Drive drive(tally, positioning, 1.0);
  drive.to(drive.weld(20) + 1.0, {drive.weld(12), drive.weld(15), drive.weld(16)});
  expect_place(positioning, drive, 0.05);
  EXPECT_EQ(positioning.estimate().joint, 20U);
  EXPECT_EQ(drive.slips() + drive.tally_errors(), 0);
}

TEST(WeldPositioning, TheJointAdvancesPastAWeldThatWasNotSeen) {
  const auto tally = fingerprint(40);
  WeldPositioning positioning({}, tally, at_joint(0, 1.0));
  Drive drive(tally, positioning, 1.0);
  drive.to(drive.weld(10) + 3.0);
  const double before = positioning.estimate().covariance(0, 0);
  drive.to(drive.weld(11) + 3.0, {drive.weld(11)});
  EXPECT_EQ(positioning.estimate().joint, 11U);
  EXPECT_NEAR(positioning.estimate().distance_into_joint, 3.0, 0.05);
  EXPECT_GT(positioning.estimate().covariance(0, 0), before + 0.01 * 0.01);  // the tally's share
}

TEST(WeldPositioning, SpuriousWeldsDoNotDisturb) {
  const auto tally = fingerprint(40);
  WeldPositioning positioning({}, tally, at_joint(0, 1.0));
  Drive drive(tally, positioning, 1.0);
  for (const double into : {0.3, 4.0, 6.0, 10.0}) {
    const std::size_t joint = positioning.estimate().joint + 3;
    drive.to(drive.weld(joint) + into);
    drive.sight(drive.place());
    EXPECT_NEAR(positioning.estimate().chainage, drive.place(), 0.05) << into << " m";
    drive.to(drive.weld(joint + 2) + 1.0);
    expect_place(positioning, drive, 0.05);
  }
  EXPECT_EQ(drive.slips() + drive.tally_errors(), 0);
}

TEST(WeldPositioning, AWeldReportedTwiceIsOneWeld) {
  const auto tally = fingerprint(40);
  WeldPositioning positioning({}, tally, at_joint(0, 1.0));
  Drive drive(tally, positioning, 1.0);
  drive.to(drive.weld(12) + 0.05);
  drive.sight(drive.weld(12));
  drive.to(drive.weld(16) + 2.0);
  expect_place(positioning, drive, 0.05);
  EXPECT_EQ(drive.slips() + drive.tally_errors(), 0);
}

TEST(WeldPositioning, ADoubleSlipIsAnnouncedAndNeverHidden) {
  for (const double error : {0.6, -0.6, 2.0, -2.0}) {
    const auto tally = fingerprint(60);
    WeldPositioning positioning({}, tally, at_joint(0, 1.0));
    Drive drive(tally, positioning, 1.0);
    drive.to(drive.weld(20) + 6.0);
    drive.slip(error);
    drive.to(drive.weld(21) + 0.5);
    const auto& estimate = positioning.estimate();
    EXPECT_LE(std::abs(estimate.chainage - drive.place()),
              1.96 * std::sqrt(estimate.covariance(0, 0)))
        << "right after the weld, " << error << " m";
    drive.to(drive.weld(24) + 0.5);
    expect_place(positioning, drive, 0.05);
    EXPECT_EQ(drive.slips(), 1) << error;
    EXPECT_EQ(drive.tally_errors(), 0);
    EXPECT_NEAR(drive.last_error(), error, 0.1);
    EXPECT_EQ(positioning.counts().double_slips, 1U);
    EXPECT_FALSE(estimate.double_slip_detected);  // news once only
    EXPECT_EQ(estimate.spacing_error, 0.0);
  }
}

TEST(WeldPositioning, FindsBackAfterAJointThatTheTallyLacksOrAdds) {
  const auto pipe = fingerprint(80);
  for (const int kind : {0, 1}) {
    auto tally = pipe;
    if (kind == 0) {
      tally.erase(tally.begin() + 30);
    } else {
      tally.insert(tally.begin() + 30, {11.7, 0.01});
    }
    WeldPositioning positioning({}, tally, at_joint(0, 1.0));
    Drive drive(pipe, positioning, 1.0);
    drive.to(drive.weld(29) + 1.0);
    expect_place(positioning, drive, 0.05);
    drive.to(drive.weld(45) + 1.0);
    EXPECT_TRUE(positioning.estimate().locked);
    EXPECT_EQ(positioning.estimate().joint, kind == 0 ? 44U : 46U);
    EXPECT_NEAR(positioning.estimate().distance_into_joint, 1.0, 0.05);
    EXPECT_EQ(drive.tally_errors(), 1);
    EXPECT_EQ(drive.slips(), 0);
  }
}

TEST(WeldPositioning, LosesTheLockWhereThePipeIsAnother) {
  const auto tally = fingerprint(200);
  WeldPositioning positioning({}, tally, at_joint(0, 1.0));
  Drive drive(tally, positioning, 1.0);
  drive.to(drive.weld(12) + 1.0);
  EXPECT_TRUE(positioning.estimate().locked);
  // Carried to another place without the odometer turning.
  Drive elsewhere(tally, positioning, drive.weld(120) + 5.0);
  elsewhere.to(elsewhere.weld(124) + 1.0);
  EXPECT_FALSE(positioning.estimate().locked);
  EXPECT_GE(positioning.counts().locks_lost, 1U);
  elsewhere.to(elsewhere.weld(145) + 1.0);
  expect_place(positioning, elsewhere, 0.05);
}

TEST(WeldPositioning, LosesTheLockWithoutWelds) {
  const auto tally = fingerprint(400);
  WeldPositioning positioning({}, tally, at_joint(0, 1.0));
  Drive drive(tally, positioning, 1.0);
  drive.to(drive.weld(12) + 1.0);
  EXPECT_TRUE(positioning.estimate().locked);
  for (int i = 0; i < 3000; ++i) {
    positioning.add_increment({1.0, 0.001});
  }
  EXPECT_FALSE(positioning.estimate().locked);
  EXPECT_GT(std::sqrt(positioning.estimate().covariance(0, 0)), 1.0);
}

TEST(WeldPositioning, LearnsTheTally) {
  const auto pipe = fingerprint(30);
  WeldPositioningParameters parameters;
  parameters.standard_joint = {.length = 12.0, .standard_deviation = 0.6};
  parameters.initial_scale_standard_deviation = 1e-3;
  parameters.first_weld_chainage = 500.0;
  parameters.largest_joint_count = 100;
  WeldPositioning positioning(parameters, {}, at_joint(0, 0.5));
  Drive drive(pipe, positioning, 0.5);
  drive.to(drive.weld(20) + 1.0);
  const auto learnt = positioning.learnt_joints();
  ASSERT_EQ(learnt.size(), 100U);
  for (std::size_t j = 2; j < 20; ++j) {
    EXPECT_GE(learnt[j].observations, 1U) << j;
    EXPECT_NEAR(learnt[j].length, pipe[j].length, 0.02) << j;
    EXPECT_LT(learnt[j].standard_deviation, 0.05) << j;
  }
  EXPECT_EQ(learnt[25].observations, 0U);
  EXPECT_EQ(learnt[25].length, 12.0);
  EXPECT_EQ(learnt[25].standard_deviation, 0.6);
  const double measured = std::accumulate(learnt.begin(), learnt.begin() + 20, 0.0,
                                          [](double sum, const auto& j) { return sum + j.length; });
  EXPECT_NEAR(positioning.estimate().chainage, 500.0 + measured + 1.0, 0.05);
}

TEST(WeldPositioning, EndsOfThePipeAreNoTrap) {
  const auto tally = fingerprint(12);
  WeldPositioning positioning({}, tally, at_joint(10, 1.0));
  for (int i = 0; i < 200; ++i) {
    positioning.add_increment({1.0, 1e-4});
    positioning.add_weld({positioning.odometer_distance(), 0.01});
    EXPECT_LT(positioning.estimate().joint, 12U);
  }
  EXPECT_FALSE(positioning.estimate().locked);
}

}  // namespace
}  // namespace pipescout::odometry
