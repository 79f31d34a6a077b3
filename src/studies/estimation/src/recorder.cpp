// SPDX-License-Identifier: Apache-2.0
#include "recorder.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "pipescout/simulation/uav.hpp"

namespace pipescout::estimation_study::internal {
namespace {

using Eigen::Vector3d;
using geometry::SE3;
using geometry::SO3;

constexpr double kTruthPeriod = 0.01;  // s
constexpr double kDue = 1e-9;          // s, for sums of steps

// Of the localisation over a rack, with its true errors: most are like this, some are worse.
constexpr double kPoseDeviation = 0.003;                          // m, per axis
constexpr double kTurnDeviation = 0.04 * std::numbers::pi / 180;  // rad, per axis
constexpr double kTailShare = 0.05;
constexpr double kTail = 4;
constexpr double kImuLatency = 0.002;    // s
constexpr double kVisionLatency = 0.03;  // s

simulation::GpsParameters gps_parameters(const RunOptions& options, const VehicleRun& run) {
  simulation::GpsParameters p;
  p.antenna = run.antenna;
  p.traps = options.traps;
  p.outlier_share = options.outliers == Sensor::kGps ? options.outlier_share : 0;
  for (const Silence& silence : options.silences) {
    if (silence.sensor == Sensor::kGps) {
      p.outages.push_back({.begin = silence.begin, .duration = silence.duration});
    }
  }
  if (options.gps == GpsGrade::kRtk) {
    p.white_deviation = {0.01, 0.01, 0.02};
    p.correlated_deviation = {0.007, 0.007, 0.014};
    p.correlation_time = 20;
  } else {
    p.white_deviation = {0.4, 0.4, 0.8};
    p.correlated_deviation = {0.5, 0.5, 1};
    p.correlation_time = 60;
  }
  if (options.world) {
    const Vector3d variance = p.white_deviation.cwiseAbs2() + p.correlated_deviation.cwiseAbs2();
    const double share = options.world->gps_correlated_share;
    p.white_deviation = ((1 - share) * variance).cwiseSqrt();
    p.correlated_deviation = (share * variance).cwiseSqrt();
    p.correlation_time = options.world->gps_correlation_time;
  } else if (!options.correlated_gps) {
    p.white_deviation =
        (p.white_deviation.cwiseAbs2() + p.correlated_deviation.cwiseAbs2()).cwiseSqrt();
    p.correlated_deviation.setZero();
  }
  return p;
}

simulation::ImuParameters imu_parameters(const RunOptions& options) {
  simulation::ImuParameters p = options.imu;
  if (options.world) {
    for (simulation::InertialTriadParameters* triad : {&p.gyro, &p.accelerometer}) {
      triad->noise_density *= options.world->imu_noise;
      triad->bias_instability *= options.world->imu_noise;
      triad->bias_random_walk *= options.world->imu_noise;
    }
  }
  return p;
}

/// Heights come and go in stretches.
bool has_height(const simulation::World& world, double time) {
  constexpr double kPeriod = 20;  // s
  return std::fmod(time, kPeriod) >= kPeriod * world.heights_missing;
}

}  // namespace

Draw make_draw(std::uint64_t seed, std::uint64_t purpose) {
  std::seed_seq sequence{seed & 0xffffffffU, seed >> 32U, purpose, std::uint64_t{77}};
  return Draw(statistics::Engine(sequence));
}

Recorder::Recorder(const RunOptions& options, VehicleRun& run, std::uint64_t seed)
    : options_(options),
      run_(run),
      imu_(imu_parameters(options), seed),
      gps_(gps_parameters(options, run), seed),
      imu_draw_(make_draw(seed, 1)),
      odometer_draw_(make_draw(seed, 2)),
      vision_draw_(make_draw(seed, 3)),
      weld_draw_(make_draw(seed, 4)) {}

void Recorder::push(double arrival, const Reading& reading, bool wrong) {
  run_.events.push_back({.arrival = arrival, .reading = reading, .wrong = wrong});
}

bool Recorder::wrong(Sensor sensor, Draw& draw) const {
  // Drawn in any case, so that the other draws are the same with and without outliers.
  const bool hit = draw.happens(options_.outlier_share);
  return hit && options_.outliers == sensor;
}

bool Recorder::silent(Sensor sensor, double time) const {
  return std::ranges::any_of(options_.silences, [&](const Silence& silence) {
    return silence.sensor == sensor && time >= silence.begin &&
           time < silence.begin + silence.duration;
  });
}

void Recorder::sample(const simulation::BodyMotion& body, double way) {
  newest_imu_.reset();
  if (body.time > static_cast<double>(imu_samples_) * options_.imu.period - kDue) {
    ++imu_samples_;
    const SO3 R_imu_body = run_.R_body_imu.inverse();
    const auto shown = imu_.measure({.angular_rate = R_imu_body * body.angular_rate,
                                     .specific_force = R_imu_body * body.specific_force()});
    estimation::ImuReading reading{body.time, shown.specific_force, shown.angular_rate};
    newest_imu_ = {body.time, run_.R_body_imu * shown.specific_force,
                   run_.R_body_imu * shown.angular_rate};
    last_rate_ = newest_imu_->angular_rate;
    const bool hit = wrong(Sensor::kImu, imu_draw_);
    const Vector3d force =
        5 * simulation::kGravity * imu_draw_.uniform(0.2, 1) * imu_draw_.direction();
    const Vector3d rate = 5 * imu_draw_.uniform(0.2, 1) * imu_draw_.direction();
    if (hit) {
      reading.specific_force += force;
      reading.angular_rate += rate;
    }
    if (!silent(Sensor::kImu, body.time)) {
      push(body.time + kImuLatency, reading, hit);
    }
  }
  if (body.time > static_cast<double>(run_.truth.size()) * kTruthPeriod - kDue) {
    const auto biases = imu_.biases();
    run_.truth.push_back({.time = body.time,
                          .state = {.R_map_body = body.T_map_body.rotation(),
                                    .position = body.T_map_body.translation(),
                                    .velocity = body.velocity,
                                    .gyro_bias = run_.R_body_imu * biases.angular_rate,
                                    .accelerometer_bias = run_.R_body_imu * biases.specific_force},
                          .way = way});
  }
  if (run_.vehicle != Vehicle::kCrawler && body.time > gps_.due() - kDue) {
    if (const auto fix = gps_.measure(body.T_map_body)) {
      estimation::GpsMeasurement shown{
          .time = fix->time, .position = fix->position, .covariance = fix->covariance};
      if (options_.world) {
        shown.time += options_.world->gps_stamp_offset;
        if (run_.vehicle == Vehicle::kGroundRobot && !has_height(*options_.world, fix->time)) {
          constexpr double kUnknown = 1e4;  // m
          shown.position.z() = 0;
          shown.covariance(2, 2) = kUnknown * kUnknown;
        }
      }
      push(fix->arrival, shown, fix->kind != simulation::GpsFixKind::kGood);
    }
  }
}

void Recorder::odometer(const estimation::OdometerReading& reading, double arrival) {
  estimation::OdometerReading shown = reading;
  if (options_.world) {
    shown.time += options_.world->odometer_stamp_offset;
    shown.distance *= 1 + options_.world->wheel_scale;
  }
  const bool hit = wrong(Sensor::kOdometer, odometer_draw_);
  const double by = odometer_draw_.uniform(-9, 9);
  if (hit) {
    shown.distance += by + std::copysign(1.0, by);
  }
  if (!silent(Sensor::kOdometer, reading.time)) {
    push(arrival, shown, hit);
  }
}

void Recorder::visual_pose(double time, const SE3& T_rack_body) {
  const double size = vision_draw_.happens(kTailShare) ? kTail : 1;
  const Vector3d moved = size * kPoseDeviation * vision_draw_.normals();
  const Vector3d turned = size * kTurnDeviation * vision_draw_.normals();
  const double late = kVisionLatency * vision_draw_.uniform(0.9, 1.5);
  const double camera_offset = options_.world ? options_.world->camera_stamp_offset : 0.0;
  const bool hit = wrong(Sensor::kVisualPose, vision_draw_);
  const Vector3d jump = vision_draw_.uniform(0.3, 3) * vision_draw_.direction();
  const Vector3d twist = vision_draw_.uniform(0, 0.5) * vision_draw_.direction();
  SO3 rotation = T_rack_body.rotation() * SO3::exp(turned);
  Vector3d position = T_rack_body.translation() + moved;
  if (hit) {
    rotation = rotation * SO3::exp(twist);
    position += jump;
  }
  // As a fit states it, of most poses: the tail is what gates are for.
  geometry::Vector6d variance;
  variance << Vector3d::Constant(kPoseDeviation * kPoseDeviation),
      Vector3d::Constant(kTurnDeviation * kTurnDeviation);
  if (!silent(Sensor::kVisualPose, time)) {
    push(time + late,
         estimation::VisualPoseMeasurement{.time = time + camera_offset,
                                           .T_rack_body = SE3(rotation, position),
                                           .covariance = variance.asDiagonal(),
                                           .angular_rate = last_rate_},
         hit);
  }
}

void Recorder::weld(const estimation::WeldMeasurement& m, double arrival, double joint) {
  estimation::WeldMeasurement shown = m;
  const bool hit = wrong(Sensor::kWeld, weld_draw_);
  const double by = joint * weld_draw_.uniform(1, 3) * (weld_draw_.happens(0.5) ? 1 : -1);
  if (hit) {
    shown.position += by * shown.direction;
  }
  if (!silent(Sensor::kWeld, m.time)) {
    push(arrival, shown, hit);
  }
}

void Recorder::given(const estimation::GivenPose& pose) {
  push(pose.time, pose, false);
}

void Recorder::finish() {
  std::ranges::stable_sort(run_.events, {}, &Event::arrival);
}

}  // namespace pipescout::estimation_study::internal
