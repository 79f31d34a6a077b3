// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "simulated_flight.hpp"

namespace pipescout::estimation {
namespace {

using Eigen::Vector3d;
using test::SimulatedFlight;

template <typename Integer>
Integer draw(Integer from, Integer to) {
  return *rc::gen::resize(rc::kNominalSize, rc::gen::inRange<Integer>(from, to));
}

NavState newest(const FixedLagSmoother& smoother) {
  return smoother.state(smoother.keyframes() - 1);
}

RC_GTEST_PROP(SmootherProperties, OrderOfArrivalBetweenUpdatesDoesNotMatter, ()) {
  constexpr int kKeyframes = 12;
  const SimulatedFlight flight(draw<std::uint64_t>(1, 100), kKeyframes);
  FixedLagSmoother in_order(test::flight_parameters());
  FixedLagSmoother shuffled(test::flight_parameters());
  in_order.initialise(0, flight.first, flight.first_covariance);
  shuffled.initialise(0, flight.first, flight.first_covariance);
  for (int k = 0; k < kKeyframes; ++k) {
    flight.feed(in_order, k, true, true, true);
    const auto i = static_cast<std::size_t>(k);
    const bool vision_first = draw(0, 2) == 1;
    if (vision_first) {
      shuffled.add(flight.vision[i]);
      shuffled.add(flight.gps[i]);
    }
    for (std::size_t s = k == 0 ? 0 : (i - 1) * 10; s < i * 10; ++s) {
      shuffled.add(flight.imu[s]);
    }
    if (!vision_first) {
      shuffled.add(flight.gps[i]);
      shuffled.add(flight.vision[i]);
    }
    if (k > 0) {
      shuffled.add(flight.odometry[i]);
    }
    shuffled.update(SimulatedFlight::time_of(k));
  }
  RC_ASSERT(newest(in_order).local(newest(shuffled)).norm() < 1e-6);
}

RC_GTEST_PROP(SmootherProperties, TheSameInputGivesTheSameBits, ()) {
  constexpr int kKeyframes = 10;
  const SimulatedFlight flight(draw<std::uint64_t>(1, 100), kKeyframes);
  const bool gps = draw(0, 2) == 1;
  std::vector<NavState> ends;
  for (int run = 0; run < 2; ++run) {
    FixedLagSmoother smoother(test::flight_parameters());
    smoother.initialise(0, flight.first, flight.first_covariance);
    for (int k = 0; k < kKeyframes; ++k) {
      flight.feed(smoother, k, gps, true, true);
    }
    ends.push_back(newest(smoother));
  }
  RC_ASSERT(ends[0].position == ends[1].position);
  RC_ASSERT(ends[0].R_map_body.quaternion().coeffs() == ends[1].R_map_body.quaternion().coeffs());
}

/// A number that may be anything.
double wild() {
  switch (draw(0, 8)) {
    case 0:
      return std::numeric_limits<double>::quiet_NaN();
    case 1:
      return std::numeric_limits<double>::infinity();
    case 2:
      return 0;
    case 3:
      return -1e-3 * draw(0, 10000);
    case 4:
      return std::ldexp(1.0, draw(-1000, 1000));
    default:
      return 1e-3 * draw(0, 10000);
  }
}

Vector3d wild_vector() {
  return {wild(), wild(), wild()};
}

template <int N>
Eigen::Matrix<double, N, N> wild_covariance() {
  Eigen::Matrix<double, N, N> c = Eigen::Matrix<double, N, N>::Zero();
  for (int i = 0; i < N; ++i) {
    c(i, i) = wild();
  }
  return c;
}

void add_wild(FixedLagSmoother& smoother, double now) {
  const double time = draw(0, 3) == 0 ? wild() : now - 0.01 * draw(-30, 200);
  const double later = time + 0.01 * draw(-5, 25);
  const geometry::SE3 pose(geometry::SO3::about_z(draw(0, 6)), Vector3d(draw(0, 100), 0, 0));
  switch (draw(0, 10)) {
    case 0:
      smoother.add(GpsMeasurement{time, wild_vector(), wild_covariance<3>()});
      break;
    case 1:
      smoother.add(HeadingMeasurement{time, wild(), wild()});
      break;
    case 2:
      smoother.add(VisualPoseMeasurement{time, pose, wild_covariance<6>()});
      break;
    case 3:
      smoother.add(
          WeldMeasurement{time, wild_vector(), Vector3d::UnitX(), wild(), wild(), wild_vector()});
      break;
    case 4:
      smoother.add(NonHolonomicMeasurement{time, wild(), wild()});
      break;
    case 5:
      smoother.add(ZeroVelocityMeasurement{time, wild()});
      break;
    case 6:
      smoother.add(OdometerMeasurement{time, later, wild(), wild(), wild()});
      break;
    case 7:
      smoother.add(RelativePoseMeasurement{time, later, pose, wild_covariance<6>()});
      break;
    case 8:
      smoother.add(CentreLineMeasurement{time, wild_vector(), Vector3d::UnitY(), wild()});
      break;
    default:
      smoother.add(ImuSample{time, 0.01 * draw(0, 20), wild_vector(), wild_vector()});
  }
}

RC_GTEST_PROP(SmootherProperties, NoInputThrowsOrLeavesAnEstimateThatIsNotFinite, ()) {
  FixedLagSmootherParameters parameters = test::flight_parameters();
  if (draw(0, 2) == 1) {
    parameters.robustness = FixedLagSmootherParameters::default_robustness();
  }
  if (draw(0, 2) == 1) {
    parameters.global_deviations = {.odometer_scale = 0.1,
                                    .mount_yaw = 0.1,
                                    .mount_pitch = 0.1,
                                    .rack_position = 1,
                                    .rack_rotation = 0.1,
                                    .gps_lever_arm = 1};
  }
  parameters.lag = 0.5;
  FixedLagSmoother smoother(parameters);
  smoother.initialise(0, {}, StateMatrix::Identity());
  double now = 0;
  for (int k = 0; k < 20; ++k) {
    for (int i = draw(0, 6); i > 0; --i) {
      add_wild(smoother, now);
    }
    now += 0.01 * draw(0, 20);
    const UpdateReport& report = smoother.update(now);
    RC_ASSERT(report.initialised == smoother.initialised());
    if (!smoother.initialised()) {
      RC_ASSERT(report.reset == ResetReason::kNumericalFailure);
      smoother.initialise(now, {}, StateMatrix::Identity());
    }
    for (std::size_t i = 0; i < smoother.keyframes(); ++i) {
      RC_ASSERT(smoother.state(i).is_finite());
    }
    RC_ASSERT(smoother.globals().is_finite());
  }
}

RC_GTEST_PROP(SmootherProperties, AnEstimateMovesWithTheMap, ()) {
  // All measurements shifted and turned about the vertical: so are the estimates.
  constexpr int kKeyframes = 15;
  const SimulatedFlight flight(draw<std::uint64_t>(1, 100), kKeyframes);
  const geometry::SO3 turn = geometry::SO3::about_z(0.01 * draw(-300, 300));
  const Vector3d shift(draw(-100, 100), draw(-100, 100), draw(-10, 10));
  FixedLagSmootherParameters parameters = test::flight_parameters();
  FixedLagSmoother here(parameters);
  parameters.globals.rack_position = shift;
  parameters.globals.R_map_rack = turn;
  FixedLagSmoother there(parameters);
  const auto moved = [&](NavState x) {
    x.position = turn * x.position + shift;
    x.velocity = turn * x.velocity;
    x.R_map_body = turn * x.R_map_body;
    return x;
  };
  // The same deviation along all axes of the map.
  here.initialise(0, flight.first, flight.first_covariance);
  there.initialise(0, moved(flight.first), flight.first_covariance);
  for (int k = 0; k < kKeyframes; ++k) {
    GpsMeasurement gps = flight.gps[static_cast<std::size_t>(k)];
    here.add(gps);
    gps.position = turn * gps.position + shift;
    there.add(gps);
    flight.feed(here, k, false, true, true);
    flight.feed(there, k, false, true, true);
  }
  RC_ASSERT(newest(there).local(moved(newest(here))).norm() < 1e-5);
}

}  // namespace
}  // namespace pipescout::estimation
