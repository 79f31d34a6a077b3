// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "pipescout/rack_vision/rack_model.hpp"
#include "pipescout/simulation/rack_image.hpp"

/// What lies on racks in plants: flanges, lagging and the seams of its cladding, branches with
/// elbows, valves, a cable tray, and people beside the pipes whose shadows fall on them.
namespace pipescout::rack_study {

struct FittedRack {
  simulation::SceneBodies bodies;
  /// The rack file of someone who has measured them: flanges and lagging as radii, the tray and the
  /// valves as supports, hand wheels and risers as pipes. It has no seams and no branches.
  rack_vision::RackModel with_bodies;
};

/// Bodies as the seed draws them on each pipe along rack y, some 40 for four pipes of 10 m; the
/// tray lies to the right of the last one. `rack` must be valid, and be the true one. The same
/// arguments give the same bodies.
[[nodiscard]] FittedRack fit_out(const rack_vision::RackModel& rack, std::uint64_t seed);

/// Where people stand who walk to and fro along a walkway on each side of the pipes along rack y,
/// at 1 m/s: their feet, rack frame, m. One entry a person, of which every second one walks on the
/// right.
[[nodiscard]] std::vector<Eigen::Vector3d> people_beside(const rack_vision::RackModel& rack,
                                                         std::size_t people, double time);

}  // namespace pipescout::rack_study
