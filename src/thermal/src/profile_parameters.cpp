// SPDX-License-Identifier: Apache-2.0
#include "pipescout/thermal/pipe_profile.hpp"
#include "pipescout/validation/check.hpp"

namespace pipescout::thermal {

using validation::refuse;
using validation::require;

std::string_view to_string(PartKind kind) noexcept {
  switch (kind) {
    case PartKind::kPipe:
      return "pipe";
    case PartKind::kLeak:
      return "leak";
    case PartKind::kShort:
      return "short";
    case PartKind::kHidden:
      return "hidden";
    case PartKind::kNotThisPipe:
      return "not_this_pipe";
  }
  return "unknown";
}

ProfileParameters ProfileParameters::torresol() {
  ProfileParameters p;
  p.split_delta = 70.0;
  p.split_distance = 1;
  p.split_creeping = false;
  p.leak_delta.reset();
  p.maximum_temperature = 165.0;
  return p;
}

void ProfileParameters::validate() const {
  require("split_delta", split_delta, split_delta > 0, "(0, inf) K");
  require("split_distance", split_distance, split_distance >= 1 && split_distance <= 64,
          "[1, 64] samples");
  require("min_part_width", min_part_width, min_part_width >= 1, "[1, inf) samples");
  require("min_part_width_m", min_part_width_m, min_part_width_m >= 0, "[0, inf) m");
  if (leak_delta) {
    require("leak_delta", *leak_delta, *leak_delta > 0, "(0, inf) K");
  }
  if (maximum_temperature) {
    require("maximum_temperature", *maximum_temperature, *maximum_temperature > -273.15,
            "(-273.15, inf) degC");
  }
  if (!leak_delta && !maximum_temperature) {
    refuse("leak_delta: is not set, nor is maximum_temperature: no leak could be detected");
  }
  require("leak_spreads", leak_spreads, leak_spreads >= 0, "[0, inf)");
  require("leak_share", leak_share, leak_share >= 0, "[0, inf)");
  require("reference_quantile", reference_quantile,
          reference_quantile > 0 && reference_quantile < 1, "(0, 1)");
}

}  // namespace pipescout::thermal
