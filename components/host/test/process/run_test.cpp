// SPDX-License-Identifier: Apache-2.0
// `pipescout run` as a user starts it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "pipescout/files/testing/temporary_folder.hpp"
#include "program.hpp"
#include "run/run.hpp"

namespace pipescout::host {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::StartsWith;
namespace fs = std::filesystem;

/// What a run logs when all its components are active.
constexpr const char* kStarted = " active\n";

class Run : public ::testing::Test {
 protected:
  void write(const std::string& text, const std::string& file = "c.yaml") const {
    std::ofstream(folder_ / file) << text;
  }
  [[nodiscard]] std::string read(const std::string& file) const {
    std::ifstream stream(folder_ / file);
    return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
  }
  /// Runs c.yaml to the end.
  [[nodiscard]] Finished run(std::vector<std::string> more = {}) const {
    std::vector<std::string> arguments{"run", "c.yaml", "--out", "m"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_program(arguments, folder_);
  }
  /// A composition of one failing component beside a talker.
  [[nodiscard]] static std::string failing(const std::string& where, const std::string& how,
                                           const std::string& more = "") {
    return "components:\n"
           "  - {type: 'pipescout_test::Talker', name: talker}\n"
           "  - {type: 'pipescout_test::FailingComponent', name: bad, parameters: {where: " +
           where + ", how: " + how + "}" + more + "}\n";
  }

  ::pipescout::testing::TemporaryFolder temporary_;
  const fs::path folder_ = temporary_.path();
};

TEST_F(Run, EndsWhenTheMissionIsComplete) {
  write(R"(name: chat
arguments: {count: 5}
components:
  - {type: pipescout_test::Listener, name: listener, parameters: {count: $(arg count)}}
  - {type: pipescout_test::Talker, name: talker, parameters: {text: "a: b"}}
complete_when: [listener]
)");
  const auto finished = run({"count:=7"});
  EXPECT_EQ(finished.code(), 0) << finished.err;
  EXPECT_THAT(finished.out, HasSubstr("finished  "));
  EXPECT_THAT(finished.out, HasSubstr("listener 7/7"));
  EXPECT_THAT(read("m/mission.yaml"), AllOf(HasSubstr("count: 7\n"), HasSubstr("text: \"a: b\"\n"),
                                            HasSubstr("period: 0.02\n")));
  EXPECT_EQ(nlohmann::json::parse(read("m/summary.json"))["mission"], "chat");
  EXPECT_TRUE(fs::exists(folder_ / "m/mission.log"));
}

TEST_F(Run, StopsOnSigintAndSigterm) {
  write("components: [{type: 'pipescout_test::Talker', name: talker}]\n");
  for (const int number : {SIGINT, SIGTERM}) {
    fs::remove_all(folder_ / "m");
    Program program({"run", "c.yaml", "--out", "m"}, folder_);
    ASSERT_TRUE(program.wait_for_err(kStarted));
    program.signal(number);
    const auto finished = program.finish();
    // By itself, and not by force for the lack of time.
    EXPECT_EQ(finished.code(), 0) << finished.err;
    EXPECT_THAT(finished.err, HasSubstr("stopping"));
    EXPECT_THAT(finished.err, Not(HasSubstr("process terminated")));
    EXPECT_TRUE(fs::exists(folder_ / "m/summary.json"));
  }
}

TEST_F(Run, AStopBeforeCompletionIsNoSuccess) {
  write("components: [{type: 'pipescout_test::Talker', name: talker}]\ncomplete_when: [talker]\n");
  Program program({"run", "c.yaml", "--out", "m"}, folder_);
  ASSERT_TRUE(program.wait_for_out("talker"));
  program.signal(SIGINT);
  EXPECT_EQ(program.finish().code(), 128 + SIGINT);
}

TEST_F(Run, LeavesNothingInSharedMemoryBehind) {
  write("components: [{type: 'pipescout_test::Talker', name: talker, isolate: true}]\n");
  Program program({"run", "c.yaml", "--out", "m"}, folder_);
  ASSERT_TRUE(program.wait_for_err(kStarted));
  auto segments = shared_memory_of(program.pid());
  for (const auto child : children_of(program.pid())) {
    segments.merge(shared_memory_of(child));
  }
  EXPECT_FALSE(segments.empty());
  program.signal(SIGINT);
  EXPECT_EQ(program.finish().code(), 0);
  for (const auto& file : segments) {
    // Ports are shared with other processes, which may still use them.
    if (file.find("port") == std::string::npos) {
      EXPECT_FALSE(fs::exists(file)) << file;
    }
  }
}

TEST_F(Run, ErrorsInTheCompositionNameTheirPlaceAndStartNothing) {
  const std::pair<std::string, std::string> cases[] = {
      {"components: [\n", "error: c.yaml:"},
      {"components:\n  - {type: 'pipescout_test::Taker', name: t}\n", "error: c.yaml:2:12: "},
      {"components:\n  - {type: 'pipescout_test::Talker', name: t}\n"
       "  - {type: 'pipescout_test::Talker', name: t}\n",
       "error: c.yaml:3:44: two components have the name '/t'"},
      {"components:\n  - {type: 'pipescout_test::Talker', name: t, parameters: {period: 1}}\n",
       "error: c.yaml:2:68: parameter 'period'"},
      {"components:\n  - {type: 'pipescout_test::Talker', name: t, parameters: {period: 11.0}}\n",
       "error: c.yaml:2:68: parameter 'period'"},
      {"components:\n  - {type: 'pipescout_test::Talker', name: t, parameters: {perod: 1.0}}\n",
       "error: c.yaml:2:67: no parameter 'perod'; did you mean 'period'?"},
      {"components:\n  - {type: 'pipescout_test::Talker', name: t, isolate: true, parameters: "
       "{perod: 1.0}}\n",
       "error: component /t: c.yaml:2:82: no parameter 'perod'"},
  };
  for (const auto& [text, message] : cases) {
    write(text);
    const auto finished = run();
    EXPECT_EQ(finished.code(), 1) << text;
    EXPECT_THAT(finished.err, HasSubstr(message)) << text;
    EXPECT_FALSE(fs::exists(folder_ / "m")) << text;
  }
}

TEST_F(Run, SaysWhatIsWrongWithTheCommandLine) {
  write("components: [{type: 'pipescout_test::Talker', name: talker}]\n");
  auto finished = run({"cont:=3"});
  EXPECT_EQ(finished.code(), 1);
  EXPECT_THAT(finished.err, HasSubstr("c.yaml has no argument 'cont'"));
  finished = run({"--param", "perod:=1.0"});
  EXPECT_EQ(finished.code(), 1);
  EXPECT_THAT(finished.err, HasSubstr("--param perod:=1.0: no component has a parameter 'perod'; "
                                      "did you mean 'period'?"));
  finished = run({"--param", "talker.period:=20.0"});
  EXPECT_EQ(finished.code(), 1);
  EXPECT_THAT(finished.err, HasSubstr("--param talker.period:=20.0"));
  finished = run({"--frob"});
  EXPECT_EQ(finished.code(), 2);
  finished = run_program({"run", "none.yaml"}, folder_);
  EXPECT_EQ(finished.code(), 1);
  EXPECT_THAT(finished.err, HasSubstr("none.yaml"));
  EXPECT_FALSE(fs::exists(folder_ / "m"));
}

TEST_F(Run, DoesNotMixTwoMissions) {
  write(
      "components: [{type: 'pipescout_test::Talker', name: talker, parameters: {count: 1}}]\n"
      "complete_when: [talker]\n");
  EXPECT_EQ(run().code(), 0);
  const auto finished = run();
  EXPECT_EQ(finished.code(), 1);
  EXPECT_THAT(finished.err, HasSubstr("contains a mission already"));
}

TEST_F(Run, ARefusedStartShutsDownWhatRuns) {
  for (const char* where : {"constructor", "configure", "activate"}) {
    for (const char* how : {"throw", "return"}) {
      if (std::string(where) == "constructor" && std::string(how) == "return") {
        continue;
      }
      for (const char* isolate : {"", ", isolate: true"}) {
        fs::remove_all(folder_ / "m");
        write(failing(where, how, isolate));
        const auto finished = run();
        const auto label = std::string(where) + " " + how + isolate;
        EXPECT_EQ(finished.code(), 1) << label;
        EXPECT_THAT(finished.err, AllOf(HasSubstr("error: "), HasSubstr("bad"))) << label;
        if (std::string(how) == "throw") {
          EXPECT_THAT(finished.err, HasSubstr("told to fail in")) << label;
        }
        EXPECT_THAT(finished.err, Not(HasSubstr("process terminated"))) << label;
        EXPECT_THAT(finished.err, Not(HasSubstr("terminate called"))) << label;
      }
    }
  }
}

TEST_F(Run, AComponentThatThrowsInACallbackHarmsNoOther) {
  for (const char* where : {"message", "timer"}) {
    fs::remove_all(folder_ / "m");
    write(failing(where, "throw") +
          "  - {type: 'pipescout_test::Listener', name: listener, parameters: {count: 20}}\n"
          "complete_when: [listener]\n");
    const auto finished = run();
    EXPECT_EQ(finished.code(), 0) << finished.err;
    EXPECT_THAT(finished.err, HasSubstr(std::string("told to fail in ") + where));
    EXPECT_THAT(read("m/mission.log"), HasSubstr(std::string("told to fail in ") + where));
  }
}

TEST_F(Run, AnAwaitedComponentThatBreaksEndsTheRun) {
  write(failing("message", "throw") + "complete_when: [bad]\n");
  auto finished = run();
  EXPECT_EQ(finished.code(), 1);
  EXPECT_THAT(finished.err, HasSubstr("component /bad went through its error state"));

  fs::remove_all(folder_ / "m");
  write(failing("timer", "report") + "complete_when: [bad]\n");
  finished = run();
  EXPECT_EQ(finished.code(), 1);
  EXPECT_THAT(finished.err, HasSubstr("component /bad failed: told to fail in timer"));
}

TEST_F(Run, FailuresOnTheWayDownAreSurvived) {
  for (const char* where : {"deactivate", "cleanup", "shutdown"}) {
    fs::remove_all(folder_ / "m");
    write(failing(where, "throw"));
    Program program({"run", "c.yaml", "--out", "m"}, folder_);
    ASSERT_TRUE(program.wait_for_err(kStarted));
    program.signal(SIGINT);
    const auto finished = program.finish();
    EXPECT_EQ(finished.code(), 0) << where << finished.err;
  }
}

TEST_F(Run, AComponentThatHangsCannotHoldTheProgram) {
  write(failing("deactivate", "hang"));
  Program program({"run", "c.yaml", "--out", "m"}, folder_);
  ASSERT_TRUE(program.wait_for_err(kStarted));
  program.signal(SIGINT);
  const auto finished = program.finish();
  EXPECT_EQ(finished.code(), 1);
  EXPECT_THAT(finished.err, HasSubstr("component /bad did not stop in time"));
  EXPECT_TRUE(fs::exists(folder_ / "m/summary.json"));
}

TEST_F(Run, ASecondSigintEndsAtOnce) {
  write(failing("activate", "hang"));
  Program program({"run", "c.yaml", "--out", "m"}, folder_);
  ASSERT_TRUE(program.wait_for_err("hangs in activate"));
  program.signal(SIGINT);
  ASSERT_TRUE(program.wait_for_err("stopping"));
  // No event: later than what counts as the same request, earlier than the time of grace.
  usleep(300000);
  program.signal(SIGINT);
  const auto finished = program.finish();
  EXPECT_THAT(finished.err, HasSubstr("second signal"));
  EXPECT_EQ(finished.code(), 128 + SIGINT);
}

/// Whatever asks a run to stop, and whatever hangs: it ends within two seconds. That is a promise;
/// the margin is for a busy machine.
TEST_F(Run, EndsWithinTwoSeconds) {
  constexpr auto kPromise = std::chrono::seconds(2);
  constexpr auto kMargin = std::chrono::milliseconds(1500);
  struct Case {
    int signal;
    const char* where;
    const char* isolate;
    const char* ready;
  };
  constexpr const char* kIsolate = ", isolate: true";
  for (const auto& [number, where, isolate, ready] :
       {Case{SIGINT, "deactivate", "", kStarted}, Case{SIGTERM, "deactivate", "", kStarted},
        Case{SIGHUP, "deactivate", "", kStarted}, Case{SIGINT, "deactivate", kIsolate, kStarted},
        Case{SIGINT, "activate", "", "hangs in activate"}}) {
    fs::remove_all(folder_ / "m");
    write(failing(where, "hang", isolate));
    Program program({"run", "c.yaml", "--out", "m"}, folder_);
    ASSERT_TRUE(program.wait_for_err(ready));
    const auto start = std::chrono::steady_clock::now();
    program.signal(number);
    const auto finished = program.finish();
    EXPECT_LT(std::chrono::steady_clock::now() - start, kPromise + kMargin);
    EXPECT_EQ(finished.code(), 1) << finished.err;
    EXPECT_THAT(finished.err, HasSubstr("component /bad did not stop in time"));
  }
}

TEST_F(Run, AComponentThatHangsDoesNotKeepOthersFromStopping) {
  const std::string talker = "  - {type: 'pipescout_test::Talker', name: talker";
  const std::string bad =
      "  - {type: 'pipescout_test::FailingComponent', name: bad, "
      "parameters: {where: deactivate, how: hang}";
  const std::string isolated = ", isolate: true}\n";
  // Stopped in the reverse order: the one that hangs first.
  for (const auto& components : {talker + isolated + bad + "}\n", talker + "}\n" + bad + isolated,
                                 talker + isolated + bad + isolated}) {
    fs::remove_all(folder_ / "m");
    write("components:\n" + components);
    Program program({"run", "c.yaml", "--out", "m"}, folder_);
    ASSERT_TRUE(program.wait_for_err(kStarted)) << program.err();
    program.signal(SIGINT);
    const auto finished = program.finish();
    EXPECT_EQ(finished.code(), 1);
    EXPECT_THAT(finished.err, AllOf(HasSubstr("[talker]: was deactivated"),
                                    HasSubstr("component /bad did not stop in time"),
                                    Not(HasSubstr("component /talker did not stop"))))
        << components;
  }
}

TEST_F(Run, ASummaryThatIsNotWholeIsAnError) {
  write("components: [{type: 'pipescout_test::Talker', name: talker}]\n");
  Program program({"run", "c.yaml", "--out", "m"}, folder_);
  ASSERT_TRUE(program.wait_for_err(kStarted));
  write("{}", "m/sections/talker.json");
  program.signal(SIGINT);
  const auto finished = program.finish();
  EXPECT_EQ(finished.code(), 1);
  EXPECT_THAT(finished.err, AllOf(HasSubstr("error: "), HasSubstr("talker.json: has no text")));
}

TEST_F(Run, RefusesNamesThatAnotherProcessUses) {
  write("components:\n  - {type: 'pipescout_test::Talker', name: talker}\n");
  Program first({"run", "c.yaml", "--out", "first"}, folder_);
  ASSERT_TRUE(first.wait_for_err(kStarted));
  const Finished second = run();
  EXPECT_EQ(second.code(), kExitNameTaken);
  EXPECT_THAT(second.err,
              AllOf(HasSubstr("error: c.yaml:2:5: another process in this DDS domain has a node "
                              "/talker already"),
                    HasSubstr("--namespace")));
  EXPECT_FALSE(fs::exists(folder_ / "m"));

  Program other({"run", "c.yaml", "--namespace", "/other", "--out", "m"}, folder_);
  EXPECT_TRUE(other.wait_for_err(kStarted));
}

TEST_F(Run, WaitsForAMissionThatIsJustEnding) {
  // The talker has to wait until the other one has used up its time.
  write(failing("deactivate", "hang", ", isolate: true"));
  Program first({"run", "c.yaml", "--out", "first"}, folder_);
  ASSERT_TRUE(first.wait_for_err(kStarted));
  write("components: [{type: 'pipescout_test::Talker', name: talker}]\n", "talker.yaml");
  first.signal(SIGINT);
  ASSERT_TRUE(first.wait_for_err("stopping"));
  Program second({"run", "talker.yaml", "--out", "second"}, folder_);
  EXPECT_TRUE(second.wait_for_err(kStarted)) << second.err();
}

TEST_F(Run, FoldersOfRunsOfTheSameSecondDiffer) {
  write("components: []\n");
  std::vector<std::unique_ptr<Program>> programs;
  for (int i = 0; i < 4; ++i) {
    programs.push_back(
        std::make_unique<Program>(std::vector<std::string>{"run", "c.yaml"}, folder_));
  }
  for (auto& program : programs) {
    ASSERT_TRUE(program->wait_for_err(kStarted)) << program->err();
  }
  const fs::directory_iterator folders(folder_ / "missions");
  EXPECT_EQ(std::distance(fs::begin(folders), fs::end(folders)), 4);
}

TEST_F(Run, ARefusedStartLeavesNoFolder) {
  for (const char* where : {"constructor", "configure", "activate"}) {
    for (const char* isolate : {"", ", isolate: true"}) {
      const auto label = std::string(where) + isolate;
      write(failing(where, "throw", isolate));
      EXPECT_EQ(run_program({"run", "c.yaml"}, folder_).code(), 1) << label;
      EXPECT_FALSE(fs::exists(folder_ / "missions")) << label;
      const auto refused = run_program({"run", "c.yaml", "--out", "new/m"}, folder_);
      EXPECT_EQ(refused.code(), 1) << label;
      EXPECT_FALSE(fs::exists(folder_ / "new")) << label << refused.err;
    }
  }
  EXPECT_THAT(run_program({"run", "c.yaml", "--out", "m"}, folder_).err,
              HasSubstr("nothing was recorded: removed the mission folder " +
                        (folder_ / "m").string() + "\n"));
}

TEST_F(Run, ARefusedStartLeavesAFolderAsItWas) {
  write(failing("activate", "throw"));
  fs::create_directories(folder_ / "m/own");
  write("of the user", "m/own/notes");
  EXPECT_EQ(run().code(), 1);
  EXPECT_TRUE(fs::exists(folder_ / "m/own/notes"));
  const fs::directory_iterator entries(folder_ / "m");
  EXPECT_EQ(std::distance(fs::begin(entries), fs::end(entries)), 1);
}

TEST_F(Run, AMissionThatFailsOnItsWayIsKept) {
  write(failing("timer", "throw") + "complete_when: [bad]\n");
  EXPECT_EQ(run().code(), 1);
  EXPECT_TRUE(fs::exists(folder_ / "m/mission.log"));
}

TEST_F(Run, AnIsolatedComponentHasAProcessOfItsOwnAndTalksOverTheNetwork) {
  write(R"(components:
  - {type: pipescout_test::Listener, name: listener, parameters: {count: 5}}
  - {type: pipescout_test::Talker, name: talker, isolate: true}
complete_when: [listener]
)");
  const auto finished = run();
  EXPECT_EQ(finished.code(), 0) << finished.err;
  EXPECT_THAT(finished.err, HasSubstr("/talker runs in process"));
  EXPECT_THAT(read("m/mission.yaml"), HasSubstr("period: 0.02"));
}

/// What it says before the network knows it.
TEST_F(Run, TheLastWordOfAnIsolatedComponentIsNotLost) {
  write(failing("constructor", "complete", ", isolate: true") + "complete_when: [bad]\n");
  auto finished = run();
  EXPECT_EQ(finished.code(), 0) << finished.err;

  fs::remove_all(folder_ / "m");
  write(failing("constructor", "report", ", isolate: true") + "complete_when: [bad]\n");
  finished = run();
  EXPECT_EQ(finished.code(), 1);
  EXPECT_THAT(finished.err, HasSubstr("component /bad failed: told to fail in constructor"));

  fs::remove_all(folder_ / "m");
  write(failing("timer", "throw", ", isolate: true") + "complete_when: [bad]\n");
  finished = run();
  EXPECT_EQ(finished.code(), 1);
  EXPECT_THAT(finished.err, HasSubstr("component /bad went through its error state"));
}

TEST_F(Run, AnIsolatedComponentHasNoSocketOfItsParent) {
  write("components: [{type: 'pipescout_test::Talker', name: talker, isolate: true}]\n");
  Program program({"run", "c.yaml", "--out", "m"}, folder_);
  ASSERT_TRUE(program.wait_for_err(kStarted));
  const auto children = children_of(program.pid());
  ASSERT_EQ(children.size(), 1U);
  const auto parents = sockets_of(program.pid());
  EXPECT_FALSE(parents.empty());
  for (const auto& socket : sockets_of(children.front())) {
    EXPECT_FALSE(parents.contains(socket)) << socket;
  }
}

TEST_F(Run, AKilledIsolatedComponentIsRestarted) {
  write(R"(components:
  - {type: pipescout_test::Listener, name: listener}
  - {type: pipescout_test::Talker, name: talker, isolate: true, restart: {limit: 2, backoff: 0.01}}
)");
  Program program({"run", "c.yaml", "--out", "m"}, folder_);
  ASSERT_TRUE(program.wait_for_err(kStarted));
  std::vector<pid_t> children;
  for (int restart = 1; restart <= 2; ++restart) {
    const auto old = children;
    ASSERT_TRUE(eventually([&] {
      children = children_of(program.pid());
      return children.size() == 1 && children != old;
    }));
    kill(children.front(), SIGKILL);
    ASSERT_TRUE(program.wait_for_err("restart " + std::to_string(restart) + " of 2"));
  }
  ASSERT_TRUE(eventually([&] {
    const auto old = children;
    children = children_of(program.pid());
    return children.size() == 1 && children != old;
  }));
  kill(children.front(), SIGKILL);
  ASSERT_TRUE(program.wait_for_err("the limit is reached"));
  // The others have not noticed.
  program.signal(SIGINT);
  EXPECT_EQ(program.finish().code(), 0);
}

TEST_F(Run, AnIsolatedComponentThatAbortsAlwaysIsGivenUp) {
  write(failing("timer", "abort", ", isolate: true, restart: {limit: 1, backoff: 0.01}") +
        "complete_when: [bad]\n");
  const auto finished = run();
  EXPECT_EQ(finished.code(), 1);
  EXPECT_THAT(finished.err, AllOf(HasSubstr("was killed by signal 6 (Aborted); restart 1 of 1"),
                                  HasSubstr("the limit is reached")));
}

TEST_F(Run, ChildrenEndWithTheirParent) {
  write("components: [{type: 'pipescout_test::Talker', name: talker, isolate: true}]\n");
  Program program({"run", "c.yaml", "--out", "m"}, folder_);
  ASSERT_TRUE(program.wait_for_err(kStarted));
  const auto children = children_of(program.pid());
  ASSERT_EQ(children.size(), 1U);
  program.signal(SIGKILL);
  EXPECT_EQ(program.finish().signal(), SIGKILL);
  EXPECT_TRUE(eventually([&] { return !is_running(children[0]); }));
}

TEST_F(Run, AChildThatHangsEndsWithItsParentToo) {
  for (const char* where : {"constructor", "deactivate"}) {
    fs::remove_all(folder_ / "m");
    write(
        "components: [{type: 'pipescout_test::FailingComponent', name: bad, isolate: true, "
        "parameters: {where: " +
        std::string(where) + ", how: hang}}]\n");
    Program program({"run", "c.yaml", "--out", "m"}, folder_);
    const bool starting = std::string(where) == "constructor";
    ASSERT_TRUE(program.wait_for_err(starting ? "hangs in constructor" : kStarted));
    const auto children = children_of(program.pid());
    ASSERT_EQ(children.size(), 1U);
    program.signal(SIGKILL);
    EXPECT_EQ(program.finish().signal(), SIGKILL);
    EXPECT_TRUE(eventually([&] { return !is_running(children[0]); }));
  }
}

TEST_F(Run, SigkillAtAnyMomentDoesNotDisturbTheNextStart) {
  write("components: [{type: 'pipescout_test::Talker', name: talker}]\n");
  for (int i = 0; i < 3; ++i) {
    Program program({"run", "c.yaml", "--out", "k" + std::to_string(i)}, folder_);
    if (i > 0) {
      ASSERT_TRUE(program.wait_for_err(kStarted));
    }
    program.signal(SIGKILL);
    program.finish();
  }
  write(
      "components: [{type: 'pipescout_test::Talker', name: talker, parameters: {count: 1}}]\n"
      "complete_when: [talker]\n");
  EXPECT_EQ(run().code(), 0);
}

}  // namespace
}  // namespace pipescout::host
