// SPDX-License-Identifier: Apache-2.0
#include "pipescout/leak_findings/leak_findings.hpp"
#include "pipescout/validation/check.hpp"

namespace pipescout::leak_findings {
namespace {

using validation::refuse;
using validation::require;

void require_positive(const char* field, double value, const char* unit_range) {
  require(field, value, value > 0, unit_range);
}

void require_not_negative(const char* field, double value, const char* unit_range) {
  require(field, value, value >= 0, unit_range);
}

}  // namespace

void LeakFindingsParameters::validate() const {
  require_not_negative("mounting_attitude_deviation", mounting_attitude_deviation, "[0, inf) rad");
  require_not_negative("mounting_position_deviation", mounting_position_deviation, "[0, inf) m");
  require_positive("distance", distance, "(0, inf) m");
  require_positive("distance_deviation", distance_deviation, "(0, inf) m");
  require_positive("pipe_diameter", pipe_diameter, "(0, inf) m");
  require("width_deviation", width_deviation, width_deviation > 0 && width_deviation < 1, "(0, 1)");
  if (range_source == RangeSource::kLine && lines.empty()) {
    refuse("lines: is empty, but range_source says that the pipes are known");
  }
  for (const PipeLine& line : lines) {
    const double length = (line.to - line.from).norm();
    require("lines, length", length, length > 1e-3, "(0.001, inf) m");
    require_not_negative("lines, radius", line.radius, "[0, inf) m");
  }
  require_positive("line_deviation", line_deviation, "(0, inf) m");
  require_positive("max_range_deviation", max_range_deviation, "(0, inf) m");
  require_positive("pixel_deviation", pixel_deviation, "(0, inf) pixels");
  require_not_negative("attitude_jitter", attitude_jitter, "[0, inf) rad");
  require_not_negative("position_jitter", position_jitter, "[0, inf) m");
  require_positive("pose_correlation_time", pose_correlation_time, "(0, inf) s");
  require_not_negative("extent_deviation", extent_deviation, "[0, inf) m");
  require_positive("hidden_length_deviation", hidden_length_deviation, "(0, inf) m");
  require_not_negative("delta_deviation", delta_deviation, "[0, inf) K");
  require("prior_probability", prior_probability, prior_probability > 0 && prior_probability < 1,
          "(0, 1)");
  require("detection_probability", detection_probability,
          detection_probability > 0 && detection_probability < 1, "(0, 1)");
  require("clutter_probability", clutter_probability,
          clutter_probability > 0 && clutter_probability < detection_probability,
          "(0, detection_probability)");
  require("raise_probability", raise_probability,
          raise_probability > prior_probability && raise_probability < 1, "(prior_probability, 1)");
  require("clear_probability", clear_probability,
          clear_probability > 0 && clear_probability < raise_probability, "(0, raise_probability)");
  require_positive("gate", gate, "(0, inf)");
  require_not_negative("extent_slack", extent_slack, "[0, inf) m");
  require_positive("pass_gap", pass_gap, "(0, inf) s");
  require_not_negative("update_interval", update_interval, "[0, inf) s");
  require("max_candidates", static_cast<double>(max_candidates), max_candidates >= 1, "[1, inf)");
  require("max_findings", static_cast<double>(max_findings), max_findings >= 1, "[1, inf)");
  require("max_passes", static_cast<double>(max_passes), max_passes >= 2, "[2, inf)");
  severity.validate();
}

}  // namespace pipescout::leak_findings
