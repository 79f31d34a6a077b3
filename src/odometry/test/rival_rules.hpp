// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pipescout/odometry/consensus_fusion.hpp"

/// Other meanings of "supported by a group", which the study measures against the library's rules.
/// All use strong support only (r_ij = r_ji = 1), return an empty set when no two odometers support
/// each other, and expect usable readings.
namespace pipescout::odometry::test {

/// The largest set whose members all support each other: the maximum clique, exact. Of equally
/// large ones that share a member: the one with the smaller sum of confidence distances, then the
/// one with the lower indices. Empty when two of them share none: there is no reason for either.
[[nodiscard]] OdometerSet largest_mutual_group(const ConfidenceDistanceMatrix& confidence_distance,
                                               const RelationMatrix& relation);

/// The largest set that is linked by support, handed on from member to member: the largest
/// connected component. Empty when two are equally large.
[[nodiscard]] OdometerSet largest_connected_group(const RelationMatrix& relation);

}  // namespace pipescout::odometry::test
