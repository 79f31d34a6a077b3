// SPDX-License-Identifier: Apache-2.0
// Valid streams with mutated messages: nothing of it may come out.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <random>

#include "simulated_vehicle.hpp"

namespace pipescout::estimation {
namespace {

using test::AnyMessage;
using test::SimulatedVehicle;
using test::VehicleOptions;

/// Changes times, values, order and number of messages.
class Mutator {
 public:
  explicit Mutator(std::uint64_t seed) : engine_(seed) {}

  double share() { return std::uniform_real_distribution<double>()(engine_); }

  void mutate(double& value) {
    switch (std::uniform_int_distribution<int>(0, 9)(engine_)) {
      case 0:
        value = std::numeric_limits<double>::quiet_NaN();
        break;
      case 1:
        value = std::numeric_limits<double>::infinity();
        break;
      case 2:
        value = 0;
        break;
      case 3:
        value = -value;
        break;
      case 4:
        value *= 1e6;
        break;
      case 5:
        value = 1e300;
        break;
      case 6:  // a bit falls over
        value = std::bit_cast<double>(std::bit_cast<std::uint64_t>(value) ^
                                      (std::uint64_t{1} << (engine_() % 64)));
        break;
      case 7:
        value += std::normal_distribution<double>(0, 1)(engine_);
        break;
      case 8:
        value *= 1 + 0.1 * std::normal_distribution<double>(0, 1)(engine_);
        break;
      default:
        value = 1e-12;
    }
  }
  template <class Matrix>
  void mutate_one(Matrix& m) {
    mutate(m.data()[engine_() % static_cast<std::size_t>(m.size())]);
  }

  void operator()(ImuReading& m) {
    pick([&] { mutate(m.time); }, [&] { mutate_one(m.specific_force); },
         [&] { mutate_one(m.angular_rate); });
  }
  void operator()(OdometerReading& m) {
    pick([&] { mutate(m.time); }, [&] { mutate(m.distance); }, [&] { mutate(m.variance); });
  }
  void operator()(GpsMeasurement& m) {
    pick([&] { mutate(m.time); }, [&] { mutate_one(m.position); },
         [&] { mutate_one(m.covariance); });
  }
  void operator()(HeadingMeasurement& m) {
    pick([&] { mutate(m.time); }, [&] { mutate(m.heading); },
         [&] { mutate(m.standard_deviation); });
  }
  void operator()(VisualPoseMeasurement& m) {
    Eigen::Vector3d t = m.T_rack_body.translation();
    pick([&] { mutate(m.time); }, [&] { mutate_one(m.covariance); },
         [&] {
           mutate_one(t);
           if (t.allFinite()) {
             m.T_rack_body = geometry::SE3(m.T_rack_body.rotation(), t);
           }
         });
  }
  template <class Other>
  void operator()(Other& m) {
    mutate(m.time);
  }

 private:
  template <class... Choices>
  void pick(Choices&&... choices) {
    std::size_t left = engine_() % sizeof...(choices);
    ((left-- == 0 ? choices() : void()), ...);
  }
  std::mt19937_64 engine_;
};

struct Fuzzed {
  std::size_t mutations = 0;
  std::size_t not_finite = 0;
  double worst = 0;  // m, error 5 s after the last mutation
};

/// Stretches of 10 s with `share` of the messages mutated, each followed by 5 s of clean data.
/// `scaled`: what the IMU's axes show is estimated too, and could keep what wrong readings said.
Fuzzed fuzz(std::uint64_t seed, bool flies, bool scaled, double share) {
  VehicleOptions options;
  options.duration = 110;
  options.kind = flies ? VehicleOptions::Kind::kFly : VehicleOptions::Kind::kDrive;
  options.odometer = !flies;
  options.compass = true;
  options.vision = flies;
  const SimulatedVehicle vehicle(seed, options);
  StateEstimatorParameters parameters =
      flies ? StateEstimatorParameters::uav() : StateEstimatorParameters::ground_robot();
  parameters.smoother.imu_noise = test::vehicle_imu_noise();
  if (scaled) {
    parameters.smoother.global_deviations.gyro_scale = 0.003;
    parameters.smoother.global_deviations.gyro_misalignment = 0.001;
    parameters.smoother.global_deviations.accelerometer_scale = 0.003;
    parameters.smoother.global_deviations.accelerometer_misalignment = 0.001;
  }
  StateEstimator estimator(parameters);
  Mutator mutator(seed);
  Fuzzed result;
  test::deliver(estimator, vehicle, 0, 20);
  std::vector<AnyMessage> delayed;
  const auto watch = [&](const Estimate& estimate) {
    result.not_finite += estimate.state.is_finite() && estimate.T_odom_body.matrix().allFinite() &&
                                 estimate.T_map_odom.matrix().allFinite()
                             ? 0U
                             : 1U;
  };
  for (double from = 20; from < 110; from += 15) {
    test::deliver(
        estimator, vehicle, from, from + 10,
        [&](AnyMessage& message) {
          if (mutator.share() >= share) {
            return true;
          }
          ++result.mutations;
          const double kind = mutator.share();
          if (kind < 0.1) {
            return false;
          }
          if (kind < 0.2) {
            test::deliver(estimator, message);  // and once more
          } else if (kind < 0.4) {
            delayed.push_back(message);
            if (delayed.size() > 20) {
              std::swap(message, delayed[delayed.size() / 2]);
              delayed.clear();
            } else {
              return false;
            }
          } else {
            std::visit(mutator, message);
          }
          return true;
        },
        watch);
    test::deliver(estimator, vehicle, from + 10, from + 15, nullptr, watch);
    result.not_finite += estimator.covariance().allFinite() ? 0U : 1U;
    const auto estimate = estimator.estimate();
    const double error =
        estimate && estimate->in_map
            ? (estimate->state.position - vehicle.truth(estimate->time).position).norm()
            : INFINITY;
    result.worst = std::max(result.worst, error);
  }
  return result;
}

TEST(StateEstimatorFuzz, MutatedMessagesNeverComeOutAndAreForgottenWithinFiveSeconds) {
  const char* const more =
      std::getenv("PIPESCOUT_FUZZ_MUTATIONS");  // NOLINT(concurrency-mt-unsafe)
  const auto wanted = more != nullptr ? std::strtoul(more, nullptr, 10) : 20000UL;
  std::size_t mutations = 0;
  for (std::uint64_t seed = 1; mutations < wanted; ++seed) {
    const bool flies = seed % 2 == 0;
    const bool scaled = seed % 4 >= 2;
    const Fuzzed result = fuzz(seed, flies, scaled, seed % 3 == 0 ? 0.5 : 0.2);
    mutations += result.mutations;
    EXPECT_EQ(result.not_finite, 0U) << "seed " << seed;
    EXPECT_LT(result.worst, 3) << "seed " << seed;
  }
  EXPECT_GE(mutations, wanted);
}

}  // namespace
}  // namespace pipescout::estimation
