// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "pipescout/odometry/weld_detector.hpp"
#include "weld_detector_state.hpp"

namespace pipescout::odometry {
namespace {

void check(const char* field, double value, double low, double high) {
  if (!(value >= low && value <= high)) {
    std::ostringstream message;
    message << field << ": " << value << " is outside [" << low << ", " << high << "]";
    throw std::invalid_argument(message.str());
  }
}

}  // namespace

void WeldDetectorParameters::validate() const {
  check("channels", static_cast<double>(channels), 1.0,
        static_cast<double>(kMaxEddyCurrentChannels));
  check("smallest_width", smallest_width, 1e-4, 1.0);
  check("largest_width", largest_width, smallest_width, 1.0);
  // From below by what the memory would be.
  check("cell", cell, std::max(largest_width / 1000.0, warm_up / 1e5), smallest_width / 4.0);
  check("width_tolerance", width_tolerance, 1.0, 3.0);
  check("false_alarms_per_km", false_alarms_per_km, 1e-12, 1000.0);
  check("smallest_match", smallest_match, 0.0, 0.999);
  check("largest_asymmetry", largest_asymmetry, 0.0, 1.0);
  check("largest_neighbour", largest_neighbour, 1e-6, 1.0);
  check("crowd_distance", crowd_distance, 0.0, 5.0);
  check("phase", phase, -1e3, 1e3);
  check("phase_tolerance", phase_tolerance, 0.0, std::numbers::pi);
  check("background_length", background_length, 1.0, 1000.0);
  check("warm_up", warm_up, 0.5, 100.0);
  check("noise_floor", noise_floor, 1e-100, 1e100);
  check("standing_after", static_cast<double>(standing_after), 32.0, 1e9);
  check("position_floor", position_floor, 0.0, 1.0);
  check("largest_step", largest_step, cell, 100.0);
  check("largest_jump", largest_jump, largest_step, 1e6);
  check("turn_distance", turn_distance, 0.1, 100.0);
  check("joint_length", joint_length, 0.1, 1000.0);
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
