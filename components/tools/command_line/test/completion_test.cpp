// SPDX-License-Identifier: Apache-2.0
#include "pipescout/command_line/completion.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pipescout/command_line/command.hpp"

namespace pipescout::command_line {
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
    echo->add_option("--format", text_)->check(CLI::IsMember({"png", "tiff"}));
    topic->add_subcommand("list");
    app_.add_subcommand("run")->add_option("composition", text_);
    app_.add_subcommand("node")->add_option("node", nodes_);
    app_.add_subcommand("__hidden")->group("");
  }

  std::vector<std::string> words(const std::vector<std::string>& given) {
    return complete(app_, given).words;
  }
  std::string kind(const std::vector<std::string>& given) { return complete(app_, given).kind; }

  CLI::App app_;
  std::string text_;
  std::vector<std::string> nodes_;
  bool flag_ = false;
};

TEST_F(CompletionTest, OffersCommands) {
  EXPECT_THAT(words({}), ElementsAre("node", "run", "topic"));
  EXPECT_THAT(words({"t"}), ElementsAre("topic"));
  EXPECT_THAT(words({"topic", ""}), ElementsAre("echo", "list"));
  EXPECT_THAT(words({"topic", "x"}), IsEmpty());
}

TEST_F(CompletionTest, OffersOptions) {
  EXPECT_THAT(words({"topic", "echo", "--"}),
              ElementsAre("--count", "--format", "--help", "--once"));
  EXPECT_THAT(words({"topic", "echo", "/odom", "--o"}), ElementsAre("--once"));
  EXPECT_THAT(words({"topic", "echo", "--", "-"}), IsEmpty());
}

TEST_F(CompletionTest, OffersTheValuesOfAnOption) {
  EXPECT_THAT(words({"topic", "echo", "--format", ""}), ElementsAre("png", "tiff"));
  EXPECT_THAT(words({"topic", "echo", "--format", "t"}), ElementsAre("tiff"));
  EXPECT_THAT(words({"topic", "echo", "--format=t"}), ElementsAre("--format=tiff"));
  EXPECT_THAT(words({"topic", "echo", "--nothing=t"}), IsEmpty());
}

TEST_F(CompletionTest, KnowsWhichArgumentStandsThere) {
  EXPECT_EQ(kind({"topic", "echo", ""}), "topic");
  EXPECT_EQ(kind({"topic", "echo", "--once", "/o"}), "topic");
  EXPECT_EQ(kind({"topic", "echo", "-n", "3", "/o"}), "topic");
  EXPECT_EQ(kind({"topic", "echo", "--count=3", "/o"}), "topic");
  EXPECT_EQ(kind({"topic", "echo", "/odom", ""}), "type");
  EXPECT_EQ(kind({"topic", "echo", "/odom", "std_msgs/msg/String", ""}), "");
  EXPECT_EQ(kind({"node", "/fusion", "/l"}), "node");
}

TEST_F(CompletionTest, LeavesTheValueOfAnOptionToTheUser) {
  EXPECT_THAT(words({"topic", "echo", "-n", ""}), IsEmpty());
  EXPECT_EQ(kind({"topic", "echo", "-n", ""}), "");
}

TEST_F(CompletionTest, AnExecutableAnswersAShell) {
  const auto asked = [this](std::vector<const char*> given) {
    given.insert(given.begin(), {"tool", "__complete", "--"});
    std::vector<std::string> texts(given.begin(), given.end());
    std::vector<char*> pointers;
    for (auto& text : texts) {
      pointers.push_back(text.data());
    }
    ::testing::internal::CaptureStdout();
    const int code = command_main(
        "", "tool",
        [this](CLI::App& app, Action&) {
          app.add_option("recording", text_)->required();
          app.add_option("--out", text_)->required();
        },
        static_cast<int>(pointers.size()), pointers.data());
    EXPECT_EQ(code, kExitOk);
    return ::testing::internal::GetCapturedStdout();
  };
  EXPECT_EQ(asked({"--o"}), "--out\n");
  EXPECT_EQ(asked({"--out", "x", ""}), "@recording\n");
  EXPECT_EQ(asked({}), "@recording\n");
}

}  // namespace
}  // namespace pipescout::command_line
