// SPDX-License-Identifier: Apache-2.0
#include "pipescout/patrol_simulation/patrol_simulation.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <pipescout_msgs/action/inspect_tour.hpp>
#include <pipescout_msgs/msg/mission_status.hpp>
#include <string>
#include <utility>
#include <vector>

#include "pipescout/catalogue/topics.hpp"
#include "pipescout/files/testing/temporary_folder.hpp"
#include "pipescout/map_files/grid_file.hpp"
#include "pipescout/map_files/route_graph_file.hpp"
#include "pipescout/message_conversions/camera.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "pipescout/testing/component_harness.hpp"

namespace pipescout {
namespace {

using pipescout_msgs::action::InspectTour;
using pipescout_msgs::msg::MissionStatus;
using testing::ComponentHarness;
using ::testing::HasSubstr;

/// A short row, small images, as fast as can be.
/// The node that listens for the test.
const std::vector<std::string> kPeer{"_component_harness"};

std::vector<NamedParameter> short_patrol(std::vector<NamedParameter> extra = {},
                                         std::int64_t width = 80) {
  extra.push_back({"row.length", 2.0});
  extra.push_back({"leaks", std::vector<double>{1.0, 0.3, 80.0}});
  extra.push_back({"camera.width", width});
  extra.push_back({"camera.height", width * 3 / 4});
  extra.push_back({"image_rate", 5.0});
  extra.push_back({"standing", 1.0});
  extra.push_back({"rate", 1000.0});
  extra.push_back({"wait_for_subscribers.image", kPeer});
  return extra;
}

TEST(PatrolSimulation, DrivesAlongTheRowAndTellsAll) {
  std::vector<std::uint8_t> last_image;
  for (int run = 0; run < 2; ++run) {
    ComponentHarness harness;
    auto& simulation = harness.make<PatrolSimulation>({.parameters = short_patrol()});
    const auto clock = harness.collect(topics::kClock);
    const auto info = harness.collect(topics::kThermalCameraInfo);
    const auto truth = harness.collect(topics::kTrueOdometry);
    const auto imu = harness.collect(topics::kImu);
    const auto fixes = harness.collect(topics::kGpsFix);
    const auto wheels = harness.collect(topics::kOdometerReadings);
    const auto progress = harness.collect(topics::kMissionStatus);
    ASSERT_TRUE(harness.bring_up(simulation).success);
    const auto images = harness.collect(topics::kThermalImage);
    ASSERT_TRUE(harness.spin_until(
        [&] { return !progress.empty() && progress.back().state == MissionStatus::COMPLETE; }));

    harness.spin();  // what came with the last image
    // 31 m, most of them at 5.5 m/s, after a second.
    ASSERT_GT(images.size(), 35U);
    ASSERT_LT(images.size(), 70U);
    ASSERT_EQ(truth.size(), images.size());
    ASSERT_EQ(info.size(), images.size());
    EXPECT_EQ(clock.size(), images.size());
    EXPECT_NEAR(static_cast<double>(imu.size()), 50.0 * static_cast<double>(images.size()), 60);
    EXPECT_NEAR(static_cast<double>(wheels.size()), 10.0 * static_cast<double>(images.size()), 12);
    EXPECT_NEAR(static_cast<double>(fixes.size()), static_cast<double>(images.size()), 4);
    for (std::size_t i = 0; i < images.size(); ++i) {
      const auto& image = images.at(i);
      EXPECT_EQ(image.encoding, "mono16");
      EXPECT_EQ(image.step, 160U);
      EXPECT_EQ(image.data.size(), 80U * 60U * 2U);
      const Time stamp = from_message(image.header.stamp);
      EXPECT_EQ(stamp - from_message(images.at(0).header.stamp),
                static_cast<std::int64_t>(i) * Duration(std::chrono::milliseconds(200)));
      EXPECT_EQ(from_message(truth.at(i).header.stamp), stamp);
    }
    EXPECT_NEAR(from_message(info.back()).focal_length, 180.4, 0.1);
    EXPECT_EQ(truth.back().header.frame_id, "map");
    EXPECT_NEAR(truth.at(0).pose.pose.position.x, -14, 0.1);
    EXPECT_GT(truth.back().pose.pose.position.x, 12);
    ASSERT_EQ(wheels.back().name.size(), 4U);
    EXPECT_NEAR(wheels.back().distance[0], truth.back().pose.pose.position.x + 14, 0.7);
    EXPECT_NEAR(fixes.back().latitude, 36.66, 1e-3);
    EXPECT_GT(fixes.back().position_covariance[0], 0);
    if (run == 0) {
      last_image = images.back().data;
    } else {
      EXPECT_EQ(images.back().data, last_image);
    }
  }
}

std::vector<NamedParameter> small_plant(std::vector<NamedParameter> extra = {}) {
  extra.push_back({"row.length", 10.0});
  extra.push_back({"leaks", std::vector<double>{1.0, 0.3, 80.0, 2.0, 0.3, 80.0}});
  extra.push_back({"plant.rows", 3});
  extra.push_back({"camera.width", 80});
  extra.push_back({"camera.height", 60});
  extra.push_back({"image_rate", 10.0});
  extra.push_back({"standing", 1.0});
  extra.push_back({"rate", 1000.0});
  return extra;
}

const NamedParameter kLeakRows{"plant.leak_rows", std::vector<std::int64_t>{0, 1}};

TEST(PatrolSimulation, InAPlantItWritesTheMapAndAsksForATour) {
  ComponentHarness harness;
  testing::TemporaryFolder folder;
  const auto scans = harness.collect(topics::kScan);
  const auto truth = harness.collect(topics::kTrueOdometry);
  const auto leaks = harness.collect(topics::kTrueLeaks);
  const auto progress = harness.collect(topics::kMissionStatus);
  std::optional<std::vector<std::int64_t>> asked;
  const auto server = harness.peer().create_action_server<InspectTour>(
      "inspect_tour", {.accepted = [&](const ServerGoal<InspectTour>& goal) {
        asked = goal.goal().rows;
        InspectTour::Result result;
        result.rows_passed = 2;
        goal.succeed(result);
      }});
  auto& simulation = harness.make<PatrolSimulation>(
      {.parameters = small_plant({kLeakRows,
                                  {"plant.tour", std::vector<std::int64_t>{2, 0}},
                                  {"plant.map_folder", folder.path().string()}})});
  ASSERT_TRUE(harness.bring_up(simulation).success);
  ASSERT_TRUE(harness.spin_until([&] { return asked.has_value(); }));
  EXPECT_EQ(*asked, (std::vector<std::int64_t>{2, 0}));
  EXPECT_NEAR(truth.back().pose.pose.position.x, -3.5, 0.02);
  EXPECT_EQ(scans.back().ranges.size(), 360U);
  ASSERT_EQ(leaks.size(), 2U);
  // The first row faces up, so its places go from the end of the rows to their beginning.
  EXPECT_NEAR(leaks.at(0).finding.position.x, 10 - 1, 1e-9);
  EXPECT_NEAR(leaks.at(0).finding.position.y, 0, 1e-9);
  EXPECT_NEAR(leaks.at(1).finding.position.x, 2, 1e-9);
  EXPECT_NEAR(leaks.at(1).finding.position.y, 6.5, 1e-9);
  std::vector<std::string> remarks;
  EXPECT_EQ(read_route_graph(folder.path() / "plant.geojson", remarks).nodes().size(), 8U);
  const auto grid = read_grid(folder.path() / "plant.yaml", remarks);
  EXPECT_THAT(remarks, ::testing::IsEmpty());
  EXPECT_EQ(grid.at(grid.cell_at({5, 0}).value()), navigation::CellState::kOccupied);

  ASSERT_TRUE(harness.spin_until(
      [&] { return !progress.empty() && progress.back().state == MissionStatus::COMPLETE; }));
  EXPECT_THAT(progress.back().message, HasSubstr("2 rows driven along, 0 left out"));
}

TEST(PatrolSimulation, WithoutATourThePlantRunsUntilItsTimeIsOver) {
  ComponentHarness harness;
  const auto scans = harness.collect(topics::kScan);
  const auto clock = harness.collect(topics::kClock);
  const auto progress = harness.collect(topics::kMissionStatus);
  int asked = 0;
  const auto server = harness.peer().create_action_server<InspectTour>(
      "inspect_tour", {.accepted = [&](const ServerGoal<InspectTour>&) { ++asked; }});
  auto& simulation =
      harness.make<PatrolSimulation>({.parameters = small_plant({kLeakRows,
                                                                 {"plant.with_tour", false},
                                                                 {"plant.time_limit", 2.0},
                                                                 {"plant.duration", 4.0}})});
  ASSERT_TRUE(harness.bring_up(simulation).success);
  ASSERT_TRUE(harness.spin_until(
      [&] { return !progress.empty() && progress.back().state != MissionStatus::RUNNING; }));
  EXPECT_EQ(progress.back().state, MissionStatus::COMPLETE) << progress.back().message;
  EXPECT_EQ(asked, 0);
  EXPECT_NEAR(to_seconds(from_message(clock.back().clock) - from_message(clock.at(0).clock)), 4.0,
              0.11);
}

TEST(PatrolSimulation, AnotherGoalPreemptsTheTourAndThePlantGoesOn) {
  ComponentHarness harness;
  const auto scans = harness.collect(topics::kScan);
  const auto clock = harness.collect(topics::kClock);
  const auto progress = harness.collect(topics::kMissionStatus);
  const auto server = harness.peer().create_action_server<InspectTour>(
      "inspect_tour", {.accepted = [&](const ServerGoal<InspectTour>& goal) {
        InspectTour::Result result;
        result.reason = "preempted";
        goal.abort(result);
      }});
  auto& simulation = harness.make<PatrolSimulation>(
      {.parameters = small_plant({kLeakRows, {"plant.time_limit", 2.0}, {"plant.duration", 4.0}})});
  ASSERT_TRUE(harness.bring_up(simulation).success);
  ASSERT_TRUE(harness.spin_until(
      [&] { return !progress.empty() && progress.back().state != MissionStatus::RUNNING; }));
  EXPECT_EQ(progress.back().state, MissionStatus::COMPLETE) << progress.back().message;
  EXPECT_NEAR(to_seconds(from_message(clock.back().clock) - from_message(clock.at(0).clock)), 4.0,
              0.11);
}

TEST(PatrolSimulation, TellsWhereTheLeaksAre) {
  ComponentHarness harness;
  auto& simulation = harness.make<PatrolSimulation>({.parameters = short_patrol()});
  const auto leaks = harness.collect(topics::kTrueLeaks);
  const auto images = harness.collect(topics::kThermalImage);
  const auto info = harness.collect(topics::kThermalCameraInfo);
  ASSERT_TRUE(harness.bring_up(simulation).success);
  ASSERT_TRUE(harness.spin_until([&] { return !images.empty() && !leaks.empty(); }));
  ASSERT_EQ(leaks.size(), 1U);
  EXPECT_EQ(leaks.back().header.frame_id, "map");
  EXPECT_EQ(leaks.back().finding.id, 1U);
  EXPECT_NEAR(leaks.back().finding.position.x, 1, 1e-9);
  EXPECT_NEAR(leaks.back().finding.position.y, 10, 1e-9);
  EXPECT_EQ(leaks.back().finding.length, 0.3);
  EXPECT_EQ(leaks.back().finding.delta, 80);
}

TEST(PatrolSimulation, ShowsGreyLevelsWhenAskedTo) {
  ComponentHarness harness;
  auto& simulation = harness.make<PatrolSimulation>(
      {.parameters = short_patrol({{"camera.encoding", "mono8"}}, 320)});
  const auto progress = harness.collect(topics::kMissionStatus);
  const auto images = harness.collect(topics::kThermalImage);
  const auto info = harness.collect(topics::kThermalCameraInfo);
  ASSERT_TRUE(harness.bring_up(simulation).success);
  ASSERT_TRUE(harness.spin_until(
      [&] { return !progress.empty() && progress.back().state == MissionStatus::COMPLETE; }));
  ASSERT_FALSE(images.empty());
  EXPECT_EQ(images.back().encoding, "mono8");
  EXPECT_EQ(images.back().data.size(), 320U * 240U);
  // Somewhere on the way the leak is seen: 230 degC are 166 of 255.
  std::uint8_t brightest = 0;
  for (std::size_t i = 0; i < images.size(); ++i) {
    const auto& data = images.at(i).data;
    // Dead pixels shine alone.
    for (std::size_t k = 1; k + 1 < data.size(); ++k) {
      brightest = std::max(brightest, std::min({data[k - 1], data[k], data[k + 1]}));
    }
  }
  EXPECT_NEAR(brightest, 166, 12);
}

TEST(PatrolSimulation, WaitsForThoseWhoLookAndPausesWhenDeactivated) {
  ComponentHarness harness;
  auto& simulation = harness.make<PatrolSimulation>({.parameters = short_patrol()});
  const auto clock = harness.collect(topics::kClock);
  const auto progress = harness.collect(topics::kMissionStatus);
  ASSERT_TRUE(harness.bring_up(simulation).success);
  harness.spin();
  EXPECT_TRUE(clock.empty());
  ASSERT_FALSE(progress.empty());
  EXPECT_THAT(progress.back().message, HasSubstr("waiting"));
  const auto images = harness.collect(topics::kThermalImage);
  const auto info = harness.collect(topics::kThermalCameraInfo);
  ASSERT_TRUE(harness.spin_until([&] { return images.size() > 3; }));
  ASSERT_TRUE(harness.deactivate(simulation).success);
  const std::size_t sent = clock.size();
  harness.spin();
  EXPECT_EQ(clock.size(), sent);
  ASSERT_TRUE(harness.activate(simulation).success);
  ASSERT_TRUE(harness.spin_until([&] { return clock.size() > sent; }));
  EXPECT_EQ(from_message(clock.at(sent).clock) - from_message(clock.at(sent - 1).clock),
            std::chrono::milliseconds(200));
}

/// Answers each joint_states: the arm stays where it is.
trajectory_msgs::msg::JointTrajectory stay(const sensor_msgs::msg::JointState& joints) {
  trajectory_msgs::msg::JointTrajectory command;
  command.header.stamp = joints.header.stamp;
  command.joint_names = joints.name;
  command.points.resize(1);
  command.points[0].positions = joints.position;
  command.points[0].velocities.assign(joints.name.size(), 0.0);
  command.points[0].time_from_start = to_message(std::chrono::milliseconds(10));
  return command;
}

TEST(PatrolSimulation, CarriesAnArmThatDoesWhatItIsTold) {
  ComponentHarness harness;
  std::vector<NamedParameter> parameters = short_patrol({{"arm.mounted", true}});
  parameters.push_back({"rate", 1.0});  // else it has driven by before the test commands
  auto& simulation = harness.make<PatrolSimulation>({.name = "patrol", .parameters = parameters});
  const auto joints = harness.collect(topics::kJointStates);
  const auto images = harness.collect(topics::kThermalImage);
  const auto truth = harness.collect(topics::kTruePipeTrack);
  const auto info = harness.collect(topics::kThermalCameraInfo);
  ASSERT_TRUE(harness.bring_up(simulation).success);
  ASSERT_TRUE(harness.spin_until([&] { return joints.size() > 2; }));
  EXPECT_EQ(joints.back().name.size(), 6U);
  EXPECT_EQ(from_message(joints.at(1).header.stamp) - from_message(joints.at(0).header.stamp),
            std::chrono::milliseconds(10));
  for (int i = 0; i < 100; ++i) {
    const auto latest = joints.back();
    harness.publish(topics::kArmCommand, stay(latest));
    ASSERT_TRUE(harness.spin_until([&] {
      return from_message(joints.back().header.stamp) > from_message(latest.header.stamp);
    }));
  }
  EXPECT_GT(images.size(), 3U);
  EXPECT_EQ(truth.size(), images.size());
  EXPECT_EQ(images.back().header.frame_id, "camera_optical_frame");
}

TEST(PatrolSimulation, CommandsThatAreNoneAreCounted) {
  ComponentHarness harness;
  auto& simulation =
      harness.make<PatrolSimulation>({.parameters = short_patrol({{"arm.mounted", true}})});
  const auto joints = harness.collect(topics::kJointStates);
  const auto images = harness.collect(topics::kThermalImage);
  const auto info = harness.collect(topics::kThermalCameraInfo);
  ASSERT_TRUE(harness.bring_up(simulation).success);
  ASSERT_TRUE(harness.spin_until([&] { return !joints.empty(); }));
  const auto send = [&harness](const trajectory_msgs::msg::JointTrajectory& command) {
    harness.publish(topics::kArmCommand, command);
    harness.spin();  // of commands only the last one is kept
  };
  auto command = stay(joints.back());
  command.points.clear();
  send(command);
  command = stay(joints.back());
  command.joint_names.back() = "gripper";
  send(command);
  command = stay(joints.back());
  command.points[0].positions[0] = std::nan("");
  send(command);
  const auto told = harness.next_diagnostics(simulation);
  EXPECT_EQ(harness.value(told, "command.points.empty"), "1");
  EXPECT_EQ(harness.value(told, "command.missing_joint"), "1");
  EXPECT_EQ(harness.value(told, "command.refused"), "1");
}

std::string refusal(std::vector<NamedParameter> parameters) {
  ComponentHarness harness;
  auto& simulation = harness.make<PatrolSimulation>({.parameters = std::move(parameters)});
  const auto result = harness.configure(simulation);
  EXPECT_FALSE(result.success);
  return result.message;
}

TEST(PatrolSimulation, NamesWhatIsWrong) {
  EXPECT_THAT(refusal({{"terrain", "F"}}), HasSubstr("'terrain': 'F' is not one of A, B, C, D, E"));
  EXPECT_THAT(refusal({{"leaks", std::vector<double>{1, 2}}}),
              HasSubstr("'leaks' has 2 values: must be a multiple of three"));
  EXPECT_THAT(refusal(small_plant()), HasSubstr("'plant.leak_rows': 0 values for 2 leaks"));
  EXPECT_THAT(refusal(small_plant({{"plant.leak_rows", std::vector<std::int64_t>{0, 3}}})),
              HasSubstr("'plant.leak_rows': 3 is not one of 3 rows"));
  EXPECT_THAT(refusal(small_plant({kLeakRows, {"plant.obstacles", std::vector<double>{1, 2, 3}}})),
              HasSubstr("'plant.obstacles': 3 values"));
  EXPECT_THAT(refusal(small_plant({kLeakRows, {"plant.start", std::vector<double>{1}}})),
              HasSubstr("'plant.start': 1 values"));
  EXPECT_THAT(refusal(small_plant({kLeakRows, {"plant.start", std::vector<double>{5, 0, 0}}})),
              HasSubstr("is in an obstacle"));
  EXPECT_THAT(refusal({{"leaks", std::vector<double>{400, 0.3, 80}}}),
              HasSubstr("leaks[0].place: 400"));
  EXPECT_THAT(refusal({{"row.position", std::vector<double>{1}}}),
              HasSubstr("'row.position' has 1 values: must be 3"));
  EXPECT_THAT(refusal({{"datum", std::vector<double>{1}}}), HasSubstr("'datum' has 1 values"));
  EXPECT_THAT(refusal({{"camera.encoding", "rgb8"}}),
              HasSubstr("'rgb8' is neither mono16 nor mono8"));
  EXPECT_THAT(refusal({{"camera.grey_range", std::vector<double>{300, 100}}}),
              HasSubstr("lowest: 300"));
  EXPECT_THAT(refusal({{"imu", "perfect"}}), HasSubstr("perfect"));
  EXPECT_THAT(refusal({{"arm.mounted", true}, {"arm.camera_frame", "gripper"}}),
              HasSubstr("gripper"));
  EXPECT_THAT(refusal({{"arm.mounted", true}, {"arm.urdf_file", "/nowhere.urdf"}}),
              HasSubstr("/nowhere.urdf"));
}

}  // namespace
}  // namespace pipescout
