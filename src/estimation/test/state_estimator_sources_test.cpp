// SPDX-License-Identifier: Apache-2.0
// Absolute sources that go, come back and lie.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <random>

#include "simulated_vehicle.hpp"

namespace pipescout::estimation {
namespace {

using Eigen::Vector3d;
using test::AnyMessage;
using test::SimulatedVehicle;
using test::VehicleOptions;

constexpr double kTrap = 700;  // m

struct Phases {
  double good_until = 0;    // s: GPS as it is
  double gone_until = 0;    // then none
  double wrong_until = 0;   // then off by kTrap, then right again
  bool moves_along = true;  // else the wrong fixes stay in one place
};

class StateEstimatorSourcesTest : public testing::Test {
 protected:
  static StateEstimatorParameters robot() {
    StateEstimatorParameters p = StateEstimatorParameters::ground_robot();
    p.smoother.imu_noise = test::vehicle_imu_noise();
    return p;
  }
  static StateEstimatorParameters aircraft() {
    StateEstimatorParameters p = StateEstimatorParameters::uav();
    p.smoother.imu_noise = test::vehicle_imu_noise();
    return p;
  }
  static double error(const StateEstimator& estimator, const SimulatedVehicle& vehicle) {
    const auto estimate = estimator.estimate();
    if (!estimate || !estimate->in_map) {
      return INFINITY;
    }
    return (estimate->state.position - vehicle.truth(estimate->time).position).norm();
  }
  static bool spoil(AnyMessage& message, const SimulatedVehicle& vehicle, const Phases& phases) {
    auto* const gps = std::get_if<GpsMeasurement>(&message);
    if (gps == nullptr || gps->time < phases.good_until) {
      return true;
    }
    if (gps->time < phases.gone_until) {
      return false;
    }
    if (gps->time < phases.wrong_until) {
      if (!phases.moves_along) {
        gps->position +=
            vehicle.truth(phases.gone_until).position - vehicle.truth(gps->time).position;
      }
      gps->position += Vector3d(0.6 * kTrap, -0.8 * kTrap, 0);
    }
    return true;
  }
  /// The largest error of estimates in [from, until).
  static double run(StateEstimator& estimator, const SimulatedVehicle& vehicle, double from,
                    double until, const Phases& phases) {
    double worst = 0;
    double next = 0;
    test::deliver(
        estimator, vehicle, from, until,
        [&](AnyMessage& message) { return spoil(message, vehicle, phases); },
        [&](const Estimate& estimate) {
          if (estimate.time >= next) {
            next = estimate.time + 0.1;
            worst = std::max(
                worst, (estimate.state.position - vehicle.truth(estimate.time).position).norm());
          }
        });
    return worst;
  }
  static std::size_t restarts(const StateEstimator& estimator, RestartReason reason) {
    return estimator.status().restarts[static_cast<std::size_t>(reason)];
  }
};

TEST_F(StateEstimatorSourcesTest, AfterAnOutageFixesThatAgreeAreTakenUpAgain) {
  VehicleOptions options;
  options.duration = 110;
  options.heading = 1;
  const SimulatedVehicle vehicle(1, options);
  StateEstimator estimator(robot());
  const Phases phases = {.good_until = 40, .gone_until = 100, .wrong_until = 100};
  run(estimator, vehicle, 0, 40, phases);
  run(estimator, vehicle, 40, 41, phases);
  EXPECT_EQ(estimator.status().of(Source::kGps).state, SourceState::kTrusted);
  const double worst = run(estimator, vehicle, 41, 100, phases);
  EXPECT_EQ(estimator.status().of(Source::kGps).state, SourceState::kTrusted);
  EXPECT_NEAR(estimator.status().since_absolute_position, 60, 0.5);
  EXPECT_LT(worst, 2);  // 180 m by odometer and gyro
  run(estimator, vehicle, 100, 100.5, phases);
  EXPECT_EQ(estimator.status().of(Source::kGps).state, SourceState::kCandidate);
  EXPECT_GT(estimator.status().of(Source::kGps).held, 0U);
  run(estimator, vehicle, 100.5, 110, phases);
  EXPECT_EQ(estimator.status().of(Source::kGps).state, SourceState::kTrusted);
  EXPECT_LT(error(estimator, vehicle), 1);
  EXPECT_EQ(restarts(estimator, RestartReason::kTakenOver), 0U);
}

TEST_F(StateEstimatorSourcesTest, WrongFixesAfterAnOutageDoNotCaptureForMinutes) {
  for (const bool moves_along : {true, false}) {
    VehicleOptions options;
    options.duration = 330;
    options.heading = -2;
    options.stop_from = moves_along ? 1e9 : 95;
    const SimulatedVehicle vehicle(2, options);
    StateEstimator estimator(robot());
    const Phases phases = {
        .good_until = 40, .gone_until = 100, .wrong_until = 310, .moves_along = moves_along};
    run(estimator, vehicle, 0, 100, phases);
    const std::size_t accepted = estimator.status().of(Source::kGps).accepted;
    EXPECT_LT(run(estimator, vehicle, 100, 310, phases), 8);
    EXPECT_EQ(estimator.status().of(Source::kGps).accepted, accepted);
    run(estimator, vehicle, 310, 330, phases);
    EXPECT_EQ(estimator.status().of(Source::kGps).state, SourceState::kTrusted);
    EXPECT_LT(error(estimator, vehicle), 1.5);
    EXPECT_EQ(restarts(estimator, RestartReason::kTakenOver), 0U);
  }
}

// Receivers that track three satellites tell a place and no height: NavSatFix has a huge variance
// there.
TEST_F(StateEstimatorSourcesTest, GpsWithoutHeightStartsAndIsWatchedInThePlane) {
  constexpr double kNone = 1e4;  // m
  VehicleOptions options;
  options.duration = 120;
  const SimulatedVehicle vehicle(3, options);
  StateEstimator estimator(robot());
  double worst = 0;
  test::deliver(
      estimator, vehicle, 0, 120,
      [&](AnyMessage& message) {
        if (auto* const gps = std::get_if<GpsMeasurement>(&message)) {
          gps->position.z() = 0;
          gps->covariance.row(2).setZero();
          gps->covariance.col(2).setZero();
          gps->covariance(2, 2) = kNone * kNone;
          gps->position.x() += gps->time > 60 && gps->time < 90 ? kTrap : 0;
        }
        return true;
      },
      [&](const Estimate& estimate) {
        if (estimate.in_map) {
          const Vector3d truth = vehicle.truth(estimate.time).position;
          worst = std::max(worst, (estimate.state.position - truth).head<2>().norm());
        }
      });
  ASSERT_EQ(estimator.status().phase, Phase::kRunning);
  EXPECT_LT(worst, 3);
  EXPECT_GT(std::sqrt(estimator.covariance()(2, 2)), 100);  // its height is not known
}

TEST_F(StateEstimatorSourcesTest, WrongFixesWithoutAnOutageAreDoubtedAndHeld) {
  VehicleOptions options;
  options.duration = 120;
  const SimulatedVehicle vehicle(3, options);
  StateEstimator estimator(robot());
  const Phases phases = {.good_until = 60, .gone_until = 60, .wrong_until = 100};
  run(estimator, vehicle, 0, 60, phases);
  EXPECT_LT(run(estimator, vehicle, 60, 100, phases), 2);
  const EstimatorStatus status = estimator.status();
  EXPECT_NE(status.of(Source::kGps).state, SourceState::kTrusted);
  EXPECT_GE(status.of(Source::kGps).gated, robot().gps.doubt_after);
  EXPECT_NEAR(status.of(Source::kGps).held_distance, kTrap, 5);
  EXPECT_NE(status.text.find("gps is held out, "), std::string::npos) << status.text;
  run(estimator, vehicle, 100, 120, phases);
  EXPECT_EQ(estimator.status().of(Source::kGps).state, SourceState::kTrusted);
  EXPECT_LT(error(estimator, vehicle), 1);
}

TEST_F(StateEstimatorSourcesTest, AFirstFixThatIsWrongIsNotBelieved) {
  VehicleOptions options;
  options.duration = 40;
  options.compass = true;
  const SimulatedVehicle vehicle(4, options);
  StateEstimator estimator(robot());
  int fixes = 0;
  double worst = 0;
  test::deliver(
      estimator, vehicle, 0, 40,
      [&](AnyMessage& message) {
        if (auto* const gps = std::get_if<GpsMeasurement>(&message); gps && gps->time > 1.1) {
          gps->position.x() += ++fixes < 3 ? kTrap : 0;
        }
        return true;
      },
      [&](const Estimate& estimate) {
        if (estimate.in_map) {
          const Vector3d truth = vehicle.truth(estimate.time).position;
          worst = std::max(worst, (estimate.state.position - truth).norm());
        }
      });
  EXPECT_LT(worst, 2);
  EXPECT_LT(error(estimator, vehicle), 1);
}

TEST_F(StateEstimatorSourcesTest, AStartFromWrongFixesIsMendedByThoseThatGoOnAgreeing) {
  VehicleOptions options;
  options.duration = 120;
  options.compass = true;
  const SimulatedVehicle vehicle(5, options);
  StateEstimator estimator(robot());
  const Phases phases = {.good_until = 0, .gone_until = 0, .wrong_until = 10};
  run(estimator, vehicle, 0, 10, phases);
  ASSERT_TRUE(estimator.estimate()->in_map);
  EXPECT_NEAR(error(estimator, vehicle), kTrap, 3);
  run(estimator, vehicle, 10, 120, phases);
  EXPECT_LT(error(estimator, vehicle), 1.5);
  EXPECT_EQ(restarts(estimator, RestartReason::kTakenOver), 1U);
}

TEST_F(StateEstimatorSourcesTest, AStartWithAWrongHeadingIsMended) {
  VehicleOptions options;
  options.duration = 130;
  const SimulatedVehicle vehicle(6, options);
  StateEstimator estimator(robot());
  const NavState begin = vehicle.truth(0);
  estimator.add(GivenPose{.time = 0,
                          .position = begin.position,
                          .position_deviation = 0.5,
                          .heading = begin.R_map_body.roll_pitch_yaw().z() + 2,
                          .heading_deviation = 0.05});
  run(estimator, vehicle, 0, 20, {.good_until = 1e9});
  EXPECT_GT(error(estimator, vehicle), 5);
  run(estimator, vehicle, 20, 130, {.good_until = 1e9});
  EXPECT_LT(error(estimator, vehicle), 2);
}

TEST_F(StateEstimatorSourcesTest, WithTheImuAloneFixesAreTakenWithinTheUncertainty) {
  VehicleOptions options;
  options.kind = VehicleOptions::Kind::kFly;
  options.odometer = false;
  options.duration = 400;
  const SimulatedVehicle vehicle(7, options);
  StateEstimator estimator(aircraft());
  const Phases phases = {.good_until = 60, .gone_until = 360, .wrong_until = 360};
  run(estimator, vehicle, 0, 360, phases);
  run(estimator, vehicle, 360, 400, phases);
  EXPECT_EQ(estimator.status().of(Source::kGps).state, SourceState::kTrusted);
  EXPECT_LT(error(estimator, vehicle), 3);
}

/// GPS, and poses over a rack where `both`, from `from` on that far from where they were.
AnyMessage shifted(AnyMessage message, double from, bool both, const Vector3d& by) {
  if (auto* const gps = std::get_if<GpsMeasurement>(&message); gps && gps->time >= from) {
    gps->position += by;
  }
  if (auto* const pose = std::get_if<VisualPoseMeasurement>(&message);
      pose && both && pose->time >= from) {
    pose->T_rack_body =
        geometry::SE3(pose->T_rack_body.rotation(), Vector3d(pose->T_rack_body.translation() + by));
  }
  return message;
}

TEST_F(StateEstimatorSourcesTest, TwoSourcesThatAgreeTakeOverOneThatAnotherContestsDoesNot) {
  constexpr double kFrom = 60;  // s, the state has been borne out for longer than is asked for
  const Vector3d by(90, 120, 0);
  VehicleOptions options;
  options.duration = 190;
  options.vision = true;
  const SimulatedVehicle vehicle(8, options);
  for (const bool both : {true, false}) {
    StateEstimator estimator(robot());
    const auto deliver_until = [&](double from, double until) {
      test::deliver(estimator, vehicle, from, until, [&](AnyMessage& message) {
        message = shifted(message, kFrom, both, by);
        return true;
      });
    };
    const auto off = [&] {
      const auto estimate = estimator.estimate();
      return Vector3d(estimate->state.position - vehicle.truth(estimate->time).position);
    };
    deliver_until(0, kFrom + robot().gps.takeover - 5);
    EXPECT_LT(off().norm(), 2);
    EXPECT_EQ(restarts(estimator, RestartReason::kTakenOver), 0U);
    deliver_until(kFrom + robot().gps.takeover - 5, options.duration);
    EXPECT_LT((off() - (both ? by : Vector3d::Zero())).norm(), 1);
    EXPECT_EQ(restarts(estimator, RestartReason::kTakenOver), both ? 1U : 0U);
    EXPECT_EQ(estimator.status().of(Source::kVisualPose).state, SourceState::kTrusted);
  }
}

/// What is left of poses over a rack when their errors last for seconds.
class CorrelatedPoses {
 public:
  static constexpr double kPosition = 0.01;  // m, per axis
  static constexpr double kAngle = 0.002;    // rad, per axis
  static constexpr double kTime = 1;         // s

  explicit CorrelatedPoses(std::uint64_t seed) : engine_(seed) {}
  void operator()(VisualPoseMeasurement& m, const SimulatedVehicle& vehicle) {
    const double keep = std::exp(-(m.time - time_) / kTime);
    time_ = m.time;
    for (double& entry : errors_) {
      entry = keep * entry + std::sqrt(1 - keep * keep) * normal_(engine_);
    }
    const NavState truth = vehicle.truth(m.time);
    m.T_rack_body = geometry::SE3(truth.R_map_body * geometry::SO3::exp(kAngle * errors_.tail<3>()),
                                  Vector3d(truth.position + kPosition * errors_.head<3>()));
  }

 private:
  std::mt19937_64 engine_;
  std::normal_distribution<double> normal_{};
  double time_ = -1e3;
  geometry::Vector6d errors_ = geometry::Vector6d::Zero();
};

TEST_F(StateEstimatorSourcesTest, ErrorsThatLastAreNotTakenForManyOfTheirOwn) {
  constexpr std::uint64_t kSeeds = 10;
  const auto mean_nees = [&](double correlation_time) {
    double sum = 0;
    int count = 0;
    for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
      VehicleOptions options;
      options.kind = VehicleOptions::Kind::kFly;
      options.duration = 60;
      options.odometer = false;
      options.gps = false;
      options.vision = true;
      const SimulatedVehicle vehicle(seed, options);
      StateEstimatorParameters parameters = aircraft();
      parameters.visual_pose.correlation_time = correlation_time;
      StateEstimator estimator(parameters);
      CorrelatedPoses poses(seed);
      double next = 10;
      test::deliver(
          estimator, vehicle, 0, options.duration,
          [&](AnyMessage& message) {
            if (auto* const pose = std::get_if<VisualPoseMeasurement>(&message)) {
              poses(*pose, vehicle);
            }
            return true;
          },
          [&](const Estimate& estimate) {
            if (estimate.time < next || !estimate.in_map) {
              return;
            }
            next += 1;
            using Vector9d = Eigen::Matrix<double, 9, 1>;
            const Vector9d error = vehicle.truth(estimate.time).local(estimate.state).head<9>();
            const Eigen::Matrix<double, 9, 9> covariance =
                estimator.covariance().topLeftCorner<9, 9>();
            sum += error.dot(covariance.ldlt().solve(error));
            ++count;
          });
    }
    return sum / count;
  };
  // Of nine degrees. The same poses, taken for white ones, are believed far too much.
  const double told = mean_nees(CorrelatedPoses::kTime);
  EXPECT_GT(told, 7);
  EXPECT_LT(told, 10);
  EXPECT_GT(mean_nees(0), 30);
}

/// Errors of RTK fixes by multipath: first-order Gauss-Markov.
class CorrelatedFixes {
 public:
  static constexpr double kTime = 40;          // s, correlation time
  static constexpr double kDeviation = 0.012;  // m, level; twice as much up

  explicit CorrelatedFixes(std::uint64_t seed) : engine_(seed) {}
  void operator()(GpsMeasurement& m, const SimulatedVehicle& vehicle) {
    const double keep = std::exp(-(m.time - time_) / kTime);
    time_ = m.time;
    for (double& entry : error_) {
      entry = keep * entry + std::sqrt(1 - keep * keep) * normal_(engine_);
    }
    const Vector3d deviation(kDeviation, kDeviation, 2 * kDeviation);
    m.position = vehicle.truth(m.time).position + deviation.cwiseProduct(error_);
    m.covariance = deviation.cwiseAbs2().asDiagonal();
  }

 private:
  std::mt19937_64 engine_;
  std::normal_distribution<double> normal_{};
  double time_ = -1e3;
  Vector3d error_ = Vector3d::Zero();
};

// What wheels and IMU tell of the height over minutes makes one mean of all heights since.
TEST_F(StateEstimatorSourcesTest,
       HeightsWhoseErrorsAreAlikeForHalfAMinuteAreBelievedForWhatTheyAre) {
  constexpr std::uint64_t kSeeds = 12;
  constexpr double kKept = 0.6;  // of the variance
  constexpr double kTime = 30;   // s
  double sum = 0;
  int count = 0;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    VehicleOptions options;
    options.duration = 120;
    options.gps_deviation = 1;
    const SimulatedVehicle vehicle(seed, options);
    StateEstimator estimator(StateEstimatorParameters::ground_robot());
    std::mt19937_64 engine(seed);
    std::normal_distribution<double> normal;
    double alike = normal(engine);
    double before = 0;
    double next = 40;
    test::deliver(
        estimator, vehicle, 0, options.duration,
        [&](AnyMessage& message) {
          if (auto* const gps = std::get_if<GpsMeasurement>(&message)) {
            const double keep = std::exp(-(gps->time - before) / kTime);
            before = gps->time;
            alike = keep * alike + std::sqrt(1 - keep * keep) * normal(engine);
            const double height = vehicle.truth(gps->time).position.z();
            gps->position.z() =
                height + std::sqrt(kKept) * alike + std::sqrt(1 - kKept) * normal(engine);
            gps->covariance(2, 2) = 1;
          }
          return true;
        },
        [&](const Estimate& estimate) {
          if (estimate.time < next || !estimate.in_map) {
            return;
          }
          next += 5;
          const double error =
              estimate.state.position.z() - vehicle.truth(estimate.time).position.z();
          sum += error * error / estimator.covariance()(kPosition + 2, kPosition + 2);
          ++count;
        });
  }
  EXPECT_GT(count, 150);
  EXPECT_LT(sum / count, 1.3);  // of one degree
}

// What is seen of a rack tells how the vehicle has moved, and makes the fixes before it, each of
// which counted while the motion was not known as well, one mean of errors that are alike.
TEST_F(StateEstimatorSourcesTest, FixesWhoseErrorsAreAlikeStayOneWhenARackTellsTheMotion) {
  constexpr std::uint64_t kSeeds = 20;
  constexpr double kSeen = 30;  // s, from then on
  double sum = 0;
  int count = 0;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    VehicleOptions options;
    options.kind = VehicleOptions::Kind::kFly;
    options.duration = 45;
    options.speed = 1.5;
    options.odometer = false;
    options.vision = true;
    const SimulatedVehicle vehicle(seed, options);
    StateEstimatorParameters parameters = aircraft();
    parameters.gps.correlation_time = CorrelatedFixes::kTime;
    parameters.gps.shortest_correlation_time = CorrelatedFixes::kTime;
    parameters.visual_pose.correlation_time = 0;
    parameters.smoother.global_deviations.gps_time_offset = 0;
    parameters.smoother.global_deviations.visual_pose_time_offset = 0;
    parameters.smoother.global_deviations.rack_position = 0.3;
    parameters.smoother.global_deviations.rack_rotation = 0.02;
    StateEstimator estimator(parameters);
    CorrelatedFixes fixes(seed);
    double next = kSeen + 5;
    test::deliver(
        estimator, vehicle, 0, options.duration,
        [&](AnyMessage& message) {
          if (auto* const gps = std::get_if<GpsMeasurement>(&message)) {
            fixes(*gps, vehicle);
          }
          const auto* const pose = std::get_if<VisualPoseMeasurement>(&message);
          return pose == nullptr || pose->time > kSeen;
        },
        [&](const Estimate& estimate) {
          if (estimate.time < next || !estimate.in_map) {
            return;
          }
          next += 1;
          const Vector3d error = estimate.state.position - vehicle.truth(estimate.time).position;
          const Eigen::Matrix3d covariance = estimator.covariance().topLeftCorner<3, 3>();
          sum += error.dot(covariance.ldlt().solve(error));
          ++count;
        });
    EXPECT_GT(estimator.status().of(Source::kVisualPose).accepted, 100U);
  }
  EXPECT_GT(count, 150);
  // Of three degrees. With as much of each fix as makes the state as sure as it: 3.9.
  EXPECT_GT(sum / count, 2);
  EXPECT_LT(sum / count, 3.3);
}

}  // namespace
}  // namespace pipescout::estimation
