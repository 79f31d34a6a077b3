// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pipescout/command_line/command.hpp"

namespace pipescout::inspect {

/// `pipescout inspect welds`, docs/weld_inspection.md.
void add_welds_command(CLI::App& app, command_line::Action& action);

}  // namespace pipescout::inspect
