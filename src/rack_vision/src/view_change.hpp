// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pipescout/geometry/se3.hpp"

namespace pipescout::rack_vision {

/// Counts views. What misleads an image, shading and paint, misleads all of the same view alike:
/// they tell no more than one of them, however many there are.
class ViewChange {
 public:
  /// Begins to count with this pose at `stamp`, s.
  void begin(const geometry::SE3& T_rack_camera, double stamp);
  /// Of a view, the share that this image tells and none before it did, in [0, 1]. Stamps ascend.
  double see(const geometry::SE3& T_rack_camera, double stamp);
  /// Of all that was seen since `begin`.
  [[nodiscard]] double views() const noexcept { return views_; }

 private:
  void take(const geometry::SE3& T_rack_camera, double stamp);

  geometry::SE3 from_{};
  double since_ = 0;  ///< s
  double told_ = 0;   ///< of the view that begins at `from_`
  double views_ = 0;
};

}  // namespace pipescout::rack_vision
