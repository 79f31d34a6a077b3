// SPDX-License-Identifier: Apache-2.0
// Images whose rows are exposed one after the other.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "drawn_rack.hpp"
#include "heap_guard.hpp"
#include "pipescout/rack_vision/rack_tracker.hpp"

namespace pipescout::rack_vision {
namespace {

constexpr double kPeriod = 0.04;            // s
constexpr double kRowTime = 0.016 / 240.0;  // s, of an image of 240 rows
constexpr double k99Of100 = 16.81;          // chi-square of six

geometry::Vector6d velocity_of(double vx, double vy, double vz, double wx, double wy, double wz) {
  geometry::Vector6d velocity;
  velocity << vx, vy, vz, wx, wy, wz;
  return velocity;
}

geometry::SE3 moved(const geometry::SE3& from, const geometry::Vector6d& by) {
  return {geometry::SO3::exp(by.tail<3>()) * from.rotation(), from.translation() + by.head<3>()};
}

geometry::Vector6d error_of(const RackTrackerResult& result, const geometry::SE3& truth) {
  geometry::Vector6d error;
  error << result.T_rack_camera.translation() - truth.translation(),
      (result.T_rack_camera.rotation() * truth.rotation().inverse()).log();
  return error;
}

double median(std::vector<double> values) {
  std::ranges::nth_element(values, values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2));
  return values[values.size() / 2];
}

double largest(const std::vector<double>& values) {
  return *std::ranges::max_element(values);
}

struct Flight {
  std::vector<double> rotations;  ///< errors of the images with a pose, rad
  std::vector<double> nees;       ///< of the whole pose
};

struct Settings {
  double row_time = kRowTime;  ///< of the images
  double told = kRowTime;      ///< of which the tracker knows
  double start_error = 1;      ///< times 1 cm and 5 mrad per axis; the tracker knows it
  int images = 25;
  std::uint64_t seed = 1;
};

Flight fly(const Settings& settings, const geometry::Vector6d& velocity) {
  const RackModel model = test::drawn_rack();
  const geometry::Camera camera = test::drawn_camera();
  RackTrackerParameters parameters;
  parameters.row_time = settings.told;
  RackTracker tracker(model, camera, parameters);
  geometry::SE3 truth = test::drawn_pose(0.78, 4.0, 2.8, 0.6);
  geometry::Vector6d deviations;
  deviations << 0.01, 0.01, 0.01, 0.005, 0.005, 0.005;
  deviations *= settings.start_error;
  std::mt19937_64 engine(settings.seed);
  std::normal_distribution<double> normal;
  geometry::Vector6d start;
  std::ranges::generate(start, [&] { return normal(engine); });
  EXPECT_TRUE(tracker.set_pose(moved(truth, start.cwiseProduct(deviations)),
                               geometry::Matrix6d(deviations.cwiseAbs2().asDiagonal())));
  Flight flight;
  for (int k = 0; k < settings.images; ++k) {
    const auto image = test::draw_rolling(model, camera, truth, velocity, settings.row_time);
    const RackTrackerResult result = tracker.track(image.view(), kPeriod * k);
    if (result.status == TrackStatus::kTracking) {
      const geometry::Vector6d error = error_of(result, truth);
      flight.rotations.push_back(error.tail<3>().norm());
      flight.nees.push_back(error.dot(result.covariance.ldlt().solve(error)));
    }
    truth = moved(truth, kPeriod * velocity);
  }
  return flight;
}

TEST(RollingShutter, ARowTimeThatIsToldTakesTheSkewOutOfThePose) {
  const geometry::Vector6d velocity = velocity_of(0.3, 0.3, -0.1, 0, 0, 0.2);
  const Flight untold = fly({.told = 0, .start_error = 0.1}, velocity);
  const Flight told = fly({.start_error = 0.1}, velocity);
  ASSERT_EQ(untold.nees.size(), 25U);
  ASSERT_EQ(told.nees.size(), 25U);
  EXPECT_GT(largest(untold.nees), k99Of100) << "there is no skew to correct";
  EXPECT_LT(largest(told.nees), k99Of100);
  EXPECT_LT(median(told.rotations), 0.3 * median(untold.rotations));
}

TEST(RollingShutter, TheFirstImagesOfAnUnknownVelocityAreWithinTheirCovariance) {
  constexpr int kFlights = 16;
  constexpr int kFirst = 4;  // images
  std::mt19937_64 engine(3);
  std::normal_distribution<double> normal;
  int with_pose = 0;
  int covered = 0;
  for (int i = 0; i < kFlights; ++i) {
    geometry::Vector6d velocity;
    std::ranges::generate(velocity, [&] { return normal(engine); });
    velocity = velocity.cwiseProduct(velocity_of(0.4, 0.4, 0.2, 0.1, 0.1, 0.2)).eval();
    const Flight flight = fly({.images = kFirst, .seed = engine()}, velocity);
    with_pose += static_cast<int>(flight.nees.size());
    covered +=
        static_cast<int>(std::ranges::count_if(flight.nees, [](double e) { return e < k99Of100; }));
  }
  EXPECT_GE(with_pose, 0.9 * kFirst * kFlights);
  EXPECT_GE(covered, 0.98 * with_pose);
}

TEST(RollingShutter, ARowTimeThatIsToldWronglyIsWithinTheCovariance) {
  const geometry::Vector6d velocity = velocity_of(0.2, 0.5, -0.1, 0, 0, 0.2);
  for (const double told : {0.8 * kRowTime, 1.2 * kRowTime}) {
    const Flight flight = fly({.told = told}, velocity);
    EXPECT_EQ(flight.nees.size(), 25U) << told;
    EXPECT_LT(largest(flight.nees), k99Of100) << told;
  }
}

TEST(RollingShutter, TakesNoHeapFromTheThirdImageOn) {
  const geometry::Vector6d velocity = velocity_of(0.2, 0.5, -0.1, 0, 0, 0.2);
  const RackModel model = test::drawn_rack();
  const geometry::Camera camera = test::drawn_camera();
  RackTrackerParameters parameters;
  parameters.row_time = kRowTime;
  RackTracker tracker(model, camera, parameters);
  geometry::SE3 truth = test::drawn_pose(0.78, 4.0, 2.8, 0.6);
  ASSERT_TRUE(tracker.set_pose(truth, 1e-4 * geometry::Matrix6d::Identity()));
  for (int k = 0; k < 10; ++k) {
    const auto image = test::draw_rolling(model, camera, truth, velocity, kRowTime);
    std::size_t allocations = 0;
    {
      const pipescout::test::HeapGuard guard;
      (void)tracker.track(image.view(), kPeriod * k);
      allocations = guard.allocations();
    }
    EXPECT_TRUE(k < 2 || allocations == 0U) << k;
    truth = moved(truth, kPeriod * velocity);
  }
}

}  // namespace
}  // namespace pipescout::rack_vision
