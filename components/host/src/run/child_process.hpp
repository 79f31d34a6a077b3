// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/child_supervisor.hpp"

namespace pipescout::host {

/// This executable, started once more with other arguments, with a socket between the two. The
/// process gets SIGTERM when this one ends, however that comes about. It is the leader of a process
/// group of its own, so that Ctrl-C reaches it through its supervisor only.
class ChildProcess final : public Child {
 public:
  /// `arguments`: without the program's name; the descriptor of the child's end of the socket is
  /// appended as "--control-fd=N". Throws std::system_error. Call on the main thread: the child
  /// ends with the thread that launched it.
  explicit ChildProcess(std::vector<std::string> arguments);
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;
  /// Kills the process if it still runs.
  ~ChildProcess() override;

  [[nodiscard]] pid_t pid() const override { return pid_; }
  void start_component() override;
  void signal(int number) override;
  void ask() override;

  /// Readable when a message waits or the child has gone.
  [[nodiscard]] int control_fd() const noexcept { return control_; }
  /// The next message, without waiting. Throws std::invalid_argument for what is no message.
  [[nodiscard]] std::optional<ChildMessage> receive();
  /// True once the child has closed its end.
  [[nodiscard]] bool closed() const noexcept { return closed_; }
  /// The status of the process once it has ended, without waiting.
  [[nodiscard]] std::optional<int> reap();

  /// Sends a signal to all processes of this class that run. Thread-safe.
  static void signal_all(int number);

 private:
  void tell(std::string_view word) const;

  pid_t pid_ = -1;
  int control_ = -1;
  bool closed_ = false;
  bool reaped_ = false;
};

/// The child's end of the socket.
class ControlSocket {
 public:
  explicit ControlSocket(int fd) : fd_(fd) {}
  [[nodiscard]] int fd() const noexcept { return fd_; }
  void send(const ChildMessage& message) const;
  enum class Received { kNothing, kStart, kAsked, kClosed };
  /// Without waiting.
  [[nodiscard]] Received receive() const;

 private:
  int fd_;
};

}  // namespace pipescout::host
