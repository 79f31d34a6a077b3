// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <chrono>
#include <diagnostic_msgs/msg/diagnostic_status.hpp>
#include <sensor_msgs/msg/imu.hpp>
#include <std_msgs/msg/string.hpp>
#include <string>
#include <utility>
#include <vector>

#include "pipescout/runtime/component.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "pipescout/testing/component_harness.hpp"

namespace pipescout {
namespace {

using diagnostic_msgs::msg::DiagnosticStatus;
using sensor_msgs::msg::Imu;
using std::chrono::milliseconds;
using std::chrono::seconds;
using testing::ComponentHarness;

/// Declares what it expects of its IMU: 20 Hz, at most 0.2 s old.
class Estimator : public Component {
 public:
  explicit Estimator(ComponentOptions options) : Component(std::move(options)) {}

 private:
  CallbackReturn on_configure() override {
    imu_ = create_subscription<Imu>("imu/data", QoS::reliable(100), [](const Imu&) {},
                                    {.expected = {.minimum_rate = 20.0, .maximum_age = 0.2}});
    text_ = create_subscription<std_msgs::msg::String>("text", QoS::reliable(100),
                                                       [](const std_msgs::msg::String&) {});
    return CallbackReturn::kSuccess;
  }
  CallbackReturn on_cleanup() override {
    imu_ = {};
    text_ = {};
    return CallbackReturn::kSuccess;
  }

  Subscription<Imu> imu_;
  Subscription<std_msgs::msg::String> text_;
};

class InputWatchTest : public ::testing::Test {
 protected:
  Estimator& make(const std::vector<NamedParameter>& parameters = {}) {
    auto& component = harness_.make<Estimator>({.name = "estimator", .parameters = parameters});
    configured_ = harness_.bring_up(component);
    return component;
  }

  /// A number of IMU messages with a period between them; their stamps are `old`.
  void drive(int messages, milliseconds period, milliseconds old = milliseconds(0)) {
    for (int i = 0; i < messages; ++i) {
      Imu imu;
      imu.header.stamp = to_message(now_ - old);
      harness_.publish("imu/data", imu);
      wait(period);
    }
  }
  void wait(milliseconds time) {
    harness_.advance(time);
    now_ += time;
  }
  DiagnosticStatus last(const Component& component) {
    return harness_.diagnostics(component).back();
  }

  ComponentHarness harness_{{.simulated_time = true}};
  Time now_{seconds(100)};
  TransitionResult configured_;

  void SetUp() override { harness_.set_time(now_); }
};

TEST_F(InputWatchTest, SaysRateAndAgeOfAnInputAsItShouldBe) {
  auto& component = make();
  ASSERT_TRUE(configured_.success) << configured_.message;
  drive(60, milliseconds(50));
  const auto status = last(component);
  EXPECT_EQ(status.level, DiagnosticStatus::OK) << status.message;
  EXPECT_EQ(ComponentHarness::value(status, "input /imu/data: rate_hz"), "20");
  EXPECT_EQ(ComponentHarness::value(status, "input /imu/data: age_s"), "0.05");
}

TEST_F(InputWatchTest, WarnsOfARateThatIsTooLow) {
  auto& component = make();
  drive(30, milliseconds(100));
  const auto status = last(component);
  EXPECT_EQ(status.level, DiagnosticStatus::WARN);
  EXPECT_EQ(status.message, "input /imu/data comes at 10 Hz, expected at least 20");
}

TEST_F(InputWatchTest, WarnsOfStampsThatAreTooOld) {
  auto& component = make();
  drive(60, milliseconds(50), milliseconds(450));
  const auto status = last(component);
  EXPECT_EQ(status.level, DiagnosticStatus::WARN);
  EXPECT_EQ(status.message, "input /imu/data is 0.5 s old, expected at most 0.2");
}

TEST_F(InputWatchTest, AnInputThatHasNotBegunIsStaleHoweverLateTheClockBegins) {
  harness_.set_time(Time{});
  auto& component = make({{"inputs.topics", std::vector<std::string>{"imu/data", "text"}},
                          {"inputs.minimum_rates", std::vector<double>{20.0, 0.0}}});
  for (int i = 0; i < 3; ++i) {
    now_ += seconds(100);
    harness_.set_time(now_);
    EXPECT_EQ(last(component).level, DiagnosticStatus::STALE);
    EXPECT_EQ(last(component).message, "input /imu/data waits for the first message");
  }
  drive(60, milliseconds(50));
  EXPECT_EQ(last(component).level, DiagnosticStatus::OK) << last(component).message;
}

TEST_F(InputWatchTest, AWarningComesBeforeAnInputThatHasNotBegun) {
  auto& component = make();
  wait(seconds(1));
  EXPECT_EQ(last(component).level, DiagnosticStatus::STALE);
  component.diagnostics().count("faults");
  harness_.spin();
  EXPECT_EQ(last(component).level, DiagnosticStatus::WARN);
  EXPECT_EQ(last(component).message, "faults +1; input /imu/data waits for the first message");
}

TEST_F(InputWatchTest, SilenceIsAnErrorUntilItEnds) {
  auto& component = make();
  drive(60, milliseconds(50));
  wait(seconds(1));
  wait(seconds(1));
  EXPECT_EQ(last(component).level, DiagnosticStatus::ERROR);
  EXPECT_EQ(last(component).message, "input /imu/data nothing came in 1 s");
  drive(60, milliseconds(50));
  EXPECT_EQ(last(component).level, DiagnosticStatus::OK) << last(component).message;
  wait(seconds(1));
  wait(seconds(1));
  EXPECT_EQ(last(component).level, DiagnosticStatus::ERROR);
}

TEST_F(InputWatchTest, ParametersComeBeforeWhatIsDeclared) {
  auto& component = make({{"inputs.topics", std::vector<std::string>{"imu/data", "text"}},
                          {"inputs.minimum_rates", std::vector<double>{5.0, 0.5}}});
  ASSERT_TRUE(configured_.success) << configured_.message;
  harness_.publish("text", std_msgs::msg::String());
  drive(30, milliseconds(100), milliseconds(450));
  EXPECT_EQ(last(component).level, DiagnosticStatus::OK) << last(component).message;
  // Half a hertz is judged over ten seconds.
  drive(80, milliseconds(100));
  const auto status = last(component);
  EXPECT_EQ(status.level, DiagnosticStatus::ERROR);
  EXPECT_EQ(status.message, "input /text nothing came in 10 s");
}

TEST_F(InputWatchTest, NamesAnInputThatIsNone) {
  auto& component = make({{"inputs.topics", std::vector<std::string>{"imu/dta"}}});
  drive(20, milliseconds(50));
  EXPECT_EQ(last(component).level, DiagnosticStatus::WARN);
  EXPECT_EQ(last(component).message, "input /imu/dta is in inputs.topics, and no input");
}

TEST_F(InputWatchTest, JudgesOnlyWhileActive) {
  auto& component = make();
  drive(60, milliseconds(50));
  ASSERT_TRUE(harness_.deactivate(component).success);
  wait(seconds(3));
  EXPECT_EQ(last(component).level, DiagnosticStatus::OK) << last(component).message;
  ASSERT_TRUE(harness_.activate(component).success);
  // The second before does not count.
  drive(25, milliseconds(50));
  EXPECT_EQ(last(component).level, DiagnosticStatus::OK) << last(component).message;
}

TEST_F(InputWatchTest, AClockThatIsSetBackStartsAnew) {
  auto& component = make();
  drive(60, milliseconds(50));
  now_ = Time(seconds(10));
  harness_.set_time(now_);
  drive(45, milliseconds(50));
  EXPECT_EQ(last(component).level, DiagnosticStatus::OK) << last(component).message;
}

TEST_F(InputWatchTest, RefusesListsThatDoNotGoTogether) {
  make({{"inputs.topics", std::vector<std::string>{"imu/data"}},
        {"inputs.maximum_ages", std::vector<double>{1.0, 2.0}}});
  EXPECT_FALSE(configured_.success);
  EXPECT_EQ(configured_.message,
            "on_configure: inputs.maximum_ages has 2 values for 1 of inputs.topics; expected one "
            "each, or none at all");
}

TEST_F(InputWatchTest, RefusesATopicTwice) {
  make({{"inputs.topics", std::vector<std::string>{"imu/data", "/imu/data"}}});
  EXPECT_EQ(configured_.message, "on_configure: inputs.topics has '/imu/data' twice");
}

TEST_F(InputWatchTest, RefusesInvalidNames) {
  make({{"inputs.topics", std::vector<std::string>{"imu data"}}});
  EXPECT_FALSE(configured_.success);
  EXPECT_EQ(configured_.message.rfind("on_configure: inputs.topics: ", 0), 0U)
      << configured_.message;
}

}  // namespace
}  // namespace pipescout
