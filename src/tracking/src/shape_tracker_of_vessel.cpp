// SPDX-License-Identifier: Apache-2.0
#include "pipescout/tracking/shape_tracker_definition.hpp"

namespace pipescout::tracking {

template class ShapeKalman<VesselShape>;
template struct ShapeTrackerParameters<VesselShape>;
template class ShapeTracker<VesselShape>;

}  // namespace pipescout::tracking
