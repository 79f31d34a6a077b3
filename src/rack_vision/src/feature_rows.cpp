// SPDX-License-Identifier: Apache-2.0
#include "feature_rows.hpp"

namespace pipescout::rack_vision {

template <int kRows, int kColumns>
void scatter(const Rows<kRows, kColumns>& derivative,
             const Eigen::Matrix<double, kRows, kRows>& information,
             const Eigen::Matrix<double, kRows, 1>& gradient, int offset,
             const UnknownLayout& layout, SystemMatrix& system, SystemVector& system_gradient) {
  // Products of this size are faster without Eigen's blocking.
  const Rows<kRows, kColumns> weighted = information.lazyProduct(derivative);
  const auto pose = derivative.template leftCols<6>();
  const auto weighted_pose = weighted.template leftCols<6>();
  system.topLeftCorner<6, 6>() += pose.transpose().lazyProduct(weighted_pose);
  system_gradient.head<6>() += pose.transpose().lazyProduct(gradient);
  const auto by_offset = derivative.col(kOffsetColumn);
  const auto weighted_offset = weighted.col(kOffsetColumn);
  if (offset >= 0) {
    system.block<6, 1>(0, offset) += pose.transpose().lazyProduct(weighted_offset);
    system.block<1, 6>(offset, 0) += by_offset.transpose().lazyProduct(weighted_pose);
    system(offset, offset) += by_offset.dot(weighted_offset);
    system_gradient(offset) += by_offset.dot(gradient);
  }
  if constexpr (kColumns == kWithIntrinsics) {
    const int k = layout.intrinsics;
    const auto by_intrinsics = derivative.template rightCols<3>();
    const auto weighted_intrinsics = weighted.template rightCols<3>();
    system.block<6, 3>(0, k) += pose.transpose().lazyProduct(weighted_intrinsics);
    system.block<3, 6>(k, 0) += by_intrinsics.transpose().lazyProduct(weighted_pose);
    system.block<3, 3>(k, k) += by_intrinsics.transpose().lazyProduct(weighted_intrinsics);
    system_gradient.segment<3>(k) += by_intrinsics.transpose().lazyProduct(gradient);
    if (offset >= 0) {
      system.block<3, 1>(k, offset) += by_intrinsics.transpose().lazyProduct(weighted_offset);
      system.block<1, 3>(offset, k) += by_offset.transpose().lazyProduct(weighted_intrinsics);
    }
  }
}

template void scatter<2, kWithoutIntrinsics>(const Rows<2, kWithoutIntrinsics>&,
                                             const Eigen::Matrix<double, 2, 2>&,
                                             const Eigen::Matrix<double, 2, 1>&, int,
                                             const UnknownLayout&, SystemMatrix&, SystemVector&);
template void scatter<2, kWithIntrinsics>(const Rows<2, kWithIntrinsics>&,
                                          const Eigen::Matrix<double, 2, 2>&,
                                          const Eigen::Matrix<double, 2, 1>&, int,
                                          const UnknownLayout&, SystemMatrix&, SystemVector&);
template void scatter<3, kWithoutIntrinsics>(const Rows<3, kWithoutIntrinsics>&,
                                             const Eigen::Matrix<double, 3, 3>&,
                                             const Eigen::Matrix<double, 3, 1>&, int,
                                             const UnknownLayout&, SystemMatrix&, SystemVector&);
template void scatter<3, kWithIntrinsics>(const Rows<3, kWithIntrinsics>&,
                                          const Eigen::Matrix<double, 3, 3>&,
                                          const Eigen::Matrix<double, 3, 1>&, int,
                                          const UnknownLayout&, SystemMatrix&, SystemVector&);

}  // namespace pipescout::rack_vision
