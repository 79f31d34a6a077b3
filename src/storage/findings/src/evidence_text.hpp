// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "pipescout/leak_store/evidence.hpp"

namespace pipescout {

/// All of the evidence but time, source and the thumbnail's PNG, as JSON.
[[nodiscard]] std::string evidence_details(const Evidence& evidence);
/// False for another text.
[[nodiscard]] bool read_evidence_details(const std::string& text, Evidence& evidence);

}  // namespace pipescout
