// SPDX-License-Identifier: Apache-2.0
#include "pipescout/validation/check.hpp"

#include <cmath>

namespace pipescout::validation {

void require(const Field& field, double value, bool in_range, std::string_view range) {
  if (!in_range || !std::isfinite(value)) {
    refuse(field.prefix, field.name, ": ", value, " is outside ", range);
  }
}

void check_within(const Field& field, double value, double low, double high) {
  if (!(value >= low && value <= high && std::isfinite(value))) {
    refuse(field.prefix, field.name, ": ", value, " is outside [", low, ", ", high, "]");
  }
}

void check_above(const Field& field, double value, double low, double high) {
  if (!(value > low && value <= high && std::isfinite(value))) {
    refuse(field.prefix, field.name, ": ", value, " is outside (", low, ", ", high, "]");
  }
}

void check_between(const Field& field, double value, double low, double high) {
  if (!(value > low && value < high && std::isfinite(value))) {
    refuse(field.prefix, field.name, ": ", value, " is outside (", low, ", ", high, ")");
  }
}

}  // namespace pipescout::validation
