// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

namespace pipescout::testing {

/// Bytes that the whole program has asked `operator new` for so far. Linking this replaces the
/// global operator.
std::size_t allocated_bytes();

}  // namespace pipescout::testing
