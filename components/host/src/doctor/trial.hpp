// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/composition.hpp"
#include "doctor/observation.hpp"

namespace pipescout::host::doctor {

/// Makes and configures each component of a composition in this process, without a network and
/// without activating it, and adds to `seen` what came of it: failures, parameters that nobody
/// declares, and the nodes and endpoints of those that `seen.nodes` does not have as running
/// already. Writes into the composition's mission folder what components write when they are
/// configured.
void try_composition(const Composition& composition, Observation& seen);

}  // namespace pipescout::host::doctor
