// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <spawn.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <iostream>
#include <memory>
#include <sstream>
#include <streambuf>
#include <string>
#include <system_error>
#include <thread>
#include <utility>

#include "cli/command.hpp"
#include "cli/daemon.hpp"
#include "cli/session.hpp"

namespace pipescout::host {
namespace {

/// As that of `ros2 daemon`.
constexpr auto kLongestIdleness = std::chrono::hours(2);

/// What is written to a stream meanwhile.
class Capture {
 public:
  explicit Capture(std::ostream& stream) : stream_(stream), before_(stream.rdbuf(&buffer_)) {}
  Capture(const Capture&) = delete;
  Capture& operator=(const Capture&) = delete;
  ~Capture() { stream_.rdbuf(before_); }
  [[nodiscard]] std::string text() const { return buffer_.str(); }

 private:
  std::ostream& stream_;
  std::stringbuf buffer_;
  std::streambuf* before_;
};

CommandOutput answer(Session& session, const std::vector<std::string>& words) {
  const Capture out(std::cout);
  const Capture err(std::cerr);
  CLI::App app;
  Action action;
  action.resident = &session;
  add_commands(app, action);
  const int code = command_line::run_command(app, action, words);
  return {code, out.text(), err.text()};
}

/// Until it is stopped.
int run_daemon(DaemonSocket socket) {
  Session session({});
  std::thread serving([&] {
    socket.serve([&](const auto& words) { return answer(session, words); }, kLongestIdleness);
    session.executor().stop();
  });
  try {
    session.spin();
  } catch (const CommandInterrupted&) {
    // That is how it is ended.
  }
  socket.stop();
  serving.join();
  return kExitOk;
}

/// Starts this executable once more, away from this terminal, with the socket as its standard
/// input.
void start_in_background(const DaemonSocket& socket) {
  constexpr const char* kNowhere = "/dev/null";
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_adddup2(&files, socket.descriptor(), STDIN_FILENO);
  posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, kNowhere, O_WRONLY, 0);
  posix_spawn_file_actions_addopen(&files, STDERR_FILENO, kNowhere, O_WRONLY, 0);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSID);
  std::array<std::string, 4> words{"pipescout", "daemon", "run", "--socket-is-stdin"};
  std::array<char*, words.size() + 1> argv{};
  for (std::size_t i = 0; i < words.size(); ++i) {
    argv[i] = words[i].data();
  }
  pid_t process = 0;
  const int error =
      posix_spawn(&process, "/proc/self/exe", &files, &attributes, argv.data(), environ);
  posix_spawn_file_actions_destroy(&files);
  posix_spawnattr_destroy(&attributes);
  if (error != 0) {
    throw std::system_error(error, std::generic_category(), "the daemon");
  }
}

int start_daemon() {
  const auto socket = DaemonSocket::claim();
  if (!socket) {
    std::cout << "The daemon is already running\n";
    return kExitOk;
  }
  start_in_background(*socket);
  std::cout << "The daemon has been started\n";
  return kExitOk;
}

}  // namespace

void add_daemon_commands(CLI::App& app, Action& action) {
  auto* group = app.add_subcommand(
      "daemon", "A process that stays on the network and answers lists of nodes, topics, services");
  group->require_subcommand(1);
  group->add_subcommand("start", "Start it in the background; it ends after 2 h without a question")
      ->callback([&action] { action = start_daemon; });
  group->add_subcommand("stop", "Stop it")->callback([&action] {
    action = [] {
      std::cout << (stop_daemon() ? "The daemon has been stopped\n"
                                  : "The daemon is not running\n");
      return kExitOk;
    };
  });
  group->add_subcommand("status", "Say whether it runs")->callback([&action] {
    action = [] {
      std::cout << (daemon_runs() ? "The daemon is running\n" : "The daemon is not running\n");
      return kExitOk;
    };
  });
  const auto has_socket = std::make_shared<bool>(false);
  auto* run = group->add_subcommand("run", "Run it in this terminal");
  run->add_flag("--socket-is-stdin", *has_socket, "Its socket is the standard input")->group("");
  run->callback([has_socket, &action] {
    action = [has_socket] {
      if (*has_socket) {
        return run_daemon(DaemonSocket(STDIN_FILENO));
      }
      auto socket = DaemonSocket::claim();
      if (!socket) {
        throw CommandError("The daemon is already running");
      }
      return run_daemon(*std::move(socket));
    };
  });
}

}  // namespace pipescout::host
