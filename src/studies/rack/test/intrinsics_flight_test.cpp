// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <random>
#include <vector>

#include "pipescout/rack_study/image_scene.hpp"
#include "pipescout/rack_study/pose_run.hpp"
#include "pipescout/rack_vision/rack_tracker.hpp"
#include "pipescout/simulation/rack_image.hpp"
#include "pipescout/simulation/rack_image_light.hpp"

namespace pipescout::rack_study {
namespace {

/// Errors of one tracker over the last quarter of a flight.
struct Errors {
  double position_square = 0;  ///< m^2, summed
  double nees = 0;             ///< summed
  std::size_t images = 0;
  [[nodiscard]] double rms() const {
    return std::sqrt(position_square / static_cast<double>(images));
  }

  void add(const rack_vision::RackTrackerResult& result, const geometry::SE3& T_camera_rack) {
    const geometry::Vector6d error = pose_error(result.T_rack_camera.inverse(), T_camera_rack);
    position_square += error.head<3>().squaredNorm();
    nees += error.dot(result.covariance.ldlt().solve(error));
    ++images;
  }
};

/// A flight with a calibration that is off; the error of the focal length that it has found, px.
void fly(std::uint64_t seed, double& focal_length_error) {
  const geometry::Camera camera;
  geometry::CameraParameters off = camera.parameters();
  off.focal_length *= 1.015;
  off.centre_u += 6;
  off.centre_v -= 6;
  rack_vision::RackTrackerParameters parameters;
  parameters.focal_sigma = 10;
  parameters.centre_sigma = 6;
  simulation::RackScene scene{.model = rack_on_beams()};
  rack_vision::RackTracker fixed(scene.model, geometry::Camera(off), parameters);
  parameters.estimate_intrinsics = true;
  rack_vision::RackTracker estimating(scene.model, geometry::Camera(off), parameters);

  std::mt19937_64 engine(seed);
  const simulation::ChangingRackLight light({}, engine());
  // The paper's way-points: up and down between 2.5 and 3 m.
  const std::vector<CameraMotion> motions =
      fly_camera(inspection_way_points(60, seed), {.duration = 20}, engine());
  scene.seed = engine();
  simulation::RackImageRenderer renderer(scene, camera);
  std::vector<std::uint8_t> grey(static_cast<std::size_t>(off.width) *
                                 static_cast<std::size_t>(off.height));
  geometry::Matrix6d covariance = geometry::Matrix6d::Zero();
  covariance.diagonal() << 9e-4, 9e-4, 9e-4, 2e-4, 2e-4, 2e-4;
  const geometry::SE3 start = motions.front().T_camera_rack.inverse();
  ASSERT_TRUE(fixed.set_pose(start, covariance));
  ASSERT_TRUE(estimating.set_pose(start, covariance));

  Errors without;
  Errors with;
  rack_vision::RackTrackerResult last;
  for (std::size_t i = 0; i < motions.size(); ++i) {
    const CameraMotion& motion = motions[i];
    renderer.render(view_of(motion, light, i), grey);
    const rack_vision::ImageView image{
        .pixels = grey.data(), .width = off.width, .height = off.height, .stride = off.width};
    const auto as_calibrated = fixed.track(image, motion.time);
    last = estimating.track(image, motion.time);
    ASSERT_EQ(last.status, rack_vision::TrackStatus::kTracking) << motion.time;
    if (4 * i >= 3 * motions.size()) {
      without.add(as_calibrated, motion.T_camera_rack);
      with.add(last, motion.T_camera_rack);
    }
  }
  ASSERT_TRUE(last.intrinsics.has_value());
  const Eigen::Vector3d error =
      last.intrinsics->mean - Eigen::Vector3d(camera.parameters().focal_length,
                                              camera.parameters().centre_u,
                                              camera.parameters().centre_v);
  focal_length_error = error(0);
  EXPECT_LT(error.tail<2>().norm(), 2.5);
  EXPECT_LT(error.dot(last.intrinsics->covariance.ldlt().solve(error)), 16);
  // 1.5 percent of 2.8 m are 42 mm.
  EXPECT_GT(without.rms(), 0.04);
  EXPECT_LT(with.rms(), 0.4 * without.rms());
  EXPECT_LT(with.nees / static_cast<double>(with.images), 12);
}

TEST(IntrinsicsFlight, ACalibrationThatIsOffIsFoundInFlightAndThePoseWithIt) {
  const std::vector<std::uint64_t> seeds{5, 6};
  double sum = 0;
  for (const std::uint64_t seed : seeds) {
    SCOPED_TRACE(seed);
    double error = std::numeric_limits<double>::quiet_NaN();
    ASSERT_NO_FATAL_FAILURE(fly(seed, error));
    sum += error * error;
  }
  EXPECT_LT(std::sqrt(sum / static_cast<double>(seeds.size())),
            0.004 * geometry::CameraParameters().focal_length);
}

}  // namespace
}  // namespace pipescout::rack_study
