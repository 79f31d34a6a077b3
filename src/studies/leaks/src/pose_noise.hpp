// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pipescout/leak_study/sequence_run.hpp"
#include "pipescout/statistics/draw.hpp"

namespace pipescout::leak_study::internal {

/// A pose that drifts about the truth.
class PoseNoise {
 public:
  PoseNoise(const PoseErrors& errors, std::uint64_t seed);

  /// The pose at a time not before the last one's, s, with the covariance that it really has.
  [[nodiscard]] leak_findings::FramePose measure(const geometry::SE3& T_map_body, double time);
  /// What the mounting is taken for.
  [[nodiscard]] geometry::SE3 mounting(const geometry::SE3& T_body_camera);
  /// Where the row is taken to be, between two points of the tube.
  [[nodiscard]] leak_findings::PipeLine line(const Eigen::Vector3d& from,
                                             const Eigen::Vector3d& to);

 private:
  PoseErrors errors_;
  statistics::Draw draw_;
  double time_ = 0;
  bool started_ = false;
  Eigen::Vector3d position_ = Eigen::Vector3d::Zero();  // in deviations
  Eigen::Vector3d rotation_ = Eigen::Vector3d::Zero();  // in deviations
};

}  // namespace pipescout::leak_study::internal
