// SPDX-License-Identifier: Apache-2.0
#include "cli/completion.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace pipescout::host {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

class CompletionTest : public ::testing::Test {
 protected:
  CompletionTest() {
    auto* const topic = app_.add_subcommand("topic");
    auto* const echo = topic->add_subcommand("echo");
    echo->add_option("topic", text_);
    echo->add_option("type", text_);
    echo->add_flag("--once", flag_);
    echo->add_option("-n,--count", text_);
    topic->add_subcommand("list");
    app_.add_subcommand("run")->add_option("composition", text_);
    app_.add_subcommand("node")->add_option("node", nodes_);
    app_.add_subcommand("__hidden")->group("");
  }

  std::vector<std::string> complete(const std::vector<std::string>& words) {
    return host::complete(app_, words, [this](const std::string& kind) {
      asked_ = kind;
      return kind == "topic"  ? std::vector<std::string>{"/odom", "/imu/data"}
             : kind == "node" ? std::vector<std::string>{"/fusion", "/locator"}
                              : std::vector<std::string>{};
    });
  }

  CLI::App app_;
  std::string text_;
  std::vector<std::string> nodes_;
  bool flag_ = false;
  std::string asked_;
};

TEST_F(CompletionTest, OffersCommands) {
  EXPECT_THAT(complete({}), ElementsAre("node", "run", "topic"));
  EXPECT_THAT(complete({"t"}), ElementsAre("topic"));
  EXPECT_THAT(complete({"topic", ""}), ElementsAre("echo", "list"));
  EXPECT_THAT(complete({"topic", "x"}), IsEmpty());
}

TEST_F(CompletionTest, OffersOptions) {
  EXPECT_THAT(complete({"topic", "echo", "--"}), ElementsAre("--count", "--help", "--once"));
  EXPECT_THAT(complete({"topic", "echo", "/odom", "--o"}), ElementsAre("--once"));
  EXPECT_THAT(complete({"topic", "echo", "--", "-"}), IsEmpty());
}

TEST_F(CompletionTest, OffersNamesOfTheRunningSystem) {
  EXPECT_THAT(complete({"topic", "echo", ""}), ElementsAre("/imu/data", "/odom"));
  EXPECT_THAT(complete({"topic", "echo", "--once", "/o"}), ElementsAre("/odom"));
  EXPECT_THAT(complete({"topic", "echo", "-n", "3", "/o"}), ElementsAre("/odom"));
  EXPECT_THAT(complete({"topic", "echo", "--count=3", "/o"}), ElementsAre("/odom"));
}

TEST_F(CompletionTest, KnowsWhichArgumentStandsThere) {
  complete({"topic", "echo", "/odom", ""});
  EXPECT_EQ(asked_, "type");
  asked_.clear();
  EXPECT_THAT(complete({"topic", "echo", "/odom", "std_msgs/msg/String", ""}), IsEmpty());
  EXPECT_EQ(asked_, "");
  EXPECT_THAT(complete({"node", "/fusion", "/l"}), ElementsAre("/locator"));
}

TEST_F(CompletionTest, LeavesTheValueOfAnOptionToTheUser) {
  EXPECT_THAT(complete({"topic", "echo", "-n", ""}), IsEmpty());
  EXPECT_EQ(asked_, "");
}

}  // namespace
}  // namespace pipescout::host
