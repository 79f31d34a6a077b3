// SPDX-License-Identifier: Apache-2.0
// Whether commands find everybody, whoever is found first.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <fstream>
#include <string>

#include "pipescout/files/testing/temporary_folder.hpp"
#include "program.hpp"

namespace pipescout::host {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class Discovery : public ::testing::Test {
 protected:
  Discovery() {
    for (const char* name : {"one", "two"}) {
      std::ofstream(folder_.path() / (std::string(name) + ".yaml"))
          << "components:\n  - {type: pipescout_test::Talker, name: " << name << "}\n";
    }
  }
  ~Discovery() override { run_program({"daemon", "stop"}, folder_.path()); }

  [[nodiscard]] Finished run(std::vector<std::string> arguments) const {
    arguments.insert(arguments.end(), {"--spin-time", "30"});
    return run_program(arguments, folder_.path());
  }

  ::pipescout::testing::TemporaryFolder folder_;
};

TEST_F(Discovery, AListNamesAProcessThatDoesNotAnswer) {
  Program one({"run", "one.yaml", "--out", "m1"}, folder_.path());
  Program two({"run", "two.yaml", "--namespace", "/far", "--out", "m2"}, folder_.path());
  ASSERT_TRUE(one.wait_for_err(" active\n"));
  ASSERT_TRUE(two.wait_for_err(" active\n"));
  const auto list = run({"node", "list"});
  EXPECT_EQ(list.out, "/one\n/pipescout_container\n/far/pipescout_container\n/far/two\n");
  EXPECT_EQ(list.err, "");
  two.signal(SIGSTOP);
  const auto short_list = run_program({"node", "list", "--spin-time", "1"}, folder_.path());
  EXPECT_THAT(short_list.out, Not(HasSubstr("/far")));
  EXPECT_THAT(short_list.err, AllOf(HasSubstr("WARNING: this may be incomplete: process " +
                                              std::to_string(two.pid()) + " (pipescout)"),
                                    HasSubstr("has not answered")));
}

TEST_F(Discovery, TheDaemonAnswersAsTheCommandItself) {
  Program one({"run", "one.yaml", "--out", "m1"}, folder_.path());
  ASSERT_TRUE(one.wait_for_err(" active\n"));
  EXPECT_EQ(run_program({"daemon", "status"}, folder_.path()).out, "The daemon is not running\n");
  EXPECT_EQ(run_program({"daemon", "start"}, folder_.path()).out, "The daemon has been started\n");
  EXPECT_EQ(run_program({"daemon", "start"}, folder_.path()).out,
            "The daemon is already running\n");
  EXPECT_EQ(run_program({"daemon", "status"}, folder_.path()).out, "The daemon is running\n");
  for (const std::vector<std::string>& command : {std::vector<std::string>{"node", "list"},
                                                  {"node", "info", "/one"},
                                                  {"topic", "list", "-t"},
                                                  {"topic", "info", "/chatter", "-v"},
                                                  {"service", "list"},
                                                  {"service", "type", "/one/get_state"},
                                                  {"action", "list"}}) {
    const auto by_daemon = run(command);
    auto alone = command;
    alone.emplace_back("--no-daemon");
    EXPECT_EQ(by_daemon.out, run(alone).out) << command[0] << ' ' << command[1];
    EXPECT_EQ(by_daemon.code(), 0);
    EXPECT_EQ(by_daemon.err, "");
  }
  const auto unknown =
      run_program({"topic", "info", "/nothing", "--spin-time", "0"}, folder_.path());
  EXPECT_EQ(unknown.code(), 1);
  EXPECT_THAT(unknown.err, HasSubstr("Unknown topic '/nothing'"));
  // Who has been killed is no longer listed, though its lease goes on.
  kill(one.pid(), SIGKILL);
  one.finish();
  EXPECT_EQ(run({"node", "list"}).out, "");
  EXPECT_EQ(run_program({"daemon", "stop"}, folder_.path()).out, "The daemon has been stopped\n");
  EXPECT_EQ(run_program({"daemon", "stop"}, folder_.path()).out, "The daemon is not running\n");
}

}  // namespace
}  // namespace pipescout::host
