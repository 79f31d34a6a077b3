// SPDX-License-Identifier: Apache-2.0
// Commands of other packages, which are executables of their own.
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
using ::testing::Not;
using ::testing::StartsWith;
namespace fs = std::filesystem;

class ExternalCommand : public ::testing::Test {
 protected:
  void SetUp() override {
    add("count_words", "echo $# words; for word; do echo \"<$word>\"; done; exit 7");
    add("listen", "echo listening; exec tail -f /dev/null");
    fs::create_directories(fs::path(TEST_PREFIX) / "share/pipescout/commands");
    std::ofstream(fs::path(TEST_PREFIX) / "share/pipescout/commands/count_words")
        << "Count the words behind it\n";
  }
  void TearDown() override {
    for (const char* name :
         {"bin/pipescout-count_words", "bin/pipescout-listen", "bin/pipescout-topic",
          "bin/pipescout-summary", "share/pipescout/commands/count_words"}) {
      fs::remove(fs::path(TEST_PREFIX) / name);
    }
  }

  static void add(const std::string& name, const std::string& script) {
    const auto file = fs::path(TEST_PREFIX) / "bin" / ("pipescout-" + name);
    fs::create_directories(file.parent_path());
    std::ofstream(file) << "#!/bin/sh\n" << script << '\n';
    fs::permissions(file, fs::perms::owner_all);
  }
  [[nodiscard]] Finished run(const std::vector<std::string>& arguments) const {
    return run_program(arguments, folder_.path());
  }

  ::pipescout::testing::TemporaryFolder folder_;
};

TEST_F(ExternalCommand, GetsItsWordsAndGivesItsExitCode) {
  const auto finished = run({"count_words", "--help", "two words", "", "--", "-5"});
  EXPECT_EQ(finished.code(), 7);
  EXPECT_EQ(finished.out, "5 words\n<--help>\n<two words>\n<>\n<-->\n<-5>\n");
  EXPECT_EQ(finished.err, "");
}

TEST_F(ExternalCommand, IsEndedByWhatEndsPipescout) {
  Program program({"listen"}, folder_.path());
  ASSERT_TRUE(program.wait_for_out("listening\n"));
  program.signal(SIGTERM);
  EXPECT_EQ(program.finish().signal(), SIGTERM);
}

TEST_F(ExternalCommand, SummaryMakesTheTablesOfAMissionsBag) {
  std::ofstream(folder_.path() / "c.yaml") << R"(components:
  - {type: pipescout_test::Listener, name: listener, parameters: {count: 2}}
  - {type: pipescout_test::Talker, name: talker}
complete_when: [listener]
)";
  for (const int code : {0, 3}) {
    const std::string name = "m" + std::to_string(code);
    // In place of a recorder.
    const fs::path mission = folder_.path() / name;
    fs::create_directories(mission / "bag");
    add("summary", "echo tables of $1; exit " + std::to_string(code));
    const auto finished = run({"run", "c.yaml", "--out", name});
    EXPECT_EQ(finished.code(), code == 0 ? 0 : 1) << finished.err;
    EXPECT_THAT(finished.out, HasSubstr("tables of " + mission.string() + "\n"));
    EXPECT_TRUE(fs::exists(mission / "versions.yaml"));
  }
}

TEST_F(ExternalCommand, SummaryIsMadeAfterSigintAndNotAfterSigterm) {
  std::ofstream(folder_.path() / "c.yaml")
      << "components: [{type: 'pipescout_test::Talker', name: talker}]\n";
  add("summary", "echo tables of $1");
  for (const int number : {SIGINT, SIGTERM}) {
    const std::string name = "m" + std::to_string(number);
    fs::create_directories(folder_.path() / name / "bag");
    Program program({"run", "c.yaml", "--out", name}, folder_.path());
    ASSERT_TRUE(program.wait_for_err(" active\n"));
    program.signal(number);
    const auto finished = program.finish();
    EXPECT_EQ(finished.code(), 0) << finished.err;
    EXPECT_EQ(finished.out.find("tables of") != std::string::npos, number == SIGINT)
        << finished.out;
    // The host's own, of what the components wrote.
    EXPECT_EQ(fs::exists(folder_.path() / name / "summary.json"), number == SIGTERM);
  }
}

TEST_F(ExternalCommand, IsListedByHelp) {
  for (const char* help : {"--help", "help", "-h"}) {
    const auto finished = run({help});
    EXPECT_EQ(finished.code(), 0);
    EXPECT_THAT(finished.out,
                AllOf(HasSubstr("Count the words behind it"), HasSubstr("bin/pipescout-listen"),
                      HasSubstr("Run a composition until")));
  }
}

TEST_F(ExternalCommand, HelpOfACommand) {
  auto finished = run({"help", "count_words"});
  EXPECT_EQ(finished.out, "1 words\n<--help>\n");
  finished = run({"help", "topic", "echo"});
  EXPECT_EQ(finished.code(), 0);
  EXPECT_EQ(finished.out, run({"topic", "echo", "--help"}).out);
  finished = run({"help", "topc"});
  EXPECT_EQ(finished.code(), 2);
  EXPECT_THAT(finished.err, HasSubstr("did you mean 'topic'?"));
}

TEST_F(ExternalCommand, OwnCommandsGoFirst) {
  add("topic", "echo wrong");
  const auto finished = run({"topic", "--help"});
  EXPECT_EQ(finished.code(), 0);
  EXPECT_THAT(finished.out, Not(HasSubstr("wrong")));
  EXPECT_THAT(run({"--help"}).out, Not(HasSubstr("bin/pipescout-topic")));
}

TEST_F(ExternalCommand, OneThatIsNotThere) {
  auto finished = run({"count_word"});
  EXPECT_EQ(finished.code(), 2);
  EXPECT_THAT(finished.err,
              StartsWith("unknown command 'count_word'; did you mean 'count_words'?"));
  finished = run({"absent"});
  EXPECT_EQ(finished.code(), 2);
  EXPECT_THAT(finished.err, AllOf(HasSubstr("unknown command 'absent'"),
                                  HasSubstr("executable pipescout-absent")));
}

TEST_F(ExternalCommand, OneThatIsNotBuiltIsNamedWithItsPackage) {
  const auto run_alone = [this](std::vector<std::string> words) {
    words.insert(words.begin(), {"-i", PIPESCOUT_PROGRAM});
    return ::pipescout::testing::run_program("/usr/bin/env", words, folder_.path());
  };
  const auto finished = run_alone({"estimate", "bag", "--out", "x"});
  EXPECT_EQ(finished.code(), 2);
  EXPECT_EQ(
      finished.err,
      "unknown command 'estimate': it comes with the package pipescout_estimate, which is not "
      "built here. In the root of the project: colcon build --packages-up-to "
      "pipescout_estimate\n");
  EXPECT_THAT(run_alone({"estimat"}).err, HasSubstr("did you mean 'estimate'?"));
  EXPECT_THAT(run_alone({"--help"}).out,
              AllOf(HasSubstr("packages are not built: "), HasSubstr("map (pipescout_map)")));
}

TEST_F(ExternalCommand, AnswersAShellIfItsPackageSaysSo) {
  EXPECT_EQ(run({"__complete", "--", "count"}).out, "count_words\n");
  EXPECT_EQ(run({"__complete", "--", "help", "count"}).out, "count_words\n");
  EXPECT_EQ(run({"__complete", "--", "count_words", "--o"}).out, "");
  std::ofstream(fs::path(TEST_PREFIX) / "share/pipescout/commands/count_words")
      << "Count the words behind it\ncompletion\n";
  EXPECT_EQ(run({"__complete", "--", "count_words", "a b", "--o"}).out,
            "4 words\n<__complete>\n<-->\n<a b>\n<--o>\n");
  EXPECT_THAT(run({"__complete", "--", "help", "count_words", "x"}).out, StartsWith("3 words\n"));
}

TEST_F(ExternalCommand, BashOffersWhatTheProgramSays) {
  std::ofstream(fs::path(TEST_PREFIX) / "share/pipescout/commands/count_words")
      << "Count the words behind it\ncompletion\n";
  add("count_words", "echo $#/$4; echo --format=png; echo @type");
  // The words of the line as bash takes them apart.
  const auto offered = [this](const std::string& line, const std::vector<std::string>& words) {
    std::vector<std::string> arguments{
        "-c",
        "COMP_LINE=$1; shift; source '" COMPLETION "'; COMP_WORDS=('" PIPESCOUT_PROGRAM
        "' \"$@\"); COMP_CWORD=$#; _pipescout_complete; printf '%s\\n' \"${COMPREPLY[@]}\"",
        "bash", line};
    arguments.insert(arguments.end(), words.begin(), words.end());
    return ::pipescout::testing::run_program("/bin/bash", arguments, folder_.path()).out;
  };
  static_cast<void>(
      run({"--version"}));  // has set the environment in which the commands of the tests are found
  EXPECT_EQ(offered("pipescout count", {"count"}), "count_words\n");
  EXPECT_EQ(offered("pipescout count_words std_srvs/srv/T", {"count_words", "std_srvs/srv/T"}),
            "3/\n--format=png\nstd_srvs/srv/Trigger\n");
  // In the place of what stands behind the sign.
  EXPECT_EQ(
      offered("pipescout count_words a --format=p", {"count_words", "a", "--format", "=", "p"}),
      "4/--format=p\npng\n");
}

TEST_F(ExternalCommand, OneThatCannotBeStarted) {
  const auto file = fs::path(TEST_PREFIX) / "bin/pipescout-listen";
  std::ofstream(file) << "#!/no/such/interpreter\n";
  const auto finished = run({"listen"});
  EXPECT_EQ(finished.code(), 1);
  EXPECT_THAT(finished.err, HasSubstr("cannot run " + file.string() + ": No such file"));
}

}  // namespace
}  // namespace pipescout::host
