// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "heap_guard.hpp"
#include "simulated_vehicle.hpp"

namespace pipescout::estimation {
namespace {

TEST(StateEstimatorHeapTest, NothingIsAllocatedAfterConstruction) {
  test::VehicleOptions options;
  options.duration = 60;
  options.compass = true;
  options.vision = true;
  const test::SimulatedVehicle vehicle(1, options);
  StateEstimatorParameters parameters = StateEstimatorParameters::ground_robot();
  parameters.centre_line.emplace(
      std::vector<Eigen::Vector3d>{vehicle.truth(0).position, vehicle.truth(60).position});
  StateEstimator estimator(parameters);
  std::size_t updates = 0;
  const pipescout::test::HeapGuard guard;
  for (const test::Message& message : vehicle.messages()) {
    const bool gap = message.arrival > 20 && message.arrival < 40;
    const bool imu = std::holds_alternative<ImuReading>(message.content);
    const bool gps = std::holds_alternative<GpsMeasurement>(message.content);
    if ((gap && gps) || (imu && message.arrival > 50 && message.arrival < 52)) {
      continue;
    }
    test::deliver(estimator, message.content);
    if (estimator.updates() != updates) {
      updates = estimator.updates();
      EXPECT_TRUE(estimator.estimate());
      EXPECT_TRUE(estimator.covariance().allFinite());
    }
  }
  EXPECT_EQ(guard.allocations(), 0U);
  EXPECT_GT(updates, 500U);
  EXPECT_TRUE(estimator.estimate()->in_map);
}

}  // namespace
}  // namespace pipescout::estimation
