// SPDX-License-Identifier: Apache-2.0
#include "cli/external_commands.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <string_view>

#include "pipescout/files/testing/temporary_folder.hpp"

namespace pipescout::host {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;

class ExternalCommands : public ::testing::Test {
 protected:
  void add(const std::string& name, const std::string& text = "#!/bin/sh\n",
           fs::perms permissions = fs::perms::owner_all) const {
    fs::create_directories(path(name).parent_path());
    std::ofstream(path(name)) << text;
    fs::permissions(path(name), permissions);
  }
  [[nodiscard]] fs::path path(const std::string& name) const { return folder_.path() / name; }
  [[nodiscard]] ExternalCommandPlaces places() const {
    return {.prefixes = {path("first"), path("second"), path("no_prefix")},
            .folders = {path("path"), path("no_folder")}};
  }
  [[nodiscard]] fs::path found(const std::string& name) const {
    const auto command = find_external_command(name, places());
    return command ? command->executable : fs::path();
  }
  [[nodiscard]] std::vector<std::string> listed() const {
    std::vector<std::string> names;
    for (const auto& command : list_external_commands(places())) {
      names.push_back(command.name + ": " + fs::relative(command.executable, path("")).string() +
                      (command.summary.empty() ? "" : " (" + command.summary + ")"));
    }
    return names;
  }

 private:
  ::pipescout::testing::TemporaryFolder folder_;
};

TEST_F(ExternalCommands, AreFoundInPrefixesThenInPath) {
  add("path/pipescout-a");
  EXPECT_EQ(found("a"), path("path/pipescout-a"));
  add("second/lib/some_package/pipescout-a");
  EXPECT_EQ(found("a"), path("second/lib/some_package/pipescout-a"));
  add("second/bin/pipescout-a");
  EXPECT_EQ(found("a"), path("second/bin/pipescout-a"));
  add("first/lib/package/pipescout-a");
  EXPECT_EQ(found("a"), path("first/lib/package/pipescout-a"));
  EXPECT_EQ(found("b"), "");
}

TEST_F(ExternalCommands, AreListedOnceWithTheirSummary) {
  add("first/bin/pipescout-weigh");
  add("first/share/pipescout/commands/weigh", "Weigh the robot\n");
  add("second/bin/pipescout-weigh");
  add("second/lib/tools/pipescout-dig_2");
  add("path/pipescout-weigh");
  add("path/pipescout-ask-me");
  EXPECT_THAT(listed(), ElementsAre("ask-me: path/pipescout-ask-me",
                                    "dig_2: second/lib/tools/pipescout-dig_2",
                                    "weigh: first/bin/pipescout-weigh (Weigh the robot)"));
}

TEST_F(ExternalCommands, SayWhetherTheyAnswerAShell) {
  add("first/bin/pipescout-weigh");
  add("first/share/pipescout/commands/weigh", "Weigh the robot\ncompletion\n");
  add("first/bin/pipescout-dig");
  add("first/share/pipescout/commands/dig", "Dig\n");
  EXPECT_TRUE(find_external_command("weigh", places())->completes);
  EXPECT_FALSE(find_external_command("dig", places())->completes);
}

TEST(ProjectCommands, AreThoseOfThePackagesBesideTheHost) {
  std::map<std::string_view, std::string_view> packages;
  for (const auto& command : project_commands()) {
    packages[command.name] = command.package;
  }
  EXPECT_EQ(packages["estimate"], "pipescout_estimate");
  EXPECT_EQ(packages["plot"], "pipescout_plot");  // is no C++
  EXPECT_FALSE(packages.contains("command_line"));
}

TEST_F(ExternalCommands, OtherFilesAreNone) {
  add("first/bin/pipescout-text", "text", fs::perms::owner_read);
  fs::create_directories(path("first/bin/pipescout-folder"));
  add("first/bin/pipescout");
  add("first/bin/pipescout-");
  add("first/bin/pipescout-a.sh");
  add("first/bin/pipescout_tool");
  fs::create_symlink(path("gone"), path("first/bin/pipescout-broken"));
  EXPECT_THAT(listed(), ElementsAre());
  for (const char* name :
       {"text", "folder", "", "broken", "a.sh", "../bin/pipescout", "-a", "a/b"}) {
    EXPECT_EQ(found(name), "") << name;
  }
}

}  // namespace
}  // namespace pipescout::host
