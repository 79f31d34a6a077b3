// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pipescout/estimation/factor.hpp>

/// Distance of an antenna from a beacon at a known position; `globals.own[0]` is its bias.
struct BeaconRange {
  static constexpr int kRows = 1;
  double stamp;             // s
  Eigen::Vector3d beacon;   // m, in the map
  Eigen::Vector3d antenna;  // m, in the body
  double range;             // m
  double deviation;         // m
  double time() const { return stamp; }
  Eigen::Matrix<double, 1, 1> evaluate(const pipescout::estimation::NavState& x,
                                       const pipescout::estimation::GlobalStates& globals,
                                       pipescout::estimation::Jacobians<1>* derivatives) const {
    using namespace pipescout::estimation;
    const Eigen::Vector3d away = x.position + x.R_map_body * antenna - beacon;
    if (derivatives != nullptr) {
      const Eigen::RowVector3d direction = away.normalized().transpose() / deviation;
      derivatives->from.middleCols<3>(kPosition) = direction;
      derivatives->from.middleCols<3>(kRotation) =
          -direction * x.R_map_body.matrix() * pipescout::geometry::skew(antenna);
      derivatives->globals(0, kOwnStates) = 1 / deviation;
    }
    return Eigen::Matrix<double, 1, 1>((away.norm() + globals.own[0] - range) / deviation);
  }
};
