// SPDX-License-Identifier: Apache-2.0
#include "core/fleet_table.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>

namespace pipescout::host {
namespace {

using diagnostic_msgs::msg::DiagnosticArray;
using diagnostic_msgs::msg::DiagnosticStatus;
using ::testing::ElementsAre;
using ::testing::Field;
using ::testing::HasSubstr;
using ::testing::Not;
using namespace std::chrono_literals;  // NOLINT(google-build-using-namespace): literals

DiagnosticArray says(const std::string& name, DiagnosticLevel level, const std::string& message,
                     const std::vector<std::pair<std::string, std::string>>& values = {}) {
  DiagnosticStatus status;
  status.name = name;
  status.level = static_cast<std::uint8_t>(level);
  status.message = message;
  for (const auto& [key, value] : values) {
    diagnostic_msgs::msg::KeyValue pair;
    pair.key = key;
    pair.value = value;
    status.values.push_back(pair);
  }
  DiagnosticArray array;
  array.status.push_back(status);
  return array;
}

MessageInfo arrived(Duration sent_by_its_clock, Duration received_by_ours) {
  MessageInfo info;
  info.source_time = Time(sent_by_its_clock);
  info.reception_time = Time(received_by_ours);
  return info;
}

const SteadyTime kNow(100s);

TEST(RobotOf, IsTheFirstPartOfTheNamespace) {
  EXPECT_EQ(robot_of("/robot_1/arm/joints"), "robot_1");
  EXPECT_EQ(robot_of("robot_1/fusion: status"), "robot_1");
  EXPECT_EQ(robot_of("/fusion"), "/");
  EXPECT_EQ(robot_of("fusion: process of /robot_2/localizer"), "/");
}

TEST(FleetTableTest, KnowsRobotsByTheirNodes) {
  FleetTable table;
  table.nodes({{"/robot_2", "fusion"}, {"/robot_1", "fusion"}, {"/robot_1/arm", "joints"}});
  EXPECT_THAT(table.robots(kNow), ElementsAre(Field(&RobotState::name, "robot_1"),
                                              Field(&RobotState::name, "robot_2")));
  EXPECT_EQ(table.robots(kNow).front().nodes, 2U);
  EXPECT_FALSE(table.robots(kNow).front().last_heard);
}

TEST(FleetTableTest, KeepsARobotThatHasLeft) {
  FleetTable table;
  table.nodes({{"/robot_1", "fusion"}});
  table.nodes({});
  ASSERT_EQ(table.robots(kNow).size(), 1U);
  EXPECT_EQ(table.robots(kNow).front().nodes, 0U);
  EXPECT_THAT(to_text(table.robots(kNow)), HasSubstr("robot_1 has left, or cannot be reached"));
}

TEST(FleetTableTest, AddsUpTheProcessesAndLossesOfARobot) {
  FleetTable table;
  const auto info = arrived(10s, 10s);
  table.diagnostics(says("robot_1/host: process", DiagnosticLevel::kOk, "",
                         {{"cpu_percent", "12.5"}, {"started", "1000.5"}}),
                    info, kNow);
  table.diagnostics(says("robot_1/other: process", DiagnosticLevel::kOk, "",
                         {{"cpu_percent", "7.5"}, {"started", "2000"}}),
                    info, kNow);
  table.diagnostics(says("robot_1/fusion: status", DiagnosticLevel::kOk, "",
                         {{"subscription /robot_1/imu: lost_by_network", "3"},
                          {"subscription /robot_1/imu: dropped_queue_full", "4"},
                          {"subscription /robot_1/imu: expired", "5"},
                          {"publisher /robot_1/odometry: send_failures", "many"}}),
                    info, kNow + 2s);
  const auto robot = table.robots(kNow + 3s).front();
  EXPECT_EQ(robot.cpu_percent, 20.0);
  EXPECT_EQ(robot.started, Time(1000500ms));
  EXPECT_EQ(robot.drops, 7U);
  EXPECT_EQ(robot.last_heard, Duration(1s));
}

TEST(FleetTableTest, TakesTheShortestWayForTheClockOffset) {
  FleetTable table;
  for (const auto way : {80ms, 10ms, 200ms}) {
    table.diagnostics(says("robot_1/fusion: status", DiagnosticLevel::kOk, ""),
                      arrived(12s, 10s + way), kNow);
  }
  EXPECT_EQ(table.robots(kNow).front().clock_offset, Duration(1990ms));
  EXPECT_THAT(to_text(table.robots(kNow)), HasSubstr("robot_1 has a clock that is 2.0 s ahead"));
}

TEST(FleetTableTest, ForgetsAnOldClockOffset) {
  FleetTable table;
  table.diagnostics(says("robot_1/fusion: status", DiagnosticLevel::kOk, ""), arrived(12s, 10s),
                    kNow);
  for (int message = 0; message < 20; ++message) {
    table.diagnostics(says("robot_1/fusion: status", DiagnosticLevel::kOk, ""), arrived(10s, 10s),
                      kNow);
  }
  EXPECT_EQ(table.robots(kNow).front().clock_offset, Duration::zero());
}

TEST(FleetTableTest, NamesTheWorstStatusThatIsNotOld) {
  FleetTable table;
  const auto info = arrived(10s, 10s);
  table.diagnostics(says("robot_1/gone: status", DiagnosticLevel::kError, "broken"), info, kNow);
  table.diagnostics(says("robot_1/imu: status", DiagnosticLevel::kWarn, "slow"), info, kNow + 9s);
  table.diagnostics(says("robot_1/gps: status", DiagnosticLevel::kOk, "fine"), info, kNow + 9s);
  const auto robot = table.robots(kNow + 10s).front();
  EXPECT_EQ(robot.level, DiagnosticLevel::kWarn);
  EXPECT_EQ(robot.message, "robot_1/imu: status: slow");
}

TEST(FleetTableTest, LevelsThatDoNotExistAreErrors) {
  FleetTable table;
  auto message = says("robot_1/imu: status", DiagnosticLevel::kOk, "?");
  message.status[0].level = 200;
  table.diagnostics(message, arrived(10s, 10s), kNow);
  EXPECT_EQ(table.robots(kNow).front().level, DiagnosticLevel::kError);
}

TEST(FleetTableTest, SaysThatARobotIsSilent) {
  FleetTable table;
  table.nodes({{"/robot_1", "fusion"}});
  table.diagnostics(says("robot_1/fusion: status", DiagnosticLevel::kOk, ""), arrived(10s, 10s),
                    kNow);
  EXPECT_THAT(to_text(table.robots(kNow + 4s)), Not(HasSubstr("silent")));
  EXPECT_THAT(to_text(table.robots(kNow + 8s)), HasSubstr("robot_1 is silent since 8.0 s"));
}

TEST(FleetTableTest, AnUnknownChargeIsNone) {
  FleetTable table;
  table.battery("/robot_1/battery_state", 0.75, arrived(10s, 10s), kNow);
  EXPECT_EQ(table.robots(kNow).front().battery_percent, 75.0);
  table.battery("/robot_1/battery_state", std::numeric_limits<double>::quiet_NaN(),
                arrived(10s, 10s), kNow);
  EXPECT_FALSE(table.robots(kNow).front().battery_percent);
}

TEST(FleetTableTest, JsonHasNullForWhatIsNotKnown) {
  FleetTable table;
  table.nodes({{"/robot_1", "fusion"}});
  table.diagnostics(says("robot_2/fusion: status", DiagnosticLevel::kWarn, "\xff slow"),
                    arrived(9s, 10s), kNow);
  const auto document = nlohmann::json::parse(to_json(table.robots(kNow + 1s), Time(0s)));
  EXPECT_EQ(document["time"], "1970-01-01T00:00:00.000Z");
  ASSERT_EQ(document["robots"].size(), 2U);
  EXPECT_EQ(document["robots"][0]["name"], "robot_1");
  EXPECT_TRUE(document["robots"][0]["last_heard_s"].is_null());
  EXPECT_TRUE(document["robots"][0]["cpu_percent"].is_null());
  EXPECT_EQ(document["robots"][1]["last_heard_s"], 1.0);
  EXPECT_EQ(document["robots"][1]["clock_offset_s"], -1.0);
  EXPECT_EQ(document["robots"][1]["level"], "warning");
}

}  // namespace
}  // namespace pipescout::host
