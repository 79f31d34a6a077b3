// SPDX-License-Identifier: Apache-2.0
#include "pipescout/simulation/rack_thermal.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

namespace pipescout::simulation {
namespace {

using ::testing::HasSubstr;

constexpr double kHeight = 2.6;  // m

RackThermalScene two_pipes() {
  RackThermalScene scene;
  const std::vector<rack_vision::RowPipe> row{
      {.name = "A", .radii = {{0, 0.15}, {10, 0.15}}, .gap = 0},
      {.name = "B", .radii = {{0, 0.20}, {10, 0.20}}, .gap = 0.1}};
  scene.model.pipes = rack_vision::row_of_pipes(row);
  scene.model.pipes.front().movable = false;
  scene.pipe_temperatures = {40, 50};
  scene.pipe_change = 0;
  return scene;
}

geometry::Camera small_camera() {
  geometry::CameraParameters p;
  p.width = 160;
  p.height = 120;
  p.focal_length = 140;
  p.centre_u = 79.5;
  p.centre_v = 59.5;
  return geometry::Camera(p);
}

/// Straight down, the upper border of the image towards rack y.
geometry::SE3 above(double x, double y) {
  return {geometry::SO3::from_roll_pitch_yaw({std::numbers::pi, 0, 0}), {x, y, kHeight}};
}

RackThermalSensor perfect() {
  return {.netd = 0, .fixed_pattern = 0, .lens_blur = 0};
}

std::vector<std::uint16_t> picture(const RackThermalScene& scene, const geometry::SE3& pose,
                                   const RackThermalSensor& sensor = perfect(),
                                   std::uint64_t frame = 0) {
  RackThermalRenderer renderer(scene, small_camera(), sensor);
  std::vector<std::uint16_t> counts(160 * 120);
  renderer.render(pose, frame, counts);
  return counts;
}

double celsius_at(const std::vector<std::uint16_t>& counts, const Eigen::Vector2d& pixel) {
  const auto u = static_cast<std::size_t>(std::lround(pixel.x()));
  const auto v = static_cast<std::size_t>(std::lround(pixel.y()));
  return kRackThermalOffset + kRackThermalGain * counts.at(v * 160 + u);
}

double celsius_at(const std::vector<std::uint16_t>& counts, const geometry::SE3& pose,
                  const Eigen::Vector3d& place) {
  return celsius_at(counts, small_camera().project(pose.inverse() * place).value());
}

TEST(RackThermal, SeesPipesBeforeTheGroundWithTheirTemperatures) {
  const RackThermalScene scene = two_pipes();
  const geometry::SE3 pose = above(0.35, 5);
  const auto counts = picture(scene, pose);
  // Apparent ones: less than true, by the reflection of the sky.
  EXPECT_NEAR(celsius_at(counts, pose, {0.15, 5, 0.30}), 35.5, 2.0);
  EXPECT_NEAR(celsius_at(counts, pose, {0.60, 5, 0.40}), 44.5, 2.0);
  EXPECT_NEAR(celsius_at(counts, pose, {-1.5, 5, -4}), 10.0, 3.0);
}

TEST(RackThermal, BlackBodyWithoutAirShowsItsTemperature) {
  RackThermalScene scene = two_pipes();
  scene.emissivity = 1;
  scene.air_absorption = 0;
  scene.ground_temperature = 20;
  scene.ground_grain = 0;
  const geometry::SE3 pose = above(0.35, 5);
  const auto counts = picture(scene, pose);
  // Straight below; Fresnel's reflection at an angle is small.
  EXPECT_NEAR(celsius_at(counts, pose, {0.35, 5, -4}), 20, 0.02);
}

TEST(RackThermal, HotSpotIsWhereItsPlaceIs) {
  RackThermalScene scene = two_pipes();
  for (const double azimuth : {-0.5, 0.0, 0.5}) {
    for (const std::size_t pipe : {0U, 1U}) {
      scene.hot_spots = {{.pipe = pipe,
                          .along = 5.2,
                          .azimuth = azimuth,
                          .length = 0.2,
                          // Of a wider one, seen askew, the middle is not in the middle.
                          .half_angle = 0.25,
                          .rise = 30}};
      const geometry::SE3 pose = above(0.35, 5);
      const auto hot = picture(scene, pose);
      RackThermalScene cold = scene;
      cold.hot_spots.clear();
      const auto sound = picture(cold, pose);
      Eigen::Vector2d sum = Eigen::Vector2d::Zero();
      int count = 0;
      for (std::size_t i = 0; i < hot.size(); ++i) {
        if (hot[i] > sound[i] + 1000) {
          sum += Eigen::Vector2d(static_cast<double>(i % 160), static_cast<double>(i / 160));
          ++count;
        }
      }
      ASSERT_GT(count, 20);
      const auto expected =
          small_camera().project(pose.inverse() * place_of(scene.hot_spots[0], scene.model));
      EXPECT_LT((sum / count - *expected).norm(), 1.0) << pipe << " " << azimuth;
      EXPECT_NEAR(celsius_at(hot, sum / count) - celsius_at(sound, sum / count), 28, 2);
    }
  }
}

TEST(RackThermal, OtherPipesHideAHotSpot) {
  RackThermalScene scene = two_pipes();
  scene.model.pipes.push_back({.name = "C",
                               .start = {-2, 5.2, 0.6},
                               .direction = Eigen::Vector3d::UnitX(),
                               .radii = {{0, 0.15}, {5, 0.15}},
                               .movable = false});
  scene.pipe_temperatures.push_back(30);
  const geometry::SE3 pose = above(0.35, 5.2);
  const auto sound = picture(scene, pose);
  scene.hot_spots = {{.pipe = 1, .along = 5.2, .length = 0.1, .half_angle = 0.5, .rise = 30}};
  EXPECT_EQ(picture(scene, pose), sound);
}

TEST(RackThermal, NoiseIsThatOfTheFrameAndOfTheSizeThatIsTold) {
  const RackThermalScene scene = two_pipes();
  const geometry::SE3 pose = above(0.35, 5);
  RackThermalSensor sensor = perfect();
  sensor.netd = 0.1;
  const auto clean = picture(scene, pose);
  const auto noisy = picture(scene, pose, sensor, 3);
  EXPECT_EQ(noisy, picture(scene, pose, sensor, 3));
  EXPECT_NE(noisy, picture(scene, pose, sensor, 4));
  double squares = 0;
  for (std::size_t i = 0; i < clean.size(); ++i) {
    const double off = kRackThermalGain * (static_cast<double>(noisy[i]) - clean[i]);
    squares += off * off;
  }
  EXPECT_NEAR(std::sqrt(squares / static_cast<double>(clean.size())), 0.11, 0.03);
}

std::string refusal(const RackThermalScene& scene) {
  try {
    scene.validate();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "none";
}

TEST(RackThermal, NamesWhatIsWrong) {
  RackThermalScene scene = two_pipes();
  EXPECT_EQ(refusal(scene), "none");
  scene.hot_spots = {{.pipe = 2}};
  EXPECT_THAT(refusal(scene), HasSubstr("hot_spots[0].pipe: 2"));
  scene.hot_spots = {{.pipe = 1, .along = 11}};
  EXPECT_THAT(refusal(scene), HasSubstr("hot_spots[0].along: 11"));
  scene.hot_spots = {{.half_angle = 4}};
  EXPECT_THAT(refusal(scene), HasSubstr("hot_spots[0].half_angle"));
  scene.hot_spots.clear();
  scene.pipe_temperatures = {40};
  EXPECT_THAT(refusal(scene), HasSubstr("pipe_temperatures: 1 values: must be 2"));
  scene.pipe_temperatures.clear();
  scene.warm_ground = {{.radius = std::nan("")}};
  EXPECT_THAT(refusal(scene), HasSubstr("warm_ground.radius"));
  RackThermalRenderer renderer(two_pipes(), small_camera());
  std::vector<std::uint16_t> few(3);
  EXPECT_THROW(renderer.render(above(0, 5), 0, few), std::invalid_argument);
}

}  // namespace
}  // namespace pipescout::simulation
