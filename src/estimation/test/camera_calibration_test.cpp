// SPDX-License-Identifier: Apache-2.0
// Mounting and delay of the camera of visual poses as states of the estimator.
#include "pipescout/estimation/camera_calibration.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "heap_guard.hpp"
#include "simulated_vehicle.hpp"

namespace pipescout::estimation {
namespace {

using Eigen::Vector3d;
using geometry::SE3;
using geometry::SO3;
using test::AnyMessage;
using test::SimulatedVehicle;
using test::VehicleOptions;
using testing::HasSubstr;
using testing::Not;

constexpr double kPositionPrior = 0.03;                          // m
constexpr double kRotationPrior = 1.5 * std::numbers::pi / 180;  // rad
constexpr double kOffsetPrior = 0.04;                            // s

/// A camera that is not where it is said to be.
struct Camera {
  Vector3d told = Vector3d(0.2, 0, -0.1);  // m, in the body
  Vector3d off = Vector3d::Zero();         // m
  Vector3d turn = Vector3d::Zero();        // rad
  double late = 0;                         // s

  explicit Camera(std::uint64_t seed) {
    std::mt19937_64 engine(seed);
    std::normal_distribution<double> normal;
    for (int i = 0; i < 3; ++i) {
      off[i] = kPositionPrior * normal(engine);
      turn[i] = kRotationPrior * normal(engine);
    }
    late = kOffsetPrior * normal(engine);
  }

  /// A pose of the body as this camera shows it.
  void show(AnyMessage& message, const SimulatedVehicle& vehicle, int mounting) const {
    auto* const pose = std::get_if<VisualPoseMeasurement>(&message);
    if (pose == nullptr) {
      return;
    }
    constexpr double kStep = 1e-3;  // s
    const auto body = [&](double t) { return vehicle.truth(t).T_map_body(); };
    const SE3 noise = body(pose->time).inverse() * pose->T_rack_body;
    const double then = pose->time + late;
    pose->angular_rate =
        (body(then - kStep).rotation().inverse() * body(then + kStep).rotation()).log() /
        (2 * kStep);
    pose->camera = told;
    pose->mounting = mounting;
    const SE3 camera(SO3::exp(turn), told + off);
    pose->T_rack_body = body(then) * camera * SE3(SO3(), told).inverse() * noise;
  }
};

StateEstimatorParameters parameters_of(VehicleOptions::Kind kind) {
  StateEstimatorParameters p = kind == VehicleOptions::Kind::kFly
                                   ? StateEstimatorParameters::uav()
                                   : StateEstimatorParameters::ground_robot();
  p.smoother.imu_noise = test::vehicle_imu_noise();
  p.gps.correlation_time = p.visual_pose.correlation_time = 0;  // errors are independent
  p.smoother.global_deviations.gps_time_offset = 0;
  return p;
}

VehicleOptions options_of(VehicleOptions::Kind kind) {
  VehicleOptions options;
  options.kind = kind;
  options.duration = 120;
  options.vision = true;
  options.odometer = kind == VehicleOptions::Kind::kDrive;
  options.gps_deviation = 0.05;
  return options;
}

struct Calibrated {
  StateEstimator estimator;
  FixedLagSmootherParameters parameters;
  int mounting = -1;
  double rms = 0;  // m, of the second half
};

Calibrated calibrated(const SimulatedVehicle& vehicle, const Camera& camera, bool calibrates) {
  StateEstimatorParameters p = parameters_of(vehicle.options().kind);
  int mounting = -1;
  p.smoother.global_deviations.visual_pose_time_offset = 0;
  if (calibrates) {
    mounting = p.smoother.estimate_camera_mounting(kPositionPrior, kRotationPrior);
    p.smoother.global_deviations.visual_pose_time_offset = kOffsetPrior;
  }
  Calibrated result{.estimator = StateEstimator(p), .parameters = p.smoother, .mounting = mounting};
  double sum = 0;
  double count = 0;
  const double half = 0.5 * vehicle.options().duration;
  test::deliver(
      result.estimator, vehicle, 0, vehicle.options().duration,
      [&](AnyMessage& message) {
        camera.show(message, vehicle, mounting);
        return true;
      },
      [&](const Estimate& estimate) {
        if (estimate.time > half) {
          sum += (estimate.state.position - vehicle.truth(estimate.time).position).squaredNorm();
          ++count;
        }
      });
  result.rms = std::sqrt(sum / count);
  return result;
}

class CameraCalibrationTest : public testing::TestWithParam<std::uint64_t> {};

TEST_P(CameraCalibrationTest, IsFoundWithinItsDeviationsInMotion) {
  const std::uint64_t seed = GetParam();
  for (const auto kind : {VehicleOptions::Kind::kFly, VehicleOptions::Kind::kDrive}) {
    const SimulatedVehicle vehicle(seed, options_of(kind));
    const Camera camera(100 + seed);
    const Calibrated with = calibrated(vehicle, camera, true);
    const Calibrated without = calibrated(vehicle, camera, false);
    EXPECT_LT(with.rms, without.rms);
    const FixedLagSmoother& smoother = with.estimator.smoother();
    const GlobalVector deviations = smoother.global_covariance().diagonal().cwiseMax(0).cwiseSqrt();
    const auto own = smoother.globals().own.segment<kMountingSize>(with.mounting);
    for (int i = 0; i < 3; ++i) {
      const int place = kOwnStates + with.mounting + i;
      EXPECT_LT(std::abs(own[i] - camera.off[i]), 3.5 * deviations[place]) << "position " << i;
      EXPECT_LT(std::abs(own[3 + i] - camera.turn[i]), 3.5 * deviations[place + 3])
          << "rotation " << i;
    }
    const double offset = smoother.globals().visual_pose_time_offset;
    EXPECT_LT(std::abs(offset - camera.late), 3.5 * deviations[kVisualPoseTimeOffset]);
    // What this motion determines.
    EXPECT_LT(deviations[kVisualPoseTimeOffset], 0.2 * kOffsetPrior);
    EXPECT_LT(deviations[kOwnStates + with.mounting + 5], 0.5 * kRotationPrior);
    EXPECT_THAT(camera_calibration_text(smoother, with.parameters, with.mounting),
                HasSubstr("their stamps"));
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, CameraCalibrationTest, testing::Values(1, 2, 3, 4));

TEST(CameraCalibration, ARobotThatStandsLearnsNothingOfIt) {
  VehicleOptions options = options_of(VehicleOptions::Kind::kDrive);
  options.duration = 30;
  options.standing = 1000;
  options.gps = false;
  const SimulatedVehicle vehicle(5, options);
  const Calibrated stood = calibrated(vehicle, Camera(6), true);
  ASSERT_TRUE(stood.estimator.estimate()->in_map);
  const FixedLagSmoother& smoother = stood.estimator.smoother();
  const GlobalVector deviations = smoother.global_covariance().diagonal().cwiseMax(0).cwiseSqrt();
  const auto own = smoother.globals().own.segment<kMountingSize>(stood.mounting);
  for (int i = 0; i < 3; ++i) {
    EXPECT_GT(deviations[kOwnStates + stood.mounting + i], 0.9 * kPositionPrior) << i;
    EXPECT_LT(std::abs(own[i]), 0.2 * kPositionPrior) << i;
  }
  EXPECT_GT(deviations[kOwnStates + stood.mounting + 5], 0.9 * kRotationPrior);
  EXPECT_GT(deviations[kVisualPoseTimeOffset], 0.9 * kOffsetPrior);
  const std::string text = camera_calibration_text(smoother, stood.parameters, stood.mounting);
  EXPECT_THAT(text, HasSubstr("does not determine: x (+-"));
  EXPECT_THAT(text, HasSubstr("about z (+-"));
  EXPECT_THAT(text, HasSubstr("the delay (+-"));
  // The position is as uncertain as the camera.
  EXPECT_GT(std::sqrt(stood.estimator.covariance()(kPosition, kPosition)), 0.9 * kPositionPrior);
}

TEST(CameraCalibration, NothingIsAllocatedAndNothingIsSaidWhereItIsNotEstimated) {
  const SimulatedVehicle vehicle(7, options_of(VehicleOptions::Kind::kFly));
  const Camera camera(8);
  StateEstimatorParameters p = parameters_of(VehicleOptions::Kind::kFly);
  const int mounting = p.smoother.estimate_camera_mounting(kPositionPrior, kRotationPrior);
  StateEstimator estimator(p);
  EXPECT_EQ(camera_calibration_text(estimator.smoother(), p.smoother, mounting), "");
  std::vector<AnyMessage> shown;
  for (const test::Message& message : vehicle.messages()) {
    shown.push_back(message.content);
    camera.show(shown.back(), vehicle, mounting);
  }
  const pipescout::test::HeapGuard guard;
  for (const AnyMessage& message : shown) {
    test::deliver(estimator, message);
  }
  EXPECT_EQ(guard.allocations(), 0U);
  EXPECT_TRUE(estimator.estimate()->in_map);
  FixedLagSmootherParameters off = p.smoother;
  off.global_deviations = {};
  EXPECT_EQ(camera_calibration_text(estimator.smoother(), off, -1), "");
}

TEST(CameraCalibration, ItsStatesAreTheUsersAndMayBeInUse) {
  FixedLagSmootherParameters p;
  EXPECT_THROW(p.estimate_camera_mounting(-1, 0.1), std::invalid_argument);
  EXPECT_THROW(p.estimate_camera_mounting(0.1, NAN), std::invalid_argument);
  EXPECT_THROW(p.estimate_camera_mounting(0.1, 2), std::invalid_argument);
  p.global_deviations.own[1] = 1;  // two are left
  EXPECT_EQ(p.estimate_camera_mounting(0.1, 0), 2);
  EXPECT_NO_THROW(p.validate());
  EXPECT_THROW(p.estimate_camera_mounting(0.1, 0.1), std::invalid_argument);
}

}  // namespace
}  // namespace pipescout::estimation
