// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "doctor/checks.hpp"

namespace pipescout::host::doctor {
namespace {

constexpr double kStandardGravity = 9.80665;  // m/s^2, ISO 80000-3
// Gravity on the ground is 9.764 to 9.834 m/s^2 (Hirt and others, 2013); the rest is the bias of a
// cheap accelerometer.
constexpr double kGravityTolerance = 0.4;  // m/s^2
constexpr double kNoGravity = 2.0;         // m/s^2: a robot does not fall so long
constexpr double kTurning = 0.2;           // rad/s: no longer at rest
constexpr double kShaking = 0.5;           // m/s^2, deviation of |a| at rest with engines on
constexpr double kUpright = 0.5;           // rad
constexpr double kStampTolerance = 0.5;    // s
constexpr double kNearDatum = 100e3;       // m: a local map says nothing so far away
constexpr double kEarthRadius = 6371e3;    // m, mean

std::string number(double value, const char* format = "%.2f") {
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), format, value);
  return text.data();
}

double norm(const Vector& vector) {
  // std::hypot of three takes a NaN for 0 here and there.
  return std::sqrt(vector[0] * vector[0] + vector[1] * vector[1] + vector[2] * vector[2]);
}

Vector mean(const std::vector<Vector>& vectors) {
  Vector sum{};
  for (const auto& vector : vectors) {
    for (std::size_t i = 0; i < 3; ++i) {
      sum[i] += vector[i] / static_cast<double>(vectors.size());
    }
  }
  return sum;
}

/// Neither turns nor shakes.
bool is_at_rest(const ImuSample& imu) {
  const auto [least, most] =
      std::minmax_element(imu.specific_force.begin(), imu.specific_force.end(),
                          [](const Vector& a, const Vector& b) { return norm(a) < norm(b); });
  return norm(*most) - norm(*least) < kShaking &&
         std::none_of(imu.angular_velocity.begin(), imu.angular_velocity.end(),
                      [](const Vector& rate) { return norm(rate) > kTurning; });
}

void check_gravity(const std::string& topic, const ImuSample& imu, std::vector<Finding>& findings) {
  const auto force = mean(imu.specific_force);
  const double size = norm(force);
  if (size == 0.0) {
    findings.push_back({Severity::kError, "The accelerometer on " + topic + " says exactly 0.",
                        "Look at its cable and driver: it measures nothing."});
  } else if (std::abs(size - 1.0) < kGravityTolerance / kStandardGravity) {
    findings.push_back(
        {Severity::kError,
         "The IMU on " + topic + " measures in g: |a| at rest is " + number(size) + ".",
         "Let its driver send m/s^2, or set imu.specific_force_scale to 9.80665."});
  } else if (size < kNoGravity) {
    findings.push_back({Severity::kError,
                        "Gravity is taken out of the IMU on " + topic + ": |a| at rest is " +
                            number(size) + " m/s^2.",
                        "Let its driver publish the raw acceleration (linear_acceleration with "
                        "gravity), which estimators need."});
  } else if (std::abs(size - kStandardGravity) > kGravityTolerance) {
    findings.push_back({Severity::kWarning,
                        "|a| at rest on " + topic + " is " + number(size) + " m/s^2, not 9.81.",
                        "Calibrate the accelerometer, or look at the scale in its driver."});
  } else if (imu.frame == "base_link" &&
             std::acos(std::clamp(force[2] / size, -1.0, 1.0)) > kUpright) {
    findings.push_back({Severity::kError,
                        "The IMU on " + topic +
                            " says that it is in base_link, but its z axis is " +
                            number(std::acos(force[2] / size) * 180.0 / std::numbers::pi, "%.0f") +
                            " degrees from upright.",
                        "Put the robot level; if it is, name the IMU's own frame in its driver and "
                        "describe its mounting (imu.roll_pitch_yaw)."});
  }
}

double distance(double latitude_1, double longitude_1, double latitude_2, double longitude_2) {
  constexpr double kRadians = std::numbers::pi / 180.0;
  const double north = std::sin((latitude_2 - latitude_1) * kRadians / 2);
  const double east = std::sin((longitude_2 - longitude_1) * kRadians / 2);
  const double chord = north * north + std::cos(latitude_1 * kRadians) *
                                           std::cos(latitude_2 * kRadians) * east * east;
  return 2 * kEarthRadius * std::asin(std::sqrt(std::min(1.0, chord)));
}

}  // namespace

std::vector<Finding> check_stamps(const Observation& seen) {
  std::vector<Finding> findings;
  if (seen.simulated_time) {
    return findings;  // stamps are of another clock
  }
  for (const auto& [topic, age] : seen.stamp_age) {
    if (!(std::abs(age) <= kStampTolerance)) {
      findings.push_back({Severity::kWarning,
                          "The stamps on " + topic + " are " + number(std::abs(age)) + " s " +
                              (age < 0 ? "ahead of" : "behind") + " the clock of this machine.",
                          "Synchronise the clocks of the machines (chrony, PTP), or set the time "
                          "source of the sensor's driver."});
    }
  }
  return findings;
}

std::vector<Finding> check_imu(const Observation& seen) {
  std::vector<Finding> findings;
  for (const auto& [topic, imu] : seen.imus) {
    if (imu.frame.empty()) {
      findings.push_back({Severity::kError, "The IMU on " + topic + " does not say its frame.",
                          "Set the frame_id of its driver."});
    }
    const auto& forces = imu.specific_force;
    const bool numbers = std::all_of(forces.begin(), forces.end(), [](const Vector& force) {
      return std::isfinite(norm(force));
    });
    if (!numbers) {
      findings.push_back({Severity::kError,
                          "The IMU on " + topic + " sends values that are no numbers.",
                          "Look at its driver."});
    } else if (!forces.empty() && is_at_rest(imu)) {
      check_gravity(topic, imu, findings);
    }
  }
  return findings;
}

std::vector<Finding> check_gps(const Observation& seen) {
  std::vector<Finding> findings;
  for (const auto& [topic, fix] : seen.fixes) {
    if (!fix.has_fix) {
      findings.push_back({Severity::kWarning, "The receiver on " + topic + " has no fix.",
                          "Give it sight of the sky, and time."});
      continue;
    }
    if (fix.latitude == 0.0 && fix.longitude == 0.0) {
      findings.push_back({Severity::kError, "The fixes on " + topic + " are at 0, 0.",
                          "Look at the driver: it says that it has a fix without a position."});
    }
    const std::array<double, 3> variances{fix.covariance[0], fix.covariance[4], fix.covariance[8]};
    const bool positive = std::all_of(variances.begin(), variances.end(), [](double variance) {
      return std::isfinite(variance) && variance > 0.0;
    });
    if (fix.covariance_type == 0) {
      findings.push_back(
          {Severity::kWarning, "The fixes on " + topic + " do not say how good they are.",
           "Let the driver fill in the covariance; gps.deviation is used for them."});
    } else if (!positive) {
      findings.push_back({Severity::kWarning,
                          "The covariance of the fixes on " + topic +
                              " is said to be known, but is zero, negative or no number.",
                          "Let the driver fill in the covariance, or say that it is unknown."});
    }
  }
  return findings;
}

std::vector<Finding> check_datum(const Observation& seen) {
  std::vector<Finding> findings;
  for (const auto& [node, datum] : seen.datums) {
    if (datum.empty()) {
      continue;  // where the first fixes agree
    }
    if (datum.size() != 3) {
      findings.push_back({Severity::kError,
                          "The datum of " + node.fully_qualified() + " has " +
                              std::to_string(datum.size()) + " values.",
                          "Give it latitude and longitude in degrees and altitude in m."});
      continue;
    }
    for (const auto& [topic, fix] : seen.fixes) {
      const double away =
          fix.has_fix ? distance(datum[0], datum[1], fix.latitude, fix.longitude) : 0.0;
      if (away > kNearDatum) {
        findings.push_back({Severity::kError,
                            "The datum of " + node.fully_qualified() + " is " +
                                number(away / 1000, "%.0f") + " km from the fixes on " + topic +
                                ".",
                            "Set datum to a place on the site, or leave it empty."});
      }
    }
  }
  return findings;
}

}  // namespace pipescout::host::doctor
