// SPDX-License-Identifier: Apache-2.0
// `pipescout summary` of bags as ROS 2 and as our missions leave them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <diagnostic_msgs/msg/diagnostic_array.hpp>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <map>
#include <nav_msgs/msg/odometry.hpp>
#include <pipescout_msgs/msg/mission_status.hpp>
#include <sensor_msgs/msg/imu.hpp>
#include <sensor_msgs/msg/nav_sat_fix.hpp>
#include <string>
#include <vector>

#include "bag_sections.hpp"
#include "pipescout/bag_topics/bag_topic.hpp"
#include "pipescout/bags/bag_error.hpp"
#include "pipescout/bags/bag_writer.hpp"
#include "pipescout/files/testing/temporary_folder.hpp"
#include "pipescout/testing/program.hpp"

namespace pipescout::summary {
namespace {

using pipescout_msgs::msg::MissionStatus;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::Each;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;
namespace fs = std::filesystem;

constexpr std::int64_t kSecond = 1'000'000'000;
constexpr std::int64_t kBegin = 1'700'000'000 * kSecond;

class SummaryOfABag : public ::testing::Test {
 protected:
  /// At `seconds` after the begin of the bag.
  template <class T>
  void write(const std::string& topic, const T& message, double seconds) {
    const MessageType& type = message_type<T>();
    std::vector<std::byte> data(type.serialized_size(&message));
    ASSERT_EQ(type.serialize(&message, data), data.size());
    write_bytes(topic, std::string(type.name), data, seconds);
  }
  void write_bytes(const std::string& topic, const std::string& type,
                   const std::vector<std::byte>& data, double seconds) {
    const std::int64_t time = kBegin + static_cast<std::int64_t>(seconds * 1e9);
    writer_.write({.topic = writer_.add_topic(make_bag_topic(topic, type, {})),
                   .log_time = time,
                   .publish_time = time,
                   .data = data});
  }
  template <class T>
  static T stamped(double seconds) {
    T message;
    message.header.stamp.sec = static_cast<std::int32_t>(kBegin / kSecond);
    message.header.stamp.nanosec = static_cast<std::uint32_t>(seconds * 1e9);
    return message;
  }
  void lose(const std::string& node, const std::string& topic, int messages, double seconds) {
    diagnose(node, "subscription " + topic + ": dropped_queue_full", messages, seconds);
  }
  void diagnose(const std::string& node, const std::string& key, int value, double seconds) {
    diagnostic_msgs::msg::DiagnosticArray array;
    array.status.resize(1);
    array.status[0].name = node;
    array.status[0].values.resize(1);
    array.status[0].values[0].key = key;
    array.status[0].values[0].value = std::to_string(value);
    write("/diagnostics", array, seconds);
  }
  void report(const std::string& node, std::uint8_t state, double seconds) {
    MissionStatus status;
    status.node = node;
    status.state = state;
    write("/mission/status", status, seconds);
  }
  [[nodiscard]] BagSections sections(const Mission& mission = {}) {
    writer_.close();
    return summarise({bag_}, mission, [](double) {});
  }

  testing::TemporaryFolder folder_;
  const fs::path bag_ = folder_.path() / "bag";
  bags::BagWriter writer_{bag_, {}};
};

TEST_F(SummaryOfABag, TopicsHaveRatesGapsAndDelays) {
  for (const double time : {0.0, 0.1, 0.2, 0.9}) {
    write("/imu", stamped<sensor_msgs::msg::Imu>(time), time + 0.004);
  }
  write_bytes("/strange", "other_msgs/msg/Unknown", std::vector<std::byte>(8), 1.0);
  const BagSections found = sections();
  EXPECT_THAT(found.problems, IsEmpty());
  const MissionSection& topics = found.sections.at("topics");
  ASSERT_THAT(topics.rows, SizeIs(2));
  EXPECT_EQ(topics.rows[0][0], MissionCell("/imu"));
  EXPECT_EQ(topics.rows[0][2], MissionCell(std::int64_t{4}));
  EXPECT_NEAR(std::get<double>(topics.rows[0][3]), 3.33, 1e-9);
  EXPECT_NEAR(std::get<double>(topics.rows[0][4]), 0.7, 1e-9);
  EXPECT_NEAR(std::get<double>(topics.rows[0][5]), 0.004, 1e-9);
  EXPECT_EQ(topics.rows[1][3], MissionCell());
  EXPECT_EQ(topics.figures.at("bag_messages"), 5.0);
  EXPECT_THAT(topics.notes, Contains(HasSubstr("other_msgs/msg/Unknown is not known here")));
  EXPECT_THAT(topics.notes, Contains(HasSubstr("2023-11-14 22:13:20 UTC")));
}

TEST_F(SummaryOfABag, StampsOfAnotherClockGoingBackOrMissingAreNamed) {
  auto odometry = stamped<nav_msgs::msg::Odometry>(0.5);
  write("/back", odometry, 1.0);
  odometry.header.stamp.nanosec = 0;
  write("/back", odometry, 1.1);
  odometry.header.stamp.sec = 12;
  write("/boot_time", odometry, 2.0);
  odometry.header.stamp.sec = 0;
  write("/none", odometry, 3.0);
  const auto found = sections();
  EXPECT_THAT(found.sections.at("topics").notes,
              AllOf(Contains("/back: stamps go back 1 times."),
                    Contains(HasSubstr("/boot_time: stamps are of another clock than the "
                                       "recording's, 1699999990.000 s before it.")),
                    Contains("/none: 1 of 1 messages have no stamp.")));
}

TEST_F(SummaryOfABag, NodesReportByClocksOfTheirOwn) {
  diagnostic_msgs::msg::DiagnosticArray told;
  for (const int stamp : {1'800'000'000, 0, 7}) {
    told.header.stamp.sec = stamp;
    write("/diagnostics", told, 1000.0);
  }
  EXPECT_THAT(sections().sections.at("topics").notes, Each(Not(HasSubstr("/diagnostics"))));
}

TEST_F(SummaryOfABag, MotionIsToldOfStandardMessages) {
  auto odometry = stamped<nav_msgs::msg::Odometry>(0.0);
  odometry.header.frame_id = "odom";
  odometry.child_frame_id = "base_link";
  double time = 0.0;
  for (const double x : {0.0, 3.0, 1.0}) {
    odometry.pose.pose.position.x = x;
    odometry.twist.twist.linear.x = x;
    write("/odom", odometry, time);
    time += 1.0;
  }
  odometry.pose.pose.position.x = std::numeric_limits<double>::quiet_NaN();
  write("/odom", odometry, 4.0);
  auto imu = stamped<sensor_msgs::msg::Imu>(0.0);
  imu.linear_acceleration.z = 1.0;
  write("/imu_in_g", imu, 4.1);
  imu.linear_acceleration.z = 0.0;
  write("/dead_imu", imu, 4.2);
  auto fix = stamped<sensor_msgs::msg::NavSatFix>(0.0);
  fix.position_covariance_type = 2;
  fix.position_covariance = {4.0, 0, 0, 0, 4.0, 0, 0, 0, 9.0};
  write("/fix", fix, 5.0);  // at 0, 0
  fix.latitude = 45.0;
  fix.longitude = 8.0;
  write("/fix", fix, 5.1);
  fix.latitude = 45.001;
  write("/fix", fix, 5.2);
  fix.status.status = -1;
  write("/fix", fix, 5.3);
  const auto found = sections();
  const auto& way = found.sections.at("odometry").rows.at(0);
  EXPECT_EQ(way[1], MissionCell("odom -> base_link"));
  EXPECT_EQ(way[3], MissionCell(5.0));
  EXPECT_EQ(way[4], MissionCell(1.0));
  EXPECT_EQ(way[5], MissionCell(3.0));
  EXPECT_EQ(way[6], MissionCell(std::int64_t{1}));
  EXPECT_EQ(found.sections.at("imu").rows.at(0)[5], MissionCell(std::int64_t{1}));
  EXPECT_THAT(found.sections.at("imu").notes,
              Contains(HasSubstr("/imu_in_g: the mean specific force is not that of gravity")));
  const auto& gps = found.sections.at("gps").rows.at(0);
  EXPECT_EQ(gps[2], MissionCell(std::int64_t{1}));
  EXPECT_EQ(gps[3], MissionCell(std::int64_t{1}));
  EXPECT_EQ(gps[4], MissionCell(2.0));
  EXPECT_NEAR(std::get<double>(gps[5]), 111.2, 0.01);
}

TEST_F(SummaryOfABag, AMissionThatLostInputsIsNotCalledComplete) {
  report("/simulation", MissionStatus::COMPLETE, 0.0);
  lose("fusion", "/readings", 3, 1.0);
  lose("fusion", "/readings", 5, 2.0);
  lose("fusion", "/readings", 2, 3.0);  // it was restarted
  const auto found = sections();
  EXPECT_EQ(found.sections.at("inputs").figures.at("inputs_lost"), 7.0);
  EXPECT_THAT(found.sections.at("mission").notes, Contains(HasSubstr("Not complete: inputs")));
}

TEST_F(SummaryOfABag, WhatAListenerLostIsNotOfTheMission) {
  report("/robot/simulation", MissionStatus::COMPLETE, 0.0);
  lose("/robot/fusion", "/readings", 0, 1.0);
  lose("rosbag2_recorder", "/clock", 27, 1.0);
  const auto found = sections({.info = {.nodes = {"/robot/simulation", "/robot/fusion"}}});
  const auto& inputs = found.sections.at("inputs");
  EXPECT_EQ(inputs.figures.at("inputs_lost"), 0.0);
  EXPECT_THAT(inputs.notes, Contains(HasSubstr("27 messages were lost by nodes that only")));
  EXPECT_THAT(found.sections.at("mission").notes, Contains(HasSubstr("Complete.")));
}

TEST_F(SummaryOfABag, WhatOthersOfTheMissionLostIsCounted) {
  report("/robot/simulation", MissionStatus::COMPLETE, 0.0);
  lose("/robot/fusion", "/readings", 2, 1.0);
  const auto found = sections({.info = {.nodes = {"/robot/simulation", "/robot/fusion"}}});
  EXPECT_EQ(found.sections.at("inputs").figures.at("inputs_lost"), 2.0);
}

TEST_F(SummaryOfABag, WhatAnotherRobotLostIsNotOfTheMission) {
  report("/robot/simulation", MissionStatus::COMPLETE, 0.0);
  lose("robot_2/fusion", "/robot_2/readings", 27, 1.0);
  lose("robot/fusion", "/diagnostics", 14, 1.0);  // of all robots
  const auto found = sections({.info = {.nodes = {"/robot/simulation", "/robot/fusion"}}});
  const auto& inputs = found.sections.at("inputs");
  EXPECT_EQ(inputs.figures.at("inputs_lost"), 0.0);
  EXPECT_THAT(inputs.notes, Contains(HasSubstr("41 messages were lost by nodes that only")));
  EXPECT_THAT(found.sections.at("mission").notes, Contains(HasSubstr("Complete.")));
}

TEST_F(SummaryOfABag, WhatTheRecorderCouldNotTakeIsLostToo) {
  report("/simulation", MissionStatus::COMPLETE, 0.0);
  diagnose("bag_recorder: status", "dropped./camera/image_raw", 4, 1.0);
  diagnose("bag_recorder: status", "dropped./camera/image_raw", 6, 2.0);
  diagnose("bag_recorder: status", "not_recorded./words", 1, 2.0);
  diagnose("other: status", "dropped.for_another_reason", 9, 2.0);
  const auto found = sections();
  const auto& inputs = found.sections.at("inputs");
  EXPECT_EQ(inputs.figures.at("inputs_lost"), 7.0);
  ASSERT_THAT(inputs.rows, SizeIs(2));
  EXPECT_EQ(inputs.rows[0][1], MissionCell("/camera/image_raw"));
  EXPECT_EQ(inputs.rows[0][2], MissionCell("dropped_by_recorder"));
  EXPECT_EQ(inputs.rows[1][2], MissionCell("not_recorded"));
  EXPECT_THAT(found.sections.at("mission").notes, Contains(HasSubstr("Not complete: inputs")));
}

TEST_F(SummaryOfABag, WithoutDiagnosticsItIsNotKnownWhetherAMissionIsComplete) {
  report("/simulation", MissionStatus::COMPLETE, 0.0);
  EXPECT_THAT(sections().sections.at("mission").notes,
              Contains(HasSubstr("whether inputs were lost is not known")));
}

TEST_F(SummaryOfABag, TheCommandFailsForAMissionThatLostInputs) {
  report("/simulation", MissionStatus::COMPLETE, 0.0);
  lose("fusion", "/readings", 3, 1.0);
  writer_.close();
  const auto result = testing::run_program(SUMMARY_COMMAND, {"bag"}, folder_.path());
  EXPECT_EQ(result.code(), 1);
  EXPECT_THAT(result.err, HasSubstr("3 inputs were lost: the mission is not complete"));
}

TEST_F(SummaryOfABag, AMissionIsCompleteWhenAllItsNodesAre) {
  report("/simulation", MissionStatus::RUNNING, 0.0);
  report("/simulation", MissionStatus::COMPLETE, 1.0);
  lose("fusion", "/readings", 0, 1.0);
  EXPECT_THAT(sections().sections.at("mission").notes, Contains("Complete."));
}

TEST_F(SummaryOfABag, AMissionThatWasInterruptedNamesWhoIsNotThrough) {
  report("/simulation", MissionStatus::RUNNING, 0.0);
  const auto found = sections();
  EXPECT_THAT(found.sections.at("mission").notes, Contains("Not complete: /simulation."));
  EXPECT_THAT(found.sections.at("inputs").notes, Contains(HasSubstr("is not known")));
}

TEST_F(SummaryOfABag, WhatIsNoMessageOfItsTypeIsCounted) {
  write_bytes("/imu", "sensor_msgs/msg/Imu", std::vector<std::byte>(5), 0.0);
  EXPECT_THAT(sections().problems, Contains("/imu: 1 messages are no sensor_msgs/msg/Imu"));
}

TEST_F(SummaryOfABag, TheCommandPrintsAndWritesThem) {
  write("/odom", stamped<nav_msgs::msg::Odometry>(0.0), 0.0);
  writer_.close();
  const auto run = [&](const std::vector<std::string>& arguments) {
    return testing::run_program(SUMMARY_COMMAND, arguments, folder_.path());
  };
  const auto bag = run({"bag", "--json", "tables.json"});
  EXPECT_EQ(bag.code(), 0) << bag.err;
  EXPECT_THAT(bag.out, AllOf(HasSubstr("Topics (bag.topics)"), HasSubstr("Odometry (bag.odometry)"),
                             HasSubstr("bag_messages = 1")));
  EXPECT_THAT(testing::content(folder_.path() / "tables.json"), HasSubstr("\"bag_messages\": 1"));
  EXPECT_THAT(run({"bag", "--json", "tables.json"}).err,
              HasSubstr("tables.json: exists already; results are never overwritten"));
  const auto none = run({"nowhere"});
  EXPECT_EQ(none.code(), 1);
  EXPECT_THAT(none.err, HasSubstr("nowhere: no such file or folder"));
  std::ofstream(folder_.path() / "text.mcap") << "no bag";
  EXPECT_EQ(run({"text.mcap"}).code(), 1);
  // In a mission folder its tables stand beside those of the components.
  fs::create_directory(folder_.path() / "mission");
  std::ofstream(folder_.path() / "mission" / "mission.yaml") << "name: survey\n";
  fs::rename(bag_, folder_.path() / "mission" / "bag");
  const auto mission = run({"mission"});
  EXPECT_EQ(mission.code(), 0) << mission.err;
  EXPECT_THAT(mission.out, AllOf(HasSubstr("Mission survey"), HasSubstr("Topics (bag.topics)")));
  EXPECT_THAT(testing::content(folder_.path() / "mission" / "summary.json"),
              HasSubstr("bag.topics"));
}

}  // namespace
}  // namespace pipescout::summary
