// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>

#include "cli/session.hpp"

namespace pipescout::host {

void add_topic_echo(CLI::App& group, Action& action);
void add_topic_pub(CLI::App& group, Action& action);
void add_topic_statistics(CLI::App& group, Action& action);

}  // namespace pipescout::host
