// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "pipescout/leak_store/leak_report.hpp"

/// The drawings of the report: SVG to stand in HTML.
namespace pipescout {

/// Pipes, the robot's track and the findings with their ellipses of 95 %; a sentence where no
/// finding has a position.
[[nodiscard]] std::string map_figure(const LeakReport& report);

/// As Figure 5 of Ibarguren et al. 2013: temperature along the pipe, the absolute value of its
/// change, and the parts that this divides it into.
[[nodiscard]] std::string profile_figure(const Evidence& evidence);

/// The thumbnail, pipe and leaks marked in it; `description` is for those who do not see it.
[[nodiscard]] std::string thumbnail_figure(const Thumbnail& thumbnail,
                                           const std::vector<OverlayLine>& pipes,
                                           const std::vector<OverlayLine>& leaks,
                                           const std::string& description);

}  // namespace pipescout
