// SPDX-License-Identifier: Apache-2.0
#include "core/child_supervisor.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>

namespace pipescout::host {
namespace {

using State = ChildSupervisor::State;
using std::chrono::milliseconds;

/// A wait status as the kernel makes it.
constexpr int exited(int code) {
  return code << 8;
}
constexpr int killed(int number) {
  return number;
}

/// What the supervisor did to its children.
struct Record {
  int launched = 0;
  int asked = 0;
  int started = 0;
  std::vector<int> signals;
  std::vector<std::string> log;
  bool refuse = false;
};

class FakeChild final : public Child {
 public:
  explicit FakeChild(Record& record) : record_(record) {}
  [[nodiscard]] pid_t pid() const override { return 4000 + record_.launched; }
  void start_component() override { ++record_.started; }
  void signal(int number) override { record_.signals.push_back(number); }
  void ask() override { ++record_.asked; }

 private:
  Record& record_;
};

class Supervision : public ::testing::Test {
 protected:
  ChildSupervisor make(RestartPolicy policy = {2, milliseconds(100)}) {
    return ChildSupervisor(
        "/fusion", policy,
        [this]() -> std::unique_ptr<Child> {
          if (record_.refuse) {
            throw std::runtime_error("no more processes");
          }
          ++record_.launched;
          return std::make_unique<FakeChild>(record_);
        },
        [this](LogSeverity, const std::string& text) { record_.log.push_back(text); });
  }

  static ChildMessage message(ChildMessage::Event event, std::string text = "") {
    return {event, std::move(text), {}};
  }
  static void bring_up(ChildSupervisor& supervisor) {
    supervisor.on_message(message(ChildMessage::Event::kConstructed));
    supervisor.on_message(message(ChildMessage::Event::kActive));
  }

  Record record_;
  SteadyTime now_{};
};

TEST_F(Supervision, TakesAChildToActive) {
  auto supervisor = make();
  EXPECT_EQ(supervisor.state(), State::kStopped);
  supervisor.launch(now_);
  EXPECT_EQ(supervisor.state(), State::kLaunched);
  supervisor.on_message({ChildMessage::Event::kConstructed, "", {{"gain", 2.0}}});
  EXPECT_EQ(supervisor.state(), State::kConstructed);
  EXPECT_EQ(supervisor.parameters(), (std::vector<NamedParameter>{{"gain", 2.0}}));
  EXPECT_EQ(record_.started, 0);
  supervisor.activate();
  EXPECT_EQ(record_.started, 1);
  EXPECT_EQ(supervisor.state(), State::kActivating);
  supervisor.on_message(message(ChildMessage::Event::kActive));
  EXPECT_EQ(supervisor.state(), State::kActive);
}

TEST_F(Supervision, RestartsWithGrowingPausesUpToTheLimit) {
  auto supervisor = make();
  supervisor.launch(now_);
  supervisor.activate();
  bring_up(supervisor);

  supervisor.on_exit(killed(SIGKILL), now_);
  EXPECT_EQ(supervisor.state(), State::kPausing);
  EXPECT_EQ(supervisor.restarts(), 1);
  EXPECT_EQ(supervisor.deadline(), now_ + milliseconds(100));
  EXPECT_EQ(record_.log.back(), "/fusion was killed by signal 9 (Killed); restart 1 of 2 in 0.1 s");
  supervisor.on_time(now_ + milliseconds(99));
  EXPECT_EQ(record_.launched, 1);
  now_ += milliseconds(100);
  supervisor.on_time(now_);
  EXPECT_EQ(record_.launched, 2);
  bring_up(supervisor);
  EXPECT_EQ(supervisor.state(), State::kActive);
  EXPECT_EQ(record_.started, 2);

  supervisor.on_exit(exited(3), now_);
  EXPECT_EQ(supervisor.deadline(), now_ + milliseconds(200));
  now_ += milliseconds(200);
  supervisor.on_time(now_);
  bring_up(supervisor);

  supervisor.on_exit(exited(0), now_);
  EXPECT_EQ(supervisor.state(), State::kFailed);
  EXPECT_EQ(supervisor.error(),
            "exited with code 0; it was restarted 2 times, the limit is reached");
  EXPECT_FALSE(supervisor.deadline());
  EXPECT_FALSE(supervisor.running());
}

TEST_F(Supervision, AFirstFailureIsAnErrorOfTheComposition) {
  auto supervisor = make();
  supervisor.launch(now_);
  supervisor.on_message(message(ChildMessage::Event::kFailed, "c.yaml:3:5: no such thing"));
  EXPECT_EQ(supervisor.state(), State::kFailed);
  supervisor.on_exit(exited(1), now_);
  EXPECT_EQ(supervisor.state(), State::kFailed);
  EXPECT_EQ(supervisor.error(), "c.yaml:3:5: no such thing");
  EXPECT_EQ(supervisor.restarts(), 0);
}

TEST_F(Supervision, ALaterFailureCountsAsARestart) {
  auto supervisor = make();
  supervisor.launch(now_);
  supervisor.activate();
  bring_up(supervisor);
  supervisor.on_exit(killed(SIGSEGV), now_);
  supervisor.on_time(now_ + milliseconds(100));
  supervisor.on_message(message(ChildMessage::Event::kFailed, "the sensor is gone"));
  EXPECT_NE(supervisor.state(), State::kFailed);
  supervisor.on_exit(exited(1), now_);
  EXPECT_EQ(supervisor.state(), State::kPausing);
  EXPECT_EQ(supervisor.restarts(), 2);
}

TEST_F(Supervision, KnowsThatTheComponentBroke) {
  auto supervisor = make();
  supervisor.launch(now_);
  supervisor.activate();
  bring_up(supervisor);
  EXPECT_FALSE(supervisor.broke());
  supervisor.on_message(ChildMessage::from_json(message(ChildMessage::Event::kBroke).to_json()));
  EXPECT_TRUE(supervisor.broke());
  EXPECT_EQ(supervisor.state(), State::kActive);
}

TEST_F(Supervision, ACrashBeforeActivationIsRestartedToo) {
  auto supervisor = make();
  supervisor.launch(now_);
  supervisor.activate();
  supervisor.on_exit(killed(SIGABRT), now_);
  EXPECT_EQ(supervisor.state(), State::kPausing);
}

TEST_F(Supervision, ALaunchThatFailsCountsAsAnEnd) {
  auto supervisor = make({1, milliseconds(100)});
  record_.refuse = true;
  supervisor.launch(now_);
  EXPECT_EQ(supervisor.state(), State::kPausing);
  supervisor.on_time(now_ + milliseconds(100));
  EXPECT_EQ(supervisor.state(), State::kFailed);
  EXPECT_THAT(supervisor.error(), ::testing::HasSubstr("no more processes"));
}

TEST_F(Supervision, StoppingSendsSigintAndEndsRestarts) {
  auto supervisor = make();
  supervisor.launch(now_);
  supervisor.activate();
  bring_up(supervisor);
  supervisor.stop();
  EXPECT_THAT(record_.signals, ::testing::ElementsAre(SIGINT));
  EXPECT_EQ(supervisor.state(), State::kStopping);
  supervisor.on_exit(killed(SIGKILL), now_);
  EXPECT_EQ(supervisor.state(), State::kStopped);
  EXPECT_FALSE(supervisor.deadline());
}

TEST_F(Supervision, StoppingInAPauseIsImmediate) {
  auto supervisor = make();
  supervisor.launch(now_);
  supervisor.on_exit(exited(1), now_);
  supervisor.stop();
  EXPECT_EQ(supervisor.state(), State::kStopped);
  supervisor.on_time(now_ + std::chrono::hours(1));
  EXPECT_EQ(record_.launched, 1);
}

TEST_F(Supervision, NoRestartsWhenTheLimitIsZero) {
  auto supervisor = make({0, milliseconds(100)});
  supervisor.launch(now_);
  supervisor.on_exit(exited(1), now_);
  EXPECT_EQ(supervisor.state(), State::kFailed);
}

TEST(RestartPause, DoublesUpToAMinute) {
  const RestartPolicy policy{100, milliseconds(500)};
  EXPECT_EQ(restart_pause(policy, 1), milliseconds(500));
  EXPECT_EQ(restart_pause(policy, 4), milliseconds(4000));
  EXPECT_EQ(restart_pause(policy, 1000), std::chrono::minutes(1));
  EXPECT_EQ(restart_pause({5, std::chrono::minutes(2)}, 3), std::chrono::minutes(2));
  EXPECT_EQ(restart_pause({5, Duration::zero()}, 1000000), Duration::zero());
}

TEST(ChildMessage, SurvivesTheWire) {
  const ChildMessage message{
      ChildMessage::Event::kConstructed,
      "a \"b\"\n",
      {{"x", 1.0}, {"names", std::vector<std::string>{"1", "b"}}, {"text", "true"}}};
  const auto again = ChildMessage::from_json(message.to_json());
  EXPECT_EQ(again.event, message.event);
  EXPECT_EQ(again.message, message.message);
  EXPECT_EQ(again.parameters, message.parameters);
}

TEST(ChildMessage, RefusesWhatIsNone) {
  for (const char* text : {"", "3", "{}", R"({"event": "x", "message": "", "parameters": []})",
                           R"({"event": "active", "message": 3, "parameters": []})",
                           R"({"event": "active", "message": "", "parameters": [["a"]]})"}) {
    EXPECT_THROW(static_cast<void>(ChildMessage::from_json(text)), std::invalid_argument) << text;
  }
}

}  // namespace
}  // namespace pipescout::host
