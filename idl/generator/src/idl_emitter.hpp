// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "definitions.hpp"
#include "model.hpp"

namespace pipescout::generator {

/// One .idl file with all structures of these interfaces and those that they use, each behind what
/// it uses: for the compilers of other vendors, which would meet a file that two others include
/// twice. Constants and defaults, which are not on the wire, are left out, and words of IDL 4.2 get
/// the underscore that such compilers want.
[[nodiscard]] std::string merged_idl(const std::vector<const Interface*>& interfaces,
                                     const Definitions& definitions);

}  // namespace pipescout::generator
