// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/composition.hpp"

namespace pipescout::host {

/// The command line of `pipescout run`.
struct RunOptions {
  std::string composition;             ///< file
  std::vector<std::string> arguments;  ///< "NAME:=VALUE"
  std::string ns = "/";
  std::vector<std::string> parameters;
  std::vector<std::string> parameter_files;
  std::optional<std::string> out;      ///< mission folder
  std::optional<std::string> enclave;  ///< of DDS Security, for all processes; nothing: "/"

  /// What `load_composition` needs of it. Throws CompositionError, InvalidName.
  [[nodiscard]] CompositionInputs inputs() const;
};

/// The composition stopped itself and should be started again, as a service manager does
/// (`EX_TEMPFAIL` of sysexits.h): the list of revoked robots has changed.
inline constexpr int kExitStartAgain = 75;
/// Another process has a node of the same name, and has had it for longer (`EX_UNAVAILABLE`).
inline constexpr int kExitNameTaken = 69;

/// Runs a composition until it is complete or stopped. Returns the exit code: 0 when it is
/// complete, or was stopped and waited for nothing; 1 after an error, also one on the way down;
/// 128 + signal when it was stopped before it was complete; kExitStartAgain;
/// kExitNameTaken.
[[nodiscard]] int run_composition(const RunOptions& options);

/// What is fed to the components instead of what their surroundings publish.
struct ReplayOptions {
  std::string bag;                    ///< a bag's folder or file
  std::optional<std::string> record;  ///< folder for a bag with what the components publish
  std::optional<double> rate;         ///< bag seconds per second; none: as fast as they go
};

/// Runs a composition on a recording: each message, and the time, is handed to the components once
/// they have done all that followed from the one before. So the same bag gives the same output,
/// however fast or busy the machine is. All components run in this process, on one thread, in
/// simulated time, and nothing reaches the network. Only topics that a component subscribes to, and
/// none publishes, are read. Ends with the bag, when the composition is complete, or stopped.
/// Returns the exit code as `run_composition`.
[[nodiscard]] int replay_composition(const RunOptions& options, const ReplayOptions& replay);

/// Runs one component of a composition on behalf of a `run_composition` in another process, which
/// holds the other end of the socket `control_fd`.
[[nodiscard]] int run_isolated(const RunOptions& options, const std::string& component,
                               int control_fd);

}  // namespace pipescout::host
