// SPDX-License-Identifier: Apache-2.0
#include "pipescout/tracking/shapes.hpp"

#include <cmath>
#include <stdexcept>
#include <string>

namespace pipescout::tracking {
namespace {

static_assert(ShapeModel<PipeShape> && ShapeModel<ValveShape> && ShapeModel<VesselShape>);

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
}

void ValveShape::validate() const {
  require_weight("lambda", lambda);
  require_weight("beta", beta);
}

void VesselShape::validate() const {
  require_weight("lambda", lambda);
  require_weight("beta", beta);
  require_weight("gamma", gamma);
}

}  // namespace pipescout::tracking
