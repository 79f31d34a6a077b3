// SPDX-License-Identifier: Apache-2.0
// The commands with which an operator steers and examines what runs.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <fstream>

#include "pipescout/files/testing/temporary_folder.hpp"
#include "program.hpp"

namespace pipescout::host {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;
namespace fs = std::filesystem;

/// One composition runs for all tests of this file: a talker and a listener.
class OperatorCommands : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    temporary_ = new ::pipescout::testing::TemporaryFolder();
    folder_ = temporary_->path();
    std::ofstream(folder_ / "c.yaml") << R"(components:
  - {type: pipescout_test::Listener, name: listener}
  - {type: pipescout_test::Talker, name: talker}
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
    arguments.insert(arguments.end(), {"--spin-time", "30", "--timeout", "30"});
    return run_program(arguments, folder_);
  }
  static Finished run_without_services(std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), {"--spin-time", "30"});
    return run_program(arguments, folder_);
  }
  static std::string out(const Finished& finished) {
    EXPECT_EQ(finished.code(), 0) << finished.err;
    return finished.out;
  }
  static std::string error(const Finished& finished) {
    EXPECT_EQ(finished.code(), 1) << finished.out;
    return finished.err;
  }

  static inline ::pipescout::testing::TemporaryFolder* temporary_ = nullptr;
  static inline fs::path folder_;
  static inline Program* program_ = nullptr;
};

TEST_F(OperatorCommands, FindTopicsAndServicesByType) {
  EXPECT_EQ(out(run_without_services({"topic", "type", "/chatter"})), "std_msgs/msg/String\n");
  EXPECT_EQ(out(run_without_services({"service", "type", "/talker/get_state"})),
            "lifecycle_msgs/srv/GetState\n");
  EXPECT_TRUE(eventually([] {
    return run_without_services({"topic", "find", "std_msgs/msg/String"}).out == "/chatter\n";
  }));
  EXPECT_TRUE(eventually([] {
    return run_without_services({"service", "find", "lifecycle_msgs/srv/GetState", "-c"}).out ==
           "2\n";
  }));
}

TEST_F(OperatorCommands, ShowAService) {
  EXPECT_EQ(out(run_without_services({"service", "info", "/talker/get_state"})),
            "Type: lifecycle_msgs/srv/GetState\nClients count: 0\nServices count: 1\n");
}

TEST_F(OperatorCommands, CallAService) {
  EXPECT_EQ(
      out(run({"service", "call", "/talker/get_state", "lifecycle_msgs/srv/GetState"})),
      "requester: making request: {}\n\nresponse:\ncurrent_state:\n  id: 3\n  label: active\n\n");
  EXPECT_THAT(out(run({"service", "call", "/listener/get_parameters",
                       "rcl_interfaces/srv/GetParameters", "{names: [use_sim_time]}"})),
              AllOf(StartsWith("requester: making request: {names: [use_sim_time]}\n"),
                    HasSubstr("bool_value: false")));
  EXPECT_THAT(error(run({"service", "call", "/talker/get_state", "lifecycle_msgs/srv/GetState",
                         "{nothing: 1}"})),
              HasSubstr("nothing"));
  EXPECT_THAT(error(run({"service", "call", "/talker/get_state", "std_msgs/msg/String"})),
              HasSubstr("is no service type"));
}

TEST_F(OperatorCommands, MeasureATopic) {
  Program bandwidth({"topic", "bw", "/chatter", "--spin-time", "30"}, folder_);
  EXPECT_TRUE(bandwidth.wait_for_out(" messages\n\tMessage size mean: "));
  bandwidth.signal(SIGINT);
  EXPECT_EQ(bandwidth.finish().code(), 0);
  EXPECT_THAT(error(run_without_services({"topic", "delay", "/chatter"})),
              HasSubstr("msg does not have header"));
}

TEST_F(OperatorCommands, ChangeTheLogLevel) {
  EXPECT_EQ(out(run({"log", "level", "get", "/talker"})), "info\n");
  EXPECT_EQ(out(run({"log", "level", "set", "/talker", "debug"})),
            "Set log level of /talker to debug\n");
  EXPECT_EQ(out(run({"log", "level", "get", "/talker"})), "debug\n");
  EXPECT_EQ(out(run({"log", "level", "set", "/talker", "info"})),
            "Set log level of /talker to info\n");
}

TEST_F(OperatorCommands, LoadParametersFromAFile) {
  const auto file = folder_ / "p.yaml";
  std::ofstream(file) << "/talker:\n  ros__parameters:\n    text: from the file\n"
                         "/**:\n  ros__parameters:\n    use_sim_time: false\n";
  EXPECT_EQ(out(run({"param", "load", "/talker", file.string()})),
            "Set parameter text successful\nSet parameter use_sim_time successful\n");
  EXPECT_EQ(out(run({"param", "get", "/talker", "text"})), "String value is: from the file\n");
  std::ofstream(file) << "/talker:\n  ros__parameters:\n    txt: x\n";
  EXPECT_THAT(error(run({"param", "load", "/talker", file.string()})),
              HasSubstr("p.yaml:3: Set parameter txt failed"));
  EXPECT_THAT(error(run({"param", "load", "/listener", file.string()})),
              HasSubstr("has no parameters for /listener"));
}

TEST_F(OperatorCommands, DeleteOnlyWhatMayGo) {
  EXPECT_THAT(error(run({"param", "delete", "/talker", "text"})),
              StartsWith("Deleting parameter failed: "));
}

TEST_F(OperatorCommands, TakeWhatFollowsTwoDashesForAValue) {
  const auto refused =
      run_program({"param", "set", "/talker", "--spin-time", "30", "text", "--", "-1"}, folder_);
  EXPECT_EQ(refused.code(), 1) << refused.err;
  EXPECT_THAT(refused.err, HasSubstr("Setting parameter failed"));  // an integer is no text
}

TEST_F(OperatorCommands, CompleteWordsOfTheShell) {
  EXPECT_EQ(run_program({"__complete", "--", "topic", "e"}, folder_).out, "echo\n");
  EXPECT_EQ(run_program({"__complete", "--", "interface", "show", "std_srvs/srv/T"}, folder_).out,
            "std_srvs/srv/Trigger\n");
  EXPECT_TRUE(eventually([] {
    return run_program({"__complete", "--", "topic", "echo", "/ch"}, folder_).out == "/chatter\n";
  }));
}

TEST_F(OperatorCommands, ExamineARunningSystem) {
  const auto finished = run({"doctor"});
  EXPECT_THAT(finished.out, HasSubstr(" from 17 checks\n"));
}

TEST_F(OperatorCommands, ExamineACompositionBeforeItRuns) {
  std::ofstream(folder_ / "wrong.yaml") << R"(components:
  - {type: pipescout_test::Talker, name: speaker, parameters: {txt: x}}
  - {type: pipescout_test::FailingComponent, name: failing, parameters: {where: configure}}
)";
  const auto finished = run({"doctor", "wrong.yaml"});
  EXPECT_EQ(finished.code(), 1);
  EXPECT_THAT(finished.out, AllOf(HasSubstr("no parameter 'txt'; did you mean 'text'?"),
                                  HasSubstr("/failing cannot be started: "),
                                  HasSubstr("told to fail in configure")));
}

TEST_F(OperatorCommands, NameTheComponentsOfACompositionThatBlock) {
  std::ofstream(folder_ / "blocking.yaml") << R"(components:
  - {type: pipescout_test::FailingComponent, name: born, parameters: {where: constructor, how: hang}}
  - {type: pipescout_test::FailingComponent, name: set_up, parameters: {where: configure, how: hang}}
  - {type: pipescout_test::Talker, name: speaker, parameters: {txt: x}}
)";
  const auto finished = run({"doctor", "blocking.yaml", "--patience", "2"});
  EXPECT_EQ(finished.code(), 1) << finished.err;
  EXPECT_THAT(
      finished.out,
      AllOf(HasSubstr("/born cannot be started: its constructor has not returned after 2 s."),
            HasSubstr("/set_up cannot be started: it is not configured after 2 s."),
            HasSubstr("no parameter 'txt'; did you mean 'text'?")));
}

TEST_F(OperatorCommands, ListAContainerThatIsEmpty) {
  std::ofstream(folder_ / "empty.yaml") << "components: []\n";
  Program empty({"run", "empty.yaml", "--out", "empty", "--namespace", "/idle"}, folder_);
  EXPECT_TRUE(eventually([] {
    return run({"component", "list"}).out.find("/idle/pipescout_container\n") != std::string::npos;
  }));
  empty.signal(SIGINT);
  EXPECT_EQ(empty.finish().code(), 0);
}

}  // namespace
}  // namespace pipescout::host
