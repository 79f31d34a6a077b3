// SPDX-License-Identifier: Apache-2.0
#include "pipescout/simulation/rack_flight.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <pipescout/rack_vision/visual_servo.hpp>
#include <pipescout/rack_vision/way_point_mission.hpp>
#include <vector>

#include "rack_image_scenes.hpp"

namespace pipescout::simulation {
namespace {

using Eigen::Vector3d;
using geometry::SE3;
using rack_vision::WayPoint;

constexpr int kWidth = 180;
constexpr int kHeight = 120;

RackFlightParameters parameters_of(std::uint64_t seed) {
  RackFlightParameters result;
  result.scene.model = test::paper_rack();
  result.camera.width = kWidth;
  result.camera.height = kHeight;
  result.camera.focal_length = 157.5;
  result.camera.centre_u = 90;
  result.camera.centre_v = 60;
  result.wind.speed_at_20_feet = 6;
  result.wind.height = 7;
  result.T_base_camera = rack_vision::downward_camera({0.1, 0, -0.05});
  result.start_position = {1, 5, 3};
  result.seed = seed;
  return result;
}

std::vector<std::uint8_t> image_of(RackFlight& flight, std::uint64_t frame) {
  std::vector<std::uint8_t> image(kWidth * kHeight);
  flight.render(frame, image);
  return image;
}

TEST(RackFlight, IsTheSameForTheSameSeedHoweverItIsAsked) {
  RackFlight at_once(parameters_of(3));
  RackFlight in_pieces(parameters_of(3));
  RackFlight other(parameters_of(4));
  at_once.fly_until(2);
  for (double time = 0; time <= 2; time += 0.037) {
    in_pieces.fly_until(time);
  }
  in_pieces.fly_until(2);
  in_pieces.fly_until(1);
  other.fly_until(2);
  EXPECT_EQ(at_once.T_rack_camera().matrix(), in_pieces.T_rack_camera().matrix());
  EXPECT_NE(at_once.T_rack_camera().matrix(), other.T_rack_camera().matrix());
  EXPECT_NEAR(at_once.uav().time, 2, 1e-9);
  const auto image = image_of(at_once, 5);
  EXPECT_EQ(image, image_of(in_pieces, 5));
  EXPECT_NE(image, image_of(other, 5));
  const auto [darkest, brightest] = std::ranges::minmax(image);
  EXPECT_GT(brightest - darkest, 50);
}

TEST(RackFlight, TellsTheVelocityOfItsCamera) {
  RackFlight flight(parameters_of(1));
  flight.command({.velocity = {0.5, 0, 0}, .yaw_rate = 0.5});
  flight.fly_until(0.9);
  const SE3 before = flight.T_rack_camera();
  flight.fly_until(0.901);
  const geometry::Vector6d velocity = flight.camera_velocity();
  flight.fly_until(0.902);
  const geometry::Vector6d moved = (before.inverse() * flight.T_rack_camera()).log() / 0.002;
  EXPECT_GT(velocity.norm(), 0.2);
  EXPECT_LT((moved - velocity).norm(), 0.01);
}

TEST(RackFlight, IsBroughtToItsWayPointsByTheServoInGusts) {
  // With the true pose, an image period late: what is left to the tracker is its own error.
  const std::vector<WayPoint> points{
      {{0.7, 5, 3}, 0, 2}, {{1.7, 6, 3}, 0.2, 2}, {{1.7, 4, 3}, -0.2, 2}, {{1.7, 4, 2.5}, -0.2, 2}};
  RackFlightParameters parameters = parameters_of(1);
  parameters.start_position = points[0].position;
  RackFlight flight(parameters);
  rack_vision::WayPointMission mission(rack_vision::WayPointPath(points, {}), {});
  rack_vision::VisualServo servo({.T_base_camera = parameters.T_base_camera});
  std::vector<double> nearest(points.size(), 10);
  double now = 0;
  for (int image = 0; image < 3000 && !mission.complete(); ++image) {
    const SE3 T_rack_camera = flight.T_rack_camera();
    const double measured = now;
    now = (image + 1) * 0.04;
    flight.fly_until(now);
    ASSERT_EQ(servo.observe({.time = measured,
                             .position = T_rack_camera.translation(),
                             .orientation = T_rack_camera.rotation().quaternion()},
                            now),
              rack_vision::PoseVerdict::kTaken);
    const SE3 T_rack_base = *servo.T_rack_base(now);
    mission.advance(now,
                    rack_vision::LevelPose{.time = measured,
                                           .position = T_rack_base.translation(),
                                           .yaw = T_rack_base.rotation().roll_pitch_yaw().z()});
    const auto command = servo.step(now, mission.target(measured));
    flight.command({.velocity = command.linear, .yaw_rate = command.angular.z()});
    double& least = nearest[mission.current()];
    least = std::min(
        least,
        (flight.uav().T_rack_body.translation() - points[mission.current()].position).norm());
  }
  EXPECT_TRUE(mission.complete());
  EXPECT_EQ(mission.count(rack_vision::WayPointOutcome::kReached), points.size());
  EXPECT_LT(*std::ranges::max_element(nearest), 0.03);
}

TEST(RackFlight, RejectsWhatIsOutOfRange) {
  RackFlightParameters parameters = parameters_of(1);
  parameters.wind.speed_at_20_feet = -1;
  EXPECT_THROW(RackFlight{parameters}, std::invalid_argument);
  parameters = parameters_of(1);
  parameters.camera.focal_length = 0;
  EXPECT_THROW(RackFlight{parameters}, std::invalid_argument);
  parameters = parameters_of(1);
  parameters.start_position.x() = std::nan("");
  EXPECT_THROW(RackFlight{parameters}, std::invalid_argument);
  RackFlight flight(parameters_of(1));
  std::array<std::uint8_t, 4> small{};
  EXPECT_THROW(flight.render(0, small), std::invalid_argument);
}

}  // namespace
}  // namespace pipescout::simulation
