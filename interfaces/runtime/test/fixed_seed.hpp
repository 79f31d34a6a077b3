// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdlib>

/// Include this in a test with RapidCheck properties: they then run from a fixed seed. RapidCheck
/// takes its seed from the environment, when the first property runs, and from the entropy of the
/// system otherwise. A seed that the user gives in RC_PARAMS counts.
inline const int kSeedIsFixed = setenv("RC_PARAMS", "seed=20221117", /*overwrite=*/0);
