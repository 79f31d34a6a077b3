// SPDX-License-Identifier: Apache-2.0
// Positions that are not as stated, judged by where they go on and not by how sure the state is.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>

#include "simulated_vehicle.hpp"

namespace pipescout::estimation {
namespace {

using Eigen::Vector3d;
using test::AnyMessage;
using test::SimulatedVehicle;
using test::VehicleOptions;

/// Errors of a receiver without corrections: first-order Gauss-Markov.
class LastingErrors {
 public:
  LastingErrors(std::uint64_t seed, double deviation, double correlation_time)
      : deviation_(deviation), correlation_time_(correlation_time), engine_(seed) {}

  Vector3d at(double time) {
    const double kept = std::exp((time_ - time) / correlation_time_);
    time_ = time;
    for (double& axis : error_) {
      axis = kept * axis + std::sqrt(1 - kept * kept) * deviation_ * normal_(engine_);
    }
    return error_;
  }

 private:
  double deviation_;
  double correlation_time_;
  std::mt19937_64 engine_;
  std::normal_distribution<double> normal_{};
  double time_ = -1e6;
  Vector3d error_ = Vector3d::Zero();
};

struct Outcomes {
  double longest_refusal = 0;  // s, between accepted positions
  double largest_error = 0;    // m
};

/// Drives with `spoil` over each position, and looks from `from` on.
template <class Spoil>
Outcomes drive(const SimulatedVehicle& vehicle, const StateEstimatorParameters& parameters,
               double from, Spoil&& spoil) {
  StateEstimator estimator(parameters);
  Outcomes outcomes;
  test::deliver(
      estimator, vehicle, 0, vehicle.options().duration,
      [&](AnyMessage& message) {
        if (auto* const gps = std::get_if<GpsMeasurement>(&message)) {
          spoil(*gps);
        }
        return true;
      },
      [&](const Estimate& estimate) {
        if (estimate.time < from || !estimate.in_map) {
          return;
        }
        outcomes.longest_refusal =
            std::max(outcomes.longest_refusal,
                     estimate.time - estimator.status().of(Source::kGps).last_accepted);
        outcomes.largest_error = std::max(
            outcomes.largest_error,
            (estimate.state.position - vehicle.truth(estimate.time).position).head<2>().norm());
      });
  return outcomes;
}

StateEstimatorParameters robot() {
  StateEstimatorParameters p = StateEstimatorParameters::ground_robot();
  // As the simulated sensors are. Of wheels that slip more it could not be told whether they drift
  // off or the positions do.
  p.smoother.imu_noise = test::vehicle_imu_noise();
  p.odometer.share = 0.005;
  return p;
}

// Receivers without corrections are off by metres for some 10 s, and state less: taken for
// independent, such errors make a state that is surer of itself than they are.
TEST(TrackWitnessInEstimatorTest, PositionsThatAreWorseThanStatedAreNotLockedOut) {
  struct Receiver {
    double deviation = 0;         // m
    double correlation_time = 0;  // s
    double told = 0;              // s, of the correlation time
    double largest_error = 0;     // m
  };
  for (const Receiver& receiver :
       {Receiver{1.4, 5, 0, 6}, Receiver{1.4, 5, 2, 4}, Receiver{1.4, 40, 0, 6},
        Receiver{3, 15, 0, 14}, Receiver{3, 15, 2, 9}, Receiver{3, 40, 0, 14}}) {
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      VehicleOptions options;
      options.duration = 200;
      options.gps_deviation = 0.8;  // as stated
      options.imu_rate = 50;
      const SimulatedVehicle vehicle(seed, options);
      StateEstimatorParameters parameters = robot();
      parameters.gps.correlation_time = receiver.told;
      LastingErrors errors(seed, receiver.deviation, receiver.correlation_time);
      const Outcomes outcomes = drive(vehicle, parameters, 30, [&](GpsMeasurement& gps) {
        gps.position = vehicle.truth(gps.time).position + errors.at(gps.time);
      });
      SCOPED_TRACE(testing::Message()
                   << receiver.deviation << " m for " << receiver.correlation_time << " s, told "
                   << receiver.told << ", seed " << seed);
      EXPECT_LT(outcomes.longest_refusal, 10);
      EXPECT_LT(outcomes.largest_error, receiver.largest_error);
    }
  }
}

TEST(TrackWitnessInEstimatorTest, PositionsThatSlowlyDriftOffDoNotTakeTheStateAlong) {
  for (const double speed : {0.5, 1.0, 2.0}) {  // m/s
    VehicleOptions options;
    options.duration = 300;
    const SimulatedVehicle vehicle(7, options);
    constexpr double kBegin = 100;
    constexpr double kEnd = 260;
    const Outcomes outcomes = drive(vehicle, robot(), 30, [&](GpsMeasurement& gps) {
      if (gps.time > kBegin && gps.time < kEnd) {
        gps.position.y() += speed * (gps.time - kBegin);
      }
    });
    EXPECT_LT(outcomes.largest_error, 10) << speed << " m/s";
  }
}

}  // namespace
}  // namespace pipescout::estimation
