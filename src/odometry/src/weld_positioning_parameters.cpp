// SPDX-License-Identifier: Apache-2.0
#include "pipescout/odometry/weld_positioning.hpp"
#include "pipescout/validation/check.hpp"

namespace pipescout::odometry {

using validation::refuse;
using validation::require;

void WeldPositioningParameters::validate() const {
  const auto within = [](const char* field, double value, double low, double high,
                         const char* range) {
    require(field, value, value >= low && value <= high, range);
  };
  const auto probability = [](const char* field, double value) {
    require(field, value, value > 0.0 && value <= 0.5, "(0, 0.5]");
  };
  const auto positive = [](const char* field, double value) {
    require(field, value, value > 0.0, "(0, inf)");
  };
  probability("missed_probability", missed_probability);
  probability("spurious_probability", spurious_probability);
  probability("missed_bend_probability", missed_bend_probability);
  probability("spurious_bend_probability", spurious_bend_probability);
  require("initial_scale", initial_scale, initial_scale > 0.5 && initial_scale < 2.0, "(0.5, 2)");
  require("initial_scale_standard_deviation", initial_scale_standard_deviation,
          initial_scale_standard_deviation > 0.0 && initial_scale_standard_deviation <= 0.2,
          "(0, 0.2]");
  within("scale_drift", scale_drift, 0.0, 1e-4, "[0, 1e-4]");
  probability("double_slip_probability", double_slip_probability);
  require("largest_double_slip", largest_double_slip,
          largest_double_slip > 0.0 && largest_double_slip <= 1.0, "(0, 1]");
  within("bend_fault_probability", bend_fault_probability, 0.0, 0.4, "[0, 0.4]");
  positive("largest_bend_fault", largest_bend_fault);
  positive("largest_increment", largest_increment);
  require("bad_increment_standard_deviation", bad_increment_standard_deviation,
          bad_increment_standard_deviation >= 0.0, "[0, inf)");
  within("noise_adaptation", noise_adaptation, 0.0, 0.2, "[0, 0.2]");
  probability("tally_error_probability", tally_error_probability);
  require("first_weld_chainage", first_weld_chainage, true, "(-inf, inf)");
  positive("standard_joint.length", standard_joint.length);
  require("standard_joint.standard_deviation", standard_joint.standard_deviation,
          standard_joint.standard_deviation >= 0.0, "[0, inf)");
  if (largest_joint_count < 1 || largest_joint_count > 1'000'000) {
    refuse("largest_joint_count: ", largest_joint_count, " is outside [1, 1000000]");
  }
  if (largest_hypothesis_count < 8 || largest_hypothesis_count > 1'000'000) {
    refuse("largest_hypothesis_count: ", largest_hypothesis_count, " is outside [8, 1000000]");
  }
  require("prune_ratio", prune_ratio, prune_ratio > 0.0 && prune_ratio <= 0.01, "(0, 0.01]");
  within("gate", gate, 3.0, 10.0, "[3, 10]");
  require("lock_probability", lock_probability, lock_probability > 0.5 && lock_probability < 1.0,
          "(0.5, 1)");
  require("unlock_probability", unlock_probability,
          unlock_probability > 0.0 && unlock_probability <= lock_probability,
          "(0, lock_probability]");
  if (lock_welds < 1) {
    refuse("lock_welds: ", lock_welds, " is outside [1, inf)");
  }
  positive("lock_standard_deviation", lock_standard_deviation);
}

const char* to_string(PositioningStatus status) noexcept {
  switch (status) {
    case PositioningStatus::kAccepted:
      return "accepted";
    case PositioningStatus::kBadValue:
      return "bad value";
    case PositioningStatus::kOutOfOrder:
      return "out of order";
  }
  return "unknown";
}

const char* to_string(Orientation orientation) noexcept {
  switch (orientation) {
    case Orientation::kForward:
      return "forward";
    case Orientation::kBackward:
      return "backward";
    case Orientation::kUnknown:
      break;
  }
  return "unknown";
}

}  // namespace pipescout::odometry
