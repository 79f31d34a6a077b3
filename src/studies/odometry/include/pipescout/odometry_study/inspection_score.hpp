// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "pipescout/odometry/weld_alignment.hpp"

/// Two real inspection runs of one pipeline, years apart, by different tools, each a list of
/// features by the tool's own odometer. The joint numbers in the lists agree: they are the ground
/// truth of the alignment and are used for the score only. Pure functions, metres.
namespace pipescout::odometry_study {

struct ListedWeld {
  double chainage = 0.0;  ///< m, by the run's odometer
  std::string key;        ///< joint number
};

struct ListedFeature {
  double chainage = 0.0;
  std::string kind;     ///< lower case: "bend", "tap", ...
  std::string clock;    ///< o'clock as printed, may be empty
  std::string comment;  ///< of a bend: "5.8D - 45° - Right"
  std::string key;      ///< joint number of the girth weld above it in the list; empty before any
};

struct InspectionList {
  std::vector<ListedWeld> welds;
  std::vector<ListedFeature> features;  ///< all others
};

/// Names of the columns of such a list, distances in feet.
struct ListColumns {
  std::string_view key;
  std::string_view chainage;
  std::string_view kind;
  std::string_view clock;
  std::string_view comment;
};
inline constexpr ListColumns kColumns2007{"J. no.", "log dist. [ft]", "event", "o'clock",
                                          "comment"};
inline constexpr ListColumns kColumns2015{"J. no.", "Log Dist. [ft]", "Event Description",
                                          "O'clock", "Comments"};

/// From CSV text; `name` is that of the file. Throws std::runtime_error "name:line: what" for a
/// missing column, a distance that is not a number and a list without girth welds.
[[nodiscard]] InspectionList read_inspection_list(std::string_view text, const ListColumns& columns,
                                                  std::string_view name);

/// For an alignment: the lists print hundredths of a foot and give no uncertainty, so 0.03 m.
[[nodiscard]] std::vector<odometry::WeldPosition> weld_positions(const InspectionList& list);

/// Chainages in both lists of the features that the answer key proves to be one: same kind, same
/// o'clock (of a bend: same direction), same joint number, and the same number of such features in
/// that joint in both runs (then in order). No distance enters, so that nothing hides an error.
/// Kinds are those that stay where they are for years; markers above ground are put down anew for
/// each run, and metal loss grows and is split differently.
[[nodiscard]] std::vector<std::pair<double, double>> common_features(const InspectionList& then,
                                                                     const InspectionList& later);

struct InspectionScore {
  std::size_t common = 0;              ///< welds of both runs
  std::size_t right = 0;               ///< matched with each other
  std::size_t wrong = 0;               ///< matches of two welds
  std::vector<double> feature_errors;  ///< m, absolute, of the common features after alignment
  std::vector<double> unaligned;       ///< m, how far apart the odometers have them
};

/// Of `align_welds` with its default parameters.
[[nodiscard]] InspectionScore score_inspection(const InspectionList& then,
                                               const InspectionList& later);

}  // namespace pipescout::odometry_study
