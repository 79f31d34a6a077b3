// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "doctor/observation.hpp"

namespace pipescout::host::doctor {

/// This machine, as a recording to `folder` would meet it.
[[nodiscard]] Machine look_at_machine(const std::filesystem::path& folder);

}  // namespace pipescout::host::doctor
