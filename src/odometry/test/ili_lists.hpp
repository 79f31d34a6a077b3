// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace pipescout::odometry::test {

/// One row of an inspection's list of features.
struct ListedFeature {
  double chainage = 0.0;  // m, the run's own odometer
  std::string kind;       // lower case: "bend", "tap", ...
  std::string clock;      // o'clock position as printed, may be empty
  std::string comment;    // of a bend: "5.8D - 45° - Right"
  std::string key;        // number of the girth weld upstream of it: answer key, for scoring only
};

struct ListedWeld {
  double chainage = 0.0;  // m
  std::string key;        // joint number: answer key, for scoring only
};

struct InspectionList {
  std::vector<ListedWeld> welds;
  std::vector<ListedFeature> features;  // all others
};

/// The two runs of the 17.5 km pipeline below the folder that PIPESCOUT_SHARED_DATA names; nothing
/// when the variable or the files are not there.
struct InspectionRuns {
  InspectionList run_2007;
  InspectionList run_2015;
};
std::optional<InspectionRuns> load_inspection_runs();

}  // namespace pipescout::odometry::test
