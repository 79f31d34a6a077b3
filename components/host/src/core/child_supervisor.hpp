// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/composition.hpp"
#include "pipescout/runtime/logger.hpp"

namespace pipescout::host {

/// A process that runs one component, as its supervisor sees it.
class Child {
 public:
  virtual ~Child() = default;
  [[nodiscard]] virtual pid_t pid() const = 0;
  /// Lets a child that has made its component configure and activate it.
  virtual void start_component() = 0;
  virtual void signal(int number) = 0;
  /// Asks for kAlive.
  virtual void ask() = 0;
};

/// What a child tells its supervisor. On the wire: JSON, one object per packet.
struct ChildMessage {
  enum class Event : std::uint8_t {
    kConstructed,  ///< the component exists, unconfigured
    kActive,       ///< it is configured and active
    kBroke,        ///< it went through its error state; the child goes on
    kAlive,        ///< its executor runs callbacks
    kFailed        ///< it could not be made or activated; the child exits
  };
  Event event = Event::kFailed;
  std::string message;                     ///< of kFailed
  std::vector<NamedParameter> parameters;  ///< of kConstructed: all that the component has

  [[nodiscard]] std::string to_json() const;
  /// Throws std::invalid_argument.
  [[nodiscard]] static ChildMessage from_json(const std::string& text);
};

/// Keeps one isolated component running: launches its process, takes it to active, and when it ends
/// by itself launches it again, after a pause that doubles each time and at most as often as the
/// policy says. A component that cannot be made or activated the first time is an error in the
/// composition and is not tried again. Knows no clock and no operating system: the host hands in
/// time and events. Not thread-safe.
class ChildSupervisor {
 public:
  enum class State : std::uint8_t {
    kLaunched,     ///< the component is being made
    kConstructed,  ///< waits for `activate`
    kActivating,
    kActive,
    kPausing,  ///< ended by itself; waits to be launched again
    kStopping,
    kStopped,
    kFailed  ///< will not run again: `error` says why
  };
  /// May throw; that counts as an end by itself.
  using Launch = std::function<std::unique_ptr<Child>()>;
  using Log = std::function<void(LogSeverity, const std::string&)>;

  ChildSupervisor(std::string name, RestartPolicy policy, Launch launch, Log log);

  /// The first launch.
  void launch(SteadyTime now);
  /// Lets the component, now or once it is made, become active; holds for later launches too.
  void activate();
  /// Asks the process to end, by SIGINT.
  void stop();

  /// Asks a process whose component is active whether its executor runs callbacks, unless it has
  /// not answered yet.
  void ask();
  /// It was asked and has not answered.
  [[nodiscard]] bool silent() const noexcept { return asked_; }

  void on_message(const ChildMessage& message);
  /// `status`: of waitpid.
  void on_exit(int status, SteadyTime now);
  /// Launches again when the pause is over.
  void on_time(SteadyTime now);
  /// When to call `on_time`.
  [[nodiscard]] std::optional<SteadyTime> deadline() const { return relaunch_at_; }

  [[nodiscard]] const std::string& name() const noexcept { return name_; }
  [[nodiscard]] State state() const noexcept { return state_; }
  /// A process exists.
  [[nodiscard]] bool running() const noexcept { return child_ != nullptr; }
  [[nodiscard]] Child* child() const noexcept { return child_.get(); }
  /// The component has gone through its error state.
  [[nodiscard]] bool broke() const noexcept { return broke_; }
  [[nodiscard]] int restarts() const noexcept { return restarts_; }
  [[nodiscard]] const RestartPolicy& policy() const noexcept { return policy_; }
  [[nodiscard]] const std::string& error() const noexcept { return error_; }
  [[nodiscard]] const std::string& last_exit() const noexcept { return last_exit_; }
  [[nodiscard]] const std::vector<NamedParameter>& parameters() const { return parameters_; }

 private:
  void try_launch(SteadyTime now);
  void ended(const std::string& how, SteadyTime now);
  void fail(const std::string& why);

  std::string name_;
  RestartPolicy policy_;
  Launch launch_;
  Log log_;
  State state_ = State::kStopped;
  std::unique_ptr<Child> child_;
  bool activate_ = false;
  bool was_active_ = false;
  bool broke_ = false;
  bool asked_ = false;
  int restarts_ = 0;
  std::optional<SteadyTime> relaunch_at_;
  std::string error_;
  std::string last_exit_;
  std::vector<NamedParameter> parameters_;
};

[[nodiscard]] const char* to_string(ChildSupervisor::State state) noexcept;

/// "was killed by signal 11 (Segmentation fault)", "exited with code 3".
[[nodiscard]] std::string describe_exit(int status);

/// The pause before restart number `restart` (from 1): doubles each time, at most a minute, or the
/// policy's own backoff when that is longer.
[[nodiscard]] Duration restart_pause(const RestartPolicy& policy, int restart);

}  // namespace pipescout::host
