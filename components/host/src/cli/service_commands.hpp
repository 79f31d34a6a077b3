// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>

#include "cli/command.hpp"

namespace pipescout::host {

void add_service_call(CLI::App& group, Action& action);

}  // namespace pipescout::host
