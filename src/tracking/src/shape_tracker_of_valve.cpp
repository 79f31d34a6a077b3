// SPDX-License-Identifier: Apache-2.0
#include "pipescout/tracking/shape_tracker_definition.hpp"

namespace pipescout::tracking {

template class ShapeKalman<ValveShape>;
template struct ShapeTrackerParameters<ValveShape>;
template class ShapeTracker<ValveShape>;

}  // namespace pipescout::tracking
