// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "pipescout/geometry/geodesy.hpp"
#include "pipescout/leak_findings/finding.hpp"
#include "pipescout/leak_findings/leak_findings.hpp"
#include "pipescout/leak_store/evidence.hpp"
#include "pipescout/leak_store/leak_store.hpp"

namespace pipescout {

struct ReportedFinding {
  leak_findings::Finding finding;
  std::optional<Evidence> evidence;
};

/// Result of one image.
struct ReportedPicture {
  std::string name;
  std::string
      problem;  ///< why there are no detections, or why they do not update findings; may be empty
  std::string summary;  ///< kind, size, temperatures, pipes
  std::string doubts;   ///< one per line
  std::optional<Overview> overview;
};

struct LeakReport {
  std::string title;
  std::string made;  ///< time and program
  std::vector<ReportedFinding> findings;
  std::vector<leak_findings::PipeLine> pipes;  ///< in the map, if known
  std::vector<Eigen::Vector2d> track;          ///< m, of the robot in the map
  std::optional<geometry::GeodeticPosition> datum;
  std::vector<ConditionRecord> conditions;
  std::string degrees;  ///< how sure they are; may be empty. Of degrees_text
  std::size_t pictures_read = 0;
  std::size_t pictures_failed = 0;
  std::vector<ReportedPicture> pictures;  ///< all, or those worth showing
};

/// How sure degrees are that were found by contrast: emissivity, reflected temperature and pipe
/// with their 95 % intervals. `posterior`: null without. `levels`: images of automatic gain, which
/// have none. Empty where neither.
[[nodiscard]] std::string degrees_text(const thermal::RadiometryPosterior* posterior, bool levels);

/// One self-contained page of HTML: no scripts, no links to other files. A map, a table by
/// severity, each finding with its image and its profile as in Figure 5 of Ibarguren et al. 2013,
/// the log of conditions and the images. Texts are escaped. Pure.
[[nodiscard]] std::string leak_report_html(const LeakReport& report);

}  // namespace pipescout
