// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "pipescout/runtime/time.hpp"

/// A process that stays on the network and answers commands that only look at the graph, so that
/// these need not discover it first. It is spoken to through a Unix socket in the abstract
/// namespace, which is that of a network namespace and leaves nothing behind, by the same user
/// alone; its name tells the version of the program and how it joins the network (docs/decisions/
/// daemon-answers-command-lines.md).
namespace pipescout::host {

/// What a command has printed, and its exit code.
struct CommandOutput {
  int code = 0;
  std::string out;
  std::string err;
};

/// Lets the daemon run a command, prints what comes of it, and returns its exit code. Nothing when
/// no daemon runs, it ends meanwhile, or has not answered when the patience ends.
[[nodiscard]] std::optional<int> ask_daemon(const std::vector<std::string>& words,
                                            Duration patience);

/// The socket of a daemon; answers one command after the other.
class DaemonSocket {
 public:
  /// Nothing when a daemon runs already. Throws std::system_error.
  [[nodiscard]] static std::optional<DaemonSocket> claim();
  /// One that another process has claimed and left open for this one.
  explicit DaemonSocket(int descriptor) : descriptor_(descriptor) {}
  DaemonSocket(DaemonSocket&& other) noexcept;
  DaemonSocket(const DaemonSocket&) = delete;
  DaemonSocket& operator=(const DaemonSocket&) = delete;
  ~DaemonSocket();

  [[nodiscard]] int descriptor() const noexcept { return descriptor_; }
  using Answer = std::function<CommandOutput(const std::vector<std::string>& words)>;
  /// Answers commands until one of them is to stop, none has come for the idle time, or `stop` was
  /// called.
  void serve(const Answer& answer, Duration idle);
  /// Thread-safe.
  void stop();

 private:
  int descriptor_ = -1;
};

/// Whether a daemon runs.
[[nodiscard]] bool daemon_runs();
/// Ends the daemon, and waits until it has; false when none runs.
bool stop_daemon();

}  // namespace pipescout::host
