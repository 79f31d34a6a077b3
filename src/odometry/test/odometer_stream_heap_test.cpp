// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "heap_guard.hpp"
#include "odometer_bench.hpp"
#include "pipescout/odometry/odometer_stream.hpp"

namespace pipescout::odometry {
namespace {

TEST(OdometerStreamHeap, NothingIsAllocatedAfterConstruction) {
  for (const std::size_t m : {2U, 3U, 16U}) {
    for (const auto source : {SigmaSource::kGiven, SigmaSource::kResiduals}) {
      auto parameters = test::fine_odometers(m);
      parameters.sigma_source = source;
      OdometerStream stream(parameters);
      std::mt19937_64 engine(1);
      std::uniform_real_distribution<double> uniform(0.0, 1.0);
      const pipescout::test::HeapGuard guard;
      for (int k = 0; k < 20000; ++k) {
        const double time = 0.02 * k + (k > 15000 ? 1000.0 : 0.0);  // all fall silent once
        for (std::size_t i = 0; i < m; ++i) {
          const double slip = i == 0 && k % 5000 > 3000 ? 5.0 : 0.0;
          const double wrong = uniform(engine);
          stream.push({.odometer = i,
                       .time = wrong < 0.01 ? time - 0.5 : time,
                       .value = wrong > 0.99 ? std::nan("") : 0.01 * k - slip});
        }
        if (k % 4000 == 3999) {
          stream.end_segment();
          stream.set_correction(0, {.scale = 1.001});
        }
      }
      stream.flush();
      EXPECT_EQ(guard.allocations(), 0U) << m;
      EXPECT_EQ(stream.state().leaps, 1U);
    }
  }
}

}  // namespace
}  // namespace pipescout::odometry
