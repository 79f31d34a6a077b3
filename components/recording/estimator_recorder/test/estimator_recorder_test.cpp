// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimator_recorder/estimator_recorder.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <pipescout_msgs/msg/mission_status.hpp>
#include <string>
#include <utility>
#include <vector>

#include "pipescout/catalogue/topics.hpp"
#include "pipescout/files/testing/temporary_folder.hpp"
#include "pipescout/message_conversions/geometry.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "pipescout/testing/component_harness.hpp"

namespace pipescout {
namespace {

using nav_msgs::msg::Odometry;
using pipescout_msgs::msg::EstimatorState;
using pipescout_msgs::msg::MissionStatus;
using sensor_msgs::msg::NavSatFix;
using testing::ComponentHarness;
using ::testing::HasSubstr;
using ::testing::Not;
namespace fs = std::filesystem;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

builtin_interfaces::msg::Time stamp(double seconds) {
  return to_message(Time{} + from_seconds(seconds));
}

class EstimatorRecorderTest : public ::testing::Test {
 protected:
  EstimatorRecorder& start(std::vector<NamedParameter> parameters = {}) {
    // Of two with the same name the later one counts.
    parameters.insert(
        parameters.begin(),
        {{"mission_folder", folder_.path().string()}, {"source", "robot"}, {"settle_time", 0.02}});
    auto& recorder =
        harness_.make<EstimatorRecorder>({.name = "recorder", .parameters = parameters});
    EXPECT_TRUE(harness_.bring_up(recorder).success);
    return recorder;
  }
  template <class T>
  void send(const Topic<T>& topic, const T& message) {
    harness_.publish(topic, message);
    harness_.spin();
  }
  static Odometry odometry(double time = 1.0, double x = 1.0) {
    Odometry message;
    message.header.stamp = stamp(time);
    message.pose.pose = to_message(geometry::SE3(geometry::SO3(), {x, 2.0, 3.0}));
    message.pose.covariance = to_message(geometry::Matrix6d(geometry::Matrix6d::Identity() * 1e-4));
    return message;
  }
  static EstimatorState state(double time = 1.0) {
    EstimatorState message;
    message.header.stamp = stamp(time);
    message.phase = "running";
    message.source = {"gps", "odometer"};
    message.source_state = {"trusted", "trusted"};
    message.source_accepted = {5, 6};
    message.source_gated = {1, 0};
    message.source_held = {0, 0};
    message.source_refused = {0, 0};
    message.factor = {"gps", "odometer", "odometer"};
    message.factor_stamp = {stamp(0.9), stamp(0.95), stamp(1.0)};
    message.factor_outcome = {"gated", "accepted", "accepted"};
    message.factor_chi_square = {90.0, 1.0, 0.5};
    message.factor_degrees = {3, 1, 1};
    message.factor_weight = {0.0, 1.0, 1.0};
    return message;
  }
  static NavSatFix fix(double latitude = 46.5) {
    NavSatFix message;
    message.header.stamp = stamp(1.0);
    message.latitude = latitude;
    message.longitude = 8.25;
    message.altitude = 500.0;
    return message;
  }
  void say(std::uint8_t state) {
    MissionStatus message;
    message.node = "/robot";
    message.state = state;
    message.message = "why";
    send(topics::kMissionStatus, message);
  }
  [[nodiscard]] std::string content(const fs::path& name) const {
    std::ifstream stream(folder_.path() / name, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  [[nodiscard]] std::size_t lines(const char* name) const {
    const std::string text = content(fs::path("estimator") / name);
    return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
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
  [[nodiscard]] std::string section() const { return content("sections/recorder.json"); }

  testing::TemporaryFolder folder_;
  ComponentHarness harness_;
  testing::Collector<MissionStatus> statuses_ = harness_.collect(topics::kMissionStatus);
};

TEST_F(EstimatorRecorderTest, WritesEverythingAndEndsWithItsSource) {
  auto& recorder = start();
  send(topics::kTrueOdometry, odometry(1.0, 1.01));
  send(topics::kOdometryFiltered, odometry());
  send(topics::kEstimatorState, state());
  send(topics::kEstimatorState, state(1.1));
  send(topics::kGpsFix, fix());
  EXPECT_EQ(lines("estimate.csv"), 2U);
  EXPECT_EQ(lines("truth.csv"), 2U);
  EXPECT_EQ(lines("errors.csv"), 2U);
  EXPECT_EQ(lines("state.csv"), 3U);
  EXPECT_EQ(lines("factors.csv"), 7U);
  EXPECT_EQ(lines("sources.csv"), 3U) << "nothing has changed in the second message";
  EXPECT_EQ(lines("gps.csv"), 2U);
  EXPECT_EQ(own_status(), nullptr);
  say(MissionStatus::COMPLETE);
  ASSERT_TRUE(harness_.spin_until([&] { return own_status() != nullptr; }));
  EXPECT_EQ(own_status()->state, MissionStatus::COMPLETE);
  EXPECT_EQ(own_status()->message, "1 estimates and 2 keyframes received");
  EXPECT_THAT(section(), HasSubstr("\"estimator_position_rmse_m\": 0.01"));
  EXPECT_THAT(section(), HasSubstr("\"estimator_gps_accepted\": 5"));
  EXPECT_THAT(section(), HasSubstr("estimator/estimate.csv"));
  EXPECT_TRUE(harness_.shutdown(recorder).success);
}

TEST_F(EstimatorRecorderTest, KeepsAPoseOfEachPeriodAndJudgesAll) {
  start({{"period", 0.5}});
  for (int k = 0; k <= 20; ++k) {
    send(topics::kOdometryFiltered, odometry(1.0 + 0.1 * k, 1.1));
    send(topics::kTrueOdometry, odometry(1.0 + 0.1 * k, 1.0));
  }
  EXPECT_EQ(lines("estimate.csv"), 6U);
  EXPECT_EQ(lines("truth.csv"), 6U);
  EXPECT_EQ(lines("errors.csv"), 6U);
  say(MissionStatus::COMPLETE);
  ASSERT_TRUE(harness_.spin_until([&] { return own_status() != nullptr; }));
  EXPECT_THAT(section(), HasSubstr("Errors of 21 estimates"));
}

TEST_F(EstimatorRecorderTest, AllPosesCanBeKept) {
  start({{"period", 0.0}});
  for (int k = 0; k < 10; ++k) {
    send(topics::kOdometryFiltered, odometry(1.0 + 0.005 * k));
  }
  EXPECT_EQ(lines("estimate.csv"), 11U);
  EXPECT_FALSE(fs::exists(folder_.path() / "estimator/errors.csv")) << "there is no truth";
}

TEST_F(EstimatorRecorderTest, FixesAreInTheMap) {
  start();
  send(topics::kGpsFix, fix());
  EXPECT_THAT(content("estimator/gps.csv"), HasSubstr("1.000000000,46.5,8.25,500,0,0,0\n"))
      << "the first is its origin";
  auto none = fix();
  none.status.status = -1;
  send(topics::kGpsFix, none);
  EXPECT_EQ(lines("gps.csv"), 2U);
  auto flat = fix(46.501);
  flat.altitude = kNan;
  send(topics::kGpsFix, flat);
  EXPECT_THAT(content("estimator/gps.csv"), HasSubstr("1.000000000,46.501,8.25,nan,"));
}

TEST_F(EstimatorRecorderTest, TheDatumIsThatOfTheEstimator) {
  start({{"datum", std::vector<double>{46.5, 8.25, 400.0}}});
  send(topics::kGpsFix, fix());
  EXPECT_THAT(content("estimator/gps.csv"), HasSubstr(",100.000000000"));
}

TEST_F(EstimatorRecorderTest, ARunWithoutEstimatesIsNotComplete) {
  start();
  send(topics::kEstimatorState, state());
  say(MissionStatus::COMPLETE);
  ASSERT_TRUE(harness_.spin_until([&] { return own_status() != nullptr; }));
  EXPECT_EQ(own_status()->state, MissionStatus::FAILED);
}

TEST_F(EstimatorRecorderTest, ASourceThatDiesFailsTheMission) {
  start({{"silent_after", 0.02}});
  send(topics::kOdometryFiltered, odometry());
  ASSERT_TRUE(harness_.spin_until([&] { return own_status() != nullptr; }));
  EXPECT_EQ(own_status()->state, MissionStatus::FAILED);
  EXPECT_EQ(own_status()->message,
            "no message has arrived for 0.02 s, and 'robot' has not reported completion: 1 "
            "estimates and 0 keyframes received");
}

TEST_F(EstimatorRecorderTest, CountsWhatItCannotRecordAndLosesNothingElse) {
  auto& recorder = start();
  const auto expect_counted = [&](const char* counter, const auto& topic, auto message,
                                  const auto& spoil) {
    const auto before = recorder.diagnostics().counter(counter);
    spoil(message);
    send(topic, message);
    EXPECT_EQ(recorder.diagnostics().counter(counter), before + 1) << counter;
  };
  expect_counted("estimate.malformed", topics::kOdometryFiltered, odometry(),
                 [](auto& m) { m.pose.pose.position.x = kNan; });
  expect_counted("estimate.malformed", topics::kOdometryFiltered, odometry(),
                 [](auto& m) { m.pose.covariance[0] = 0.0; });
  expect_counted("estimate.malformed", topics::kOdometryFiltered, odometry(),
                 [](auto& m) { m.twist.twist.angular.z = kNan; });
  expect_counted("truth.malformed", topics::kTrueOdometry, odometry(),
                 [](auto& m) { m.pose.pose.orientation.w = 0.5; });
  expect_counted("state.malformed", topics::kEstimatorState, state(),
                 [](auto& m) { m.source_gated.pop_back(); });
  expect_counted("state.malformed", topics::kEstimatorState, state(),
                 [](auto& m) { m.factor_weight.pop_back(); });
  expect_counted("state.malformed", topics::kEstimatorState, state(),
                 [](auto& m) { m.source[0] = "g p s"; });
  expect_counted("state.malformed", topics::kEstimatorState, state(), [](auto& m) {
    m.rack.covariance[0] = 1.0;
    m.rack.pose.position.x = kNan;
  });
  expect_counted("fix.malformed", topics::kGpsFix, fix(), [](auto& m) { m.latitude = 91.0; });
  send(topics::kOdometryFiltered, odometry());
  send(topics::kEstimatorState, state());
  send(topics::kGpsFix, fix());
  EXPECT_EQ(lines("estimate.csv"), 2U);
  EXPECT_EQ(lines("state.csv"), 2U);
  EXPECT_EQ(lines("factors.csv"), 4U);
  EXPECT_EQ(lines("gps.csv"), 2U);
  EXPECT_FALSE(fs::exists(folder_.path() / "estimator/truth.csv"));
  EXPECT_EQ(recorder.state(), LifecycleState::kActive);
}

TEST_F(EstimatorRecorderTest, FailsWhenItCannotWrite) {
  auto& recorder = start();
  std::ofstream(folder_.path() / "estimator" / "errors.csv") << "somebody else's\n";
  send(topics::kOdometryFiltered, odometry());
  send(topics::kTrueOdometry, odometry());
  ASSERT_NE(own_status(), nullptr);
  EXPECT_EQ(own_status()->state, MissionStatus::FAILED);
  EXPECT_THAT(own_status()->message, HasSubstr("errors.csv"));
  EXPECT_EQ(recorder.state(), LifecycleState::kActive);
}

TEST_F(EstimatorRecorderTest, EachRunHasAFolderAndAReportOfItsOwn) {
  auto& recorder = start();
  send(topics::kEstimatorState, state());
  send(topics::kOdometryFiltered, odometry());
  ASSERT_TRUE(harness_.deactivate(recorder).success);
  ASSERT_TRUE(harness_.cleanup(recorder).success);
  ASSERT_TRUE(harness_.bring_up(recorder).success);
  send(topics::kOdometryFiltered, odometry());
  EXPECT_TRUE(fs::exists(folder_.path() / "estimator_2" / "estimate.csv"));
  ASSERT_TRUE(harness_.deactivate(recorder).success);
  EXPECT_THAT(section(), Not(HasSubstr("estimator_gps_accepted")));
}

TEST(EstimatorRecorderStart, RefusesADatumThatIsNone) {
  ComponentHarness harness;
  const testing::TemporaryFolder folder;
  const auto refused = [&](const char* name, const std::vector<double>& datum) {
    auto& recorder = harness.make<EstimatorRecorder>(
        {.name = name,
         .parameters = {{"mission_folder", folder.path().string()}, {"datum", datum}}});
    return harness.configure(recorder).message;
  };
  EXPECT_THAT(refused("a", {46.5, 8.25}), HasSubstr("parameter 'datum' has 2 values"));
  EXPECT_THAT(refused("b", {91.0, 8.25, 0.0}), HasSubstr("parameter 'datum': "));
  EXPECT_FALSE(fs::exists(folder.path() / "estimator")) << "nothing is left behind";
}

}  // namespace
}  // namespace pipescout
