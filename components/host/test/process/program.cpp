// SPDX-License-Identifier: Apache-2.0
#include "program.hpp"

#include <cstdlib>

namespace pipescout::host {
namespace {

/// The path of the executable, for a process that finds what the tests install.
const char* executable() {
  static const std::string kPrefixes = [] {
    const char* outside = std::getenv("AMENT_PREFIX_PATH");
    return std::string(TEST_PREFIX) + (outside != nullptr ? ":" + std::string(outside) : "");
  }();
  setenv("AMENT_PREFIX_PATH", kPrefixes.c_str(), 1);
  return PIPESCOUT_PROGRAM;
}

}  // namespace

Program::Program(const std::vector<std::string>& arguments, const std::filesystem::path& folder)
    : ::pipescout::testing::Program(executable(), arguments, folder) {}

Finished run_program(const std::vector<std::string>& arguments,
                     const std::filesystem::path& folder) {
  return Program(arguments, folder).finish();
}

}  // namespace pipescout::host
