// SPDX-License-Identifier: Apache-2.0
#include "pipescout/simulation/thermal_scene.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>
#include <string>

namespace pipescout::simulation {
namespace {

using ::testing::HasSubstr;

TEST(ThermalScene, LeaksRiseFromNothingAtTheirEndsToFullBetween) {
  const ThermalLeak leak{.place = 10, .length = 0.4, .rise = 80, .shoulder = 0.1};
  EXPECT_DOUBLE_EQ(ThermalScene::rise_of(leak, 10), 80);
  EXPECT_NEAR(ThermalScene::rise_of(leak, 9.8), 40, 1e-9);
  EXPECT_NEAR(ThermalScene::rise_of(leak, 10.2), 40, 1e-9);
  EXPECT_NEAR(ThermalScene::rise_of(leak, 10.15), 80, 1e-9);
  EXPECT_NEAR(ThermalScene::rise_of(leak, 10.25), 0, 1e-9);
  const ThermalLeak sharp{.place = 10, .length = 0.4, .rise = 80, .shoulder = 0};
  EXPECT_DOUBLE_EQ(ThermalScene::rise_of(sharp, 10.19), 80);
  EXPECT_DOUBLE_EQ(ThermalScene::rise_of(sharp, 10.21), 0);
}

TEST(ThermalScene, TubeIsAsWarmAsAskedFor) {
  ThermalSceneParameters parameters;
  parameters.length = 600;
  parameters.tube_temperature = 150;
  parameters.tube_change = 12;
  parameters.tube_grain = 3;
  const ThermalScene scene(parameters);
  double sum = 0;
  double squares = 0;
  int count = 0;
  for (double place = 0.1; place < 600; place += 0.2, ++count) {
    const double grain = scene.tube_temperature(place) - 150 - 12 * (place / 300 - 1);
    sum += grain;
    squares += grain * grain;
  }
  // Of about 1000 independent stretches.
  EXPECT_NEAR(sum / count, 0, 4 * 3 / std::sqrt(1000.0));
  EXPECT_NEAR(std::sqrt(squares / count), 3, 0.3);
  EXPECT_EQ(scene.tube_temperature(-5), scene.tube_temperature(0));
  EXPECT_EQ(scene.tube_temperature(700), scene.tube_temperature(600));
}

TEST(ThermalScene, JointsAreATubeApartAndWithinTheirRange) {
  const ThermalScene scene(ThermalSceneParameters{});
  const ThermalSceneParameters& p = scene.parameters();
  ASSERT_EQ(scene.joints().size(), 36U);
  for (std::size_t i = 0; i < scene.joints().size(); ++i) {
    const ThermalJoint& joint = scene.joints()[i];
    EXPECT_NEAR(joint.place, static_cast<double>(i + 1) * kAbsorberLength, 1e-9);
    EXPECT_GE(joint.rise - joint.swing, p.joint_least);
    EXPECT_LE(joint.rise + joint.swing, p.joint_most);
    EXPECT_NEAR(joint.width, p.joint_width, p.joint_width / 4);
    for (const double support : scene.supports()) {
      EXPECT_GT(std::abs(support - joint.place), 1);
    }
  }
  ASSERT_EQ(scene.supports().size(), 13U);
}

TEST(ThermalScene, ABrightJointIsTheOneNearest) {
  ThermalSceneParameters parameters;
  const ThermalScene plain(parameters);
  parameters.decoys = {
      {.kind = ThermalDecoyKind::kBrightJoint, .place = 41, .size = 0.17, .rise = 150}};
  const ThermalScene scene(parameters);
  for (std::size_t i = 0; i < scene.joints().size(); ++i) {
    const bool nearest = i == 9;  // at 40.6 m
    EXPECT_EQ(scene.joints()[i].rise == plain.joints()[i].rise, !nearest);
    EXPECT_EQ(scene.joints()[i].width == 0.17, nearest);
  }
}

TEST(ThermalScene, TheSameSeedGivesTheSameScene) {
  ThermalSceneParameters parameters;
  const ThermalScene first(parameters);
  const ThermalScene again(parameters);
  parameters.seed = 2;
  const ThermalScene other(parameters);
  EXPECT_EQ(first.tube_temperature(33.3), again.tube_temperature(33.3));
  EXPECT_NE(first.tube_temperature(33.3), other.tube_temperature(33.3));
  EXPECT_EQ(first.joints()[3].rise, again.joints()[3].rise);
  EXPECT_NE(first.joints()[3].rise, other.joints()[3].rise);
}

TEST(ThermalScene, IsWhereTheRowIs) {
  ThermalSceneParameters parameters;
  parameters.T_map_row = {geometry::SO3::about_z(std::acos(-1.0) / 2), {100, 50, 2}};
  const ThermalScene scene(parameters);
  EXPECT_LT((scene.on_tube(7) - Eigen::Vector3d(100, 57, 5)).norm(), 1e-9);
}

std::string refusal(const std::function<void(ThermalSceneParameters&)>& spoil) {
  ThermalSceneParameters parameters;
  parameters.leaks.resize(1);
  parameters.decoys.resize(2);
  spoil(parameters);
  try {
    const ThermalScene scene(parameters);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "accepted";
}

TEST(ThermalScene, NamesWhatIsWrong) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(refusal([](auto&) {}), "accepted");
  EXPECT_THAT(refusal([](auto& p) { p.length = 0; }), HasSubstr("length: 0 is outside [1, 5000]"));
  EXPECT_THAT(refusal([](auto& p) { p.tube_height = kNan; }), HasSubstr("tube_height"));
  EXPECT_THAT(refusal([](auto& p) { p.joint_most = -30; }), HasSubstr("joint_most"));
  EXPECT_THAT(refusal([](auto& p) { p.object.emissivity = 0; }), HasSubstr("emissivity"));
  EXPECT_THAT(refusal([](auto& p) { p.leaks[0].place = 151; }), HasSubstr("leaks[0].place"));
  EXPECT_THAT(refusal([](auto& p) { p.leaks[0].shoulder = 1; }), HasSubstr("leaks[0].shoulder"));
  EXPECT_THAT(refusal([](auto& p) { p.decoys[1].follow = 2; }), HasSubstr("decoys[1].follow"));
  EXPECT_THAT(refusal([](auto& p) {
                p.decoys[1].kind = ThermalDecoyKind::kHotPixels;
                p.decoys[1].size = 0.5;
              }),
              HasSubstr("decoys[1].size: 0.5 is outside [1, 5]"));
}

}  // namespace
}  // namespace pipescout::simulation
