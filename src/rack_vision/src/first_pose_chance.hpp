// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "first_pose_evidence.hpp"
#include "pipescout/geometry/camera.hpp"

namespace pipescout::rack_vision::internal {

/// How many poses as good as this one are to be expected among as many lines without order: the
/// assignments of three lines, times the probability that so many of the other contours meet a line
/// by chance (the a-contrario principle of Desolneux, Moisan and Morel, "Meaningful alignments",
/// 2000). `rms`: distance of lines from contours, pixels. Not checked: three contours at least.
[[nodiscard]] double false_alarms(const Evidence& evidence, std::size_t lines, std::size_t pipes,
                                  double rms, const geometry::Camera& camera);

}  // namespace pipescout::rack_vision::internal
