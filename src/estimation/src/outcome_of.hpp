// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pipescout/estimation/fixed_lag_smoother.hpp"

namespace pipescout::estimation {

/// What becomes of a measurement with such a fault; of one without it is waiting.
inline Outcome outcome_of(InputFault fault) {
  switch (fault) {
    case InputFault::kNone:
      break;
    case InputFault::kNotFinite:
      return Outcome::kNotFinite;
    case InputFault::kBadCovariance:
      return Outcome::kBadCovariance;
    case InputFault::kBadInterval:
      return Outcome::kBadInterval;
    case InputFault::kBadDirection:
      return Outcome::kBadDirection;
  }
  return Outcome::kWaiting;
}

}  // namespace pipescout::estimation
