// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/stop_signals.hpp"

#include <poll.h>
#include <sys/eventfd.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <optional>
#include <system_error>
#include <utility>

namespace pipescout {
namespace {

// What is written to wake_: an eventfd adds up.
constexpr std::uint64_t kExpectEnd = 1;
constexpr std::uint64_t kQuit = std::uint64_t{1} << 32U;

constexpr Duration kSameRequest = std::chrono::milliseconds(200);

sigset_t stop_set() {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGINT);
  sigaddset(&set, SIGTERM);
  // Under nohup the end of the terminal means nothing; a blocked signal would arrive all the same.
  struct sigaction hang_up {};
  if (sigaction(SIGHUP, nullptr, &hang_up) != 0 || hang_up.sa_handler != SIG_IGN) {
    sigaddset(&set, SIGHUP);
  }
  return set;
}

void write_number(int fd, std::uint64_t number) {
  [[maybe_unused]] const auto written = write(fd, &number, sizeof number);
}

}  // namespace

void StopSignals::block() {
  const auto set = stop_set();
  pthread_sigmask(SIG_BLOCK, &set, nullptr);
}

StopSignals::StopSignals(Duration grace, std::function<void(int)> on_stop,
                         std::function<void()> before_forced_end)
    : grace_(grace),
      on_stop_(std::move(on_stop)),
      before_forced_end_(std::move(before_forced_end)) {
  block();
  const auto set = stop_set();
  signals_ = signalfd(-1, &set, SFD_CLOEXEC);
  wake_ = eventfd(0, EFD_CLOEXEC);
  if (signals_ < 0 || wake_ < 0) {
    throw std::system_error(errno, std::generic_category(), "signalfd");
  }
  thread_ = std::thread([this] { run(); });
}

StopSignals::~StopSignals() {
  write_number(wake_, kQuit);
  thread_.join();
  close(signals_);
  close(wake_);
}

void StopSignals::expect_end() {
  write_number(wake_, kExpectEnd);
}

void StopSignals::end_by_force(int code, const char* why) const {
  before_forced_end_();
  [[maybe_unused]] const auto written = write(STDERR_FILENO, why, std::strlen(why));
  _exit(code);
}

void StopSignals::run() {
  std::optional<SteadyTime> first_at;
  std::optional<SteadyTime> end_at;
  while (true) {
    int timeout = -1;
    if (end_at) {
      const auto left = std::chrono::ceil<std::chrono::milliseconds>(*end_at - steady_now());
      timeout = static_cast<int>(std::max<std::int64_t>(0, left.count()));
    }
    std::array<pollfd, 2> descriptors{{{signals_, POLLIN, 0}, {wake_, POLLIN, 0}}};
    const int count = poll(descriptors.data(), descriptors.size(), timeout);
    if (count == 0) {
      end_by_force(1, "error: some components did not stop in time; process terminated\n");
    }
    if (count < 0) {
      continue;
    }
    if (descriptors[1].revents != 0) {
      std::uint64_t number = 0;
      [[maybe_unused]] const auto size = read(wake_, &number, sizeof number);
      if (number >= kQuit) {
        return;
      }
      end_at = end_at.value_or(steady_now() + grace_);
    }
    if (descriptors[0].revents != 0) {
      signalfd_siginfo info{};
      if (read(signals_, &info, sizeof info) != sizeof info) {
        continue;
      }
      const int number = static_cast<int>(info.ssi_signo);
      const SteadyTime now = steady_now();
      if (first_at) {
        if (now - *first_at >= kSameRequest) {
          end_by_force(128 + number, "second signal; process terminated\n");
        }
        continue;
      }
      first_at = now;
      end_at = end_at.value_or(now + grace_);
      on_stop_(number);
    }
  }
}

}  // namespace pipescout
