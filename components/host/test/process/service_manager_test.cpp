// SPDX-License-Identifier: Apache-2.0
// What `pipescout run` tells a service manager, and what its executors run with.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sched.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <stdexcept>

#include "pipescout/files/testing/temporary_folder.hpp"
#include "program.hpp"

namespace pipescout::host {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

/// The manager's end of the notification socket.
class NotifySocket {
 public:
  explicit NotifySocket(const fs::path& path) : fd_(socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.string().copy(address.sun_path, sizeof address.sun_path - 1);
    if (fd_ < 0 || bind(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
      throw std::runtime_error("no socket " + path.string());
    }
  }
  NotifySocket(const NotifySocket&) = delete;
  NotifySocket& operator=(const NotifySocket&) = delete;
  ~NotifySocket() { close(fd_); }

  /// Waits for the next message; empty when patience is over.
  [[nodiscard]] std::string next() const {
    return next_within(
        static_cast<int>(std::chrono::duration_cast<std::chrono::milliseconds>(kPatience).count()));
  }
  /// What has arrived so far is forgotten.
  void drain() const {
    while (!next_within(0).empty()) {
    }
  }

 private:
  [[nodiscard]] std::string next_within(int milliseconds) const {
    pollfd descriptor{fd_, POLLIN, 0};
    if (poll(&descriptor, 1, milliseconds) != 1) {
      return {};
    }
    std::array<char, 512> text{};
    const auto size = recv(fd_, text.data(), text.size(), 0);
    return {text.data(), size > 0 ? static_cast<std::size_t>(size) : 0};
  }

  int fd_;
};

class ServiceRun : public ::testing::Test {
 protected:
  ServiceRun() : socket_(folder_.path() / "notify") {
    setenv("NOTIFY_SOCKET", (folder_.path() / "notify").c_str(), 1);
  }
  ~ServiceRun() override {
    unsetenv("NOTIFY_SOCKET");
    unsetenv("WATCHDOG_USEC");
  }

  [[nodiscard]] std::vector<std::string> run_of(const std::string& composition) const {
    std::ofstream(folder_.path() / "c.yaml") << composition;
    return {"run", "c.yaml", "--out", "m"};
  }

  ::pipescout::testing::TemporaryFolder folder_;
  NotifySocket socket_;
};

TEST_F(ServiceRun, IsReadyWhenAllAreActiveAndSaysThatItStops) {
  Program program(run_of("name: survey\ncomponents:\n"
                         "  - {type: pipescout_test::Talker, name: talker}\n"),
                  folder_.path());
  EXPECT_EQ(socket_.next(), "READY=1\nSTATUS=survey: 1 component is active");
  program.signal(SIGTERM);
  EXPECT_EQ(socket_.next(), "STOPPING=1");
  EXPECT_EQ(program.finish().code(), 0);
}

TEST_F(ServiceRun, WatchdogHearsThatItIsAlive) {
  setenv("WATCHDOG_USEC", "200000", 1);
  Program program(
      run_of("components:\n"
             "  - {type: pipescout_test::Talker, name: talker, executor: {}}\n"
             "  - {type: pipescout_test::Talker, name: talker, namespace: far, isolate: true}\n"),
      folder_.path());
  EXPECT_THAT(socket_.next(), HasSubstr("READY=1"));
  for (int k = 0; k < 10; ++k) {
    EXPECT_EQ(socket_.next(), "WATCHDOG=1");
  }
  program.signal(SIGTERM);
  EXPECT_EQ(program.finish().code(), 0);
}

/// The watchdog hears nothing once a callback hangs.
void expect_silence(const NotifySocket& socket, Program& program, const std::string& component) {
  EXPECT_THAT(socket.next(), HasSubstr("READY=1"));
  ASSERT_TRUE(program.wait_for_err("no answer from the executor of " + component));
  socket.drain();
  program.signal(SIGTERM);
  EXPECT_EQ(socket.next(), "STOPPING=1");
}

TEST_F(ServiceRun, WatchdogHearsNothingWhenAnExecutorHangs) {
  setenv("WATCHDOG_USEC", "200000", 1);
  Program program(
      run_of("components:\n"
             "  - {type: pipescout_test::Talker, name: talker}\n"
             "  - {type: pipescout_test::FailingComponent, name: hanging, executor: {},\n"
             "     parameters: {where: timer, how: hang}}\n"),
      folder_.path());
  expect_silence(socket_, program, "/hanging");
  EXPECT_EQ(program.finish().code(), 1);
}

TEST_F(ServiceRun, WatchdogHearsNothingWhenAnIsolatedComponentHangs) {
  setenv("WATCHDOG_USEC", "200000", 1);
  Program program(
      run_of("components:\n"
             "  - {type: pipescout_test::FailingComponent, name: hanging, isolate: true,\n"
             "     parameters: {where: timer, how: hang}}\n"),
      folder_.path());
  expect_silence(socket_, program, "/hanging");
  EXPECT_EQ(program.finish().code(), 1);
}

TEST_F(ServiceRun, AComponentThatHangsDoesNotStopOneOnAnotherExecutor) {
  Program program(run_of("components:\n"
                         "  - {type: pipescout_test::FailingComponent, name: hanging, "
                         "executor: {},\n     parameters: {where: timer, how: hang}}\n"
                         "  - {type: pipescout_test::Talker, name: talker}\n"),
                  folder_.path());
  EXPECT_THAT(socket_.next(), HasSubstr("READY=1"));
  ASSERT_TRUE(program.wait_for_err("hangs in timer"));
  // Asked after that, it still answers and publishes.
  const auto answer = run_program({"lifecycle", "get", "/talker"}, folder_.path());
  EXPECT_EQ(answer.out, "active [3]\n") << answer.err;
  const auto heard = run_program({"topic", "echo", "/chatter", "--once"}, folder_.path());
  EXPECT_THAT(heard.out, HasSubstr("data: hello"));
  program.signal(SIGTERM);
  const auto finished = program.finish();
  EXPECT_EQ(finished.code(), 1);
  EXPECT_THAT(finished.err, AllOf(HasSubstr("component /hanging did not stop in time"),
                                  HasSubstr("[talker]: was deactivated")));
}

/// Of the threads of a process: niceness, and real-time priority where the policy is SCHED_FIFO.
struct ThreadPriorities {
  std::multiset<int> niceness;
  std::multiset<int> fifo;
};

ThreadPriorities priorities_of(pid_t pid) {
  ThreadPriorities priorities;
  for (const auto& task : fs::directory_iterator("/proc/" + std::to_string(pid) + "/task")) {
    const auto thread = static_cast<pid_t>(std::stol(task.path().filename().string()));
    priorities.niceness.insert(getpriority(PRIO_PROCESS, static_cast<id_t>(thread)));
    sched_param parameter{};
    if (sched_getscheduler(thread) == SCHED_FIFO && sched_getparam(thread, &parameter) == 0) {
      priorities.fifo.insert(parameter.sched_priority);
    }
  }
  return priorities;
}

TEST_F(ServiceRun, ExecutorsHaveThreadsAndPrioritiesOfTheirOwn) {
  // Where the tests themselves have the greatest niceness, all threads have it.
  const int nice = std::min(getpriority(PRIO_PROCESS, 0) + 3, 19);
  Program program(
      run_of("components:\n"
             "  - {type: pipescout_test::Talker, name: plain, log_level: error}\n"
             "  - {type: pipescout_test::Talker, name: patient, executor: {nice: " +
             std::to_string(nice) +
             "}}\n"
             "  - {type: pipescout_test::Talker, name: urgent, executor: {fifo: 1, type: "
             "multi_threaded, threads: 2}}\n"),
      folder_.path());
  EXPECT_THAT(socket_.next(), HasSubstr("READY=1"));
  const auto priorities = priorities_of(program.pid());
  EXPECT_GE(priorities.niceness.count(nice), 1U);
  // Without the permission there is a warning in place of the priority.
  const bool permitted = program.err().find(
                             "executor of /urgent: real-time priority 1 (SCHED_FIFO) "
                             "is not permitted") == std::string::npos;
  EXPECT_EQ(priorities.fifo.count(1), permitted ? 2U : 0U);
  program.signal(SIGTERM);
  const auto finished = program.finish();
  EXPECT_EQ(finished.code(), 0);
  EXPECT_THAT(finished.err, AllOf(HasSubstr("[urgent]: was deactivated"),
                                  Not(HasSubstr("[plain]: was deactivated"))));
}

}  // namespace
}  // namespace pipescout::host
