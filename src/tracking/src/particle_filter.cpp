// SPDX-License-Identifier: Apache-2.0
#include "pipescout/tracking/particle_filter_definition.hpp"

namespace pipescout::tracking {

template class ParticleFilter<PipeShape>;
template class ParticleFilter<ValveShape>;
template class ParticleFilter<VesselShape>;
template struct ParticleFilterParameters<PipeShape>;
template struct ParticleFilterParameters<ValveShape>;
template struct ParticleFilterParameters<VesselShape>;

}  // namespace pipescout::tracking
