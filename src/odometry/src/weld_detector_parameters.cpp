// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "pipescout/odometry/weld_detector.hpp"
#include "pipescout/validation/check.hpp"
#include "weld_detector_state.hpp"

namespace pipescout::odometry {
namespace {}  // namespace

void WeldDetectorParameters::validate() const {
  validation::check_within("channels", static_cast<double>(channels), 1.0,
                           static_cast<double>(kMaxEddyCurrentChannels));
  validation::check_within("smallest_width", smallest_width, 1e-4, 1.0);
  validation::check_within("largest_width", largest_width, smallest_width, 1.0);
  // From below by what the memory would be.
  validation::check_within("cell", cell, std::max(largest_width / 1000.0, warm_up / 1e5),
                           smallest_width / 4.0);
  validation::check_within("width_tolerance", width_tolerance, 1.0, 3.0);
  validation::check_within("false_alarms_per_km", false_alarms_per_km, 1e-12, 1000.0);
  validation::check_within("smallest_match", smallest_match, 0.0, 0.999);
  validation::check_within("largest_asymmetry", largest_asymmetry, 0.0, 1.0);
  validation::check_within("largest_neighbour", largest_neighbour, 1e-6, 1.0);
  validation::check_within("crowd_distance", crowd_distance, 0.0, 5.0);
  validation::check_within("phase", phase, -1e3, 1e3);
  validation::check_within("phase_tolerance", phase_tolerance, 0.0, std::numbers::pi);
  validation::check_within("background_length", background_length, 1.0, 1000.0);
  validation::check_within("warm_up", warm_up, 0.5, 100.0);
  validation::check_within("noise_floor", noise_floor, 1e-100, 1e100);
  validation::check_within("standing_after", static_cast<double>(standing_after), 32.0, 1e9);
  validation::check_within("position_floor", position_floor, 0.0, 1.0);
  validation::check_within("largest_step", largest_step, cell, 100.0);
  validation::check_within("largest_jump", largest_jump, largest_step, 1e6);
  validation::check_within("turn_distance", turn_distance, 0.1, 100.0);
  validation::check_within("joint_length", joint_length, 0.1, 1000.0);
}

std::vector<WeldFilter> weld_filters(const WeldDetectorParameters& p) {
  p.validate();
  const double smallest = p.smallest_width / 2.0 / p.cell;
  const double largest = p.largest_width / 2.0 / p.cell;
  return make_weld_filters(smallest, largest, weld_filter_count(smallest, largest));
}

double weld_false_alarms_per_km(const WeldDetectorParameters& parameters, double threshold) {
  return false_alarms_per_cell(weld_filters(parameters), parameters.channels, threshold) * 1000.0 /
         parameters.cell;
}

double weld_threshold(const WeldDetectorParameters& parameters) {
  const auto filters = weld_filters(parameters);
  const double wanted = parameters.false_alarms_per_km * parameters.cell / 1000.0;
  // The rate falls from its maximum at C - 1/2 on.
  double low = static_cast<double>(parameters.channels);
  double high = 1000.0;
  for (int i = 0; i < 60; ++i) {
    const double middle = (low + high) / 2.0;
    const bool too_many = false_alarms_per_cell(filters, parameters.channels, middle) > wanted;
    (too_many ? low : high) = middle;
  }
  return high;
}

}  // namespace pipescout::odometry
