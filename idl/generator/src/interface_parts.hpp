// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "model.hpp"
#include "parsers.hpp"

namespace pipescout::generator {

/// The interface with the structures that a file of that path holds, each without content: "Type";
/// "Type_Request", "Type_Response"; "Type_Goal", "Type_Result", "Type_Feedback".
[[nodiscard]] Interface empty_interface(const DefinitionPath& path);

/// Rules that do not depend on other files: names, repetitions, defaults. Throws DefinitionError.
void check_interface(const Interface& interface);

/// Adds to an action the structures of its services and topics, as ROS 2 derives them.
void add_action_structures(Interface& action);

}  // namespace pipescout::generator
