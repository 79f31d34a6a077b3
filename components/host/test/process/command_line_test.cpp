// SPDX-License-Identifier: Apache-2.0
// The commands that look into a running composition, from another process.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <csignal>
#include <fstream>

#include "pipescout/files/testing/temporary_folder.hpp"
#include "program.hpp"

namespace pipescout::host {
namespace {

using ::testing::AllOf;
using ::testing::Eq;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::MatchesRegex;
using ::testing::Not;
using ::testing::StartsWith;
namespace fs = std::filesystem;

/// One composition runs for all tests of this file: a listener, a talker, a listener in a hidden
/// namespace, and an isolated talker in another one.
class CommandLine : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    temporary_ = new ::pipescout::testing::TemporaryFolder();
    folder_ = temporary_->path();
    std::ofstream(folder_ / "c.yaml") << R"(components:
  - {type: pipescout_test::Listener, name: listener}
  - {type: pipescout_test::Talker, name: talker, parameters: {text: "it's: x"}}
  - {type: pipescout_test::Listener, name: listener, namespace: _hidden}
  - {type: pipescout_test::Talker, name: talker, namespace: far, isolate: true,
     restart: {limit: 9, backoff: 0.01}}
)";
    program_ = new Program({"run", "c.yaml", "--out", "m"}, folder_);
    ASSERT_TRUE(program_->wait_for_err(" active\n"));
  }
  static void TearDownTestSuite() {
    program_->signal(SIGINT);
    EXPECT_EQ(program_->finish().code(), 0);
    delete program_;
    delete temporary_;
  }

  /// With time enough for a busy machine; all end as soon as they have what they want.
  static Finished run(std::vector<std::string> arguments) {
    if (arguments[1] != "types") {
      arguments.insert(arguments.begin() + 2, {"--spin-time", "30"});
    }
    return run_program(arguments, folder_);
  }
  /// Right at the first try, and without a warning.
  static void expect_listed(const std::vector<std::string>& arguments,
                            const ::testing::Matcher<std::string>& matcher) {
    const auto finished = run(arguments);
    EXPECT_EQ(finished.code(), 0);
    EXPECT_THAT(finished.out, matcher);
    EXPECT_EQ(finished.err, "");
  }
  static std::string out(const std::vector<std::string>& arguments) {
    const auto finished = run(arguments);
    EXPECT_EQ(finished.code(), 0) << arguments[0] << ' ' << arguments[1] << ": " << finished.err;
    return finished.out;
  }
  static std::string error(const std::vector<std::string>& arguments) {
    const auto finished = run(arguments);
    EXPECT_EQ(finished.code(), 1) << finished.out;
    return finished.err;
  }

  static inline ::pipescout::testing::TemporaryFolder* temporary_ = nullptr;
  static inline fs::path folder_;
  static inline Program* program_ = nullptr;
};

TEST_F(CommandLine, ListsNodes) {
  expect_listed({"node", "list"},
                Eq("/listener\n/pipescout_container\n/talker\n/_hidden/listener\n/far/talker\n"));
  expect_listed({"node", "list", "-a"}, HasSubstr("/far/_talker\n"));
  expect_listed({"node", "list", "-c"}, Eq("5\n"));
}

TEST_F(CommandLine, DescribesANode) {
  const auto text = out({"node", "info", "/listener"});
  EXPECT_THAT(text, StartsWith("/listener\n  Subscribers:\n    /chatter: std_msgs/msg/String\n"
                               "  Publishers:\n    /diagnostics: "));
  EXPECT_THAT(text, HasSubstr("    /listener/get_state: lifecycle_msgs/srv/GetState\n"));
  EXPECT_THAT(text, HasSubstr("  Service Clients:\n\n  Action Servers:\n\n  Action Clients:\n\n"));
}

TEST_F(CommandLine, ListsTopics) {
  expect_listed({"topic", "list"},
                AllOf(HasSubstr("/chatter\n"), HasSubstr("/far/chatter\n"), HasSubstr("/rosout\n"),
                      Not(HasSubstr("get_state")), Not(HasSubstr("/_hidden"))));
  expect_listed({"topic", "list", "-a"}, HasSubstr("/_hidden/chatter\n"));
  expect_listed({"topic", "list", "-t"}, HasSubstr("/chatter [std_msgs/msg/String]\n"));
  expect_listed({"topic", "list", "-v"},
                AllOf(HasSubstr("Published topics:\n"),
                      HasSubstr(" * /chatter [std_msgs/msg/String] 1 publisher\n"),
                      HasSubstr("\nSubscribed topics:\n"),
                      HasSubstr(" * /chatter [std_msgs/msg/String] 1 subscriber\n")));
}

TEST_F(CommandLine, DescribesATopic) {
  EXPECT_EQ(out({"topic", "info", "/chatter"}),
            "Type: std_msgs/msg/String\nPublisher count: 1\nSubscription count: 1\n");
  const auto text = out({"topic", "info", "/chatter", "-v"});
  EXPECT_THAT(text, HasSubstr("Node name: talker\nNode namespace: /\n"
                              "Topic type: std_msgs/msg/String\nEndpoint type: PUBLISHER\nGID: "));
  EXPECT_THAT(text, HasSubstr("QoS profile:\n  Reliability: RELIABLE\n  History (Depth): UNKNOWN\n"
                              "  Durability: VOLATILE\n  Lifespan: Infinite\n"
                              "  Deadline: Infinite\n  Liveliness: AUTOMATIC\n"
                              "  Liveliness lease duration: Infinite\n\n"));
}

TEST_F(CommandLine, PrintsMessages) {
  EXPECT_THAT(out({"topic", "echo", "/chatter", "--once"}),
              MatchesRegex("data: 'it''s: x [0-9]+'\n---\n"));
  EXPECT_THAT(out({"topic", "echo", "chatter", "-n", "2", "--field", "data"}),
              MatchesRegex("it's: x [0-9]+\n---\nit's: x [0-9]+\n---\n"));
  EXPECT_THAT(out({"topic", "echo", "/chatter", "--once", "--csv"}),
              MatchesRegex("it's: x [0-9]+\n"));
  EXPECT_THAT(out({"topic", "echo", "/chatter", "std_msgs/String", "--once", "--qos-reliability",
                   "best_effort"}),
              StartsWith("data: "));
}

TEST_F(CommandLine, PublishesWhatYamlSays) {
  Program listener({"topic", "echo", "/published", "geometry_msgs/msg/PointStamped", "--once",
                    "--spin-time", "30"},
                   folder_);
  // Goes on until it is heard: the listener may know of it later than it knows of the listener.
  Program publisher(
      {"topic", "pub", "-w", "1", "-r", "20", "/published", "geometry_msgs/msg/PointStamped",
       "{header: {frame_id: map}, point: {x: 1.5}}"},
      folder_);
  const auto finished = listener.finish();
  EXPECT_EQ(finished.code(), 0);
  EXPECT_EQ(finished.out,
            "header:\n  stamp:\n    sec: 0\n    nanosec: 0\n  frame_id: map\n"
            "point:\n  x: 1.5\n  y: 0.0\n  z: 0.0\n---\n");
  publisher.signal(SIGINT);
  EXPECT_EQ(publisher.finish().code(), 128 + SIGINT);
  EXPECT_THAT(out({"topic", "pub", "--once", "-w", "0", "/published",
                   "geometry_msgs/msg/PointStamped", "{header: {frame_id: map}, point: {x: 1.5}}"}),
              HasSubstr("publishing #1: {header: {stamp: {sec: 0, nanosec: 0}, frame_id: map}, "
                        "point: {x: 1.5, y: 0.0, z: 0.0}}\n"));
  EXPECT_THAT(error({"topic", "pub", "/published", "std_msgs/String", "{date: x}"}),
              HasSubstr("'date' is not a field of std_msgs/msg/String"));
}

TEST_F(CommandLine, KnowsInterfaces) {
  const auto said = [](const std::vector<std::string>& arguments) {
    const auto finished = run_program(arguments, folder_);
    EXPECT_EQ(finished.code(), 0) << finished.err;
    return finished.out;
  };
  EXPECT_THAT(said({"interface", "list", "-s"}),
              AllOf(StartsWith("Services:\n    "), HasSubstr("\n    std_srvs/srv/Trigger\n"),
                    Not(HasSubstr("Messages:"))));
  EXPECT_THAT(said({"interface", "packages", "-a"}), HasSubstr("nav2_msgs\n"));
  EXPECT_EQ(said({"interface", "package", "rosgraph_msgs"}), "rosgraph_msgs/msg/Clock\n");
  EXPECT_EQ(said({"interface", "show", "std_srvs/srv/SetBool", "--no-comments"}),
            "bool data\n---\nbool success\nstring message\n");
  EXPECT_EQ(said({"interface", "proto", "std_msgs/msg/Header"}),
            "\"stamp:\n  sec: 0\n  nanosec: 0\nframe_id: ''\n\"\n");
  EXPECT_THAT(said({"interface", "export", "rosgraph_msgs", "--ros2", "ws"}),
              HasSubstr("rosgraph_msgs: 1 interfaces; uses builtin_interfaces\n"));
  EXPECT_TRUE(fs::exists(folder_ / "ws/rosgraph_msgs/msg/Clock.msg"));
  const auto unknown = run_program({"interface", "show", "std_msgs/msg/None"}, folder_);
  EXPECT_EQ(unknown.code(), 1);
  EXPECT_THAT(unknown.err, HasSubstr("Could not find the interface 'std_msgs/msg/None'"));
}

TEST_F(CommandLine, SaysWhyNothingIsPrinted) {
  EXPECT_THAT(error({"topic", "echo", "/chatter", "--field", "dat"}),
              HasSubstr("Invalid field 'dat': 'dat' is not a field of std_msgs/msg/String"));
  EXPECT_THAT(error({"topic", "echo", "/chatter", "no_msgs/msg/None"}),
              HasSubstr("The message type 'no_msgs/msg/None' is not one of this installation"));
  const auto finished = run_program({"topic", "echo", "/nope", "--spin-time", "0.1"}, folder_);
  EXPECT_EQ(finished.code(), 1);
  EXPECT_THAT(finished.err, HasSubstr("Could not determine the type for the passed topic"));
}

TEST_F(CommandLine, EchoAndHzEndOnSigint) {
  {
    Program program({"topic", "echo", "/chatter", "--spin-time", "30"}, folder_);
    ASSERT_TRUE(program.wait_for_out("---"));
    program.signal(SIGINT);
    EXPECT_EQ(program.finish().code(), 0);
  }
  Program program({"topic", "hz", "/chatter", "--spin-time", "30"}, folder_);
  ASSERT_TRUE(program.wait_for_out("window: "));
  EXPECT_THAT(program.out(),
              MatchesRegex("average rate: [0-9.]+\n\tmin: [0-9.]+s max: [0-9.]+s std dev: "
                           "[0-9.]+s window: [0-9]+\n(.|\n)*"));
  program.signal(SIGINT);
  EXPECT_EQ(program.finish().code(), 0);
}

/// Whether the process blocks or handles the signal, so that it does not just end.
bool takes_signal(pid_t pid, int number) {
  std::ifstream status("/proc/" + std::to_string(pid) + "/status");
  for (std::string line; std::getline(status, line);) {
    if ((line.starts_with("SigBlk:") || line.starts_with("SigCgt:")) &&
        ((std::stoull(line.substr(7), nullptr, 16) >> static_cast<unsigned>(number - 1)) & 1U) !=
            0) {
      return true;
    }
  }
  return false;
}

TEST_F(CommandLine, SignalsEndTheSearch) {
  for (const std::vector<std::string>& command :
       {std::vector<std::string>{"topic", "echo", "/none"},
        {"topic", "hz", "/none"},
        {"topic", "info", "/none"},
        {"node", "info", "/none"},
        {"param", "list", "/none"},
        {"lifecycle", "get", "/none"},
        {"component", "list", "/none"}}) {
    for (const int number : {SIGINT, SIGTERM}) {
      auto arguments = command;
      arguments.insert(arguments.end(), {"--spin-time", "3600"});
      Program program(arguments, folder_);
      // It has joined the network; what it inherits may be a socket before it takes signals.
      ASSERT_TRUE(eventually([&] {
        return takes_signal(program.pid(), number) && !sockets_of(program.pid()).empty();
      }));
      program.signal(number);
      const auto finished = program.finish();
      EXPECT_EQ(finished.code(), 128 + number) << command[0] << ' ' << command[1];
      EXPECT_THAT(finished.err, IsEmpty());
    }
  }
}

TEST_F(CommandLine, ReadsParameters) {
  EXPECT_EQ(out({"param", "list", "/talker"}),
            "  count\n  inputs.maximum_ages\n  inputs.minimum_rates\n  inputs.topics\n"
            "  period\n  text\n  use_sim_time\n");
  expect_listed({"param", "list"},
                AllOf(HasSubstr("/talker:\n  count\n"), HasSubstr("/far/talker:\n  count\n")));
  EXPECT_THAT(out({"param", "list", "/talker", "--param-type"}),
              HasSubstr("  period (type: double)\n"));
  EXPECT_EQ(out({"param", "get", "/talker", "period"}), "Double value is: 0.02\n");
  EXPECT_EQ(out({"param", "get", "talker", "text", "--hide-type"}), "it's: x\n");
  EXPECT_EQ(error({"param", "get", "/talker", "perod"}),
            "Parameter 'perod' is not declared by /talker; did you mean 'period'?\n");
  EXPECT_EQ(out({"param", "describe", "/talker", "period"}),
            "Parameter name: period\n  Type: double\n"
            "  Description: time between two messages, s\n"
            "  Constraints:\n    Min value: 0.001\n    Max value: 10.0\n");
  EXPECT_EQ(out({"param", "dump", "/talker"}),
            "/talker:\n  ros__parameters:\n    count: 0\n"
            "    inputs:\n      maximum_ages: []\n      minimum_rates: []\n      topics: []\n"
            "    period: 0.02\n    text: \"it's: x\"\n    use_sim_time: false\n");
}

TEST_F(CommandLine, SetsParameters) {
  EXPECT_EQ(out({"param", "set", "/far/talker", "text", "changed"}), "Set parameter successful\n");
  EXPECT_EQ(out({"param", "get", "/far/talker", "text"}), "String value is: changed\n");
  EXPECT_THAT(error({"param", "set", "/far/talker", "text", "5"}),
              StartsWith("Setting parameter failed: "));
  EXPECT_THAT(error({"param", "set", "/far/talker", "period", "-1.0"}),
              AllOf(StartsWith("Setting parameter failed: "), HasSubstr("range")));
  EXPECT_THAT(error({"param", "set", "/far/talker", "perod", "1.0"}),
              StartsWith("Setting parameter failed: "));
}

TEST_F(CommandLine, StopsAndStartsComponents) {
  expect_listed({"lifecycle", "nodes"}, Eq("/listener\n/talker\n/_hidden/listener\n/far/talker\n"));
  EXPECT_EQ(out({"lifecycle", "get", "/far/talker"}), "active [3]\n");
  EXPECT_EQ(out({"lifecycle", "list", "/far/talker"}),
            "- deactivate [4]\n\tStart: active\n\tGoal: deactivating\n"
            "- shutdown [7]\n\tStart: active\n\tGoal: shuttingdown\n");
  EXPECT_EQ(out({"lifecycle", "set", "/far/talker", "deactivate"}), "Transitioning successful\n");
  EXPECT_EQ(out({"lifecycle", "get", "/far/talker"}), "inactive [2]\n");
  EXPECT_THAT(error({"lifecycle", "set", "/far/talker", "deactivate"}),
              StartsWith("Unknown transition requested, available ones are:\n- "));
  EXPECT_EQ(out({"lifecycle", "set", "/far/talker", "3"}), "Transitioning successful\n");
  expect_listed({"lifecycle", "get"}, AllOf(HasSubstr("/listener: active [3]\n"),
                                            HasSubstr("/far/talker: active [3]\n")));
  const auto finished =
      run_program({"lifecycle", "get", "/pipescout_container", "--spin-time", "4"}, folder_);
  EXPECT_EQ(finished.code(), 1);
  EXPECT_THAT(finished.err, HasSubstr("has no managed lifecycle"));
}

TEST_F(CommandLine, LoadsAndUnloadsComponents) {
  EXPECT_THAT(out({"component", "types"}),
              HasSubstr("pipescout_failing_components\n  pipescout_test::FailingComponent\n"));
  EXPECT_EQ(out({"component", "list", "/pipescout_container"}),
            "1  /listener\n2  /talker\n3  /_hidden/listener\n");
  EXPECT_EQ(out({"component", "load", "/pipescout_container", "pipescout_failing_components",
                 "pipescout_test::Talker", "-n", "extra", "--node-namespace", "/other", "-p",
                 "text:=hi"}),
            "Loaded component 4 into '/pipescout_container' container node as '/other/extra'\n");
  EXPECT_EQ(out({"param", "get", "/other/extra", "text"}), "String value is: hi\n");
  EXPECT_EQ(out({"lifecycle", "get", "/other/extra"}), "active [3]\n");
  EXPECT_THAT(error({"component", "load", "/pipescout_container", "pipescout_failing_components",
                     "pipescout_test::Talker", "-n", "extra", "--node-namespace", "/other"}),
              StartsWith("Failed to load component: "));
  EXPECT_THAT(error({"component", "load", "/pipescout_container", "pipescout_failing_components",
                     "pipescout_test::Taker"}),
              HasSubstr("did you mean 'pipescout_test::Talker'?"));
  EXPECT_EQ(out({"component", "unload", "/pipescout_container", "4"}),
            "Unloaded component 4 from '/pipescout_container' container node\n");
  EXPECT_THAT(error({"component", "unload", "/pipescout_container", "4"}),
              StartsWith("Failed to unload component 4 from '/pipescout_container'"));
  expect_listed({"component", "list"}, HasSubstr("/pipescout_container\n  1  /listener\n"));
}

TEST_F(CommandLine, ListsServices) {
  expect_listed({"service", "list", "-t"},
                AllOf(HasSubstr("/talker/get_state [lifecycle_msgs/srv/GetState]\n"),
                      HasSubstr("/far/talker/get_state [lifecycle_msgs/srv/GetState]\n")));
}

TEST_F(CommandLine, CountsRestartsOnDiagnostics) {
  Program echo({"topic", "echo", "/diagnostics", "--spin-time", "30"}, folder_);
  ASSERT_TRUE(echo.wait_for_out("name: 'pipescout_container: process of /far/talker'"));
  const auto children = children_of(program_->pid());
  ASSERT_EQ(children.size(), 1U);
  kill(children.front(), SIGKILL);
  EXPECT_TRUE(echo.wait_for_out("- key: restarts\n    value: '1'\n"));
  EXPECT_TRUE(echo.wait_for_out("value: was killed by signal 9 (Killed)\n"));
}

TEST_F(CommandLine, UnknownNodesAndCommandsAreErrors) {
  for (const char* group : {"param", "lifecycle", "node"}) {
    const auto verb = std::string(group) == "node" ? "info" : "list";
    const auto finished = run_program({group, verb, "/none", "--spin-time", "0.1"}, folder_);
    EXPECT_EQ(finished.code(), 1);
    EXPECT_EQ(finished.err, "Node not found: /none\n");
  }
  auto finished = run_program({"topic", "lst"}, folder_);
  EXPECT_EQ(finished.code(), 2);
  EXPECT_THAT(finished.err, StartsWith("unknown command 'lst'; did you mean 'list'?"));
  finished = run_program({}, folder_);
  EXPECT_EQ(finished.code(), 2);
  finished = run_program({"topic", "hz", "/chatter", "-w", "0"}, folder_);
  EXPECT_EQ(finished.code(), 2);
  EXPECT_THAT(finished.err, HasSubstr("Value 0 not in range 1 to 1000000000"));
  finished = run_program({"node", "list", "--spin-time", "-1"}, folder_);
  EXPECT_EQ(finished.code(), 2);
  EXPECT_THAT(finished.err, HasSubstr("--spin-time: Value -1 not in range"));
}

TEST_F(CommandLine, HelpIsEverywhere) {
  for (const std::vector<std::string>& command : {std::vector<std::string>{},
                                                  {"run"},
                                                  {"topic"},
                                                  {"topic", "echo"},
                                                  {"component", "load"},
                                                  {"param", "set"}}) {
    auto arguments = command;
    arguments.emplace_back("--help");
    const auto finished = run_program(arguments, folder_);
    EXPECT_EQ(finished.code(), 0);
    EXPECT_THAT(finished.out, HasSubstr("Usage: "));
    EXPECT_THAT(finished.out, Not(HasSubstr("--control-fd")));
    EXPECT_THAT(finished.err, IsEmpty());
  }
}

}  // namespace
}  // namespace pipescout::host
