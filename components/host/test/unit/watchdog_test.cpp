// SPDX-License-Identifier: Apache-2.0
#include "core/watchdog.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace pipescout::host {
namespace {

using std::chrono::milliseconds;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class WatchdogTest : public ::testing::Test {
 protected:
  /// Of a second.
  Watchdog make() {
    return {std::chrono::seconds(1),
            start_,
            {.ask = [this] { ++asked_; },
             .silent = [this] { return silent_; },
             .alive = [this] { ++alive_; },
             .warn = [this](const std::string& text) { warnings_.push_back(text); }}};
  }

  SteadyTime start_{std::chrono::seconds(7)};
  int asked_ = 0;
  int alive_ = 0;
  std::vector<std::string> silent_;
  std::vector<std::string> warnings_;
};

TEST_F(WatchdogTest, SaysAliveWhileAllAnswer) {
  auto watchdog = make();
  EXPECT_EQ(alive_, 1);
  EXPECT_EQ(watchdog.on_time(start_ + milliseconds(10)), start_ + milliseconds(250));
  EXPECT_EQ(alive_, 1);
  for (int k = 1; k <= 8; ++k) {
    const auto now = start_ + k * milliseconds(250);
    EXPECT_EQ(watchdog.on_time(now), now + milliseconds(250));
    EXPECT_EQ(alive_, 1 + k);
    EXPECT_EQ(asked_, 1 + k);
  }
  EXPECT_THAT(warnings_, IsEmpty());
}

TEST_F(WatchdogTest, IsQuietAndWarnsOnceWhileOneDoesNotAnswer) {
  auto watchdog = make();
  silent_ = {"/arm", "/fusion"};
  for (int k = 1; k <= 3; ++k) {
    watchdog.on_time(start_ + k * milliseconds(250));
  }
  EXPECT_EQ(alive_, 1);
  EXPECT_THAT(warnings_, ElementsAre(HasSubstr("no answer from the executor of /arm, /fusion")));
  silent_.clear();
  watchdog.on_time(start_ + milliseconds(1000));
  EXPECT_EQ(alive_, 2);
  silent_ = {"/arm"};
  watchdog.on_time(start_ + milliseconds(1250));
  EXPECT_EQ(warnings_.size(), 2U);
}

}  // namespace
}  // namespace pipescout::host
