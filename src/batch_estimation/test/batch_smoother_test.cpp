// SPDX-License-Identifier: Apache-2.0
#include "pipescout/batch_estimation/batch_smoother.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <stdexcept>
#include <string>
#include <variant>
#include <vector>

#include "pipescout/estimation_study/fusion_stream.hpp"
#include "pipescout/estimation_study/late_rack.hpp"
#include "simulated_drive.hpp"
#include "simulated_flight.hpp"

namespace pipescout::estimation {
namespace {

using Eigen::Vector3d;
using geometry::SO3;
using test::SimulatedDrive;
using test::SimulatedFlight;

/// Keeps all, and iterates until nothing moves any more.
FixedLagSmootherParameters without_end(FixedLagSmootherParameters parameters) {
  parameters.lag = 1000;
  parameters.max_keyframes = 1000;
  parameters.max_imu_samples = 100000;
  parameters.max_iterations = 100;
  parameters.relinearisation = {.position = 1e-9,
                                .rotation = 1e-9,
                                .velocity = 1e-9,
                                .gyro_bias = 1e-9,
                                .accelerometer_bias = 1e-9,
                                .odometer_scale = 1e-9,
                                .mount = 1e-9,
                                .time_offset = 1e-9,
                                .imu_scale = 1e-9};
  return parameters;
}

/// Feeds a recording to a smoother, keyframe by keyframe. The guesses of the recording become the
/// states and the scale of the IMU when the next keyframe came, with which it was integrated.
void feed(FixedLagSmoother& smoother, Recording& recording) {
  smoother.initialise(recording.times[0], recording.first, recording.first_covariance);
  recording.guesses.clear();
  recording.imu_scale_guesses.clear();
  std::size_t next = 0;
  for (const double time : recording.times) {
    for (; next < recording.imu.size() && recording.imu[next].time < time - 1e-6; ++next) {
      smoother.add(recording.imu[next]);
    }
    for (const AnyFactor& factor : recording.measurements) {
      const double at = factor.to_time();
      if (at <= time + 1e-6 && at > time - 0.1 + 1e-6) {
        ASSERT_EQ(smoother.add(factor), Outcome::kWaiting);
      }
    }
    ASSERT_EQ(smoother.update(time).reset, ResetReason::kNone);
    recording.guesses.push_back(smoother.state(smoother.keyframes() - 1));
    recording.imu_scale_guesses.push_back(smoother.globals().imu_scale);
  }
  for (int i = 0; i < 10 && !smoother.update(recording.times.back()).converged; ++i) {
  }
}

/// Largest difference of two covariances, in parts of the deviations.
template <class Matrix>
double apart(const Matrix& a, const Matrix& b) {
  double most = 0;
  for (Eigen::Index i = 0; i < a.rows(); ++i) {
    for (Eigen::Index j = 0; j < a.cols(); ++j) {
      const double scale = std::sqrt(b(i, i) * b(j, j));
      most = std::max(most, scale > 0 ? std::abs(a(i, j) - b(i, j)) / scale : std::abs(a(i, j)));
    }
  }
  return most;
}

void expect_agreement(const char* name, Recording recording,
                      const FixedLagSmootherParameters& parameters) {
  FixedLagSmoother smoother(parameters);
  feed(smoother, recording);
  ASSERT_EQ(smoother.keyframes(), recording.times.size());
  BatchSmootherParameters all = BatchSmootherParameters::like(parameters);
  all.tolerance = 1e-15;
  all.max_reintegrations = 0;
  for (const LinearSolver solver : {LinearSolver::kSparseCholesky, LinearSolver::kSparseSchur}) {
    all.linear_solver = solver;
    BatchSmoother batch(all, recording);
    const BatchReport& report = batch.solve();
    EXPECT_TRUE(report.converged) << report.message;
    double states_apart = 0;
    for (std::size_t k = 0; k < recording.times.size(); ++k) {
      states_apart =
          std::max(states_apart, smoother.state(k).local(batch.states()[k]).cwiseAbs().maxCoeff());
    }
    const double globals_apart = smoother.globals().local(batch.globals()).cwiseAbs().maxCoeff();
    EXPECT_LT(states_apart, 1e-6);
    EXPECT_LT(globals_apart, 1e-6);
    const std::vector<std::size_t> chosen = {0, recording.times.size() / 2,
                                             recording.times.size() - 1, 0};
    const std::vector<StateMatrix> covariances = batch.covariances(chosen);
    ASSERT_EQ(covariances.size(), chosen.size());
    double covariances_apart = 0;
    for (std::size_t i = 0; i < chosen.size(); ++i) {
      covariances_apart =
          std::max(covariances_apart, apart(smoother.covariance(chosen[i]), covariances[i]));
    }
    covariances_apart =
        std::max(covariances_apart, apart(smoother.global_covariance(), batch.global_covariance()));
    EXPECT_LT(covariances_apart, 1e-6);
    std::printf("%s: states %.1e, globals %.1e, covariances %.1e apart; %d iterations\n", name,
                states_apart, globals_apart, covariances_apart, report.iterations);
  }
}

Recording recording_of(const SimulatedFlight& flight) {
  Recording recording{.first = flight.first, .first_covariance = flight.first_covariance};
  for (std::size_t k = 0; k < flight.truth.size(); ++k) {
    recording.times.push_back(SimulatedFlight::time_of(static_cast<int>(k)));
    recording.measurements.emplace_back(flight.gps[k]);
    recording.measurements.emplace_back(flight.vision[k]);
    if (k > 0) {
      recording.measurements.emplace_back(flight.odometry[k]);
    }
  }
  recording.imu = flight.imu;
  return recording;
}

Recording recording_of(const SimulatedDrive& drive, bool with_vision) {
  Recording recording{.first = drive.first, .first_covariance = drive.first_covariance};
  for (std::size_t k = 0; k < drive.truth.size(); ++k) {
    recording.times.push_back(SimulatedDrive::time_of(static_cast<int>(k)));
    if (k % 2 == 0) {
      recording.measurements.emplace_back(drive.gps[k]);
    }
    if (with_vision) {
      recording.measurements.emplace_back(drive.vision[k]);
    }
    recording.measurements.emplace_back(drive.non_holonomic[k]);
    if (k > 0) {
      recording.measurements.emplace_back(drive.odometer[k]);
    }
  }
  recording.imu = drive.imu;
  return recording;
}

TEST(BatchSmootherTest, AgreesWithTheSmootherOverAFlight) {
  GlobalStates truth;
  truth.rack_position = Vector3d(0.3, -0.2, 0.1);
  truth.R_map_rack = SO3::from_roll_pitch_yaw({0.02, -0.03, 0.1});
  truth.gps_lever_arm = Vector3d(0.3, -0.2, 0.5);
  truth.imu_scale = test::wrong_scale();
  FixedLagSmootherParameters parameters = without_end(test::flight_parameters());
  parameters.global_deviations = {.rack_position = 1,
                                  .rack_rotation = 0.3,
                                  .gps_lever_arm = 0.5,
                                  .gyro_scale = 0.02,
                                  .gyro_misalignment = 0.01,
                                  .accelerometer_scale = 0.01,
                                  .accelerometer_misalignment = 0.01};
  expect_agreement("flight", recording_of(SimulatedFlight(1, 50, truth)), parameters);
}

TEST(BatchSmootherTest, AgreesWithTheSmootherWhereKernelsAreAtWork) {
  SimulatedFlight flight(2, 50);
  for (std::size_t k = 7; k < flight.gps.size(); k += 7) {
    flight.gps[k].position += Vector3d(3, -2, 1);
  }
  FixedLagSmootherParameters parameters = without_end(test::flight_parameters());
  parameters.robustness[static_cast<std::size_t>(FactorKind::kGps)].kernel =
      statistics::RobustKernel::kCauchy;
  expect_agreement("outliers", recording_of(flight), parameters);
}

TEST(BatchSmootherTest, AgreesWithTheSmootherOverADriveBetweenKeyframes) {
  GlobalStates truth;
  truth.odometer_scale = 1.03;
  truth.mount_yaw = 0.04;
  truth.gps_time_offset = 0.05;
  truth.imu_scale = test::wrong_scale();
  SimulatedDrive drive(3, 60, truth, Vector3d(-0.8, 0.3, -0.4));
  for (std::size_t k = 1; k < drive.truth.size(); ++k) {
    drive.non_holonomic[k].time -= 0.03;
    drive.non_holonomic[k].lateral_deviation = 0.2;
  }
  FixedLagSmootherParameters parameters = without_end(test::drive_parameters());
  parameters.global_deviations = {.odometer_scale = 0.05,
                                  .mount_yaw = 0.05,
                                  .mount_pitch = 0.05,
                                  .gps_time_offset = 0.1,
                                  .gyro_scale = 0.02,
                                  .accelerometer_misalignment = 0.01};
  expect_agreement("drive", recording_of(drive, false), parameters);
}

TEST(BatchSmootherTest, FindsTheCalibrationOfADrive) {
  GlobalStates truth;
  truth.odometer_scale = 1.04;
  truth.mount_yaw = 0.06;
  truth.gps_lever_arm = Vector3d(0.4, -0.3, 0.6);
  truth.gps_time_offset = 0.05;
  truth.rack_position = Vector3d(12, -7, 1);
  truth.R_map_rack = SO3::from_roll_pitch_yaw({0.01, -0.02, 0.3});
  truth.imu_scale = test::wrong_scale();
  const SimulatedDrive drive(4, 600, truth, Vector3d(-0.8, 0.3, -0.4));
  FixedLagSmootherParameters parameters = test::drive_parameters();
  parameters.globals.rack_position = Vector3d(10, -5, 0);
  parameters.global_deviations = {.odometer_scale = 0.1,
                                  .mount_yaw = 0.1,
                                  .mount_pitch = 0.1,
                                  .rack_position = 5,
                                  .rack_rotation = 0.5,
                                  .gps_lever_arm = 1,
                                  .gps_time_offset = 0.2,
                                  .visual_pose_time_offset = 0.1,
                                  .gyro_scale = 0.02,
                                  .gyro_misalignment = 0.01,
                                  .accelerometer_scale = 0.01,
                                  .accelerometer_misalignment = 0.01};
  // It begins where the smoother was at the time: the IMU alone is hundreds of metres away at the
  // end, and finds a robot that drives backwards.
  Recording recording = recording_of(drive, true);
  FixedLagSmoother smoother(parameters);
  feed(smoother, recording);
  BatchSmoother batch(BatchSmootherParameters::like(parameters), recording);
  const BatchReport& report = batch.solve();
  EXPECT_TRUE(report.converged) << report.message;
  EXPECT_GT(report.reintegrations, 0);
  const GlobalVector error = batch.globals().local(truth);
  const GlobalVector deviations = batch.global_covariance().diagonal().cwiseSqrt();
  for (int i = 0; i < kOwnStates; ++i) {
    EXPECT_GT(deviations[i], 0);
    EXPECT_LT(std::abs(error[i]), 4 * deviations[i]) << i;
  }
  EXPECT_LT(deviations[kOdometerScale], 0.002);
  EXPECT_LT(deviations[kMountYaw], 0.005);
  EXPECT_LT(deviations.segment<3>(kRackPosition).maxCoeff(), 0.1);
  // The height of the antenna shows where the ground robot tilts, which it hardly does.
  EXPECT_LT(deviations.segment<2>(kGpsLeverArm).maxCoeff(), 0.03);
  double square = 0;
  for (std::size_t k = 0; k < drive.truth.size(); ++k) {
    square += (batch.states()[k].position - drive.truth[k].position).squaredNorm();
  }
  EXPECT_LT(std::sqrt(square / static_cast<double>(drive.truth.size())), 0.05);
  // Their noise is nearly all that the residuals of these are made of.
  for (const FactorKind kind : {FactorKind::kGps, FactorKind::kVisualPose}) {
    double sum = 0;
    double degrees = 0;
    for (const FactorReport& one : report.factors) {
      sum += one.kind == kind ? one.chi_square : 0;
      degrees += one.kind == kind ? one.degrees : 0;
    }
    EXPECT_NEAR(sum, degrees, 0.15 * degrees) << to_string(kind);
  }
}

TEST(BatchSmootherTest, KnowsMoreThanTheSmootherDidAtTheTime) {
  const SimulatedFlight flight(5, 200);
  Recording recording = recording_of(flight);
  FixedLagSmoother smoother(test::flight_parameters());
  feed(smoother, recording);
  const std::vector<NavState> at_the_time = recording.guesses;
  BatchSmoother batch(BatchSmootherParameters::like(test::flight_parameters()), recording);
  batch.solve();
  const auto rmse = [&](const std::vector<NavState>& states) {
    double square = 0;
    for (std::size_t k = 20; k < states.size(); ++k) {
      square += (states[k].position - flight.truth[k].position).squaredNorm();
    }
    return std::sqrt(square / static_cast<double>(states.size() - 20));
  };
  EXPECT_LT(rmse(batch.states()), 0.85 * rmse(at_the_time));
}

TEST(BatchSmootherTest, SmoothsTheFusionStream) {
  // NOLINTNEXTLINE(concurrency-mt-unsafe): there is no other thread.
  const char* const shared = std::getenv("PIPESCOUT_SHARED_DATA");
  estimation_study::FusionStream stream;
  if (shared != nullptr) {
    std::ifstream file(std::filesystem::path(shared) / "fusion_stream" / "stream.csv");
    stream = estimation_study::parse_fusion_stream(
        std::string{std::istreambuf_iterator<char>(file), {}});
  }
  if (stream.truth.empty()) {
    GTEST_SKIP() << "no fusion_stream below PIPESCOUT_SHARED_DATA: BATCH SMOOTHING OF THE STREAM "
                    "THAT GTSAM WAS MEASURED ON NOT TESTED";
  }
  StateVector deviations;
  deviations << Vector3d::Constant(0.01), Vector3d::Constant(0.02), Vector3d::Constant(0.1),
      Vector3d::Constant(0.01), Vector3d::Constant(0.1);
  Recording recording{.first = stream.truth[0].state,
                      .first_covariance = deviations.cwiseAbs2().asDiagonal(),
                      .imu = stream.imu};
  for (const estimation_study::TrueState& truth : stream.truth) {
    recording.times.push_back(truth.time);
  }
  const auto append = [&](const auto& list) {
    recording.measurements.insert(recording.measurements.end(), list.begin(), list.end());
  };
  append(stream.gps);
  append(stream.vision);
  append(stream.odometry);
  BatchSmoother batch(BatchSmootherParameters::like(estimation_study::fusion_stream_parameters()),
                      recording);
  const BatchReport& report = batch.solve();
  EXPECT_TRUE(report.converged) << report.message;
  double square = 0;
  for (std::size_t k = 50; k < stream.truth.size(); ++k) {
    square += (batch.states()[k].position - stream.truth[k].state.position).squaredNorm();
  }
  const double rmse = std::sqrt(square / static_cast<double>(stream.truth.size() - 50));
  std::printf("fusion stream: %.4f m after %d iterations\n", rmse, report.iterations);
  // GTSAM's with a lag of 2 s, at the end of the lag.
  EXPECT_LE(rmse, 0.0124);
  // The smoother of all takes long over 60 s: 15 s.
  constexpr std::size_t kKeyframes = 151;
  const double end = recording.times[kKeyframes - 1];
  recording.times.resize(kKeyframes);
  std::erase_if(recording.imu, [&](const ImuSample& sample) { return sample.time > end; });
  std::erase_if(recording.measurements,
                [&](const AnyFactor& factor) { return factor.to_time() > end + 1e-6; });
  expect_agreement("fusion stream", recording,
                   without_end(estimation_study::fusion_stream_parameters()));
}

TEST(BatchSmootherTest, ALateRackIsKnownOnLineAsWellAsToTheBatch) {
  double online = 0;
  double of_batch = 0;
  for (const std::uint64_t seed : {1, 2, 3, 4}) {
    const auto flight = estimation_study::fly_to_late_rack({.duration = 20, .seen_from = 10}, seed);
    BatchSmoother batch(BatchSmootherParameters::like(flight.parameters),
                        {.times = flight.times,
                         .first = flight.first,
                         .first_covariance = flight.first_covariance,
                         .imu = flight.imu,
                         .measurements = flight.measurements()});
    batch.solve();
    of_batch +=
        estimation_study::rack_nees(batch.globals(), flight.truth, batch.global_covariance());
    online += estimation_study::score_late_rack(flight).nees;
  }
  std::printf("NEES of the rack, four flights: on line %.2f, batch %.2f\n", online, of_batch);
  EXPECT_LT(online, 1.2 * of_batch);
}

TEST(BatchSmootherTest, BadDataAreReportedAndChangeNothing) {
  const SimulatedFlight flight(6, 20);
  Recording clean = recording_of(flight);
  Recording bad = clean;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  GpsMeasurement gps = flight.gps[3];
  gps.position.x() = nan;
  bad.measurements.emplace_back(gps);
  gps = flight.gps[3];
  gps.covariance.setZero();
  bad.measurements.emplace_back(gps);
  gps = flight.gps[3];
  gps.time = -1;
  bad.measurements.emplace_back(gps);
  gps.time = 100;
  bad.measurements.emplace_back(gps);
  bad.imu.push_back({nan, 0.01, Vector3d::Zero(), Vector3d::Zero()});
  bad.imu.push_back({0.5, 0.01, Vector3d::Zero(), Vector3d::Zero()});
  bad.imu.push_back({100, 0.01, Vector3d(1e300, 0, 0), Vector3d::Zero()});
  const BatchSmootherParameters parameters =
      BatchSmootherParameters::like(test::flight_parameters());
  BatchSmoother of_clean(parameters, clean);
  BatchSmoother of_bad(parameters, bad);
  of_clean.solve();
  const BatchReport& report = of_bad.solve();
  EXPECT_EQ(report.refused_imu, 3U);
  const std::size_t first = clean.measurements.size();
  EXPECT_EQ(report.factors[first].outcome, Outcome::kNotFinite);
  EXPECT_EQ(report.factors[first + 1].outcome, Outcome::kBadCovariance);
  EXPECT_EQ(report.factors[first + 2].outcome, Outcome::kLate);
  EXPECT_EQ(report.factors[first + 3].outcome, Outcome::kFuture);
  EXPECT_EQ(report.factors[first + 3].weight, 0);
  for (std::size_t k = 0; k < clean.times.size(); ++k) {
    EXPECT_EQ(of_clean.states()[k].position, of_bad.states()[k].position);
  }
}

TEST(BatchSmootherTest, RelativePosesMaySpanManyKeyframes) {
  // Odometry of a nanometre from the first to the last ties them.
  const SimulatedFlight flight(7, 30);
  Recording recording = recording_of(flight);
  RelativePoseMeasurement whole = flight.odometry[1];
  whole.to_time = recording.times.back();
  whole.T_from_to = flight.truth.front().T_map_body().inverse() * flight.truth.back().T_map_body();
  whole.covariance = 1e-12 * geometry::Matrix6d::Identity();
  recording.measurements.emplace_back(whole);
  BatchSmoother batch(BatchSmootherParameters::like(test::flight_parameters()), recording);
  EXPECT_TRUE(batch.solve().converged);
  const auto moved =
      batch.states().front().T_map_body().inverse() * batch.states().back().T_map_body();
  EXPECT_LT((moved.translation() - whole.T_from_to.translation()).norm(), 1e-4);
}

TEST(BatchSmootherTest, TellsHowFarItIsAndStopsWhenTold) {
  const SimulatedFlight flight(8, 30);
  BatchSmoother batch(BatchSmootherParameters::like(test::flight_parameters()),
                      recording_of(flight));
  std::vector<double> costs;
  const BatchReport& report = batch.solve([&](const BatchProgress& progress) {
    costs.push_back(progress.cost);
    return costs.size() < 3;
  });
  ASSERT_EQ(costs.size(), 3U);
  EXPECT_LT(costs[1], costs[0]);
  EXPECT_EQ(report.cost, std::min(costs[1], costs[2]));
  EXPECT_EQ(report.first_cost, costs[0]);
  EXPECT_TRUE(batch.states().back().is_finite());
}

TEST(BatchSmootherTest, ParametersAndRecordingsAreValidated) {
  const Recording sound = recording_of(SimulatedFlight(9, 5));
  const auto refused = [&](auto&& change) {
    BatchSmootherParameters parameters;
    Recording recording = sound;
    change(parameters, recording);
    try {
      BatchSmoother smoother(parameters, recording);
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_EQ(refused([](auto&, auto&) {}), "");
  EXPECT_THAT(refused([](auto& p, auto&) { p.tolerance = 0; }),
              testing::StartsWith("tolerance: 0 is outside"));
  EXPECT_THAT(refused([](auto& p, auto&) { p.max_iterations = 0; }),
              testing::HasSubstr("max_iterations"));
  EXPECT_THAT(refused([](auto& p, auto&) { p.gravity = std::nan(""); }),
              testing::HasSubstr("gravity"));
  EXPECT_THAT(refused([](auto& p, auto&) { p.global_deviations.mount_yaw = -1; }),
              testing::HasSubstr("mount_yaw"));
  EXPECT_THAT(refused([](auto& p, auto&) { p.linear_solver = static_cast<LinearSolver>(7); }),
              testing::HasSubstr("linear_solver"));
  EXPECT_THAT(refused([](auto&, auto& r) { r.times.clear(); }), testing::HasSubstr("times"));
  EXPECT_THAT(refused([](auto&, auto& r) { r.times[2] = r.times[1]; }),
              testing::HasSubstr("times"));
  EXPECT_THAT(refused([](auto&, auto& r) { r.guesses.resize(2); }), testing::HasSubstr("guesses"));
  EXPECT_THAT(refused([](auto&, auto& r) { r.imu_scale_guesses.resize(2); }),
              testing::HasSubstr("imu_scale_guesses"));
  EXPECT_THAT(refused([](auto&, auto& r) {
                r.imu_scale_guesses.resize(r.times.size());
                r.imu_scale_guesses[1].gyro(0, 0) = std::nan("");
              }),
              testing::HasSubstr("imu_scale_guesses"));
  EXPECT_THAT(refused([](auto&, auto& r) { r.first_covariance.setZero(); }),
              testing::HasSubstr("covariance"));
}

}  // namespace
}  // namespace pipescout::estimation
