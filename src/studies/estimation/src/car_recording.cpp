// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation_study/car_recording.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "pipescout/csv/number_table.hpp"
#include "pipescout/geometry/geodesy.hpp"

namespace pipescout::estimation_study {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// m: white noise and what does not change within a lag, taken as if fixes were independent.
constexpr double kGpsLevel = 1.5;
constexpr double kGpsUp = 3;
/// Of the mean of the wheels: a count of speed is 3.6 mm/s, and they roll.
constexpr double kWheelVariance = 1e-4;  // m^2 per m

/// Specific force at the time of a reading of the gyro, between the two nearest.
Vector3d force_at(const std::vector<std::vector<double>>& forces, double time) {
  const auto after = std::ranges::lower_bound(forces, time, {}, [](const auto& r) { return r[0]; });
  const auto at = [](const std::vector<double>& r) { return Vector3d(r[1], r[2], r[3]); };
  if (after == forces.begin()) {
    return at(*after);
  }
  if (after == forces.end()) {
    return at(forces.back());
  }
  const auto& before = *std::prev(after);
  const double share = (time - before[0]) / ((*after)[0] - before[0]);
  return (1 - share) * at(before) + share * at(*after);
}

/// Nothing beyond its ends.
std::optional<CarReference> reference_at(const CarRecording& car, double time) {
  const auto after = std::ranges::lower_bound(car.reference, time, {}, &CarReference::time);
  if (after == car.reference.begin() || after == car.reference.end()) {
    return std::nullopt;
  }
  const CarReference& before = *std::prev(after);
  const double share = (time - before.time) / (after->time - before.time);
  return CarReference{time, (1 - share) * before.position + share * after->position,
                      (1 - share) * before.velocity + share * after->velocity};
}

Vector2d dead_reckon(const CarRecording& car, const CarReference& from, double until) {
  Vector2d place = from.position.head<2>();
  double course = std::atan2(from.velocity.y(), from.velocity.x());
  auto turn = std::ranges::lower_bound(car.turns, from.time, {}, &CarRecording::Turn::time);
  auto speed = std::ranges::lower_bound(car.speeds, from.time, {}, &CarRecording::Speed::time);
  double time = from.time;
  for (; turn != car.turns.end() && turn->time <= until; ++turn) {
    while (std::next(speed) != car.speeds.end() && std::next(speed)->time <= turn->time) {
      ++speed;
    }
    const double dt = turn->time - time;
    course += dt * turn->rate;
    place += dt * speed->speed * Vector2d(std::cos(course), std::sin(course));
    time = turn->time;
  }
  return place;
}

/// Feeds the recording without the GPS of [begin, begin + duration), and tells each new state.
template <class Told>
void drive(const CarRecording& car, double begin, double duration, Told&& told) {
  estimation::StateEstimator estimator(car_parameters());
  std::uint64_t updates = 0;
  for (const Event& event : car.events) {
    const bool withheld = std::holds_alternative<estimation::GpsMeasurement>(event.reading) &&
                          event.arrival >= begin && event.arrival < begin + duration;
    if (withheld) {
      continue;
    }
    std::visit([&](const auto& reading) { (void)estimator.add(reading); }, event.reading);
    if (estimator.updates() != updates) {
      updates = estimator.updates();
      if (const auto estimate = estimator.estimate(); estimate && estimate->in_map) {
        told(*estimate);
      }
    }
  }
}

}  // namespace

CarRecording read_car(const CarFiles& files) {
  const auto forces = number_table(files.accelerometer, "accelerometer.csv", true, 4);
  const auto rates = number_table(files.gyro, "gyro.csv", true, 4);
  const auto wheels = number_table(files.wheel_speed, "wheel_speed.csv", true, 5);
  const auto fixes = number_table(files.gnss, "gnss_ublox_live.csv", true, 7);
  const auto reference = number_table(files.reference, "reference_pose_20hz.csv", true, 13);

  CarRecording car;
  const auto geocentric = [](const std::vector<double>& r, std::size_t i) {
    return Vector3d(r[i], r[i + 1], r[i + 2]);
  };
  // The datum is wherever the first fix is; the reference's first position becomes the origin.
  const geometry::LocalFrame map({fixes[0][1], fixes[0][2], fixes[0][5]});
  const Vector3d origin = map.from_geocentric(geocentric(reference[0], 3));
  for (const auto& row : reference) {
    car.reference.push_back({row[0], map.from_geocentric(geocentric(row, 3)) - origin,
                             map.R_local_geocentric() * geocentric(row, 6)});
  }
  for (const auto& row : rates) {
    car.events.push_back(
        {row[0], estimation::ImuReading{.time = row[0],
                                        .specific_force = force_at(forces, row[0]),
                                        .angular_rate = {row[1], row[2], row[3]}}});
    car.turns.push_back({row[0], -row[3]});
  }
  double distance = 0;
  for (const auto& row : wheels) {
    const double speed = (row[1] + row[2] + row[3] + row[4]) / 4;
    if (!car.speeds.empty()) {
      distance += (row[0] - car.speeds.back().time) * (speed + car.speeds.back().speed) / 2;
    }
    car.speeds.push_back({row[0], speed});
    car.events.push_back(
        {row[0], estimation::OdometerReading{
                     .time = row[0], .distance = distance, .variance = kWheelVariance * distance}});
  }
  for (const auto& row : fixes) {
    estimation::GpsMeasurement fix;
    fix.time = row[0];
    fix.position = map.position({row[1], row[2], row[5]}) - origin;
    fix.covariance.diagonal() << kGpsLevel * kGpsLevel, kGpsLevel * kGpsLevel, kGpsUp * kGpsUp;
    car.events.push_back({row[0], fix});
  }
  std::ranges::stable_sort(car.events, {}, &Event::arrival);
  return car;
}

estimation::StateEstimatorParameters car_parameters() {
  auto parameters = estimation::StateEstimatorParameters::ground_robot();
  parameters.gps.correlation_time = 0;  // see kGpsLevel
  // Forward, right, down.
  parameters.R_body_imu = geometry::SO3::about_x(M_PI);
  parameters.smoother.gravity = 9.80;  // at 38 degrees of latitude
  parameters.smoother.lag = 4;
  parameters.smoother.max_keyframes = 64;
  // A telephone: figures of the kind of BMI160, and an engine that shakes it.
  parameters.odometer.share = 0.005;  // tyres that roll, not wheels that skid
  parameters.smoother.imu_noise.gyro = 1e-3;
  parameters.smoother.imu_noise.accelerometer = 2e-2;
  parameters.smoother.imu_noise.gyro_bias = 2e-5;
  parameters.smoother.imu_noise.accelerometer_bias = 5e-4;
  parameters.smoother.global_deviations.odometer_scale = 0.02;
  parameters.smoother.relinearisation.rotation = 1e-3;  // as mount angles ask for
  parameters.smoother.global_deviations.mount_yaw = 0.1;
  parameters.smoother.global_deviations.mount_pitch = 0.1;
  parameters.smoother.global_deviations.gps_time_offset = 0.1;
  parameters.start.largest_speed = 40;
  parameters.odometer.largest_speed = 60;
  return parameters;
}

CarOutage score_car_outage(const CarRecording& car, double begin, double duration) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const double end = begin + duration;
  CarOutage result{.begin = begin, .error = kNan, .dead_reckoned = kNan};
  Vector2d error_at_begin = Vector2d::Constant(kNan);
  Vector2d error_at_end = Vector2d::Constant(kNan);
  drive(car, begin, duration, [&](const estimation::Estimate& estimate) {
    if (const auto truth = reference_at(car, estimate.time)) {
      const Vector2d error = (estimate.state.position - truth->position).head<2>();
      if (estimate.time <= begin) {
        error_at_begin = error;
      } else if (estimate.time <= end) {
        error_at_end = error;
      }
    }
  });
  result.error = (error_at_end - error_at_begin).norm();
  const auto from = reference_at(car, begin);
  const auto to = reference_at(car, end);
  if (from && to) {
    result.dead_reckoned = (dead_reckon(car, *from, end) - to->position.head<2>()).norm();
    for (const CarReference& point : car.reference) {
      if (point.time >= begin && point.time < end) {
        const auto next = reference_at(car, std::min(end, point.time + 0.05));
        result.way += next ? (next->position - point.position).norm() : 0.0;
      }
    }
  }
  return result;
}

CarScore score_car(const CarRecording& car) {
  constexpr double kSettling = 5;  // s
  CarScore result{.started = std::numeric_limits<double>::quiet_NaN()};
  double first = std::numeric_limits<double>::quiet_NaN();
  double count = 0;
  drive(car, 0, 0, [&](const estimation::Estimate& estimate) {
    if (std::isnan(first)) {
      first = estimate.time;
      result.started = first - car.events.front().arrival;
    }
    const auto truth = reference_at(car, estimate.time);
    if (!truth || estimate.time < first + kSettling) {
      return;
    }
    const auto& velocity = estimate.state.velocity;
    const double course = std::atan2(velocity.y(), velocity.x()) -
                          std::atan2(truth->velocity.y(), truth->velocity.x());
    result.position += (estimate.state.position - truth->position).head<2>().squaredNorm();
    result.speed += std::pow(velocity.norm() - truth->velocity.norm(), 2);
    result.course += std::pow(std::remainder(course, 2 * M_PI), 2);
    count += 1;
  });
  for (double* const sum : {&result.position, &result.speed, &result.course}) {
    *sum = std::sqrt(*sum / count);
  }
  return result;
}

}  // namespace pipescout::estimation_study
