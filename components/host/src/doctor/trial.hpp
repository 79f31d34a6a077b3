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
///
/// Each component is made and configured on a thread of its own. One that takes longer than
/// `patience` is a failure, its thread is left behind, and the next component is tried; since that
/// thread may still run when the program ends, the program then ends without destroying its static
/// objects.
void try_composition(const Composition& composition, Duration patience, Observation& seen);

}  // namespace pipescout::host::doctor
