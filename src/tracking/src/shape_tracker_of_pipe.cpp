// SPDX-License-Identifier: Apache-2.0
#include "pipescout/tracking/shape_tracker_definition.hpp"

namespace pipescout::tracking {

template class ShapeKalman<PipeShape>;
template struct ShapeTrackerParameters<PipeShape>;
template class ShapeTracker<PipeShape>;

}  // namespace pipescout::tracking
