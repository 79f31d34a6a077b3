// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <urdf_model/model.h>
#include <urdf_world/types.h>

#include <string_view>

namespace pipescout::manipulation::internal {

/// Throws std::invalid_argument with what the parser says when the text is no robot description.
/// Thread-safe.
[[nodiscard]] urdf::ModelInterfaceSharedPtr parse_urdf(std::string_view text);

}  // namespace pipescout::manipulation::internal
