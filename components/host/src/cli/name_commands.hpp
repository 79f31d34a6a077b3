// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>

#include "cli/session.hpp"
#include "pipescout/runtime/graph.hpp"

namespace pipescout::host {

/// The commands `type NAME` and `find TYPE` of a group, over what `names` finds on the network.
/// `what`: "topic", "service".
void add_name_commands(CLI::App& group, Action& action, const char* what,
                       NamesAndTypes (*names)(Session& session));

}  // namespace pipescout::host
