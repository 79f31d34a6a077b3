// SPDX-License-Identifier: Apache-2.0
#include "mounting_evidence.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "pipescout/command_line/formatted.hpp"
#include "pipescout/statistics/median.hpp"

namespace pipescout::estimate {
namespace {

using command_line::formatted;
using Complex = std::complex<double>;
using Eigen::Vector3d;

constexpr double kGravity = 9.81;  // m/s^2
constexpr double kStep = 0.5;      // s, of the differences of speed
constexpr std::size_t kFewestIntervals = 60;
/// Accelerations below this are vibration and slope.
constexpr double kLeastAcceleration = 0.08;  // m/s^2, rms
constexpr double kLeastTurn = 0.03;          // rad/s, rms
constexpr double kStrongCorrelation = 0.6;
constexpr double kStrongRateCorrelation = 0.8;
/// Of the correlation, by a delay that is one: slow turns correlate at any.
constexpr double kClearGain = 0.02;
constexpr double kLargestSpread = 15 * kDegree;
constexpr double kOtherMounting = 10 * kDegree;  // smaller differences are left to the estimator
constexpr double kToAxes = 12 * kDegree;         // IMUs are mounted along axes, slopes are not

Vector3d median_force(const std::vector<ImuRow>& rows) {
  Vector3d result;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    values.reserve(rows.size());
    for (const ImuRow& row : rows) {
      values.push_back(row.force[axis]);
    }
    result[axis] = statistics::median(std::move(values));
  }
  return result;
}

/// Sums of the IMU's readings up to each row: means over intervals cost nothing.
class Means {
 public:
  explicit Means(const std::vector<ImuRow>& rows) : rows_(rows) {
    force_.reserve(rows.size() + 1);
    rate_.reserve(rows.size() + 1);
    force_.push_back(Vector3d::Zero());
    rate_.push_back(Vector3d::Zero());
    for (const ImuRow& row : rows) {
      force_.push_back(force_.back() + row.force);
      rate_.push_back(rate_.back() + row.rate);
    }
  }
  struct Mean {
    Vector3d force;
    Vector3d rate;
  };
  [[nodiscard]] std::optional<Mean> between(double from, double to) const {
    const auto index = [&](double time) {
      return static_cast<std::size_t>(std::ranges::lower_bound(rows_, time, {}, &ImuRow::time) -
                                      rows_.begin());
    };
    const std::size_t a = index(from);
    const std::size_t b = index(to);
    if (b < a + 2) {
      return std::nullopt;
    }
    const double n = static_cast<double>(b - a);
    return Mean{(force_[b] - force_[a]) / n, (rate_[b] - rate_[a]) / n};
  }

 private:
  const std::vector<ImuRow>& rows_;
  std::vector<Vector3d> force_;
  std::vector<Vector3d> rate_;
};

struct Pairs {
  std::vector<Complex> vehicle;  // m/s^2, forwards and to the left
  std::vector<Complex> level;    // m/s^2, of the IMU in the levelled frame
};

void remove_mean(std::vector<Complex>& values) {
  Complex sum = 0;
  for (const Complex& v : values) {
    sum += v;
  }
  for (Complex& v : values) {
    v -= sum / static_cast<double>(values.size());
  }
}

struct YawFit {
  double yaw = 0;
  double correlation = 0;
};

YawFit fit_yaw(const Pairs& pairs, std::size_t begin, std::size_t end) {
  Complex sum = 0;
  double vehicle = 0;
  double level = 0;
  for (std::size_t i = begin; i < end; ++i) {
    sum += pairs.vehicle[i] * std::conj(pairs.level[i]);
    vehicle += std::norm(pairs.vehicle[i]);
    level += std::norm(pairs.level[i]);
  }
  return {std::arg(sum), vehicle * level > 0 ? std::abs(sum) / std::sqrt(vehicle * level) : 0};
}

struct RateFit {
  double correlation = 0;
  double factor = 0;
  double rms = 0;
  std::size_t count = 0;
};

/// Of the odometer's yaw rate, moved back by `delay`, and the gyro's about the vertical.
RateFit fit_rates(const std::vector<OdometerRow>& rows, const Means& means, const Vector3d& up,
                  double delay) {
  double n = 0, x = 0, y = 0, xx = 0, yy = 0, xy = 0;
  for (std::size_t i = 1; i + 1 < rows.size(); ++i) {
    if (!rows[i].yaw_rate || rows[i + 1].time - rows[i - 1].time > 2 * kStep) {
      continue;
    }
    const double half = std::max(0.05, (rows[i + 1].time - rows[i - 1].time) / 4);
    const double time = rows[i].time - delay;
    if (const auto mean = means.between(time - half, time + half)) {
      const double a = *rows[i].yaw_rate;
      const double b = mean->rate.dot(up);
      n += 1, x += a, y += b, xx += a * a, yy += b * b, xy += a * b;
    }
  }
  if (n < static_cast<double>(kFewestIntervals)) {
    return {};
  }
  const double vx = xx / n - x / n * (x / n);
  const double vy = yy / n - y / n * (y / n);
  const double c = xy / n - x / n * (y / n);
  return {.correlation = vx * vy > 0 ? c / std::sqrt(vx * vy) : 0,
          .factor = vx > 0 ? c / vx : 0,
          .rms = std::sqrt(std::max(0.0, vx)),
          .count = static_cast<std::size_t>(n)};
}

Pairs accelerations(const std::vector<OdometerRow>& rows, const Means& means, const Vector3d& up,
                    const geometry::SO3& R_level_imu, double delay) {
  Pairs pairs;
  std::size_t from = 0;
  for (std::size_t to = 1; to < rows.size(); ++to) {
    const double step = rows[to].time - rows[from].time;
    if (step < kStep) {
      continue;
    }
    if (step < 2 * kStep) {
      if (const auto mean = means.between(rows[from].time - delay, rows[to].time - delay)) {
        const double along = (rows[to].speed - rows[from].speed) / step;
        const double across = (rows[to].speed + rows[from].speed) / 2 * mean->rate.dot(up);
        const Vector3d level = R_level_imu * mean->force;
        pairs.vehicle.emplace_back(along, across);
        pairs.level.emplace_back(level.x(), level.y());
      }
    }
    from = to;
  }
  if (!pairs.vehicle.empty()) {
    remove_mean(pairs.vehicle);
    remove_mean(pairs.level);
  }
  return pairs;
}

double rms(const std::vector<Complex>& values) {
  double sum = 0;
  for (const Complex& v : values) {
    sum += std::norm(v);
  }
  return values.empty() ? 0 : std::sqrt(sum / static_cast<double>(values.size()));
}

/// The mounting along the axes that is next to it, if one is near.
geometry::SO3 along_axes(const geometry::SO3& rotation) {
  geometry::SO3 best = rotation;
  double nearest = kToAxes;
  for (int roll = 0; roll < 4; ++roll) {
    for (int pitch = -1; pitch < 2; ++pitch) {
      for (int yaw = 0; yaw < 4; ++yaw) {
        const geometry::SO3 candidate =
            geometry::SO3::from_roll_pitch_yaw(Vector3d(roll, pitch, yaw) * (std::numbers::pi / 2));
        const double distance = (candidate.inverse() * rotation).log().norm();
        if (distance < nearest) {
          nearest = distance;
          best = candidate;
        }
      }
    }
  }
  return best;
}

/// Turned about the vertical by half a turn: an odometer that counts backwards looks the same.
bool is_reversed(const geometry::SO3& found, const geometry::SO3& assumed) {
  const geometry::SO3 half_turn = geometry::SO3::about_z(std::numbers::pi);
  return (half_turn * assumed * found.inverse()).log().norm() < kLargestSpread;
}

void examine_motion(const Stream& imu, const Stream& odometer, const Vector3d& up,
                    const geometry::SO3& assumed, MountingEvidence& result) {
  const Means means(imu.imu);
  const RateFit rates = fit_rates(odometer.odometer, means, up, 0);
  if (rates.count > 0 && rates.rms >= kLeastTurn) {
    result.rate_correlation = rates.correlation;
    result.rate_factor = rates.factor;
    if (std::abs(rates.correlation) >= kStrongRateCorrelation) {
      double best = std::abs(rates.correlation) + kClearGain;
      for (int i = -24; i <= 24; ++i) {
        const double delay = 0.02 * i;
        const double c = std::abs(fit_rates(odometer.odometer, means, up, delay).correlation);
        if (c > best) {
          best = c;
          result.odometer_delay = delay;
        }
      }
    }
  }
  const geometry::SO3 R_level_imu =
      geometry::SO3::from_quaternion(Eigen::Quaterniond::FromTwoVectors(up, Vector3d::UnitZ()));
  const Pairs pairs =
      accelerations(odometer.odometer, means, up, R_level_imu, result.odometer_delay.value_or(0));
  result.intervals = pairs.vehicle.size();
  if (result.intervals < kFewestIntervals || rms(pairs.vehicle) < kLeastAcceleration) {
    return;
  }
  const std::size_t half = result.intervals / 2;
  const YawFit whole = fit_yaw(pairs, 0, result.intervals);
  const YawFit first = fit_yaw(pairs, 0, half);
  const YawFit second = fit_yaw(pairs, half, result.intervals);
  result.acceleration_correlation = whole.correlation;
  result.yaw_spread = std::abs(std::remainder(first.yaw - second.yaw, 2 * std::numbers::pi));
  const bool agrees_with_turns =
      !result.rate_correlation || *result.rate_correlation >= kStrongRateCorrelation;
  if (whole.correlation < kStrongCorrelation || result.yaw_spread > kLargestSpread ||
      !agrees_with_turns) {
    return;
  }
  result.acceleration_is_clear = true;
  const geometry::SO3 found = along_axes(geometry::SO3::about_z(whole.yaw) * R_level_imu);
  if ((found.inverse() * assumed).log().norm() < kOtherMounting) {
    return;
  }
  result.R_body_imu = found;
  const Vector3d angles = found.roll_pitch_yaw() / kDegree;
  result.findings.push_back(formatted(
      "%s: the IMU seems to be mounted with roll %.0f, pitch %.0f, yaw %.0f degrees, which is "
      "not what was assumed. Evidence: accelerations of the odometer and the IMU in %zu "
      "intervals correlate by %.2f with it, and both halves of the recording agree within "
      "%.0f degrees. Set imu.rotation to these angles, or run with --apply-mounting%s.",
      imu.name.c_str(), angles.x(), angles.y(), angles.z(), result.intervals, whole.correlation,
      result.yaw_spread / kDegree,
      is_reversed(found, assumed)
          ? "; or, if the mounting is right, the odometer counts backwards: odometer.scale: -1"
          : ""));
}

void judge_rates(const Stream& imu, const Stream& odometer, MountingEvidence& result) {
  if (!result.rate_correlation || std::abs(*result.rate_correlation) < kStrongRateCorrelation) {
    return;
  }
  const double factor = result.rate_factor;
  if (factor < 0) {
    result.opposite_rates = formatted(
        "%s and %s turn in opposite directions (correlation %.2f): one of them has the wrong "
        "sign of its yaw rate, and nothing here tells which. Positive is to the left (REP 103). If "
        "it is that of %s, the trajectory is wrong.",
        imu.name.c_str(), odometer.name.c_str(), *result.rate_correlation, imu.name.c_str());
  } else if (factor > 30) {
    result.findings.push_back(formatted(
        "%s: angular_velocity is %.0f times that of %s: it seems to be in degrees per second "
        "and must be in rad/s.",
        imu.name.c_str(), factor, odometer.name.c_str()));
  } else if (factor < 0.7 || factor > 1.4) {
    result.findings.push_back(formatted(
        "%s: the odometer turns %.2f times as fast as the gyro of %s: its wheel separation "
        "seems to be set too %s. Its speed is used, its yaw rate is not.",
        odometer.name.c_str(), 1 / factor, imu.name.c_str(), factor > 1 ? "large" : "small"));
  }
}

}  // namespace

MountingEvidence examine_mounting(const Stream& imu, const Stream* odometer,
                                  const geometry::SO3& assumed) {
  MountingEvidence result;
  if (imu.imu.size() < 3) {
    return result;
  }
  const Vector3d force = median_force(imu.imu);
  result.mean_force = force.norm();
  if (std::abs(result.mean_force - kGravity) < 0.15 * kGravity) {
    result.gravity = Gravity::kMeasured;
  } else if (std::abs(result.mean_force - 1) < 0.1) {
    result.gravity = Gravity::kUnitG;
    result.findings.push_back(formatted(
        "%s: the mean specific force is %.2f: linear_acceleration seems to be in g instead of "
        "m/s^2. It is multiplied by 9.80665 (imu.specific_force_scale).",
        imu.name.c_str(), result.mean_force));
  } else if (result.mean_force < 0.2 * kGravity) {
    result.gravity = Gravity::kRemoved;
    result.findings.push_back(formatted(
        "%s: the mean specific force is only %.2f m/s^2: gravity has already been taken out of "
        "linear_acceleration by the driver. The estimator needs the raw readings, which are "
        "9.8 m/s^2 at rest; use the driver's raw topic.",
        imu.name.c_str(), result.mean_force));
  } else {
    result.findings.push_back(formatted(
        "%s: the mean specific force is %.2f m/s^2, neither gravity (9.8) nor in g (1): the "
        "accelerometer is not scaled to m/s^2 or is faulty.",
        imu.name.c_str(), result.mean_force));
  }
  if (result.gravity == Gravity::kRemoved || result.gravity == Gravity::kUnclear) {
    return result;
  }
  const Vector3d up = force.normalized();
  result.tilt = std::acos(std::clamp((assumed * up).z(), -1.0, 1.0));
  if (odometer != nullptr) {
    examine_motion(imu, *odometer, up, assumed, result);
    judge_rates(imu, *odometer, result);
  }
  if (result.tilt > 30 * kDegree && !result.R_body_imu) {
    result.findings.push_back(formatted(
        "%s: with the assumed mounting, gravity is %.0f degrees off the vertical: the IMU is "
        "mounted on its side or upside down, or its frame is wrong (its axis that points up is "
        "(%.2f, %.2f, %.2f)). Its yaw is not certain from the motion, so no mounting is "
        "proposed; set imu.rotation.",
        imu.name.c_str(), result.tilt / kDegree, up.x(), up.y(), up.z()));
  }
  return result;
}

}  // namespace pipescout::estimate
