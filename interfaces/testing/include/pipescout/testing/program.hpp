// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <functional>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <vector>

namespace pipescout::testing {

/// Time-out of a test for an event that must occur. Far longer than needed, also on a loaded
/// machine.
inline constexpr std::chrono::seconds kPatience{60};

/// The result of a finished program.
struct Finished {
  int status = 0;  ///< of waitpid
  std::string out;
  std::string err;
  [[nodiscard]] int code() const;    ///< -1 when a signal ended it
  [[nodiscard]] int signal() const;  ///< 0 when it exited
};

/// An executable in a separate process and folder, on the loopback and a DDS domain that the tests
/// of this process share. Killed when the object is destroyed.
class Program {
 public:
  /// `executable`: its path. `folder`: where it runs. Throws std::runtime_error.
  Program(const std::string& executable, const std::vector<std::string>& arguments,
          const std::filesystem::path& folder);
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;
  ~Program();

  [[nodiscard]] pid_t pid() const noexcept { return pid_; }
  void signal(int number) const;
  /// Waits until its stdout (or stderr) contains the text; false when the program ends or the
  /// time-out passes before.
  bool wait_for_out(const std::string& text);
  bool wait_for_err(const std::string& text);
  [[nodiscard]] std::string out();
  [[nodiscard]] std::string err();
  /// Waits for its end. A program that does not end in time is killed, and signal() is SIGKILL.
  Finished finish();

 private:
  struct Stream {
    int fd = -1;
    std::string text;
    bool ended = false;
    std::thread reader;
  };
  void collect(Stream& stream);
  bool wait_for(const Stream& stream, const std::string& text);

  pid_t pid_ = -1;
  bool reaped_ = false;
  std::mutex mutex_;
  std::condition_variable changed_;
  Stream out_;
  Stream err_;
};

/// Runs to the end.
Finished run_program(const std::string& executable, const std::vector<std::string>& arguments,
                     const std::filesystem::path& folder);

/// Processes whose parent is `pid`.
std::vector<pid_t> children_of(pid_t pid);

/// The process exists and is not a zombie.
bool is_running(pid_t pid);

/// The sockets that a process has open: "socket:[123]".
std::set<std::string> sockets_of(pid_t pid);

/// The files in /dev/shm that a process has mapped.
std::set<std::string> shared_memory_of(pid_t pid);

/// Waits until the condition holds; false after the time-out. For conditions without an event, such
/// as the state of another process.
bool eventually(const std::function<bool()>& condition);

}  // namespace pipescout::testing
