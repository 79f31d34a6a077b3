// SPDX-License-Identifier: Apache-2.0
#include "pipescout/odometry_recorder/odometry_recorder.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "pipescout/catalogue/topics.hpp"
#include "pipescout/files/testing/temporary_folder.hpp"
#include "pipescout/odometer_replay/csv_file.hpp"
#include "pipescout/odometer_replay/readings_csv.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "pipescout/testing/component_harness.hpp"

namespace {

int syncs = 0;

}  // namespace

// Takes the place of the C library's, so that tests see who waits for the disk.
extern "C" int fsync(int descriptor) {
  ++syncs;
  return static_cast<int>(::syscall(SYS_fsync, descriptor));
}

namespace pipescout {
namespace {

using pipescout::testing::content;
using pipescout::testing::lines;
using pipescout::testing::TemporaryFolder;
using pipescout_msgs::msg::FusedOdometer;
using pipescout_msgs::msg::MissionStatus;
using pipescout_msgs::msg::OdometerReadings;
using testing::ComponentHarness;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

OdometerReadings readings_at(int second, std::vector<double> distance = {5.45, 5.34}) {
  OdometerReadings message;
  message.header.stamp = to_message(Time(std::chrono::seconds(second)));
  message.name = {"left", "right"};
  message.distance = std::move(distance);
  message.standard_deviation = {0.06, 0.055};
  message.valid = {true, false};
  return message;
}

FusedOdometer fused_at(int second, double distance = 5.5) {
  FusedOdometer message;
  message.header.stamp = to_message(Time(std::chrono::seconds(second)));
  message.name = {"left", "right"};
  message.distance = distance;
  message.variance = 0.0004;
  message.in_fusion_set = {true, false};
  message.rejection_reason = {0, 2};
  return message;
}

class OdometryRecorderTest : public ::testing::Test {
 protected:
  OdometryRecorder& make(const std::vector<NamedParameter>& extra = {},
                         const std::string& name = "recorder") {
    std::vector<NamedParameter> parameters{{"mission_folder", mission_.path().string()},
                                           {"source", "replay"}};
    parameters.insert(parameters.end(), extra.begin(), extra.end());
    return harness_.make<OdometryRecorder>({.name = name, .parameters = parameters});
  }
  OdometryRecorder& start(const std::vector<NamedParameter>& extra = {}) {
    auto& recorder = make(extra);
    EXPECT_TRUE(harness_.bring_up(recorder).success);
    return recorder;
  }
  void send(const OdometerReadings& message) {
    harness_.publish(topics::kOdometerReadings, message);
    harness_.spin();
  }
  void send(const FusedOdometer& message) {
    harness_.publish(topics::kOdometerFused, message);
    harness_.spin();
  }
  void say(std::uint8_t state, std::uint32_t total, const std::string& node = "/replay") {
    MissionStatus status;
    status.node = node;
    status.state = state;
    status.total = total;
    status.message = "because";
    harness_.publish(topics::kMissionStatus, status);
    harness_.spin();
  }
  /// The latest report of the recorder itself.
  std::optional<MissionStatus> reported() const {
    std::optional<MissionStatus> latest;
    for (const auto& status : statuses_.messages()) {
      if (status->node == "/recorder") {
        latest = *status;
      }
    }
    return latest;
  }
  nlohmann::json section(const std::string& name = "recorder") const {
    return nlohmann::json::parse(content(mission_.path() / "sections" / (name + ".json")));
  }
  std::string first_note() const { return section().at("notes").at(0); }
  fs::path data(const std::string& file) const { return mission_.path() / "odometry" / file; }

  TemporaryFolder mission_;
  ComponentHarness harness_{{.simulated_time = true}};
  testing::Collector<MissionStatus> statuses_ = harness_.collect(topics::kMissionStatus);
};

TEST_F(OdometryRecorderTest, WritesEveryMessageAtOnce) {
  start();
  send(readings_at(1));
  EXPECT_THAT(lines(data("readings.csv")),
              ElementsAre("reading,stamp,left,right,left.standard_deviation,"
                          "right.standard_deviation,left.valid,right.valid",
                          "1,1.000000000,5.45,5.34,0.06,0.055,1,0"));
  send(fused_at(1));
  EXPECT_THAT(lines(data("fused.csv")),
              ElementsAre("reading,stamp,distance,standard_deviation,status,fusion_set,"
                          "left.rejection,right.rejection",
                          "1,1.000000000,5.5,0.02,ok,1,none,marked invalid"));
}

TEST_F(OdometryRecorderTest, WhatItWritesTheReplayReads) {
  start();
  send(readings_at(1, {std::numeric_limits<double>::quiet_NaN(), 0.1 + 0.2}));
  send(readings_at(2));
  const std::string path = data("readings.csv").string();
  const auto recording = parse_readings_csv(read_csv_text(path), path);
  EXPECT_THAT(recording.odometers, ElementsAre("left", "right"));
  ASSERT_EQ(recording.size(), 2U);
  EXPECT_EQ(recording.row(0).distance[1], 0.1 + 0.2);
  EXPECT_EQ(recording.row(1).stamp, std::chrono::seconds(2));
  EXPECT_THAT(recording.row(1).valid, ElementsAre(true, false));
  EXPECT_THAT(recording.row(1).standard_deviation, ElementsAre(0.06, 0.055));
}

TEST_F(OdometryRecorderTest, CompleteWhenTheSourceIsAndAllIsThere) {
  start();
  say(MissionStatus::RUNNING, 2);
  for (int i = 1; i <= 2; ++i) {
    send(readings_at(i));
    send(fused_at(i));
  }
  EXPECT_NE(reported()->state, MissionStatus::COMPLETE);
  EXPECT_EQ(reported()->done, 2U);
  EXPECT_EQ(reported()->total, 2U);
  say(MissionStatus::COMPLETE, 0);
  EXPECT_EQ(reported()->state, MissionStatus::COMPLETE);
  EXPECT_EQ(first_note(), "Complete: 2 of 2 readings recorded, 2 fused distances.");
  EXPECT_EQ(section().at("table").at("rows").size(), 2U);
  EXPECT_EQ(section().at("figures").at("odometry_readings"), 2.0);
}

TEST_F(OdometryRecorderTest, WaitsForWhatIsStillUnderWay) {
  start();
  send(fused_at(1));
  send(readings_at(1));
  say(MissionStatus::RUNNING, 2);
  say(MissionStatus::COMPLETE, 0);
  EXPECT_NE(reported().value_or(MissionStatus()).state, MissionStatus::COMPLETE);
  send(fused_at(2));
  send(readings_at(2));
  EXPECT_EQ(reported()->state, MissionStatus::COMPLETE);
  EXPECT_EQ(lines(data("fused.csv"))[1], ",1.000000000,5.5,0.02,ok,1,none,marked invalid");
}

TEST_F(OdometryRecorderTest, FailsWithTheCountsWhenSomethingIsLost) {
  auto& recorder = start({{"completion_timeout", 2.0}});
  say(MissionStatus::RUNNING, 3);
  send(readings_at(1));
  send(fused_at(1));
  send(readings_at(2));
  say(MissionStatus::COMPLETE, 0);
  harness_.advance(std::chrono::milliseconds(1900));
  EXPECT_NE(reported()->state, MissionStatus::FAILED);
  harness_.advance(std::chrono::milliseconds(200));
  ASSERT_EQ(reported()->state, MissionStatus::FAILED);
  EXPECT_EQ(reported()->message,
            "2 of 3 readings recorded, 1 fused distances, 1 of them with their readings");
  EXPECT_THAT(first_note(), HasSubstr("Failed: 2 of 3"));
  // Late is better than lost.
  send(readings_at(3));
  EXPECT_EQ(lines(data("readings.csv")).size(), 4U);
  EXPECT_TRUE(harness_.shutdown(recorder).success);
  EXPECT_EQ(section().at("table").at("rows").size(), 3U);
}

TEST_F(OdometryRecorderTest, FailsWhenTheSourceSaysNothingOfItsReadings) {
  start();
  say(MissionStatus::COMPLETE, 0);
  harness_.advance(std::chrono::seconds(6));
  EXPECT_EQ(reported()->state, MissionStatus::FAILED);
  EXPECT_EQ(reported()->message, "0 readings recorded, 0 fused distances");
}

TEST_F(OdometryRecorderTest, FailsWithItsSource) {
  start();
  say(MissionStatus::FAILED, 0);
  EXPECT_EQ(reported()->state, MissionStatus::FAILED);
  EXPECT_EQ(reported()->message, "/replay failed: because");
}

TEST_F(OdometryRecorderTest, OnlyItsSourceCounts) {
  start();
  say(MissionStatus::FAILED, 0, "/other");
  say(MissionStatus::COMPLETE, 1, "/robot_2/replay");
  harness_.advance(std::chrono::seconds(10));
  EXPECT_EQ(reported(), std::nullopt);
}

TEST_F(OdometryRecorderTest, WithoutASourceItRecordsUntilItIsStopped) {
  auto& recorder = start({{"source", ""}});
  say(MissionStatus::COMPLETE, 1);
  send(readings_at(1));
  send(fused_at(1));
  EXPECT_EQ(reported(), std::nullopt);
  EXPECT_TRUE(harness_.shutdown(recorder).success);
  EXPECT_EQ(first_note(), "Not complete: 1 readings recorded, 1 fused distances.");
}

TEST_F(OdometryRecorderTest, KeepsItsSectionUpToDate) {
  start();
  send(readings_at(1));
  harness_.advance(std::chrono::seconds(5));
  EXPECT_EQ(section().at("table").at("rows").size(), 1U);
  send(readings_at(2));
  harness_.advance(std::chrono::seconds(5));
  EXPECT_EQ(section().at("table").at("rows").size(), 2U);
  EXPECT_EQ(first_note(),
            "Not complete: 2 readings recorded, 0 fused distances, 0 of them with "
            "their readings.");
}

TEST_F(OdometryRecorderTest, WaitsForTheDiskOnlyWhenItIsStopped) {
  auto& recorder = start();
  syncs = 0;
  say(MissionStatus::RUNNING, 1);
  send(readings_at(1));
  harness_.advance(std::chrono::seconds(5));
  send(fused_at(1));
  say(MissionStatus::COMPLETE, 0);
  ASSERT_EQ(reported()->state, MissionStatus::COMPLETE);
  EXPECT_EQ(section().at("table").at("rows").size(), 1U);
  EXPECT_EQ(syncs, 0);
  ASSERT_TRUE(harness_.deactivate(recorder).success);
  EXPECT_EQ(syncs, 4) << "two data files, the section and its folder";
}

TEST_F(OdometryRecorderTest, ParametersTakeEffectWhenItIsConfigured) {
  const TemporaryFolder elsewhere;
  std::ofstream(mission_.path() / "reference.csv") << "paper,other\n5.49,1\n";
  auto& recorder = start({{"reference_file", (mission_.path() / "reference.csv").string()},
                          {"completion_timeout", 2.0},
                          {"notes", std::vector<std::string>{"A remark."}}});
  const auto set = [&](const char* name, const ParameterValue& value) {
    EXPECT_TRUE(harness_.set_parameter(recorder, name, value).successful) << name;
  };
  set("mission_folder", elsewhere.path().string());
  set("source", "other");
  set("completion_timeout", 100.0);
  set("reference_column", "other");
  set("table_rows", 1);
  set("notes", std::vector<std::string>{"Another remark."});
  say(MissionStatus::RUNNING, 3);
  send(readings_at(1));
  send(readings_at(2));
  say(MissionStatus::COMPLETE, 0);
  harness_.advance(std::chrono::milliseconds(2100));
  EXPECT_EQ(reported()->state, MissionStatus::FAILED);
  EXPECT_TRUE(fs::is_empty(elsewhere.path()));
  const auto json = section();
  EXPECT_EQ(json.at("table").at("rows").size(), 2U);
  EXPECT_THAT(json.at("table").at("columns").dump(), HasSubstr("paper [m]"));
  EXPECT_THAT(json.at("notes").dump(), HasSubstr("\"A remark.\""));
}

TEST_F(OdometryRecorderTest, ShowsReferenceAndNotes) {
  std::ofstream(mission_.path() / "reference.csv") << "reading,paper\n1,5.49\n2,nan\n";
  auto& recorder = start({{"reference_file", (mission_.path() / "reference.csv").string()},
                          {"notes", std::vector<std::string>{"A remark."}}});
  send(readings_at(1));
  send(fused_at(1));
  EXPECT_TRUE(harness_.deactivate(recorder).success);
  EXPECT_EQ(section().at("table").at("rows").at(0),
            nlohmann::json::parse(R"([1, 5.45, 5.34, "1", 5.5, 0.02, 5.49, 0.01])"));
  EXPECT_NEAR(section().at("figures").at("odometry_max_abs_difference_m").get<double>(), 0.01,
              1e-12);
  EXPECT_THAT(section().at("notes").dump(), HasSubstr("A remark."));
}

TEST_F(OdometryRecorderTest, AMissingReferenceColumnIsSaid) {
  std::ofstream(mission_.path() / "reference.csv") << "a,b\n1,2\n";
  auto& recorder = start({{"reference_file", (mission_.path() / "reference.csv").string()}});
  EXPECT_TRUE(harness_.deactivate(recorder).success);
  EXPECT_THAT(section().at("notes").dump(), HasSubstr("no column 'paper'"));
}

TEST_F(OdometryRecorderTest, BadReferencesAreRefused) {
  const auto configure = [&](const std::string& file, const std::string& name) {
    return harness_.configure(make({{"reference_file", (mission_.path() / file).string()}}, name))
        .message;
  };
  EXPECT_THAT(configure("missing.csv", "first"), HasSubstr("missing.csv: No such file"));
  std::ofstream(mission_.path() / "text.csv") << "paper\n5.5\nfive\n";
  EXPECT_THAT(configure("text.csv", "second"),
              HasSubstr("text.csv:3: column 'paper': 'five' is not a number"));
}

TEST_F(OdometryRecorderTest, BadMissionFoldersAreRefused) {
  auto& empty = harness_.make<OdometryRecorder>({.name = "first"});
  EXPECT_THAT(harness_.configure(empty).message, HasSubstr("'mission_folder' is empty"));
  auto& missing = harness_.make<OdometryRecorder>(
      {.name = "second",
       .parameters = {{"mission_folder", (mission_.path() / "missing").string()}}});
  EXPECT_THAT(harness_.configure(missing).message, HasSubstr("missing"));
  EXPECT_EQ(missing.state(), LifecycleState::kUnconfigured);
}

TEST_F(OdometryRecorderTest, EveryRecordingHasAFolderOfItsOwn) {
  auto& recorder = start();
  send(readings_at(1));
  ASSERT_TRUE(harness_.deactivate(recorder).success);
  ASSERT_TRUE(harness_.cleanup(recorder).success);
  const std::string first = content(data("readings.csv"));
  ASSERT_TRUE(harness_.bring_up(recorder).success);
  send(readings_at(2));
  EXPECT_EQ(content(data("readings.csv")), first);
  EXPECT_EQ(lines(mission_.path() / "odometry_2" / "readings.csv").size(), 2U);
  ASSERT_TRUE(harness_.shutdown(recorder).success);
  EXPECT_THAT(section().at("notes").dump(), HasSubstr("odometry_2/readings.csv"));
}

TEST_F(OdometryRecorderTest, LeavesNoEmptyFolderBehind) {
  auto& recorder = start();
  EXPECT_TRUE(fs::exists(mission_.path() / "odometry"));
  ASSERT_TRUE(harness_.shutdown(recorder).success);
  EXPECT_FALSE(fs::exists(mission_.path() / "odometry"));
}

TEST_F(OdometryRecorderTest, GoesOnAfterAPause) {
  auto& recorder = start();
  send(readings_at(1));
  ASSERT_TRUE(harness_.deactivate(recorder).success);
  ASSERT_TRUE(harness_.activate(recorder).success);
  send(readings_at(2));
  EXPECT_EQ(lines(data("readings.csv")).size(), 3U);
}

TEST_F(OdometryRecorderTest, MalformedMessagesAreCountedAndLeftOut) {
  auto& recorder = start();
  send(OdometerReadings());
  OdometerReadings readings = readings_at(1);
  readings.valid.clear();
  send(readings);
  readings = readings_at(1);
  readings.standard_deviation.pop_back();
  send(readings);
  EXPECT_EQ(recorder.diagnostics().counter("readings.malformed"), 3U);
  FusedOdometer fused = fused_at(1);
  fused.rejection_reason.clear();
  send(fused);
  EXPECT_EQ(recorder.diagnostics().counter("fused.malformed"), 1U);
  EXPECT_FALSE(fs::exists(data("readings.csv")));

  send(readings_at(1));
  readings = readings_at(2);
  readings.name[0] = "middle";
  send(readings);
  readings = readings_at(2);
  readings.standard_deviation.clear();
  send(readings);
  fused = fused_at(1);
  fused.name[0] = "middle";
  send(fused);
  EXPECT_EQ(recorder.diagnostics().counter("readings.other_odometers"), 2U);
  EXPECT_EQ(recorder.diagnostics().counter("fused.other_odometers"), 1U);
  EXPECT_EQ(lines(data("readings.csv")).size(), 2U);
}

TEST_F(OdometryRecorderTest, HostileNamesDoNotBreakTheFile) {
  start();
  OdometerReadings readings = readings_at(1);
  readings.name = {"a,b\n", "\"\xFF"};
  send(readings);
  EXPECT_THAT(lines(data("readings.csv")).at(0), HasSubstr(",a_b_,_\xFF,"));
  EXPECT_EQ(lines(data("readings.csv")).size(), 2U);
}

TEST_F(OdometryRecorderTest, AFullDiskFailsTheMissionAndNothingElse) {
  auto& recorder = start();
  send(readings_at(1));
  const std::string before = content(data("readings.csv"));
  // Stands in for the disk: no file may grow beyond what this one has.
  rlimit old{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &old), 0);
  const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
  rlimit limit = old;
  limit.rlim_cur = before.size() + 1;
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &limit), 0);
  send(readings_at(2));
  send(readings_at(3));
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &old), 0);
  std::signal(SIGXFSZ, old_handler);
  ASSERT_TRUE(reported().has_value());
  EXPECT_EQ(reported()->state, MissionStatus::FAILED);
  EXPECT_THAT(reported()->message, HasSubstr("readings.csv"));
  EXPECT_EQ(content(data("readings.csv")), before);
  harness_.advance(std::chrono::seconds(20));
  EXPECT_EQ(recorder.diagnostics().counter("not_recorded"), 1U) << "messages, and nothing else";
  EXPECT_EQ(recorder.state(), LifecycleState::kActive);
}

TEST(OdometryRecorderNamespace, KeepsRobotsApart) {
  const TemporaryFolder mission;
  ComponentHarness harness({.ns = "/robot_1"});
  auto& recorder = harness.make<OdometryRecorder>(
      {.name = "recorder", .parameters = {{"mission_folder", mission.path().string()}}});
  ASSERT_TRUE(harness.bring_up(recorder).success);
  harness.publish(topics::kOdometerReadings, readings_at(1));
  harness.spin();
  ASSERT_TRUE(harness.shutdown(recorder).success);
  EXPECT_TRUE(fs::exists(mission.path() / "robot_1" / "odometry" / "readings.csv"));
  const auto json =
      nlohmann::json::parse(content(mission.path() / "sections" / "robot_1.recorder.json"));
  EXPECT_EQ(json.at("figures").at("robot_1.odometry_readings"), 1.0);
}

}  // namespace
}  // namespace pipescout
