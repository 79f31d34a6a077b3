// SPDX-License-Identifier: Apache-2.0
#include "estimator_inputs.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <numbers>
#include <string>

#include "pipescout/estimation_study/fusion_stream.hpp"

namespace pipescout::benchmarks {
namespace {

using Eigen::Vector3d;
using geometry::SE3;
using geometry::SO3;

constexpr int kSamples = 10;
constexpr double kDt = kKeyframeStep / kSamples;
constexpr double kGravity = 9.81;
constexpr double kSame = 1e-6;  // s

Vector3d rate_at(double t) {
  return {0.3 * std::sin(1.1 * t), 0.2 * std::cos(0.7 * t), 0.4 + 0.2 * std::sin(0.3 * t)};
}

Vector3d velocity_at(double t) {
  return {1.9 * std::cos(0.8 * t), 1.3 * std::sin(0.9 * t), 0.4 * std::cos(1.3 * t)};
}

geometry::Matrix6d covariance(double translation, double rotation) {
  geometry::Vector6d d;
  d << Vector3d::Constant(translation * translation), Vector3d::Constant(rotation * rotation);
  return d.asDiagonal();
}

EstimatorRecording in_steps(const estimation_study::FusionStream& stream) {
  EstimatorRecording recording{.start = stream.truth.front().state, .simulated = false};
  std::size_t imu = 0;
  std::size_t odometry = 0;
  std::size_t gps = 0;
  std::size_t vision = 0;
  for (std::size_t k = 1; k < stream.truth.size(); ++k) {
    EstimatorStep& step = recording.steps.emplace_back();
    step.time = stream.truth[k].time;
    for (; imu < stream.imu.size() && stream.imu[imu].time < step.time - 0.5 * kDt; ++imu) {
      step.imu.push_back(stream.imu[imu]);
    }
    for (; odometry < stream.odometry.size() &&
           stream.odometry[odometry].to_time <= step.time + kSame;
         ++odometry) {
      step.odometry = stream.odometry[odometry];
    }
    // Those of time 0 are not used.
    for (; gps < stream.gps.size() && stream.gps[gps].time <= step.time + kSame; ++gps) {
      if (stream.gps[gps].time > step.time - kSame) {
        step.gps = stream.gps[gps];
      }
    }
    for (; vision < stream.vision.size() && stream.vision[vision].time <= step.time + kSame;
         ++vision) {
      step.vision = stream.vision[vision];
    }
  }
  return recording;
}

void append(const EstimatorStep& step, estimation::Recording& recording) {
  recording.imu.insert(recording.imu.end(), step.imu.begin(), step.imu.end());
  const auto add = [&](const auto& measurement) {
    if (measurement) {
      recording.measurements.emplace_back(*measurement);
    }
  };
  add(step.odometry);
  add(step.gps);
  add(step.vision);
}

estimation::StateMatrix start_covariance() {
  estimation::StateVector deviations;
  deviations << Vector3d::Constant(0.01), Vector3d::Constant(0.02), Vector3d::Constant(0.1),
      Vector3d::Constant(0.01), Vector3d::Constant(0.1);
  return deviations.cwiseAbs2().asDiagonal();
}

}  // namespace

EstimatorStream::EstimatorStream(std::uint64_t seed) : engine_(seed) {
  state_.velocity = velocity_at(0);
  state_.gyro_bias = noise(0.003);
  state_.accelerometer_bias = noise(0.03);
  start_ = state_;
}

Vector3d EstimatorStream::noise(double deviation) {
  return {deviation * normal_(engine_), deviation * normal_(engine_), deviation * normal_(engine_)};
}

void EstimatorStream::next(EstimatorStep& step) {
  const estimation::ImuNoise densities = estimator_parameters().imu_noise;
  const SE3 from = state_.T_map_body();
  const double from_time = kKeyframeStep * static_cast<double>(steps_);
  ++steps_;
  step.time = kKeyframeStep * static_cast<double>(steps_);
  step.imu.clear();
  for (int i = 0; i < kSamples; ++i) {
    const double at = from_time + i * kDt;
    const Vector3d rate = rate_at(at + 0.5 * kDt);
    const Vector3d gained = velocity_at(at + kDt) - velocity_at(at);
    const Vector3d force = (state_.R_map_body * SO3::exp(0.5 * kDt * rate)).inverse() *
                           (gained / kDt + Vector3d(0, 0, kGravity));
    step.imu.push_back(
        {at, kDt, rate + state_.gyro_bias + noise(densities.gyro / std::sqrt(kDt)),
         force + state_.accelerometer_bias + noise(densities.accelerometer / std::sqrt(kDt))});
    state_.position += kDt * (state_.velocity + 0.5 * gained);
    state_.velocity = velocity_at(at + kDt);
    state_.R_map_body = state_.R_map_body * SO3::exp(kDt * rate);
  }
  const SE3 moved = from.inverse() * state_.T_map_body();
  const double slip = std::max(1e-3, 0.01 * moved.translation().norm());
  const double turn = std::max(5e-4, 0.01 * moved.rotation().log().norm());
  step.odometry = {from_time, step.time,
                   SE3(moved.rotation() * SO3::exp(noise(turn)),
                       moved.translation() + moved.rotation() * noise(slip)),
                   covariance(slip, turn)};
  constexpr double kPlace = 0.05;
  constexpr double kAngle = 0.5 * std::numbers::pi / 180;
  step.vision = {step.time,
                 SE3(state_.R_map_body * SO3::exp(noise(kAngle)), state_.position + noise(kPlace)),
                 covariance(kPlace, kAngle)};
  step.gps.reset();
  if (steps_ % 2 == 0) {
    constexpr double kFix = 0.2;
    step.gps = {step.time, state_.position + noise(kFix),
                kFix * kFix * Eigen::Matrix3d::Identity()};
  }
}

EstimatorRecording estimator_recording(std::uint64_t seed) {
  // NOLINTNEXTLINE(concurrency-mt-unsafe): there is no other thread.
  const char* const shared = std::getenv("PIPESCOUT_SHARED_DATA");
  if (shared != nullptr) {
    std::ifstream file(std::filesystem::path(shared) / "fusion_stream" / "stream.csv");
    const auto stream = estimation_study::parse_fusion_stream(
        std::string{std::istreambuf_iterator<char>(file), {}});
    if (!stream.truth.empty()) {
      return in_steps(stream);
    }
  }
  constexpr std::size_t kSteps = 600;
  EstimatorStream stream(seed);
  EstimatorRecording recording{.start = stream.start(), .steps = {}};
  recording.steps.resize(kSteps);
  for (EstimatorStep& step : recording.steps) {
    stream.next(step);
  }
  return recording;
}

estimation::FixedLagSmootherParameters estimator_parameters() {
  return estimation_study::fusion_stream_parameters();
}

void start(estimation::FixedLagSmoother& smoother, const estimation::NavState& state) {
  smoother.initialise(0, state, start_covariance());
}

void feed(estimation::FixedLagSmoother& smoother, const EstimatorStep& step) {
  for (const estimation::ImuSample& sample : step.imu) {
    smoother.add(sample);
  }
  const auto add = [&](const auto& measurement) {
    if (measurement) {
      smoother.add(*measurement);
    }
  };
  add(step.odometry);
  add(step.gps);
  add(step.vision);
}

estimation::Recording window_for_ceres(const estimation::FixedLagSmoother& smoother,
                                       const std::vector<EstimatorStep>& steps, std::size_t index) {
  estimation::Recording window{.first = smoother.state(0),
                               .first_covariance = smoother.covariance(0)};
  for (std::size_t k = 0; k < smoother.keyframes(); ++k) {
    window.times.push_back(smoother.time(k));
    window.guesses.push_back(smoother.state(k));
  }
  window.times.push_back(steps[index].time);
  window.guesses.push_back(smoother.propagated()->state);
  for (std::size_t i = index + 1 - smoother.keyframes(); i <= index; ++i) {
    append(steps[i], window);
  }
  return window;
}

estimation::Recording batch_recording(std::uint64_t seed, std::size_t keyframes) {
  EstimatorStream stream(seed);
  estimation::FixedLagSmoother smoother(estimator_parameters());
  start(smoother, stream.start());
  estimation::Recording recording{
      .times = {0}, .first = stream.start(), .first_covariance = start_covariance()};
  recording.guesses.push_back(stream.start());
  EstimatorStep step;
  while (recording.times.size() < keyframes) {
    stream.next(step);
    append(step, recording);
    feed(smoother, step);
    smoother.update(step.time);
    recording.times.push_back(step.time);
    recording.guesses.push_back(smoother.state(smoother.keyframes() - 1));
  }
  return recording;
}

}  // namespace pipescout::benchmarks
