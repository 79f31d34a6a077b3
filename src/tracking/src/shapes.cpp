// SPDX-License-Identifier: Apache-2.0
#include "pipescout/tracking/shapes.hpp"

#include <cmath>
#include <stdexcept>
#include <string>

namespace pipescout::tracking {
namespace {

static_assert(TrackableShape<PipeShape> && TrackableShape<ValveShape> &&
              TrackableShape<VesselShape>);

void require_weight(const char* field, double value) {
  if (!(value > 0) || !std::isfinite(value)) {
    throw std::invalid_argument(std::string(field) + " is " + std::to_string(value) +
                                ": must be above 0 and finite");
  }
}

}  // namespace

void PipeShape::validate() const {
  require_weight("lambda", lambda);
  require_weight("beta", beta);
  require_weight("gamma", gamma);
  require_weight("edge_deviation", edge_deviation);
  require_weight("end_deviation", end_deviation);
  if (!(border >= 0) || !std::isfinite(border)) {
    throw std::invalid_argument("border is " + std::to_string(border) +
                                ": must be at least 0 and finite");
  }
  if (!(least_piece >= 0 && least_piece <= 0.5)) {
    throw std::invalid_argument("least_piece is " + std::to_string(least_piece) +
                                ": must be in [0, 0.5]");
  }
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
