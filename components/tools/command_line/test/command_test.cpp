// SPDX-License-Identifier: Apache-2.0
#include "pipescout/command_line/command.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace pipescout::command_line {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

/// A program with a command of a group, as all tools have them.
class EndOfOptions : public ::testing::Test {
 protected:
  EndOfOptions() {
    app_.require_subcommand(1);
    CLI::App* group = app_.add_subcommand("param");
    group->require_subcommand(1);
    CLI::App* set = group->add_subcommand("set");
    set->add_option("node", node_)->required();
    set->add_option("values", values_);
    set->add_flag("--quiet", quiet_);
    set->callback([this] { action_ = [] { return kExitOk; }; });
    CLI::App* get = group->add_subcommand("get");
    get->add_option("node", node_)->required();
  }
  int run(const std::vector<std::string>& words) { return run_command(app_, action_, words); }

  CLI::App app_{"", "tool"};
  Action action_;
  std::string node_;
  std::vector<std::string> values_;
  bool quiet_ = false;
};

TEST_F(EndOfOptions, AllBehindItAreArguments) {
  EXPECT_EQ(run({"param", "set", "--quiet", "/n", "1", "--", "-2", "--quiet", "--", "set", ""}),
            kExitOk);
  EXPECT_EQ(node_, "/n");
  EXPECT_THAT(values_, ElementsAre("1", "-2", "--quiet", "--", "set", ""));
  EXPECT_TRUE(quiet_);
}

TEST_F(EndOfOptions, ItMayComeBeforeAllArgumentsAndBehindThem) {
  EXPECT_EQ(run({"param", "set", "--", "-n", "-.inf"}), kExitOk);
  EXPECT_EQ(node_, "-n");
  EXPECT_THAT(values_, ElementsAre("-.inf"));
  EXPECT_FALSE(quiet_);
  EXPECT_EQ(run({"param", "set", "/n", "1", "--"}), kExitOk);
  EXPECT_THAT(values_, ElementsAre("1"));
}

TEST_F(EndOfOptions, ArgumentsTooManyAreNamedAsTheyAre) {
  ::testing::internal::CaptureStderr();
  EXPECT_EQ(run({"param", "get", "/n", "--", "-2"}), kExitUsage);
  const std::string problem = ::testing::internal::GetCapturedStderr();
  EXPECT_THAT(problem, HasSubstr("not expected: -2"));
  EXPECT_THAT(problem, Not(HasSubstr("\x01")));
}

}  // namespace
}  // namespace pipescout::command_line
