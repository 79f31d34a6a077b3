// SPDX-License-Identifier: Apache-2.0
#include "run/child_process.hpp"

#include <fcntl.h>
#include <linux/close_range.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <mutex>
#include <set>
#include <system_error>

namespace pipescout::host {
namespace {

constexpr std::string_view kStart = "start";
constexpr std::string_view kAsk = "alive?";
/// Room for the parameters of a component; a larger packet is refused by the sender's kernel.
constexpr std::size_t kLargestMessage = 256 * 1024;

std::mutex& running_mutex() {
  static std::mutex mutex;
  return mutex;
}

std::set<pid_t>& running() {
  static std::set<pid_t> pids;
  return pids;
}

[[noreturn]] void throw_errno(const char* what) {
  throw std::system_error(errno, std::generic_category(), what);
}

/// Runs between fork and exec, in a copy of a process with threads: async-signal-safe calls only.
[[noreturn]] void become(char* const* argv, int control, pid_t parent, int failure_pipe) {
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  ::signal(SIGPIPE, SIG_DFL);
  setpgid(0, 0);
  const int null = open("/dev/null", O_RDONLY);
  if (null >= 0) {
    dup2(null, STDIN_FILENO);
  }
  // Sockets of the network must not stay open in another process; their makers do not care. A
  // kernel that cannot do it is no reason not to start.
  [[maybe_unused]] const int closed = close_range(3, ~0U, CLOSE_RANGE_CLOEXEC);
  // A parent that has died before this call would never be noticed.
  if (prctl(PR_SET_PDEATHSIG, SIGTERM) == 0 && getppid() == parent &&
      fcntl(control, F_SETFD, 0) == 0) {
    execv("/proc/self/exe", argv);
  }
  const int reason = errno;
  [[maybe_unused]] const auto written = write(failure_pipe, &reason, sizeof reason);
  _exit(127);
}

}  // namespace

ChildProcess::ChildProcess(std::vector<std::string> arguments) {
  std::array<int, 2> sockets{};
  if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, sockets.data()) != 0) {
    throw_errno("socketpair");
  }
  // Closed by a successful exec; else it carries the reason.
  std::array<int, 2> failure{};
  if (pipe2(failure.data(), O_CLOEXEC) != 0) {
    const int reason = errno;
    close(sockets[0]);
    close(sockets[1]);
    errno = reason;
    throw_errno("pipe2");
  }
  arguments.insert(arguments.begin(), "pipescout");
  arguments.push_back("--control-fd=" + std::to_string(sockets[1]));
  std::vector<char*> argv;
  for (auto& argument : arguments) {
    argv.push_back(argument.data());
  }
  argv.push_back(nullptr);

  const pid_t parent = getpid();
  pid_ = fork();
  if (pid_ == 0) {
    become(argv.data(), sockets[1], parent, failure[1]);
  }
  int reason = pid_ < 0 ? errno : 0;
  close(sockets[1]);
  close(failure[1]);
  if (pid_ > 0) {
    while (read(failure[0], &reason, sizeof reason) < 0 && errno == EINTR) {
    }
  }
  close(failure[0]);
  if (reason != 0) {
    close(sockets[0]);
    if (pid_ > 0) {
      waitpid(pid_, nullptr, 0);
    }
    errno = reason;
    throw_errno("a process of its own");
  }
  control_ = sockets[0];
  const std::lock_guard lock(running_mutex());
  running().insert(pid_);
}

ChildProcess::~ChildProcess() {
  if (!reaped_) {
    kill(pid_, SIGKILL);
    const std::lock_guard lock(running_mutex());
    waitpid(pid_, nullptr, 0);
    running().erase(pid_);
  }
  close(control_);
}

void ChildProcess::start_component() {
  tell(kStart);
}

void ChildProcess::ask() {
  tell(kAsk);
}

void ChildProcess::tell(std::string_view word) const {
  // A child that has gone is noticed by its exit.
  [[maybe_unused]] const auto sent =
      ::send(control_, word.data(), word.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
}

void ChildProcess::signal(int number) {
  if (!reaped_) {
    kill(pid_, number);
  }
}

std::optional<ChildMessage> ChildProcess::receive() {
  std::string text(kLargestMessage, '\0');
  const auto size = recv(control_, text.data(), text.size(), MSG_DONTWAIT | MSG_TRUNC);
  if (size > 0) {
    if (static_cast<std::size_t>(size) > text.size()) {
      throw std::invalid_argument("message of " + std::to_string(size) + " bytes");
    }
    text.resize(static_cast<std::size_t>(size));
    return ChildMessage::from_json(text);
  }
  closed_ = size == 0 || (errno != EAGAIN && errno != EINTR);
  return std::nullopt;
}

std::optional<int> ChildProcess::reap() {
  // Under the lock no signal can be sent to a process that was reaped, and whose number may be
  // somebody else's by then.
  const std::lock_guard lock(running_mutex());
  int status = 0;
  if (reaped_ || waitpid(pid_, &status, WNOHANG) != pid_) {
    return std::nullopt;
  }
  reaped_ = true;
  running().erase(pid_);
  return status;
}

void ChildProcess::signal_all(int number) {
  const std::lock_guard lock(running_mutex());
  for (const pid_t pid : running()) {
    kill(pid, number);
  }
}

void ControlSocket::send(const ChildMessage& message) const {
  const auto text = message.to_json();
  if (::send(fd_, text.data(), text.size(), MSG_NOSIGNAL) < 0 && errno == EMSGSIZE) {
    auto smaller = message;
    smaller.parameters.clear();
    const auto rest = smaller.to_json();
    [[maybe_unused]] const auto sent = ::send(fd_, rest.data(), rest.size(), MSG_NOSIGNAL);
  }
}

ControlSocket::Received ControlSocket::receive() const {
  std::array<char, 64> text{};
  const auto size = recv(fd_, text.data(), text.size(), MSG_DONTWAIT);
  if (size < 0 && (errno == EAGAIN || errno == EINTR)) {
    return Received::kNothing;
  }
  const std::string_view word(text.data(), size > 0 ? static_cast<std::size_t>(size) : 0);
  return word == kStart ? Received::kStart : word == kAsk ? Received::kAsked : Received::kClosed;
}

}  // namespace pipescout::host
