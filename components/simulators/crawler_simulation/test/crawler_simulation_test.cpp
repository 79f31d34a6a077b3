// SPDX-License-Identifier: Apache-2.0
#include "pipescout/crawler_simulation/crawler_simulation.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <pipescout_msgs/msg/mission_status.hpp>
#include <string>
#include <vector>

#include "pipescout/catalogue/topics.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "pipescout/testing/component_harness.hpp"

namespace pipescout {
namespace {

using pipescout_msgs::msg::MissionStatus;
using testing::ComponentHarness;
using ::testing::HasSubstr;

/// The node that listens for the test.
const std::vector<std::string> kPeer{"_component_harness"};

std::vector<NamedParameter> short_run(std::vector<NamedParameter> extra = {}) {
  extra.push_back({"tally", std::string(TALLY_FILE)});
  extra.push_back({"length", 3.0});
  extra.push_back({"rate", 1000.0});
  extra.push_back({"wait_for_subscribers.readings", kPeer});
  extra.push_back({"wait_for_subscribers.eddy_current", kPeer});
  extra.push_back({"stop_spacing", 1000.0});
  return extra;
}

TEST(CrawlerSimulation, DrivesToTheEndAndSaysSo) {
  ComponentHarness harness;
  auto& simulation = harness.make<CrawlerSimulation>({.parameters = short_run()});
  const auto clock = harness.collect(topics::kClock);
  const auto readings = harness.collect(topics::kOdometerReadings);
  const auto samples = harness.collect(topics::kEddyCurrent);
  const auto truth = harness.collect(topics::kTruePipePosition);
  const auto progress = harness.collect(topics::kMissionStatus);
  ASSERT_TRUE(harness.bring_up(simulation).success);
  ASSERT_TRUE(harness.spin_until(
      [&] { return !progress.empty() && progress.back().state == MissionStatus::COMPLETE; }));
  EXPECT_EQ(progress.back().done, progress.back().total);

  EXPECT_NEAR(truth.back().odometer_distance, 3.0, 1e-6);
  EXPECT_EQ(truth.size(), clock.size());
  Time last{};
  std::size_t values = 0;
  for (const auto& message : readings.messages()) {
    const Time stamp = from_message(message->header.stamp);
    EXPECT_GE(stamp, last);
    EXPECT_LE(stamp, from_message(clock.back().clock));
    last = stamp;
    EXPECT_EQ(message->name.size(), message->distance.size());
    EXPECT_EQ(message->name.size(), message->valid.size());
    values += message->name.size();
  }
  EXPECT_GT(values, 100U);
  std::size_t sample_count = 0;
  for (const auto& message : samples.messages()) {
    EXPECT_EQ(message->channels, 1U);
    EXPECT_EQ(message->x.size(), message->y.size());
    EXPECT_NEAR(
        to_seconds(from_message(message->header.stamp) - from_message(samples.at(0).header.stamp)),
        static_cast<double>(sample_count) * message->sample_interval, 1e-6);
    sample_count += message->x.size();
  }
  EXPECT_GT(sample_count, 1000U);
}

TEST(CrawlerSimulation, WaitsForThoseWhoListen) {
  ComponentHarness harness;
  auto& simulation = harness.make<CrawlerSimulation>({.parameters = short_run()});
  const auto clock = harness.collect(topics::kClock);
  const auto progress = harness.collect(topics::kMissionStatus);
  ASSERT_TRUE(harness.bring_up(simulation).success);
  harness.spin();
  EXPECT_TRUE(clock.empty());
  ASSERT_FALSE(progress.empty());
  EXPECT_THAT(progress.back().message, HasSubstr("waiting"));
  const auto readings = harness.collect(topics::kOdometerReadings);
  const auto samples = harness.collect(topics::kEddyCurrent);
  EXPECT_TRUE(harness.spin_until([&] { return readings.size() > 10; }));
  ASSERT_TRUE(harness.deactivate(simulation).success);
  const auto sent = clock.size();
  harness.spin();
  EXPECT_EQ(clock.size(), sent);
  // It goes on where it was.
  ASSERT_TRUE(harness.activate(simulation).success);
  EXPECT_TRUE(harness.spin_until([&] { return clock.size() > sent; }));
  EXPECT_GT(from_message(clock.back().clock), from_message(clock.at(sent - 1).clock));
}

std::string refusal(std::vector<NamedParameter> parameters) {
  ComponentHarness harness;
  auto& simulation = harness.make<CrawlerSimulation>({.parameters = std::move(parameters)});
  const auto result = harness.configure(simulation);
  EXPECT_FALSE(result.success);
  return result.message;
}

TEST(CrawlerSimulation, NamesWhatIsWrong) {
  EXPECT_THAT(refusal({}), HasSubstr("'tally' is empty"));
  EXPECT_THAT(refusal({{"tally", "/no/such.csv"}}), HasSubstr("/no/such.csv"));
  EXPECT_THAT(refusal(short_run({{"start_joint", 60}})), HasSubstr("start_joint"));
  EXPECT_THAT(refusal(short_run({{"periods", std::vector<double>{0.02}}})),
              HasSubstr("'periods' has 1 values for 3 wheels"));
  EXPECT_THAT(refusal(short_run({{"kinds", std::vector<std::string>(3, "both")}})),
              HasSubstr("'both'"));
  EXPECT_THAT(refusal(short_run({{"wheels", std::vector<std::string>{}}})), HasSubstr("wheels"));
}

}  // namespace
}  // namespace pipescout
