// SPDX-License-Identifier: Apache-2.0
// A program outside of the project that uses an algorithm package alone: no middleware anywhere.
#include <array>
#include <cmath>
#include <iostream>

#include "pipescout/odometry/consensus_fusion.hpp"

int main() {
  using namespace pipescout::odometry;
  const ConsensusFusion fusion(ConsensusFusionParameters{.offsets = {0.18, 0.155, 0.165}});
  const std::array<OdometerReading, 3> readings{{{.distance = 5.45, .standard_deviation = 0.06},
                                                 {.distance = 5.34, .standard_deviation = 0.055},
                                                 {.distance = 5.36, .standard_deviation = 0.056}}};
  const ConsensusFusionResult result = fusion.fuse(readings);
  std::cout << result.fused.distance << " m from " << result.fusion_set << '\n';
  return result.status == FusionStatus::kOk && std::abs(result.fused.distance - 5.51) < 0.006 ? 0
                                                                                              : 1;
}
