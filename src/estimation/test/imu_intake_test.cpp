// SPDX-License-Identifier: Apache-2.0
#include "imu_intake.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace pipescout::estimation {
namespace {

using Eigen::Vector3d;

constexpr double kPeriod = 0.01;

ImuReading reading(int i, const Vector3d& off = Vector3d::Zero()) {
  const double t = kPeriod * i;
  return {t, Vector3d(std::sin(t), 0, 9.81) + off, Vector3d(0, 0.1 * std::cos(t), 0.2)};
}

/// Time that the samples cover, and the integral of the force over it.
struct Sum {
  double duration = 0;
  Vector3d velocity = Vector3d::Zero();
  void add(const ImuIntake::Taken& taken) {
    for (std::size_t i = 0; i < taken.count; ++i) {
      duration += taken.samples[i].duration;
      velocity += taken.samples[i].duration * taken.samples[i].specific_force;
    }
  }
};

TEST(ImuIntake, JoinsReadingsToMeans) {
  ImuIntake intake({});
  EXPECT_EQ(intake.add(reading(0)).count, 0U);
  const ImuIntake::Taken taken = intake.add(reading(1));
  ASSERT_EQ(taken.count, 1U);
  EXPECT_EQ(taken.samples[0].time, 0);
  EXPECT_DOUBLE_EQ(taken.samples[0].duration, kPeriod);
  EXPECT_LT((taken.samples[0].specific_force -
             0.5 * (reading(0).specific_force + reading(1).specific_force))
                .norm(),
            1e-12);
  EXPECT_EQ(intake.add(reading(1)).outcome, Outcome::kDuplicate);
  EXPECT_EQ(intake.add(reading(0)).outcome, Outcome::kLate);
  EXPECT_EQ(intake.add(reading(21)).count, 0U);  // a gap
  EXPECT_EQ(intake.add(reading(22)).count, 1U);
}

TEST(ImuIntake, TurnsAndScalesIntoTheBody) {
  StateEstimatorParameters parameters;
  parameters.R_body_imu = geometry::SO3::about_x(1.5707963267948966);
  parameters.specific_force_scale = 9.80665;
  ImuIntake intake(parameters);
  intake.add({0, Vector3d(0, 1, 0), Vector3d(0, 0.2, 0)});
  const ImuIntake::Taken taken = intake.add({kPeriod, Vector3d(0, 1, 0), Vector3d(0, 0.2, 0)});
  EXPECT_LT((taken.samples[0].specific_force - Vector3d(0, 0, 9.80665)).norm(), 1e-9);
  EXPECT_LT((taken.samples[0].angular_rate - Vector3d(0, 0, 0.2)).norm(), 1e-9);
}

TEST(ImuIntake, SpikesAreBridged) {
  std::mt19937_64 engine(1);
  std::uniform_real_distribution<double> uniform(-1, 1);
  ImuIntake intake({});
  Sum sum;
  int spikes = 0;
  for (int i = 0; i <= 1000; ++i) {
    const bool spike = i > 10 && i < 990 && std::abs(uniform(engine)) < 0.1;
    spikes += spike ? 1 : 0;
    const Vector3d off(uniform(engine), uniform(engine), uniform(engine));
    sum.add(intake.add(reading(i, spike ? Vector3d(50 * off) : Vector3d(0.01 * off))));
  }
  EXPECT_GT(spikes, 70);
  EXPECT_NEAR(sum.duration, 10, 1e-9);
  EXPECT_LT((sum.velocity - Vector3d(1 - std::cos(10), 0, 98.1)).norm(), 0.05);
}

TEST(ImuIntake, ASlowGyroThatTurnsInIsNoSpike) {
  // 5 Hz: a mower that stood turns by half a radian per second, from one reading to the next.
  StateEstimatorParameters parameters;
  parameters.largest_imu_gap = 0.5;
  constexpr double kSlow = 0.2;
  ImuIntake intake(parameters);
  double duration = 0;
  for (int i = 0; i < 100; ++i) {
    const double rate = i % 20 < 10 ? 1e-4 * (i % 3) : 0.5;
    const auto taken = intake.add({kSlow * i, Vector3d(0, 0, 9.81), Vector3d(0, 0, rate)});
    EXPECT_NE(taken.outcome, Outcome::kGated) << i;
    for (std::size_t k = 0; k < taken.count; ++k) {
      duration += taken.samples[k].duration;
    }
  }
  EXPECT_NEAR(duration, 99 * kSlow, 1e-9);
}

TEST(ImuIntake, DeadReadingsAreRefused) {
  ImuIntake intake(StateEstimatorParameters{});
  const auto add = [&](double time, const Eigen::Vector3d& force, const Eigen::Vector3d& rate) {
    return intake.add({.time = time, .specific_force = force, .angular_rate = rate}).outcome;
  };
  const Eigen::Vector3d gravity(0, 0, 9.81);
  double time = 0;
  for (; time < 0.2; time += 0.01) {
    EXPECT_EQ(add(time, gravity, {0.01, 0.02, time}), Outcome::kWaiting);
  }
  EXPECT_EQ(add(time, Eigen::Vector3d::Zero(), {0.01, 0.02, 0.2}), Outcome::kDead);
  std::size_t dead = 0;
  for (int i = 0; i < 50; ++i) {
    time += 0.01;
    dead += add(time, gravity, {0.01, 0.02, 0.3}) == Outcome::kDead ? 1 : 0;
  }
  EXPECT_NEAR(static_cast<double>(dead), 25, 2);
  EXPECT_EQ(add(time + 0.01, gravity, {0.01, 0.02, 0.31}), Outcome::kWaiting);
}

TEST(ImuIntake, AGyroOfOneAxisThatStandsIsNotDead) {
  ImuIntake intake(StateEstimatorParameters{});
  for (double time = 0; time < 2; time += 0.01) {
    EXPECT_EQ(intake
                  .add({.time = time,
                        .specific_force = Eigen::Vector3d(0, 0, 9.81),
                        .angular_rate = Eigen::Vector3d(0, 0, 0.1)})
                  .outcome,
              Outcome::kWaiting);
  }
}

TEST(ImuIntake, WrongFirstReadingsAreNotJoined) {
  for (int wrong = 1; wrong <= 3; ++wrong) {
    ImuIntake intake({});
    Sum sum;
    for (int i = 0; i <= 100; ++i) {
      sum.add(intake.add(reading(i, i < wrong ? Vector3d(20 + 10 * i, 0, 0) : Vector3d::Zero())));
    }
    const double begin = kPeriod * wrong;
    EXPECT_NEAR(sum.duration, 1 - begin, 1e-9);
    EXPECT_LT(
        (sum.velocity - Vector3d(std::cos(begin) - std::cos(1), 0, 9.81 * (1 - begin))).norm(),
        1e-3);
  }
}

TEST(ImuIntake, AStepThatLastsIsTakenOneReadingLate) {
  ImuIntake intake({});
  Sum sum;
  for (int i = 0; i <= 200; ++i) {
    sum.add(intake.add(reading(i, i < 100 ? Vector3d::Zero() : Vector3d(12, 0, 0))));
  }
  EXPECT_NEAR(sum.duration, 2, 1e-9);
  EXPECT_NEAR(sum.velocity.x(), 1 - std::cos(2) + 12 * 1.005, 0.01);
}

TEST(ImuIntake, ViolentMotionIsNotShutOut) {
  std::mt19937_64 engine(2);
  std::normal_distribution<double> normal;
  ImuIntake intake({});
  Sum quiet;
  Sum violent;
  for (int i = 0; i < 3000; ++i) {
    const double size = i < 1000 ? 0.01 : 3;
    const Vector3d off = size * Vector3d(normal(engine), normal(engine), normal(engine));
    (i < 1500 ? quiet : violent).add(intake.add(reading(i, off)));
  }
  EXPECT_GT(violent.duration, 0.9 * 15);
}

TEST(ImuIntake, AClockThatJumpsIsFollowedAStampIsNot) {
  ImuIntake intake({});
  for (int i = 0; i < 100; ++i) {
    intake.add(reading(i));
  }
  EXPECT_EQ(intake.add(reading(100000)).outcome, Outcome::kFuture);
  EXPECT_EQ(intake.add(reading(-100000)).outcome, Outcome::kLate);
  EXPECT_EQ(intake.add(reading(100)).count, 1U);
  for (int i = 0; i < 4; ++i) {
    EXPECT_FALSE(intake.add(reading(100000 + i)).jumped);
  }
  EXPECT_TRUE(intake.add(reading(100004)).jumped);
  EXPECT_EQ(intake.add(reading(100005)).count, 1U);
}

}  // namespace
}  // namespace pipescout::estimation
