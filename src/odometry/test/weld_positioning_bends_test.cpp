// SPDX-License-Identifier: Apache-2.0
// Bends as landmarks between welds.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "fingerprint.hpp"
#include "pipescout/odometry/weld_positioning.hpp"

namespace pipescout::odometry {
namespace {

using test::at_joint;
using test::fingerprint;

constexpr double kQuarter = std::numbers::pi / 2;

/// A crawler without noise, and welds and bends where they are.
class Drive {
 public:
  explicit Drive(WeldPositioning& positioning) : positioning_(positioning) {}

  void go(double metres, double slip = 0) {
    const int steps = static_cast<int>(std::ceil(metres / 0.25));
    for (int i = 0; i < steps; ++i) {
      positioning_.add_increment({(metres + slip) / steps, 1e-6});
    }
  }
  void weld(double behind = 0) {
    positioning_.add_weld({positioning_.odometer_distance() - behind, 0.01});
  }
  const WeldPositionEstimate& bend(double behind, double angle) {
    return positioning_.add_bend({.odometer_distance = positioning_.odometer_distance() - behind,
                                  .standard_deviation = 0.05,
                                  .angle = angle,
                                  .angle_standard_deviation = 0.02});
  }

 private:
  WeldPositioning& positioning_;
};

TEST(WeldPositioningBends, ABendShowsASlipBeforeTheNextWeldDoes) {
  const auto tally = fingerprint(10);
  const std::vector<TallyBend> bends{
      {.joint = 2, .distance = 6, .standard_deviation = 0.05, .angle = kQuarter}};
  WeldPositioning positioning({}, tally, at_joint(0, 0.0), bends);
  Drive drive(positioning);
  for (int joint = 0; joint < 2; ++joint) {
    drive.go(tally[static_cast<std::size_t>(joint)].length);
    drive.weld();
  }
  drive.go(8, 0.8);
  EXPECT_NEAR(positioning.estimate().distance_into_joint, 8.8, 0.02);
  const auto& estimate = drive.bend(2, kQuarter);
  EXPECT_EQ(estimate.joint, 2U);
  // Some doubt is left: it may be a bend that the tally does not have.
  EXPECT_NEAR(estimate.distance_into_joint, 8, 0.1);
  EXPECT_TRUE(estimate.double_slip_detected);
  EXPECT_NEAR(estimate.spacing_error, 0.8, 0.02);
  EXPECT_LT(std::abs(estimate.distance_into_joint - 8), std::sqrt(estimate.covariance(0, 0)));
}

TEST(WeldPositioningBends, ABendTellsJointsOfOneLengthApart) {
  const std::vector<TallyJoint> tally(30, {12.0, 0.01});
  const std::vector<TallyBend> bends{{.joint = 7, .distance = 3, .angle = 0.6},
                                     {.joint = 21, .distance = 3, .angle = kQuarter}};
  for (const bool with_bends : {false, true}) {
    WeldPositioning positioning({.lock_probability = 0.999}, tally,
                                {.orientation = Orientation::kForward},
                                with_bends ? bends : std::vector<TallyBend>{});
    Drive drive(positioning);
    for (int joint = 0; joint < 3; ++joint) {
      drive.weld();
      drive.go(12);
    }
    drive.weld();
    EXPECT_FALSE(positioning.estimate().locked);
    drive.go(8);
    drive.bend(5, kQuarter);
    drive.go(4);
    drive.weld();
    EXPECT_EQ(positioning.estimate().locked, with_bends);
    if (with_bends) {
      EXPECT_EQ(positioning.estimate().joint, 22U);
    } else {
      EXPECT_EQ(positioning.counts().unexplained_bends, 1U);
    }
  }
}

TEST(WeldPositioningBends, ABendIsTakenThoughItIsFoundBehindAWeld) {
  const std::vector<TallyJoint> tally(10, {12.0, 0.0});
  const std::vector<TallyBend> bends{
      {.joint = 0, .distance = 10, .standard_deviation = 0.02, .angle = kQuarter}};
  WeldPositioning positioning({.initial_scale_standard_deviation = 1e-5, .scale_drift = 0}, tally,
                              at_joint(0, 0.0), bends);
  Drive drive(positioning);
  drive.go(12);
  drive.weld();
  drive.go(3);
  const WeldPositionEstimate before = positioning.estimate();
  const WeldPositionEstimate after = drive.bend(5.05, kQuarter);
  // 5 cm further on than the welds say; the welds are better known.
  EXPECT_LT(std::abs(after.chainage - before.chainage), 0.01);
  EXPECT_GT(after.chainage, before.chainage);
  EXPECT_LT(after.covariance(0, 0), before.covariance(0, 0));
  EXPECT_EQ(positioning.counts().unexplained_bends, 0U);
}

TEST(WeldPositioningBends, WhatIsNearNoBendOfTheTallyMovesNothing) {
  const auto tally = fingerprint(10);
  const std::vector<TallyBend> bends{{.joint = 5, .distance = 6, .angle = kQuarter}};
  WeldPositioning positioning({}, tally, at_joint(0, 0.0), bends);
  Drive drive(positioning);
  drive.go(8);
  const WeldPositionEstimate before = positioning.estimate();
  const WeldPositionEstimate after = drive.bend(2, kQuarter);
  EXPECT_EQ(after.status, PositioningStatus::kAccepted);
  EXPECT_EQ(after.chainage, before.chainage);
  EXPECT_EQ(after.covariance(0, 0), before.covariance(0, 0));
  EXPECT_EQ(positioning.counts().unexplained_bends, 1U);
}

/// Of a fault of the odometer in a bend nothing shows before the next weld: near it the joint is
/// not certain, whether the tally has the bend or the wheels have found one.
TEST(WeldPositioningBends, NearTheWeldBehindABendTheJointIsNotCertain) {
  const auto tally = fingerprint(10);
  const std::vector<TallyBend> bends{
      {.joint = 2, .distance = 6, .standard_deviation = 0.05, .angle = kQuarter}};
  for (const bool of_the_tally : {true, false}) {
    for (const double probability : {0.02, 0.0}) {
      WeldPositioning positioning({.bend_fault_probability = probability}, tally, at_joint(0, 0.0),
                                  of_the_tally ? bends : std::vector<TallyBend>{});
      Drive drive(positioning);
      constexpr double kLag = 0.3;  // m, behind a weld, in which it is detected
      for (std::size_t joint = 0; joint < 4; ++joint) {
        SCOPED_TRACE(joint);
        drive.go(joint == 0 ? 8 : 8 - kLag);
        if (joint == 2 && !of_the_tally) {
          drive.bend(2, kQuarter);
        }
        EXPECT_EQ(positioning.estimate().locked, joint > 0);
        EXPECT_GT(positioning.estimate().joint_probability, 0.998);
        drive.go(tally[joint].length - 8.2);
        const bool doubtful = joint == 2 && probability > 0;
        EXPECT_EQ(positioning.estimate().joint, joint);
        EXPECT_EQ(positioning.estimate().locked, joint > 0 && !doubtful);
        if (doubtful) {
          EXPECT_NEAR(positioning.estimate().joint_probability, 0.995, 0.001);
        }
        drive.go(0.2);
        EXPECT_NEAR(positioning.estimate().joint_probability, 0.5, 0.1);
        drive.go(kLag);
        drive.weld(kLag);
        EXPECT_TRUE(positioning.estimate().locked);
        EXPECT_EQ(positioning.estimate().joint, joint + 1);
      }
    }
  }
}

TEST(WeldPositioningBends, RefusesWhatCannotBe) {
  const auto tally = fingerprint(3);
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  const auto made_with = [&](const TallyBend& bend, const std::vector<TallyJoint>& joints) {
    return WeldPositioning({}, joints, at_joint(0, 0.0), std::vector<TallyBend>{bend});
  };
  const TallyBend good{.joint = 1, .distance = 2, .angle = 1};
  EXPECT_NO_THROW(made_with(good, tally));
  EXPECT_THROW(made_with(good, {}), std::invalid_argument);
  for (const auto& spoil : std::vector<void (*)(TallyBend&)>{
           [](TallyBend& bend) { bend.joint = 3; }, [](TallyBend& bend) { bend.distance = kNaN; },
           [](TallyBend& bend) { bend.standard_deviation = 0; },
           [](TallyBend& bend) { bend.angle = 4; },
           [](TallyBend& bend) { bend.angle_standard_deviation = -1; }}) {
    TallyBend bad = good;
    spoil(bad);
    EXPECT_THROW(made_with(bad, tally), std::invalid_argument);
  }
  WeldPositioning positioning = made_with(good, tally);
  Drive drive(positioning);
  drive.go(5);
  EXPECT_EQ(drive.bend(1, kNaN).status, PositioningStatus::kBadValue);
  EXPECT_EQ(drive.bend(1, 0).status, PositioningStatus::kBadValue);
  EXPECT_EQ(drive.bend(-5, 1).status, PositioningStatus::kOutOfOrder);
  EXPECT_EQ(drive.bend(500, 1).status, PositioningStatus::kOutOfOrder);
  EXPECT_EQ(positioning.counts().bad_bends, 2U);
  EXPECT_EQ(positioning.counts().out_of_order_bends, 2U);
}

}  // namespace
}  // namespace pipescout::odometry
