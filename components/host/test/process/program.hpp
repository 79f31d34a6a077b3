// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pipescout/testing/program.hpp"

namespace pipescout::host {

using ::pipescout::testing::children_of;
using ::pipescout::testing::eventually;
using ::pipescout::testing::Finished;
using ::pipescout::testing::is_running;
using ::pipescout::testing::kPatience;
using ::pipescout::testing::shared_memory_of;
using ::pipescout::testing::sockets_of;

/// The executable `pipescout`, which finds the components of the tests.
class Program : public ::pipescout::testing::Program {
 public:
  Program(const std::vector<std::string>& arguments, const std::filesystem::path& folder);
};

/// Runs to the end.
Finished run_program(const std::vector<std::string>& arguments,
                     const std::filesystem::path& folder);

}  // namespace pipescout::host
