// SPDX-License-Identifier: Apache-2.0
#include "pipescout/crawler_recorder/crawler_recorder.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <string>
#include <vector>

#include "pipescout/catalogue/topics.hpp"
#include "pipescout/files/testing/temporary_folder.hpp"
#include "pipescout/testing/component_harness.hpp"

namespace pipescout {
namespace {

using pipescout_msgs::msg::EddyCurrentSamples;
using pipescout_msgs::msg::FusedOdometer;
using pipescout_msgs::msg::MissionStatus;
using pipescout_msgs::msg::PipePosition;
using pipescout_msgs::msg::WeldDetection;
using testing::ComponentHarness;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

class CrawlerRecorderTest : public ::testing::Test {
 protected:
  CrawlerRecorder& start(std::vector<NamedParameter> parameters = {}) {
    parameters.push_back({"mission_folder", folder_.path().string()});
    parameters.push_back({"source", "driver"});
    parameters.push_back({"settle_time", 0.02});
    auto& recorder = harness_.make<CrawlerRecorder>({.name = "recorder", .parameters = parameters});
    EXPECT_TRUE(harness_.bring_up(recorder).success);
    return recorder;
  }
  template <class T>
  void send(const Topic<T>& topic, const T& message) {
    harness_.publish(topic, message);
    harness_.spin();
  }
  static FusedOdometer fused() {
    FusedOdometer message;
    message.name = {"a", "b"};
    message.support = {1, 1, 1, 1};
    message.rejection_reason = {0, 0};
    return message;
  }
  static EddyCurrentSamples samples() {
    EddyCurrentSamples message;
    message.sample_interval = 0.01;
    message.channels = 1;
    message.x = {1.0, 2.0};
    message.y = {1.0, 2.0};
    return message;
  }
  static WeldDetection weld() {
    WeldDetection message;
    message.weld = 3;
    message.weld_id = "W3";
    return message;
  }
  static PipePosition position() {
    PipePosition message;
    message.locked = true;
    return message;
  }
  void say(std::uint8_t state) {
    MissionStatus message;
    message.node = "/driver";
    message.state = state;
    message.message = "why";
    harness_.publish(topics::kMissionStatus, message);
    harness_.spin();
  }
  [[nodiscard]] std::vector<std::string> lines(const char* name) const {
    std::ifstream stream(folder_.path() / "crawler" / name);
    std::vector<std::string> result;
    for (std::string line; std::getline(stream, line);) {
      result.push_back(line);
    }
    return result;
  }
  /// The recorder's last word.
  [[nodiscard]] const MissionStatus* own_status() const {
    for (std::size_t k = statuses_.size(); k-- > 0;) {
      if (statuses_.at(k).node == "/recorder") {
        return &statuses_.at(k);
      }
    }
    return nullptr;
  }
  [[nodiscard]] std::string section() const {
    std::ifstream stream(folder_.path() / "sections" / "recorder.json");
    return {std::istreambuf_iterator<char>(stream), {}};
  }

  testing::TemporaryFolder folder_;
  ComponentHarness harness_;
  testing::Collector<MissionStatus> statuses_ = harness_.collect(topics::kMissionStatus);
};

TEST_F(CrawlerRecorderTest, WritesEverythingAndEndsWithItsSource) {
  auto& recorder = start();
  send(topics::kOdometerFused, fused());
  send(topics::kEddyCurrent, samples());
  send(topics::kWeld, weld());
  send(topics::kTruePipePosition, position());
  send(topics::kPipePosition, position());
  send(topics::kPipePosition, position());
  EXPECT_EQ(lines("fused.csv").size(), 2U);
  EXPECT_EQ(lines("eddy_current.csv").size(), 3U);
  EXPECT_EQ(lines("welds.csv").size(), 2U);
  EXPECT_EQ(lines("truth.csv").size(), 2U);
  EXPECT_EQ(lines("positions.csv").size(), 3U);
  EXPECT_EQ(own_status(), nullptr);
  say(MissionStatus::COMPLETE);
  ASSERT_TRUE(harness_.spin_until([&] { return own_status() != nullptr; }));
  EXPECT_EQ(own_status()->state, MissionStatus::COMPLETE);
  EXPECT_THAT(own_status()->message, HasSubstr("2 positions and 1 welds"));
  EXPECT_THAT(section(), HasSubstr("\"crawler_welds\""));
  EXPECT_TRUE(harness_.shutdown(recorder).success);
}

TEST_F(CrawlerRecorderTest, FailsWithItsSourceOrWithoutAnyPosition) {
  start();
  say(MissionStatus::FAILED);
  ASSERT_NE(own_status(), nullptr);
  EXPECT_EQ(own_status()->state, MissionStatus::FAILED);
  EXPECT_THAT(own_status()->message, HasSubstr("/driver failed: why"));
}

TEST_F(CrawlerRecorderTest, ARunWithoutPositionsIsNotComplete) {
  start();
  say(MissionStatus::COMPLETE);
  ASSERT_TRUE(harness_.spin_until([&] { return own_status() != nullptr; }));
  EXPECT_EQ(own_status()->state, MissionStatus::FAILED);
}

TEST_F(CrawlerRecorderTest, CountsWhatItCannotRecord) {
  auto& recorder = start();
  send(topics::kOdometerFused, fused());
  send(topics::kEddyCurrent, samples());
  const std::vector<std::pair<const char*, std::function<void(FusedOdometer&)>>> fused_faults{
      {"fused.malformed", [](auto& message) { message.name.clear(); }},
      {"fused.malformed", [](auto& message) { message.support.pop_back(); }},
      {"fused.malformed", [](auto& message) { message.rejection_reason.clear(); }},
      {"fused.malformed", [](auto& message) { message.health = {0}; }},
      {"fused.malformed",
       [](auto& message) {
         message.scale = {1.0, 1.0};
       }},
      {"fused.malformed",
       [](auto& message) {
         message.health = {0, 0};
         message.scale = {1.0, 1.0};
       }},
      {"fused.other_odometers",
       [](auto& message) {
         message.name = {"a", "c"};
       }},
  };
  for (const auto& [counter, spoil] : fused_faults) {
    const auto before = recorder.diagnostics().counter(counter);
    FusedOdometer message = fused();
    spoil(message);
    send(topics::kOdometerFused, message);
    EXPECT_EQ(recorder.diagnostics().counter(counter), before + 1) << counter;
  }
  EXPECT_EQ(lines("fused.csv").size(), 2U);
  const std::vector<std::pair<const char*, std::function<void(EddyCurrentSamples&)>>> faults{
      {"eddy_current.malformed", [](auto& message) { message.channels = 0; }},
      {"eddy_current.malformed", [](auto& message) { message.y.pop_back(); }},
      {"eddy_current.malformed", [](auto& message) { message.sample_interval = -1.0; }},
      {"eddy_current.other_channels", [](auto& message) { message.channels = 2; }},
  };
  for (const auto& [counter, spoil] : faults) {
    const auto before = recorder.diagnostics().counter(counter);
    EddyCurrentSamples message = samples();
    spoil(message);
    send(topics::kEddyCurrent, message);
    EXPECT_EQ(recorder.diagnostics().counter(counter), before + 1) << counter;
  }
  EXPECT_EQ(lines("eddy_current.csv").size(), 3U);
}

TEST_F(CrawlerRecorderTest, TheSignalCanBeLeftOut) {
  start({{"record_signal", false}});
  send(topics::kEddyCurrent, samples());
  EXPECT_FALSE(fs::exists(folder_.path() / "crawler" / "eddy_current.csv"));
}

TEST_F(CrawlerRecorderTest, FailsWhenItCannotWrite) {
  auto& recorder = start();
  std::ofstream(folder_.path() / "crawler" / "welds.csv") << "somebody else's\n";
  send(topics::kWeld, weld());
  ASSERT_NE(own_status(), nullptr);
  EXPECT_EQ(own_status()->state, MissionStatus::FAILED);
  EXPECT_THAT(own_status()->message, HasSubstr("welds.csv"));
  send(topics::kPipePosition, position());
  EXPECT_EQ(recorder.diagnostics().counter("not_recorded"), 1U);
  EXPECT_EQ(recorder.state(), LifecycleState::kActive);
}

TEST_F(CrawlerRecorderTest, EachRunHasAFolderOfItsOwn) {
  auto& recorder = start();
  send(topics::kWeld, weld());
  ASSERT_TRUE(harness_.deactivate(recorder).success);
  ASSERT_TRUE(harness_.cleanup(recorder).success);
  ASSERT_TRUE(harness_.bring_up(recorder).success);
  send(topics::kWeld, weld());
  EXPECT_TRUE(fs::exists(folder_.path() / "crawler" / "welds.csv"));
  EXPECT_TRUE(fs::exists(folder_.path() / "crawler_2" / "welds.csv"));
}

TEST(CrawlerRecorderStart, NeedsAFolder) {
  ComponentHarness harness;
  auto& recorder = harness.make<CrawlerRecorder>();
  EXPECT_THAT(harness.configure(recorder).message, HasSubstr("mission_folder"));
}

}  // namespace
}  // namespace pipescout
