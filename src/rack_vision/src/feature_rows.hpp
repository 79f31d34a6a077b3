// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "feature_system.hpp"

/// From the rows of one feature to the normal equations. Internal to FeatureSystem.
namespace pipescout::rack_vision {

/// Derivative of image coordinates with respect to pose, one offset and, with 10 columns,
/// intrinsics.
template <int kRows, int kColumns>
using Rows = Eigen::Matrix<double, kRows, kColumns>;
inline constexpr int kOffsetColumn = kPoseUnknowns;
inline constexpr int kWithoutIntrinsics = kPoseUnknowns + 1;
inline constexpr int kWithIntrinsics = kWithoutIntrinsics + kIntrinsicUnknowns;

/// Adds derivative^T information derivative to the system, derivative^T gradient to its gradient.
/// For 2 and 3 rows, and for 7 and 10 columns.
template <int kRows, int kColumns>
void scatter(const Rows<kRows, kColumns>& derivative,
             const Eigen::Matrix<double, kRows, kRows>& information,
             const Eigen::Matrix<double, kRows, 1>& gradient, int offset,
             const UnknownLayout& layout, SystemMatrix& system, SystemVector& system_gradient);

}  // namespace pipescout::rack_vision
