// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "odometer_bench.hpp"
#include "pipescout/odometry/odometer_stream.hpp"

namespace pipescout::odometry {
namespace {

using test::fine_odometers;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// Anything at all, in any order: the state stays finite and the variance no less than nothing.
RC_GTEST_PROP(OdometerStreamProperty, SurvivesEveryInput, ()) {
  const auto m = *rc::gen::inRange<std::size_t>(2, 6);
  auto parameters = fine_odometers(m);
  for (auto& odometer : parameters.odometers) {
    odometer.kind = *rc::gen::element(OdometerKind::kAbsolute, OdometerKind::kIncrement);
    odometer.wrap = *rc::gen::element(0.0, 4.096);
    odometer.period = *rc::gen::element(0.0, 0.05);
  }
  parameters.lookback_windows = *rc::gen::inRange<std::size_t>(0, 17);
  parameters.sigma_source = *rc::gen::element(SigmaSource::kGiven, SigmaSource::kResiduals);
  OdometerStream stream(parameters);
  const auto steps =
      *rc::gen::resize(2000, rc::gen::container<std::vector<std::pair<int, int>>>(rc::gen::pair(
                                 rc::gen::inRange(0, 1000), rc::gen::inRange(0, 1000))));
  double time = 0.0;
  double distance = 0.0;
  for (const auto& [a, b] : steps) {
    time += 0.02 * (a % 7);
    distance += 0.01 * (b % 11 - 3);
    OdometerSample sample{.odometer = static_cast<std::size_t>(a) % (m + 1),
                          .time = time,
                          .value = distance,
                          .valid = b % 50 != 0};
    sample.time = a % 41 == 0 ? time + 1e5 * (b - 500) : a % 43 == 0 ? kNaN : sample.time;
    sample.value = b % 37 == 0 ? 1e300 * (a - 500) : b % 31 == 0 ? kNaN : sample.value;
    if (a == 999) {
      stream.end_segment();
    } else if (b == 999) {
      stream.flush();
    }
    stream.push(sample);
    const auto& state = stream.state();
    RC_ASSERT(std::isfinite(state.distance));
    RC_ASSERT(state.variance >= 0.0 && std::isfinite(state.variance));
    RC_ASSERT(state.random_variance <= state.variance * (1.0 + 1e-12));
  }
}

}  // namespace
}  // namespace pipescout::odometry
