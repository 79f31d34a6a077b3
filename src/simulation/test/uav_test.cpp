// SPDX-License-Identifier: Apache-2.0
#include "pipescout/simulation/uav.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>

namespace pipescout::simulation {
namespace {

using Eigen::Vector3d;

const Vector3d kStart(1, 5, 3);
const Vector3d kNoWind = Vector3d::Zero();

/// Knows its velocity exactly, so that closed forms hold.
UavParameters exact() {
  return {.velocity_error = 0};
}

void fly(Uav& uav, double duration, const UavCommand& command, const WindSample& wind = {}) {
  const int steps = static_cast<int>(std::lround(duration / Uav::kStep));
  for (int i = 0; i < steps; ++i) {
    uav.command(command);
    uav.step(wind);
  }
}

double tilt(const UavState& state) {
  return std::acos(std::min(1.0, (state.T_rack_body.rotation() * Vector3d::UnitZ()).z()));
}

double yaw(const UavState& state) {
  return state.T_rack_body.rotation().roll_pitch_yaw().z();
}

TEST(Uav, HoversInStillAirWithoutMoving) {
  Uav uav(exact(), kStart, 0.7, kNoWind, 1);
  fly(uav, 20, {});
  EXPECT_LT((uav.state().T_rack_body.translation() - kStart).norm(), 1e-9);
  EXPECT_LT(tilt(uav.state()), 1e-7);
  EXPECT_NEAR(yaw(uav.state()), 0.7, 1e-12);
  EXPECT_NEAR(uav.state().time, 20, 1e-9);
  EXPECT_LT((uav.state().specific_force - Vector3d(0, 0, kGravity)).norm(), 1e-9);
}

TEST(Uav, LeansAgainstASteadyWindFromTheStart) {
  const Vector3d wind(6, -2, 0);
  Uav uav(exact(), kStart, 1, wind, 1);
  const UavParameters parameters = exact();
  const double drag =
      (parameters.linear_drag + parameters.quadratic_drag * wind.norm()) * wind.norm();
  const double expected = std::atan(drag / kGravity);
  EXPECT_NEAR(tilt(uav.state()), expected, 1e-9);
  fly(uav, 10, {}, {.velocity = wind});
  EXPECT_NEAR(tilt(uav.state()), expected, 1e-9);
  EXPECT_NEAR(yaw(uav.state()), 1, 1e-9);
  EXPECT_LT((uav.state().T_rack_body.translation() - kStart).norm(), 1e-9);
  // It leans into the wind.
  EXPECT_LT((uav.state().T_rack_body.rotation() * Vector3d::UnitZ()).dot(wind), 0);
}

TEST(Uav, IsDisplacedByAWindThatItDidNotExpectAndThenStands) {
  const Vector3d wind(0, 5, 0);
  Uav uav(exact(), kStart, 0, kNoWind, 1);
  fly(uav, 10, {}, {.velocity = wind});
  const double drag = (0.2 + 0.01 * 5) * 5;
  EXPECT_NEAR(tilt(uav.state()), std::atan(drag / kGravity), 1e-6);
  EXPECT_LT(uav.state().velocity.norm(), 1e-6);
  const Vector3d displacement = uav.state().T_rack_body.translation() - kStart;
  EXPECT_GT(displacement.y(), 0.01);
  EXPECT_LT(displacement.norm(), 0.2);
}

TEST(Uav, WithoutTheAccelerometerDriftsAsTheVelocityLoopLets) {
  // Steady state: velocity_gain v = drag of the air; linear alone: gain v = linear (w - v).
  UavParameters parameters = exact();
  parameters.gust_bandwidth = 0;
  parameters.quadratic_drag = 0;
  Uav uav(parameters, kStart, 0, kNoWind, 1);
  fly(uav, 20, {}, {.velocity = {4, 0, 0}});
  const double expected =
      4 * parameters.linear_drag / (parameters.linear_drag + parameters.velocity_gain);
  EXPECT_LT((uav.state().velocity - Vector3d(expected, 0, 0)).norm(), 1e-6);
}

TEST(Uav, ClimbsAsAFirstOrderSystem) {
  UavParameters parameters = exact();
  parameters.linear_drag = 0;
  parameters.quadratic_drag = 0;
  Uav uav(parameters, kStart, 0, kNoWind, 1);
  for (int n = 1; n <= 2000; ++n) {
    uav.command({.velocity = {0, 0, 0.5}});
    uav.step({});
    // The autopilot acts once a step: v_n = v (1 - (1 - gain step)^n).
    const double expected = 0.5 * (1 - std::pow(1 - parameters.velocity_gain * Uav::kStep, n));
    ASSERT_NEAR(uav.state().velocity.z(), expected, 1e-9) << n;
  }
  EXPECT_LT(uav.state().velocity.head<2>().norm(), 1e-9);
}

TEST(Uav, TurnsAsASecondOrderSystem) {
  UavParameters parameters = exact();
  parameters.rotational_drag = 0;
  parameters.attitude_damping = 0.6;
  Uav uav(parameters, kStart, 0.2, kNoWind, 1);
  const double rate = 0.5;
  const double omega = parameters.attitude_frequency;
  const double damped = omega * std::sqrt(1 - 0.6 * 0.6);
  for (int n = 1; n <= 1000; ++n) {
    uav.command({.yaw_rate = rate});
    uav.step({});
    const double t = n * Uav::kStep;
    // e'' + 2 zeta omega e' + omega^2 e = 0 of the lag e behind the commanded yaw, e'(0) = rate.
    const double lag = rate / damped * std::exp(-0.6 * omega * t) * std::sin(damped * t);
    // The commanded yaw is held for a step, which is ahead by half of one at most.
    ASSERT_NEAR(yaw(uav.state()), 0.2 + rate * t - lag, rate * Uav::kStep) << t;
  }
  EXPECT_NEAR(uav.state().angular_rate.z(), rate, 1e-3);
}

TEST(Uav, FollowsVelocityCommandsInItsHeadingFrame) {
  for (const double heading : {0.0, std::numbers::pi / 2, -2.5}) {
    Uav uav(exact(), kStart, heading, kNoWind, 1);
    double fastest = 0;
    for (int i = 0; i < 5; ++i) {
      fly(uav, 0.5, {.velocity = {0.4, 0.3, 0}});
      fastest = std::max(fastest, uav.state().velocity.norm());
    }
    const Vector3d expected(0.4 * std::cos(heading) - 0.3 * std::sin(heading),
                            0.4 * std::sin(heading) + 0.3 * std::cos(heading), 0);
    EXPECT_LT((uav.state().velocity - expected).norm(), 0.005) << heading;
    EXPECT_LT(fastest, 0.5 * 1.1) << heading;
  }
}

TEST(Uav, StopsWhenNoCommandComesAnyMore) {
  Uav uav(exact(), kStart, 0, kNoWind, 1);
  fly(uav, 3, {.velocity = {0.5, 0, 0}, .yaw_rate = 0.2});
  for (int i = 0; i < 900; ++i) {
    uav.step({});
  }
  EXPECT_GT(uav.state().velocity.norm(), 0.45);
  for (int i = 0; i < 4000; ++i) {
    uav.step({});
  }
  EXPECT_LT(uav.state().velocity.norm(), 0.005);
  EXPECT_LT(uav.state().angular_rate.norm(), 0.005);
}

TEST(Uav, CutsCommandsAndTilt) {
  UavParameters parameters = exact();
  parameters.largest_speed = 2;
  parameters.largest_tilt = 0.2;
  parameters.largest_yaw_rate = 0.3;
  Uav uav(parameters, kStart, 0, kNoWind, 1);
  double largest_tilt = 0;
  for (int i = 0; i < 10000; ++i) {
    uav.command({.velocity = {300, 400, 0}, .yaw_rate = -7});
    uav.step({});
    largest_tilt = std::max(largest_tilt, tilt(uav.state()));
  }
  EXPECT_NEAR(uav.state().velocity.norm(), 2, 0.05);
  EXPECT_NEAR(uav.state().angular_rate.z(), -0.3, 0.01);
  // A damping ratio of 0.9 overshoots by 0.2 %.
  EXPECT_GT(largest_tilt, 0.19);
  EXPECT_LT(largest_tilt, 0.2 * 1.01);
}

TEST(Uav, CountsAndIgnoresCommandsThatAreNotFinite) {
  Uav uav(exact(), kStart, 0, kNoWind, 1);
  fly(uav, 2, {.velocity = {0.5, 0, 0}});
  uav.command({.velocity = {std::numeric_limits<double>::quiet_NaN(), 0, 0}});
  uav.command({.yaw_rate = std::numeric_limits<double>::infinity()});
  EXPECT_EQ(uav.bad_commands(), 2U);
  for (int i = 0; i < 500; ++i) {
    uav.step({});
  }
  EXPECT_NEAR(uav.state().velocity.x(), 0.5, 0.01);
}

TEST(Uav, ItsTruthIsOneMotion) {
  DrydenWind wind({.speed_at_20_feet = 8, .period = Uav::kStep}, 4);
  Uav uav({}, kStart, 0.4, {wind.model().mean_speed, 0, 0}, 4);
  UavState before = uav.state();
  for (int i = 0; i < 5000; ++i) {
    uav.command({.velocity = {0.5 * std::sin(i * 2e-3), 0.3, 0.1}, .yaw_rate = 0.2});
    uav.step(wind.next());
    const UavState& now = uav.state();
    // Specific force and acceleration are the same thing in two frames, and gravity.
    const Vector3d accelerometer =
        now.T_rack_body.rotation() * now.specific_force - Vector3d(0, 0, kGravity);
    ASSERT_LT((accelerometer - now.acceleration).norm(), 1e-9);
    const Vector3d moved = now.T_rack_body.translation() - before.T_rack_body.translation();
    ASSERT_LT((moved / Uav::kStep - (now.velocity + before.velocity) / 2).norm(), 1e-5);
    ASSERT_LT(((now.velocity - before.velocity) / Uav::kStep - now.acceleration).norm(), 0.05);
    const Vector3d turned =
        (before.T_rack_body.rotation().inverse() * now.T_rack_body.rotation()).log();
    ASSERT_LT((turned / Uav::kStep - (now.angular_rate + before.angular_rate) / 2).norm(), 1e-4);
    before = now;
  }
}

TEST(Uav, GainsTheEnergyThatRotorsAndAirPutIn) {
  DrydenWind wind({.speed_at_20_feet = 8, .period = Uav::kStep}, 9);
  Uav uav({}, kStart, 0, {wind.model().mean_speed, 0, 0}, 9);
  double work = 0;
  double power_before = 0;
  for (int i = 0; i < 10000; ++i) {
    uav.command({.velocity = {0.3, 0, i < 5000 ? 0.4 : -0.2}});
    uav.step(wind.next());
    const UavState& now = uav.state();
    const double power = (now.T_rack_body.rotation() * now.specific_force).dot(now.velocity);
    work += (power + power_before) / 2 * Uav::kStep;
    power_before = power;
  }
  const UavState& end = uav.state();
  const double energy =
      end.velocity.squaredNorm() / 2 + kGravity * (end.T_rack_body.translation().z() - kStart.z());
  EXPECT_GT(energy, 5);
  EXPECT_NEAR(work, energy, 0.01);
}

TEST(Uav, StaysNearByInGusts) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    DrydenWind wind({.speed_at_20_feet = 7.7, .direction = static_cast<double>(seed)}, seed);
    const Vector3d mean(wind.model().mean_speed * std::cos(seed),
                        wind.model().mean_speed * std::sin(seed), 0);
    Uav uav({}, kStart, 0, mean, seed);
    double squares = 0;
    double largest_tilt = 0;
    double smallest_tilt = 1;
    WindSample sample;
    for (int i = 0; i < 60000; ++i) {
      if (i % 10 == 0) {
        sample = wind.next();
      }
      uav.step(sample);
      squares += uav.state().velocity.squaredNorm() / 60000;
      largest_tilt = std::max(largest_tilt, tilt(uav.state()));
      smallest_tilt = std::min(smallest_tilt, tilt(uav.state()));
    }
    // Gusts of 1.5 m/s move it, but not by much, and turn it by some degrees; it does
    // not come to the limit of what it can lean against.
    EXPECT_GT(std::sqrt(squares), 0.01) << seed;
    EXPECT_LT(std::sqrt(squares), 0.1) << seed;
    EXPECT_GT(largest_tilt - smallest_tilt, 0.03) << seed;
    EXPECT_LT(largest_tilt, uav.parameters().largest_tilt) << seed;
  }
}

TEST(Uav, IsTheSameForTheSameSeed) {
  Uav first({}, kStart, 0, kNoWind, 3);
  Uav second({}, kStart, 0, kNoWind, 3);
  Uav other({}, kStart, 0, kNoWind, 4);
  const UavCommand command{.velocity = {0.2, 0.1, 0}, .yaw_rate = 0.1};
  fly(first, 3, command);
  fly(second, 3, command);
  fly(other, 3, command);
  EXPECT_EQ(first.state().T_rack_body.matrix(), second.state().T_rack_body.matrix());
  EXPECT_EQ(first.state().angular_rate, second.state().angular_rate);
  EXPECT_NE(first.state().T_rack_body.matrix(), other.state().T_rack_body.matrix());
}

TEST(Uav, RejectsParametersOutOfRange) {
  const auto message = [](const UavParameters& parameters) -> std::string {
    try {
      const Uav uav(parameters, kStart, 0, kNoWind, 1);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  using testing::HasSubstr;
  EXPECT_EQ(message({}), "");
  EXPECT_THAT(message({.linear_drag = -0.1}), HasSubstr("linear_drag: -0.1"));
  EXPECT_THAT(message({.quadratic_drag = 11}), HasSubstr("quadratic_drag: 11"));
  EXPECT_THAT(message({.rotational_drag = -1}), HasSubstr("rotational_drag"));
  EXPECT_THAT(message({.largest_tilt = 0}), HasSubstr("largest_tilt: 0"));
  EXPECT_THAT(message({.largest_thrust = 9}), HasSubstr("largest_thrust: 9"));
  EXPECT_THAT(message({.velocity_gain = 0}), HasSubstr("velocity_gain"));
  EXPECT_THAT(message({.gust_bandwidth = 51}), HasSubstr("gust_bandwidth"));
  EXPECT_THAT(message({.attitude_frequency = 0}), HasSubstr("attitude_frequency"));
  EXPECT_THAT(message({.attitude_damping = std::nan("")}), HasSubstr("attitude_damping"));
  EXPECT_THAT(message({.largest_speed = 0}), HasSubstr("largest_speed"));
  EXPECT_THAT(message({.largest_yaw_rate = 7}), HasSubstr("largest_yaw_rate"));
  EXPECT_THAT(message({.command_time_out = 0}), HasSubstr("command_time_out"));
  EXPECT_THAT(message({.velocity_error = 2}), HasSubstr("velocity_error"));
  EXPECT_THAT(message({.velocity_error_time = 0}), HasSubstr("velocity_error_time"));
  EXPECT_THROW(Uav({}, {0, 0, std::nan("")}, 0, kNoWind, 1), std::invalid_argument);
  EXPECT_THROW(Uav({}, kStart, 0, {40, 0, 0}, 1), std::invalid_argument);
}

}  // namespace
}  // namespace pipescout::simulation
