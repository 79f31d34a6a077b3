// SPDX-License-Identifier: Apache-2.0
// Tables, sections and outcomes of missions, from bags with our topics.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nav_msgs/msg/odometry.hpp>
#include <pipescout_msgs/msg/estimator_state.hpp>
#include <pipescout_msgs/msg/fused_odometer.hpp>
#include <pipescout_msgs/msg/leak_detections.hpp>
#include <pipescout_msgs/msg/mission_status.hpp>
#include <pipescout_msgs/msg/odometer_readings.hpp>
#include <pipescout_msgs/msg/pipe_position.hpp>
#include <sensor_msgs/msg/nav_sat_fix.hpp>
#include <string>
#include <system_error>
#include <tf2_msgs/msg/tf_message.hpp>
#include <vector>

#include "bag_sections.hpp"
#include "pipescout/bag_topics/bag_topic.hpp"
#include "pipescout/bags/bag_writer.hpp"
#include "pipescout/csv/csv_table.hpp"
#include "pipescout/files/testing/temporary_folder.hpp"
#include "pipescout/message_conversions/map_origin.hpp"
#include "pipescout/testing/program.hpp"
#include "tables/table_files.hpp"

namespace pipescout::summary {
namespace {

using pipescout_msgs::msg::FusedOdometer;
using pipescout_msgs::msg::LeakDetections;
using pipescout_msgs::msg::MissionStatus;
using pipescout_msgs::msg::OdometerReadings;
using pipescout_msgs::msg::PipePosition;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
namespace fs = std::filesystem;

constexpr std::int32_t kBegin = 1'700'000'000;  // s

template <class T>
T at(int second) {
  T message;
  message.header.stamp.sec = kBegin + second;
  return message;
}

PipePosition position(int second) {
  auto message = at<PipePosition>(second);
  message.odometer_distance = second;
  return message;
}

MissionStatus status(const std::string& node, std::uint8_t state, int second,
                     std::uint32_t total = 0) {
  auto message = at<MissionStatus>(second);
  message.node = node;
  message.state = state;
  message.total = total;
  message.message = "out of current";
  return message;
}

OdometerReadings readings(int second, const std::vector<double>& distances) {
  auto message = at<OdometerReadings>(second);
  for (std::size_t i = 0; i < distances.size(); ++i) {
    message.name.push_back("wheel_" + std::to_string(i + 1));
    message.valid.push_back(true);
  }
  message.distance = distances;
  return message;
}

FusedOdometer fused(int second, double distance) {
  auto message = at<FusedOdometer>(second);
  message.name = {"wheel_1", "wheel_2"};
  message.in_fusion_set = {true, true};
  message.rejection_reason = {0, 0};
  message.support = {1, 1, 1, 1};
  message.distance = distance;
  message.variance = 0.25;
  return message;
}

nav_msgs::msg::Odometry odometry(int second) {
  auto message = at<nav_msgs::msg::Odometry>(second);
  message.pose.pose.orientation.w = 1;
  for (std::size_t k = 0; k < 6; ++k) {
    message.pose.covariance[7 * k] = 0.01;
  }
  return message;
}

class TablesOfAMission : public ::testing::Test {
 protected:
  TablesOfAMission() { fs::create_directories(folder_); }

  template <class T>
  void write(const std::string& topic, const T& message) {
    const MessageType& type = message_type<T>();
    std::vector<std::byte> data(type.serialized_size(&message));
    ASSERT_EQ(type.serialize(&message, data), data.size());
    time_ += 1'000'000;
    writer_.write({.topic = writer_.add_topic(make_bag_topic(topic, std::string(type.name), {})),
                   .log_time = time_,
                   .publish_time = time_,
                   .data = data});
  }
  void compose(const std::string& yaml) const { std::ofstream(folder_ / "mission.yaml") << yaml; }
  /// As `pipescout summary FOLDER` makes them.
  [[nodiscard]] BagSections tables() {
    writer_.close();
    return summarise(bags_of(folder_), {.info = read_mission_info(folder_), .folder = folder_},
                     [](double) {});
  }
  [[nodiscard]] std::string content(const std::string& file) const {
    return testing::content(folder_ / file);
  }

  testing::TemporaryFolder temporary_;
  const fs::path folder_ = temporary_.path() / "mission";
  std::int64_t time_ = std::int64_t{kBegin} * 1'000'000'000;
  bags::BagWriter writer_{folder_ / "bag", {}};
};

constexpr const char* kCrawler = R"(name: c
components:
  - type: "pipescout::BagRecorder"
    name: recorder
    parameters: {source: simulation}
)";

TEST_F(TablesOfAMission, FilesAndSectionComeOfTheTopicsOfTheSubject) {
  compose(kCrawler);
  write("/pipe/position", position(1));
  write("/pipe/position", position(2));
  write("/mission/status", status("/simulation", MissionStatus::COMPLETE, 2));
  const auto found = tables();
  EXPECT_THAT(found.problems, IsEmpty());
  const auto& section = found.tables.at("crawler");
  EXPECT_EQ(section.figures.at("crawler_positions"), 2.0);
  EXPECT_EQ(section.notes.front(), "Complete: 2 positions and 0 welds recorded.");
  EXPECT_THAT(content("crawler/positions.csv"),
              AllOf(HasSubstr("stamp,odometer_distance"), HasSubstr("\n1700000002.000000000,2,")));
  EXPECT_FALSE(fs::exists(folder_ / "crawler/welds.csv"));
}

TEST_F(TablesOfAMission, WhatIsStampedAfterTheEndOfTheSourceIsLeftOut) {
  compose(kCrawler);
  write("/pipe/position", position(1));
  write("/mission/status", status("/another", MissionStatus::COMPLETE, 0));
  write("/mission/status", status("/simulation", MissionStatus::COMPLETE, 2));
  write("/pipe/position", position(2));
  write("/pipe/position", position(3));
  EXPECT_EQ(tables().tables.at("crawler").figures.at("crawler_positions"), 2.0);
}

TEST_F(TablesOfAMission, EachRobotHasItsOwn) {
  for (const std::string robot : {"robot_1", "robot_2"}) {
    write("/" + robot + "/pipe/position", position(1));
  }
  const auto found = tables();
  EXPECT_EQ(found.tables.at("robot_2.crawler").figures.at("robot_2.crawler_positions"), 1.0);
  EXPECT_TRUE(fs::exists(folder_ / "robot_1/crawler/positions.csv"));
  // Nobody knows when it was complete.
  EXPECT_THAT(found.tables.at("robot_1.crawler").notes.front(), HasSubstr("Found: 1 positions"));
}

TEST_F(TablesOfAMission, FailsWithItsSourceAndWhenTheSourceIsCompleteWithoutData) {
  compose(kCrawler);
  write("/leak/detections", at<LeakDetections>(1));
  write("/mission/status", status("/simulation", MissionStatus::FAILED, 2));
  const auto found = tables();
  EXPECT_THAT(found.tables.at("leaks").notes.front(),
              "Failed: /simulation failed: out of current.");
  EXPECT_THAT(found.problems, Contains(HasSubstr("leaks: Failed: /simulation failed")));
}

TEST_F(TablesOfAMission, MalformedMessagesAreCountedAndLeftOut) {
  auto bad = fused(1, 1.0);
  bad.rejection_reason.clear();
  write("/odometer/fused", bad);
  write("/pipe/position", position(1));
  EXPECT_THAT(tables().tables.at("crawler").notes,
              Contains("Left out, 1 times: fused distances: lists of different lengths."));
  EXPECT_FALSE(fs::exists(folder_ / "crawler/fused.csv"));
}

TEST_F(TablesOfAMission, ReadingsWantTheirFusedDistancesAndAReference) {
  std::ofstream(temporary_.path() / "paper.csv") << "paper\n1.5\n2.0\n";
  compose(std::string(kCrawler) +
          "summary:\n  odometry.reference_file: " + (temporary_.path() / "paper.csv").string() +
          "\n  odometry.reference_columns: [reference, paper]\n"
          "  odometry.notes: [\"Of a dry pipe.\"]\n");
  write("/odometer/readings", readings(1, {1.0, 1.2}));
  write("/odometer/fused", fused(1, 1.1));
  write("/odometer/readings", readings(2, {2.0, 2.2}));
  write("/mission/status", status("/simulation", MissionStatus::COMPLETE, 2, 2));
  const auto found = tables();
  const auto& section = found.tables.at("odometry");
  EXPECT_THAT(section.notes,
              AllOf(Contains("Failed: 2 of 2 readings recorded, 1 fused distances, 1 of them with "
                             "their readings."),
                    Contains("Of a dry pipe.")));
  EXPECT_THAT(section.columns, Contains("paper [m]"));
  EXPECT_THAT(found.problems, Contains(HasSubstr("odometry: Failed")));
  EXPECT_THAT(content("odometry/fused.csv"), HasSubstr("1,1700000001.000000000,1.1,0.5,ok,1 2,"));
}

TEST_F(TablesOfAMission, ReadingsHaveTheOffsetsOfTheirFusion) {
  compose(std::string(kCrawler) +
          "  - {type: \"pipescout::OdometryFusion\", name: fusion, parameters: {offsets: [0.5, "
          "0.25]}}\n");
  write("/odometer/readings", readings(1, {1.0, 1.2}));
  write("/odometer/fused", fused(1, 1.475));
  const auto section = tables().tables.at("odometry");
  EXPECT_THAT(section.columns,
              AllOf(Contains("wheel_1 + 0.5 [m]"), Contains("wheel_2 + 0.25 [m]")));
  EXPECT_EQ(section.rows[0][1], MissionCell(1.5));
  EXPECT_EQ(section.rows[0][2], MissionCell(1.45));
  EXPECT_THAT(content("odometry/readings.csv"), HasSubstr(",1,1.2,"));
}

TEST_F(TablesOfAMission, FixesAreInTheMapOfTheEstimator) {
  compose(kCrawler);
  const auto fix = [](int second, double latitude) {
    auto message = at<sensor_msgs::msg::NavSatFix>(second);
    message.latitude = latitude;
    message.longitude = -5.83;
    message.altitude = 60;
    return message;
  };
  // Before the estimator tells where its map is, and after it.
  write("/gps/fix", fix(1, 36.66));
  tf2_msgs::msg::TFMessage told;
  told.transforms.push_back(
      map_origin_transform(geometry::LocalFrame({36.6599, -5.83, 50}), "map", {}));
  write("/tf", told);
  write("/gps/fix", fix(2, 36.66));
  write("/odometry/filtered", odometry(2));
  const auto found = tables();
  const CsvTable gps(content("estimator/gps.csv"), "gps.csv");
  ASSERT_EQ(gps.rows(), 2U);
  for (const std::size_t row : {0U, 1U}) {
    EXPECT_NEAR(std::stod(gps.cell(row, 5)), 11.1, 0.01);  // y: north
    EXPECT_NEAR(std::stod(gps.cell(row, 6)), 10.0, 1e-3);
  }
  EXPECT_THAT(found.tables.at("estimator").notes,
              Contains("Origin of the map: 36.6599000, -5.8300000, 50.00 m, as the estimator tells "
                       "it."));
}

TEST_F(TablesOfAMission, FixesOfAMapWhoseOriginIsNotToldAreFromTheFirst) {
  auto fix = at<sensor_msgs::msg::NavSatFix>(1);
  fix.latitude = 36.66;
  write("/gps/fix", fix);
  write("/odometry/filtered", odometry(1));
  const auto found = tables();
  EXPECT_THAT(found.tables.at("estimator").notes, Contains(HasSubstr("which is the first fix")));
  EXPECT_THAT(content("estimator/gps.csv"), HasSubstr(",36.66,0,0,0,0,0\n"));
}

TEST_F(TablesOfAMission, OdometersThatAreFollowedOverTimeHaveNoTableOfReadings) {
  auto message = fused(1, 1.0);
  message.health = {0, 0};
  write("/odometer/readings", readings(1, {1.0, 1.2}));
  write("/odometer/fused", message);
  EXPECT_THAT(tables().tables, IsEmpty());
  EXPECT_FALSE(fs::exists(folder_ / "odometry"));
}

TEST_F(TablesOfAMission, AnEstimatorThatNeverRanSaysWhatItWaitedFor) {
  compose(kCrawler);
  auto state = at<pipescout_msgs::msg::EstimatorState>(1);
  state.waits_for = "a position and a heading";
  write("/estimator/state", state);
  write("/odometry/filtered", nav_msgs::msg::Odometry{});  // malformed: no orientation
  write("/mission/status", status("/simulation", MissionStatus::COMPLETE, 2));
  const auto found = tables();
  EXPECT_THAT(found.tables.at("estimator").notes.front(), HasSubstr("Failed: 0 estimates"));
  EXPECT_THAT(content("estimator/state.csv"), HasSubstr("a position and a heading"));
}

TEST_F(TablesOfAMission, BagsOfARecorderThatWasRestartedAreReadAsOne) {
  write("/pipe/position", position(1));
  bags::BagWriter second(folder_ / "bag_2", {});
  writer_.close();
  const MessageType& type = message_type<PipePosition>();
  const auto message = position(2);
  std::vector<std::byte> data(type.serialized_size(&message));
  type.serialize(&message, data);
  second.write(
      {.topic = second.add_topic(make_bag_topic("/pipe/position", std::string(type.name), {})),
       .log_time = time_ + 1,
       .publish_time = time_ + 1,
       .data = data});
  second.close();
  EXPECT_EQ(tables().tables.at("crawler").figures.at("crawler_positions"), 2.0);
}

TEST_F(TablesOfAMission, AnUnknownOptionIsNamedWithItsPlace) {
  compose("name: c\ncomponents: []\nsummary:\n  rack.image: 1.0\n");
  try {
    static_cast<void>(read_mission_info(folder_));
    FAIL() << "it was taken";
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("mission.yaml:4"),
                                    HasSubstr("summary.rack.image is not known; there are "),
                                    HasSubstr("rack.image_period")));
  }
  compose("name: c\ncomponents: []\nsummary:\n  rack.image_period: -1.0\n");
  EXPECT_THROW(static_cast<void>(read_mission_info(folder_)), std::invalid_argument);
  compose("name: c\ncomponents: []\nsummary:\n  rack.rack: 5\n");
  EXPECT_THROW(static_cast<void>(read_mission_info(folder_)), std::invalid_argument);
}

TEST_F(TablesOfAMission, TheCommandMakesTheFilesAnewAndOfAnyBagIntoAFolder) {
  write("/pipe/position", position(1));
  writer_.close();
  compose("name: survey\ncomponents: []\n");
  fs::create_directories(folder_ / "crawler");
  std::ofstream(folder_ / "crawler/old.csv") << "of another version\n";
  const auto run = [&](const std::vector<std::string>& arguments) {
    return testing::run_program(SUMMARY_COMMAND, arguments, temporary_.path());
  };
  const auto mission = run({"mission"});
  EXPECT_EQ(mission.code(), 0) << mission.err;
  EXPECT_THAT(mission.out, HasSubstr("Crawler (crawler)"));
  EXPECT_THAT(content("summary.json"), HasSubstr("\"crawler_positions\": 1"));
  EXPECT_FALSE(fs::exists(folder_ / "crawler/old.csv"));
  EXPECT_EQ(run({"mission/bag"}).code(), 0);
  EXPECT_EQ(run({"mission/bag", "--tables", "elsewhere"}).code(), 0);
  EXPECT_EQ(testing::content(temporary_.path() / "elsewhere/crawler/positions.csv"),
            content("crawler/positions.csv"));
  const auto over = run({"mission/bag", "--tables", "elsewhere"});
  EXPECT_EQ(over.code(), 1);
  EXPECT_THAT(over.err, HasSubstr("elsewhere: is not empty ("));
}

TEST(TableFiles, AppearTogetherAndOnlyWhenTheyAreFinished) {
  const testing::TemporaryFolder temporary;
  {
    TableFiles unfinished(temporary.path() / "data");
    unfinished.file("a.csv", [] { return std::string("x"); }).write("1");
  }
  EXPECT_TRUE(fs::is_empty(temporary.path()));
  TableFiles files(temporary.path() / "data");
  files.file("a.csv", [] { return std::string("x"); }).write("1");
  files.write_whole("pictures/1.pgm", "P5");
  EXPECT_FALSE(fs::exists(temporary.path() / "data"));
  files.finish();
  EXPECT_EQ(testing::content(temporary.path() / "data/a.csv"), "x\n1\n");
  EXPECT_EQ(testing::content(temporary.path() / "data/pictures/1.pgm"), "P5");
}

TEST(TableFiles, AFullDiskIsNamed) {
  const testing::TemporaryFolder temporary;
  std::ofstream(temporary.path() / "file") << "no folder";
  TableFiles files(temporary.path() / "file/data");
  EXPECT_THROW(static_cast<void>(files.file("a.csv", [] { return std::string("x"); })),
               std::system_error);
  if (fs::exists("/dev/full")) {
    TableFile full(fs::path("/dev/full"));
    full.write("1");
    EXPECT_THROW(full.close(), std::system_error);
  }
}

}  // namespace
}  // namespace pipescout::summary
