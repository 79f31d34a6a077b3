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
  std::optional<std::string> out;  ///< mission folder

  /// What `load_composition` needs of it. Throws CompositionError, InvalidName.
  [[nodiscard]] CompositionInputs inputs() const;
};

/// Runs a composition until it is complete or stopped. Returns the exit code: 0 when it is
/// complete, or was stopped and waited for nothing; 1 after an error, also one on the way down;
/// 128 + signal when it was stopped before it was complete.
[[nodiscard]] int run_composition(const RunOptions& options);

/// Runs one component of a composition on behalf of a `run_composition` in another process, which
/// holds the other end of the socket `control_fd`.
[[nodiscard]] int run_isolated(const RunOptions& options, const std::string& component,
                               int control_fd);

}  // namespace pipescout::host
