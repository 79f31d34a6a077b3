// SPDX-License-Identifier: Apache-2.0
#include "pipescout/patrol_simulation/patrol_drive.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "pipescout/manipulation/arm_controller.hpp"

namespace pipescout {
namespace {

PatrolDriveParameters parameters_of(std::uint64_t seed) {
  PatrolDriveParameters parameters;
  parameters.patrol.scene.length = 20;
  parameters.patrol.end = 30;
  parameters.patrol.seed = seed;
  parameters.imu.period = 0.004;
  parameters.gps.period = 0.2;
  parameters.standing = 2;
  parameters.seed = seed;
  return parameters;
}

TEST(PatrolDrive, SensorsSayWhatTheyShouldWhenTheyShould) {
  PatrolDrive drive(parameters_of(1));
  drive.drive_until(1.5);
  const auto still = drive.take_imu_samples();
  ASSERT_EQ(still.size(), 376U);
  for (std::size_t i = 0; i < still.size(); ++i) {
    EXPECT_NEAR(still[i].time, 0.004 * static_cast<double>(i), 1e-9);
  }
  // It stands on rough ground: gravity, and no turning.
  EXPECT_NEAR(still.back().reading.specific_force.norm(), 9.8, 0.3);
  EXPECT_LT(still.back().reading.angular_rate.norm(), 0.05);
  const auto wheels = drive.take_odometer_samples();
  ASSERT_EQ(wheels.size(), 76U);
  EXPECT_NEAR(wheels.back().distances[0], 0, 0.01);

  drive.drive_until(8);
  const auto fixes = drive.take_fixes();
  // 40 until then, those on their way not counted.
  EXPECT_GE(fixes.size(), 38U);
  EXPECT_LE(fixes.size(), 41U);
  for (std::size_t i = 1; i < fixes.size(); ++i) {
    EXPECT_LE(fixes[i - 1].arrival, fixes[i].arrival);
    EXPECT_LE(fixes[i].arrival, 8);
  }
  const auto driven = drive.take_odometer_samples();
  EXPECT_NEAR(driven.back().distances[2], drive.patrol().robot().distance(), 0.6);
  EXPECT_GT(drive.patrol().robot().speed(), 5);
  EXPECT_TRUE(drive.take_imu_samples().size() > 1600);
  EXPECT_TRUE(drive.take_imu_samples().empty());
}

TEST(PatrolDrive, IsTheSameForTheSameSeedHoweverItIsAsked) {
  PatrolDrive at_once(parameters_of(3));
  PatrolDrive in_pieces(parameters_of(3));
  PatrolDrive other(parameters_of(4));
  at_once.drive_until(4);
  std::size_t samples = 0;
  simulation::ImuReading last;
  for (double time = 0; time <= 4; time += 0.037) {
    in_pieces.drive_until(time);
    for (const auto& sample : in_pieces.take_imu_samples()) {
      ++samples;
      last = sample.reading;
    }
  }
  in_pieces.drive_until(4);
  for (const auto& sample : in_pieces.take_imu_samples()) {
    ++samples;
    last = sample.reading;
  }
  other.drive_until(4);
  const auto all = at_once.take_imu_samples();
  EXPECT_EQ(all.size(), samples);
  EXPECT_EQ(all.back().reading.angular_rate, last.angular_rate);
  EXPECT_NE(other.take_imu_samples().back().reading.angular_rate, last.angular_rate);
  EXPECT_EQ(at_once.motion().T_map_body.matrix(), in_pieces.motion().T_map_body.matrix());
}

TEST(PatrolDrive, ArrivesPastTheTube) {
  PatrolDrive drive(parameters_of(2));
  double time = 0;
  while (!drive.arrived() && time < 60) {
    time += 0.1;
    drive.drive_until(time);
  }
  EXPECT_TRUE(drive.arrived());
  EXPECT_GT(drive.patrol().place(), 25);
}

TEST(PatrolDrive, RefusesWhatIsOutOfRange) {
  PatrolDriveParameters parameters = parameters_of(1);
  parameters.standing = -1;
  EXPECT_THROW(PatrolDrive{parameters}, std::invalid_argument);
  parameters = parameters_of(1);
  parameters.odometer_period = std::nan("");
  EXPECT_THROW(PatrolDrive{parameters}, std::invalid_argument);
  parameters = parameters_of(1);
  parameters.gps.period = 0;
  EXPECT_THROW(PatrolDrive{parameters}, std::invalid_argument);
}

PatrolDriveParameters with_arm(std::uint64_t seed) {
  PatrolDriveParameters parameters = parameters_of(seed);
  parameters.arm = PatrolArmParameters{.urdf = std::string(manipulation::camera_arm_urdf()),
                                       .base_link = "base_link",
                                       .camera_link = "camera_optical_frame",
                                       .start = manipulation::ArmControllerParameters{}.ready};
  return parameters;
}

TEST(PatrolDrive, TheCameraRidesOnTheArm) {
  PatrolDrive drive(with_arm(1));
  drive.drive_until(1);
  const auto camera_at = [&drive](const std::vector<double>& joints) {
    const manipulation::JointVector q = Eigen::Map<const Eigen::VectorXd>(joints.data(), 6);
    return (drive.motion().T_map_body * drive.arm()->T_base_camera(q)).matrix();
  };
  const auto seen_from = [&drive] { return drive.patrol().view(0).T_map_camera.matrix(); };
  std::vector<double> joints = drive.arm_dynamics()->positions();
  EXPECT_TRUE(seen_from().isApprox(camera_at(joints), 1e-9));

  joints[0] += 0.2;
  drive.command_arm(joints, std::vector<double>(6, 0.0), 0.5);
  drive.drive_until(1.08);
  const auto moving = drive.patrol().view(0);
  EXPECT_GT(moving.velocity.tail<3>().norm(), 0.1) << "the picture is blurred by it";
  drive.drive_until(2);
  EXPECT_TRUE(seen_from().isApprox(camera_at(joints), 1e-3));
}

TEST(PatrolDrive, WithoutAnArmCommandsMeanNothing) {
  PatrolDrive drive(parameters_of(1));
  drive.command_arm(std::vector<double>(6, 0.0), std::vector<double>(6, 0.0), 0.5);
  EXPECT_EQ(drive.arm(), nullptr);
  EXPECT_EQ(drive.arm_dynamics(), nullptr);
}

TEST(PatrolDrive, TellsWhereTheTubeIsSeen) {
  PatrolDrive drive(parameters_of(1));
  drive.drive_until(1);
  EXPECT_FALSE(drive.tube_in_view()) << "before the row";
  drive.drive_until(7);
  const auto view = drive.tube_in_view();
  ASSERT_TRUE(view) << drive.patrol().place();
  simulation::ThermalTruth truth;
  drive.patrol().renderer().truth(drive.patrol().view(0), truth);
  ASSERT_TRUE(truth.tube);
  EXPECT_NEAR(view->from.y(), truth.tube->from.y(), 0.5);
  EXPECT_NEAR(view->to.y(), truth.tube->to.y(), 0.5);
}

}  // namespace
}  // namespace pipescout
