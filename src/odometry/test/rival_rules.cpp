// SPDX-License-Identifier: Apache-2.0
#include "rival_rules.hpp"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

namespace pipescout::odometry::test {
namespace {

using Neighbours = std::array<OdometerSet, kMaxOdometers>;

Neighbours strong_neighbours(const RelationMatrix& relation) {
  Neighbours neighbours;
  for (Eigen::Index i = 0; i < relation.rows(); ++i) {
    for (Eigen::Index j = 0; j < relation.rows(); ++j) {
      neighbours[static_cast<std::size_t>(i)].set(
          static_cast<std::size_t>(j), i != j && relation(i, j) != 0 && relation(j, i) != 0);
    }
  }
  return neighbours;
}

OdometerSet all_of(const RelationMatrix& relation) {
  return OdometerSet((1UL << static_cast<std::size_t>(relation.rows())) - 1);
}

/// Bron and Kerbosch with a pivot: every set that cannot be extended, once.
void collect_maximal(const Neighbours& neighbours, OdometerSet chosen, OdometerSet candidates,
                     OdometerSet done, std::vector<OdometerSet>& found) {
  if (candidates.none() && done.none()) {
    found.push_back(chosen);
    return;
  }
  OdometerSet branches = candidates;
  for (std::size_t pivot = 0; pivot < kMaxOdometers; ++pivot) {
    const OdometerSet rest = candidates & ~neighbours[pivot];
    if ((candidates | done)[pivot] && rest.count() < branches.count()) {
      branches = rest;
    }
  }
  for (std::size_t next = 0; next < kMaxOdometers; ++next) {
    if (branches[next]) {
      collect_maximal(neighbours, OdometerSet(chosen).set(next), candidates & neighbours[next],
                      done & neighbours[next], found);
      candidates.reset(next);
      done.set(next);
    }
  }
}

double total_distance(const ConfidenceDistanceMatrix& distances, const OdometerSet& members) {
  double total = 0.0;
  for (Eigen::Index i = 0; i < distances.rows(); ++i) {
    for (Eigen::Index j = 0; j < distances.cols(); ++j) {
      if (members[static_cast<std::size_t>(i)] && members[static_cast<std::size_t>(j)]) {
        total += distances(i, j);
      }
    }
  }
  return total;
}

}  // namespace

OdometerSet largest_mutual_group(const ConfidenceDistanceMatrix& confidence_distance,
                                 const RelationMatrix& relation) {
  std::vector<OdometerSet> groups;
  collect_maximal(strong_neighbours(relation), {}, all_of(relation), {}, groups);
  std::size_t largest = 2;
  for (const auto& group : groups) {
    largest = std::max(largest, group.count());
  }
  std::erase_if(groups, [&](const OdometerSet& group) { return group.count() < largest; });
  OdometerSet best;
  double best_total = 0.0;
  for (const auto& group : groups) {
    for (const auto& rival : groups) {
      if ((group & rival).none()) {
        return {};
      }
    }
    const double total = total_distance(confidence_distance, group);
    if (best.none() ||
        std::pair(total, group.to_ulong()) < std::pair(best_total, best.to_ulong())) {
      best = group;
      best_total = total;
    }
  }
  return best;
}

OdometerSet largest_connected_group(const RelationMatrix& relation) {
  const Neighbours neighbours = strong_neighbours(relation);
  OdometerSet left = all_of(relation);
  OdometerSet best;
  bool unique = false;
  for (std::size_t start = 0; start < kMaxOdometers; ++start) {
    if (!left[start]) {
      continue;
    }
    OdometerSet group;
    OdometerSet reached = OdometerSet().set(start);
    while (group != reached) {
      group = reached;
      for (std::size_t i = 0; i < kMaxOdometers; ++i) {
        if (group[i]) {
          reached |= neighbours[i];
        }
      }
    }
    left &= ~group;
    if (group.count() >= best.count()) {
      unique = group.count() > best.count();
      best = group;
    }
  }
  return unique && best.count() >= 2 ? best : OdometerSet();
}

}  // namespace pipescout::odometry::test
