// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "heap_guard.hpp"
#include "simulated_flight.hpp"

namespace pipescout::estimation {
namespace {

TEST(SmootherHeapTest, NothingIsAllocatedAfterConstruction) {
  constexpr int kKeyframes = 60;
  const test::SimulatedFlight flight(1, kKeyframes);
  FixedLagSmootherParameters parameters = test::flight_parameters();
  parameters.robustness = FixedLagSmootherParameters::default_robustness();
  for (Robustness& one : parameters.robustness) {
    one.kernel = statistics::RobustKernel::kCauchy;
  }
  parameters.global_deviations = {.odometer_scale = 0.1,
                                  .mount_yaw = 0.1,
                                  .mount_pitch = 0.1,
                                  .rack_position = 0.1,
                                  .rack_rotation = 0.1,
                                  .gps_lever_arm = 0.1,
                                  .gps_time_offset = 0.1,
                                  .gyro_scale = 0.01,
                                  .gyro_misalignment = 0.01,
                                  .accelerometer_scale = 0.01,
                                  .accelerometer_misalignment = 0.01};
  FixedLagSmoother smoother(parameters);
  std::vector<FactorReport> reports;
  reports.reserve(1000);

  const pipescout::test::HeapGuard guard;
  smoother.initialise(0, flight.first, flight.first_covariance);
  for (int k = 0; k < kKeyframes; ++k) {
    const double time = test::SimulatedFlight::time_of(k);
    smoother.add(NonHolonomicMeasurement{time - 0.03, 5, 5});
    smoother.add(HeadingMeasurement{time, 0, 3});
    smoother.add(GpsMeasurement{time - 0.05, Eigen::Vector3d(1e3, 0, 0),  // gated
                                Eigen::Matrix3d::Identity()});
    flight.feed(smoother, k, true, true, true);
    EXPECT_TRUE(smoother.covariance(0).allFinite());
    EXPECT_TRUE(smoother.global_covariance().allFinite());
    EXPECT_TRUE(smoother.propagated());
    smoother.report_factors(reports);
  }
  smoother.update(100);  // resets
  smoother.initialise(0, flight.first, flight.first_covariance);
  EXPECT_EQ(guard.allocations(), 0U);
}

}  // namespace
}  // namespace pipescout::estimation
