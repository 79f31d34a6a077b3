// SPDX-License-Identifier: Apache-2.0
#include "pipescout/tracking/shapes.hpp"

#include "pipescout/validation/check.hpp"

namespace pipescout::tracking {
namespace {

static_assert(TrackableShape<PipeShape> && TrackableShape<ValveShape> &&
              TrackableShape<VesselShape>);

void require_weight(const char* field, double value) {
  validation::require(field, value, value > 0, "(0, inf)");
}

}  // namespace

void PipeShape::validate() const {
  require_weight("lambda", lambda);
  require_weight("beta", beta);
  require_weight("gamma", gamma);
  require_weight("edge_deviation", edge_deviation);
  require_weight("end_deviation", end_deviation);
  validation::require("border", border, border >= 0, "[0, inf)");
  validation::check_within("least_piece", least_piece, 0, 0.5);
}

void ValveShape::validate() const {
  require_weight("lambda", lambda);
  require_weight("beta", beta);
  require_weight("edge_deviation", edge_deviation);
}

void VesselShape::validate() const {
  require_weight("lambda", lambda);
  require_weight("beta", beta);
  require_weight("gamma", gamma);
  require_weight("edge_deviation", edge_deviation);
}

}  // namespace pipescout::tracking
