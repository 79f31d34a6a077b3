// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/silence_watch.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <string>
#include <utility>
#include <vector>

#include "pipescout/testing/component_harness.hpp"

namespace pipescout {
namespace {

using std::chrono::seconds;
using testing::ComponentHarness;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

class Listener : public Component {
 public:
  explicit Listener(ComponentOptions options) : Component(std::move(options)) {}

  std::vector<std::string> faults;
  SilenceWatch watch{*this, "image.silent",
                     [this](std::string_view counter, std::string_view text) {
                       faults.push_back(std::string(counter) + ": " + std::string(text));
                     }};

 private:
  CallbackReturn on_configure() override {
    watch.start("image", 2.0);
    return CallbackReturn::kSuccess;
  }
  CallbackReturn on_cleanup() override {
    watch.stop();
    return CallbackReturn::kSuccess;
  }
};

class SilenceWatchTest : public ::testing::Test {
 protected:
  SilenceWatchTest() { EXPECT_TRUE(harness_.bring_up(listener_).success); }

  std::vector<std::string> told() {
    std::vector<std::string> texts;
    for (const auto& message : harness_.logs()) {
      if (message.text.starts_with("waits")) {
        texts.push_back(message.text);
      }
    }
    return texts;
  }

  ComponentHarness harness_{{.simulated_time = true}};
  Listener& listener_ = harness_.make<Listener>({.name = "listener"});
};

TEST_F(SilenceWatchTest, ASourceThatHasNotBegunIsNotSilentHoweverLateTheClockBegins) {
  harness_.set_time(Time(seconds(1000)));
  EXPECT_THAT(told(), IsEmpty()) << "the clock has only begun";
  harness_.advance(seconds(1));
  harness_.advance(seconds(1));
  EXPECT_THAT(told(), ElementsAre("waits for the first image"));
  for (int i = 0; i < 10; ++i) {
    harness_.advance(seconds(2));
  }
  EXPECT_THAT(told(), SizeIs(1));
  EXPECT_THAT(listener_.faults, IsEmpty());
}

TEST_F(SilenceWatchTest, ASourceThatStopsIsSilentOnceForEachPeriod) {
  harness_.set_time(Time(seconds(1000)));
  harness_.advance(std::chrono::milliseconds(1999));
  listener_.watch.heard();
  harness_.advance(seconds(1));
  EXPECT_THAT(listener_.faults, IsEmpty()) << "the period begins with the first message";
  harness_.advance(seconds(1));
  EXPECT_THAT(listener_.faults, IsEmpty());
  harness_.advance(seconds(2));
  EXPECT_THAT(listener_.faults, ElementsAre("image.silent: no image for 2 s"));
  listener_.watch.heard();
  harness_.advance(seconds(2));
  EXPECT_THAT(listener_.faults, SizeIs(1));
  harness_.advance(seconds(2));
  EXPECT_THAT(listener_.faults, SizeIs(2));
}

TEST_F(SilenceWatchTest, WhatIsNotActiveIsNotWatchedAndAfterItsCleanUpItBeginsAnew) {
  harness_.set_time(Time(seconds(1000)));
  listener_.watch.heard();
  ASSERT_TRUE(harness_.deactivate(listener_).success);
  harness_.advance(seconds(10));
  EXPECT_THAT(listener_.faults, IsEmpty());
  ASSERT_TRUE(harness_.cleanup(listener_).success);
  ASSERT_TRUE(harness_.bring_up(listener_).success);
  harness_.advance(seconds(2));
  harness_.advance(seconds(2));
  harness_.advance(seconds(2));
  EXPECT_THAT(listener_.faults, IsEmpty());
}

}  // namespace
}  // namespace pipescout
