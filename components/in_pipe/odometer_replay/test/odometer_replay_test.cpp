// SPDX-License-Identifier: Apache-2.0
#include "pipescout/odometer_replay/odometer_replay.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <pipescout_msgs/msg/mission_status.hpp>
#include <string>
#include <vector>

#include "pipescout/catalogue/topics.hpp"
#include "pipescout/files/testing/temporary_folder.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "pipescout/testing/component_harness.hpp"

namespace pipescout {
namespace {

using pipescout_msgs::msg::MissionStatus;
using pipescout_msgs::msg::OdometerReadings;
using testing::Collector;
using testing::ComponentHarness;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::TemporaryFolder;

constexpr Time kStart{std::chrono::seconds(1000)};

class OdometerReplayTest : public ::testing::Test {
 protected:
  OdometerReplayTest() { harness_.set_time(kStart); }

  std::string write(const std::string& text, const std::string& name = "readings.csv") {
    const auto path = folder_.path() / name;
    std::ofstream(path, std::ios::binary) << text;
    return path.string();
  }
  OdometerReplay& make(const std::string& file, const std::vector<NamedParameter>& extra = {},
                       const std::string& name = "replay") {
    std::vector<NamedParameter> parameters{
        {"file", file}, {"standard_deviations", std::vector<double>{0.06, 0.055}}};
    parameters.insert(parameters.end(), extra.begin(), extra.end());
    return harness_.make<OdometerReplay>({.name = name, .parameters = parameters});
  }
  /// Moves the time in small steps, as a running clock does.
  void pass(Duration duration, Duration step = std::chrono::milliseconds(10)) {
    for (Duration passed{}; passed < duration; passed += step) {
      harness_.advance(step);
    }
  }
  std::vector<double> first_distances(const Collector<OdometerReadings>& readings) const {
    std::vector<double> result;
    for (const auto& message : readings.messages()) {
      result.push_back(message->distance.at(0));
    }
    return result;
  }
  std::size_t count(std::uint8_t state) const {
    std::size_t result = 0;
    for (const auto& status : statuses_.messages()) {
      result += status->state == state ? 1U : 0U;
    }
    return result;
  }

  TemporaryFolder folder_;
  ComponentHarness harness_{{.simulated_time = true}};
  Collector<MissionStatus> statuses_ = harness_.collect(topics::kMissionStatus);
};

constexpr const char* kThreeRows = "reading,left,right\n1,1.5,1\n2,2.5,2\n3,3.5,3\n";

TEST_F(OdometerReplayTest, PublishesEveryRowAndSaysSo) {
  auto& replay = make(write(kThreeRows), {{"period", 0.1}});
  const auto readings = harness_.collect(topics::kOdometerReadings);
  ASSERT_TRUE(harness_.bring_up(replay).success);
  pass(std::chrono::milliseconds(150));
  EXPECT_THAT(first_distances(readings), ElementsAre(1.5, 2.5));
  EXPECT_EQ(count(MissionStatus::COMPLETE), 0U);
  pass(std::chrono::seconds(1));
  EXPECT_THAT(first_distances(readings), ElementsAre(1.5, 2.5, 3.5));
  EXPECT_EQ(count(MissionStatus::COMPLETE), 1U);

  const OdometerReadings& first = readings.at(0);
  EXPECT_THAT(first.name, ElementsAre("left", "right"));
  EXPECT_THAT(first.distance, ElementsAre(1.5, 1.0));
  EXPECT_THAT(first.standard_deviation, ElementsAre(0.06, 0.055));
  EXPECT_THAT(first.valid, ElementsAre(true, true));
  EXPECT_EQ(first.header.frame_id, "base_link");
  EXPECT_EQ(from_message(first.header.stamp), kStart);
  for (std::size_t i = 1; i < 3; ++i) {
    EXPECT_EQ(
        from_message(readings.at(i).header.stamp) - from_message(readings.at(i - 1).header.stamp),
        std::chrono::milliseconds(100));
  }
}

TEST_F(OdometerReplayTest, TellsItsProgress) {
  auto& replay = make(write(kThreeRows));
  const auto readings = harness_.collect(topics::kOdometerReadings);
  ASSERT_TRUE(harness_.bring_up(replay).success);
  pass(std::chrono::seconds(1));
  ASSERT_GE(statuses_.size(), 4U);
  const MissionStatus& last_running = statuses_.at(statuses_.size() - 2);
  EXPECT_EQ(last_running.state, MissionStatus::RUNNING);
  EXPECT_EQ(last_running.done, 3U);
  EXPECT_EQ(last_running.total, 3U);
  EXPECT_EQ(statuses_.back().node, "/replay");
}

TEST_F(OdometerReplayTest, ReportsAtMostAHundredTimes) {
  std::string text = "left,right\n";
  for (int i = 0; i < 1000; ++i) {
    text += "1,1\n";
  }
  auto& replay = make(write(text), {{"period", 0.01}});
  const auto readings = harness_.collect(topics::kOdometerReadings);
  ASSERT_TRUE(harness_.bring_up(replay).success);
  pass(std::chrono::seconds(11));
  EXPECT_EQ(readings.size(), 1000U);
  EXPECT_LE(count(MissionStatus::RUNNING), 100U);
}

TEST_F(OdometerReplayTest, WaitsForTheNamedNodes) {
  auto& replay =
      make(write(kThreeRows),
           {{"wait_for_subscribers", std::vector<std::string>{"_component_harness", "late"}}});
  const auto first = harness_.collect(topics::kOdometerReadings);
  ASSERT_TRUE(harness_.bring_up(replay).success);
  pass(std::chrono::seconds(1));
  EXPECT_TRUE(first.empty());
  EXPECT_THAT(statuses_.back().message,
              HasSubstr("waiting for the subscriptions of /late to /odometer/readings"));
  Node late({.context = harness_.context().shared_from_this(),
             .executor = &harness_.executor(),
             .name = {"/", "late"}});
  std::size_t heard = 0;
  const auto subscription = late.create_subscription(topics::kOdometerReadings,
                                                     [&](const OdometerReadings&) { ++heard; });
  pass(std::chrono::seconds(1));
  EXPECT_EQ(first.size(), 3U);
  EXPECT_EQ(heard, 3U);
}

TEST_F(OdometerReplayTest, NeedsNobodyWhenToldSo) {
  auto& replay = make(write(kThreeRows));
  ASSERT_TRUE(harness_.bring_up(replay).success);
  pass(std::chrono::seconds(1));
  EXPECT_EQ(count(MissionStatus::COMPLETE), 1U);
}

TEST_F(OdometerReplayTest, KeepsTheRhythmOfTheStamps) {
  auto& replay = make(write("stamp,left,right\n50.5,1,1\n50.8,2,2\n52,3,3\n"), {{"rate", 2.0}});
  const auto readings = harness_.collect(topics::kOdometerReadings);
  ASSERT_TRUE(harness_.bring_up(replay).success);
  pass(std::chrono::seconds(1));
  ASSERT_EQ(readings.size(), 3U);
  EXPECT_EQ(from_message(readings.at(1).header.stamp), kStart + std::chrono::milliseconds(150));
  EXPECT_EQ(from_message(readings.at(2).header.stamp), kStart + std::chrono::milliseconds(750));
}

TEST_F(OdometerReplayTest, PublishesRecordedStamps) {
  auto& replay =
      make(write("stamp,left,right\n50.5,1,1\n50.8,2,2\n"), {{"use_recorded_stamps", true}});
  const auto readings = harness_.collect(topics::kOdometerReadings);
  ASSERT_TRUE(harness_.bring_up(replay).success);
  pass(std::chrono::seconds(1));
  ASSERT_EQ(readings.size(), 2U);
  EXPECT_EQ(from_message(readings.at(0).header.stamp), Time(std::chrono::milliseconds(50500)));
}

TEST_F(OdometerReplayTest, RateMayChangeWhileItPlays) {
  auto& replay = make(write(kThreeRows), {{"period", 1.0}});
  const auto readings = harness_.collect(topics::kOdometerReadings);
  ASSERT_TRUE(harness_.bring_up(replay).success);
  pass(std::chrono::milliseconds(50));
  ASSERT_TRUE(harness_.set_parameter(replay, "rate", 10.0).successful);
  pass(std::chrono::milliseconds(1000));
  EXPECT_EQ(readings.size(), 2U);
  pass(std::chrono::milliseconds(100));
  EXPECT_EQ(readings.size(), 3U);
}

TEST_F(OdometerReplayTest, AClockSetBackDoesNotStopIt) {
  auto& replay = make(write(kThreeRows), {{"period", 0.1}});
  const auto readings = harness_.collect(topics::kOdometerReadings);
  ASSERT_TRUE(harness_.bring_up(replay).success);
  pass(std::chrono::milliseconds(50));
  ASSERT_EQ(readings.size(), 1U);
  harness_.set_time(Time(std::chrono::seconds(10)));
  pass(std::chrono::seconds(1));
  EXPECT_EQ(readings.size(), 3U);
}

TEST_F(OdometerReplayTest, TheFirstClockMessageIsNoDelay) {
  // As when it is activated before a simulation has said what time it is.
  harness_.set_time(Time{});
  auto& replay = make(write(kThreeRows), {{"period", 0.1}});
  const auto readings = harness_.collect(topics::kOdometerReadings);
  ASSERT_TRUE(harness_.bring_up(replay).success);
  const Time start{std::chrono::seconds(1'700'000'000)};
  harness_.set_time(start);
  pass(std::chrono::milliseconds(50));
  ASSERT_EQ(readings.size(), 1U);
  EXPECT_EQ(from_message(readings.at(0).header.stamp), start);
  pass(std::chrono::milliseconds(100));
  ASSERT_EQ(readings.size(), 2U);
  EXPECT_EQ(from_message(readings.at(1).header.stamp), start + std::chrono::milliseconds(100));
}

TEST_F(OdometerReplayTest, AClockSetForwardDoesNotHurryIt) {
  auto& replay = make(write(kThreeRows), {{"period", 0.1}});
  const auto readings = harness_.collect(topics::kOdometerReadings);
  ASSERT_TRUE(harness_.bring_up(replay).success);
  pass(std::chrono::milliseconds(50));
  ASSERT_EQ(readings.size(), 1U);
  const Time later = kStart + std::chrono::hours(1);
  harness_.set_time(later);
  pass(std::chrono::milliseconds(50));
  ASSERT_EQ(readings.size(), 2U);
  EXPECT_EQ(from_message(readings.at(1).header.stamp), later);
  pass(std::chrono::milliseconds(100));
  ASSERT_EQ(readings.size(), 3U);
  EXPECT_EQ(from_message(readings.at(2).header.stamp), later + std::chrono::milliseconds(100));
}

TEST_F(OdometerReplayTest, ALateRowDoesNotDelayTheOthers) {
  auto& replay = make(write(kThreeRows), {{"period", 0.1}});
  const auto readings = harness_.collect(topics::kOdometerReadings);
  ASSERT_TRUE(harness_.bring_up(replay).success);
  harness_.advance(std::chrono::milliseconds(500));
  harness_.advance(std::chrono::milliseconds(500));
  harness_.advance(std::chrono::milliseconds(10));
  ASSERT_EQ(readings.size(), 3U);
  EXPECT_EQ(from_message(readings.at(2).header.stamp) - from_message(readings.at(0).header.stamp),
            std::chrono::milliseconds(200));
}

TEST_F(OdometerReplayTest, ParametersTakeEffectWhenItIsConfigured) {
  auto& replay = make(write("stamp,left,right\n50.5,1,1\n50.6,2,2\n"));
  const auto readings = harness_.collect(topics::kOdometerReadings);
  ASSERT_TRUE(harness_.configure(replay).success);
  const auto set = [&](const char* name, const ParameterValue& value) {
    EXPECT_TRUE(harness_.set_parameter(replay, name, value).successful) << name;
  };
  set("use_recorded_stamps", true);
  set("wait_for_subscribers", std::vector<std::string>{"nobody"});
  set("frame_id", "other");
  set("standard_deviations", std::vector<double>{0.5, 0.5});
  ASSERT_TRUE(harness_.activate(replay).success);
  pass(std::chrono::seconds(1));
  ASSERT_EQ(readings.size(), 2U);
  EXPECT_EQ(from_message(readings.at(0).header.stamp), kStart);
  EXPECT_EQ(readings.at(0).header.frame_id, "base_link");
  EXPECT_THAT(readings.at(0).standard_deviation, ElementsAre(0.06, 0.055));

  ASSERT_TRUE(harness_.deactivate(replay).success);
  ASSERT_TRUE(harness_.cleanup(replay).success);
  set("wait_for_subscribers", std::vector<std::string>{});
  ASSERT_TRUE(harness_.bring_up(replay).success);
  pass(std::chrono::seconds(1));
  ASSERT_EQ(readings.size(), 4U);
  EXPECT_EQ(from_message(readings.at(2).header.stamp), Time(std::chrono::milliseconds(50500)));
  EXPECT_EQ(readings.at(2).header.frame_id, "other");
  EXPECT_THAT(readings.at(2).standard_deviation, ElementsAre(0.5, 0.5));
}

TEST_F(OdometerReplayTest, PausesAndGoesOn) {
  auto& replay = make(write(kThreeRows), {{"period", 0.1}});
  const auto readings = harness_.collect(topics::kOdometerReadings);
  ASSERT_TRUE(harness_.bring_up(replay).success);
  pass(std::chrono::milliseconds(50));
  ASSERT_TRUE(harness_.deactivate(replay).success);
  pass(std::chrono::seconds(1));
  EXPECT_EQ(readings.size(), 1U);
  ASSERT_TRUE(harness_.activate(replay).success);
  pass(std::chrono::seconds(1));
  EXPECT_THAT(first_distances(readings), ElementsAre(1.5, 2.5, 3.5));
  EXPECT_EQ(replay.publishers().empty(), false);
}

TEST_F(OdometerReplayTest, StartsFromTheBeginningWhenConfiguredAgain) {
  auto& replay = make(write(kThreeRows));
  const auto readings = harness_.collect(topics::kOdometerReadings);
  for (int i = 0; i < 2; ++i) {
    ASSERT_TRUE(harness_.bring_up(replay).success);
    pass(std::chrono::seconds(1));
    ASSERT_TRUE(harness_.deactivate(replay).success);
    ASSERT_TRUE(harness_.cleanup(replay).success);
  }
  EXPECT_EQ(readings.size(), 6U);
  EXPECT_TRUE(harness_.shutdown(replay).success);
}

TEST_F(OdometerReplayTest, ReadingsThatAreNoNumbersArePublished) {
  auto& replay = make(write("left,right\nnan,2\n"));
  const auto readings = harness_.collect(topics::kOdometerReadings);
  ASSERT_TRUE(harness_.bring_up(replay).success);
  pass(std::chrono::seconds(1));
  ASSERT_EQ(readings.size(), 1U);
  EXPECT_TRUE(std::isnan(readings.at(0).distance[0]));
  EXPECT_THAT(readings.at(0).valid, ElementsAre(true, true));
}

TEST_F(OdometerReplayTest, StandardDeviationsMayComeFromTheFile) {
  auto& replay = harness_.make<OdometerReplay>(
      {.parameters = {{"file", write("a,b,a.standard_deviation,b.standard_deviation\n"
                                     "1,2,0.1,-1\n")}}});
  const auto readings = harness_.collect(topics::kOdometerReadings);
  ASSERT_TRUE(harness_.bring_up(replay).success);
  pass(std::chrono::seconds(1));
  ASSERT_EQ(readings.size(), 1U);
  EXPECT_THAT(readings.at(0).standard_deviation, ElementsAre(0.1, -1.0));
}

TEST_F(OdometerReplayTest, BadInputIsRefusedWithFileAndLine) {
  int number = 0;
  const auto refusal = [&](const std::string& file, const std::vector<NamedParameter>& extra = {}) {
    auto& replay = make(file, extra, "replay_" + std::to_string(++number));
    const TransitionResult result = harness_.configure(replay);
    EXPECT_FALSE(result.success);
    EXPECT_EQ(result.state, LifecycleState::kUnconfigured);
    return result.message;
  };
  EXPECT_THAT(refusal(""), HasSubstr("'file' is empty"));
  EXPECT_THAT(refusal((folder_.path() / "missing.csv").string()),
              HasSubstr("missing.csv: No such file"));
  EXPECT_THAT(refusal(folder_.path().string()), HasSubstr("is not a regular file"));
  const std::string pipe = (folder_.path() / "pipe").string();
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_THAT(refusal(pipe), HasSubstr("is not a regular file"));
  EXPECT_THAT(refusal(write("")), HasSubstr("readings.csv: is empty"));
  EXPECT_THAT(refusal(write("left,right\n1,2\n1\n")), HasSubstr("readings.csv:3: 1 cells"));
  EXPECT_THAT(refusal(write("left,right\n1,x\n")), HasSubstr("readings.csv:2: column 'right'"));
  EXPECT_THAT(refusal(write("stamp,left,right\n2,1,1\n1,1,1\n")),
              HasSubstr("readings.csv:3: column 'stamp'"));
  EXPECT_THAT(refusal(write("left,middle,right\n1,2,3\n")),
              HasSubstr("'standard_deviations' has 2 values for 3 odometers"));
  EXPECT_THAT(refusal(write(kThreeRows), {{"odometers", std::vector<std::string>{"leftt"}}}),
              HasSubstr("readings.csv:1: no column 'leftt'"));
  EXPECT_THAT(
      refusal(write(kThreeRows), {{"standard_deviations", std::vector<double>{}}}),
      HasSubstr("give parameter 'standard_deviations' (inspect.sh: --sigma), 2 values in m, one "
                "for each odometer; or the file columns left.standard_deviation, right."));
  EXPECT_THAT(refusal(write(kThreeRows), {{"use_recorded_stamps", true}}),
              HasSubstr("no column 'stamp'"));
}

TEST_F(OdometerReplayTest, TablesOfSpreadsheetsAreReadAndThisIsSaid) {
  auto& replay = make(write("sep=;\r\nstamp;left;right\r\ns;mm;mm\r\n1700000000250;1500,5;1000\r\n"
                            "1700000000350;2500;2000\r\n"),
                      {{"time_unit", "ms"}, {"use_recorded_stamps", true}});
  const auto readings = harness_.collect(topics::kOdometerReadings);
  ASSERT_TRUE(harness_.bring_up(replay).success);
  pass(std::chrono::seconds(1));
  ASSERT_EQ(readings.size(), 2U);
  EXPECT_EQ(readings.at(0).distance[0], 1500.5 * 1e-3);
  EXPECT_EQ(from_message(readings.at(0).header.stamp),
            Time(std::chrono::milliseconds(1'700'000'000'250)));
  const auto was_said = [logs = harness_.logs()](const std::string& text) {
    return std::ranges::any_of(
        logs, [&](const auto& entry) { return entry.text.find(text) != std::string::npos; });
  };
  EXPECT_TRUE(was_said("numbers have a decimal comma"));
  EXPECT_TRUE(was_said("column 'left' is in mm"));
}

TEST_F(OdometerReplayTest, WhatMayBeThousandsIsAskedAbout) {
  const std::string file = write("left;right\n1,234;2\n");
  auto& doubtful = make(file);
  EXPECT_THAT(harness_.configure(doubtful).message,
              HasSubstr("readings.csv:2: column 'left': '1,234' may be 1.234 or 1234; set "
                        "'decimal_mark' in the parameters"));
  auto& sure = make(file, {{"decimal_mark", ","}}, "sure");
  const auto readings = harness_.collect(topics::kOdometerReadings);
  ASSERT_TRUE(harness_.bring_up(sure).success);
  pass(std::chrono::seconds(1));
  EXPECT_THAT(first_distances(readings), ElementsAre(1.234));
  auto& wrong = make(file, {{"decimal_mark", "comma"}}, "wrong");
  EXPECT_THAT(harness_.configure(wrong).message, HasSubstr("decimal_mark must be '.' or ','"));
}

TEST_F(OdometerReplayTest, CanBeConfiguredOnceTheFileIsRight) {
  const std::string file = write("left,right\n1,x\n");
  auto& replay = make(file);
  EXPECT_FALSE(harness_.configure(replay).success);
  write(kThreeRows);
  EXPECT_TRUE(harness_.bring_up(replay).success);
}

TEST_F(OdometerReplayTest, ParametersHaveRanges) {
  auto& replay = make(write(kThreeRows));
  EXPECT_FALSE(harness_.set_parameter(replay, "rate", 0.0).successful);
  EXPECT_FALSE(harness_.set_parameter(replay, "period", -1.0).successful);
  EXPECT_FALSE(
      harness_.set_parameter(replay, "standard_deviations", std::vector<double>{0.0}).successful);
}

}  // namespace
}  // namespace pipescout
