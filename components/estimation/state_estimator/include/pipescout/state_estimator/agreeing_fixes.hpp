// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <sensor_msgs/msg/nav_sat_fix.hpp>
#include <vector>

namespace pipescout {

/// Collects fixes until several in a row are near each other: the first fixes of a receiver may be
/// anywhere, and an origin of the map far away stays wrong.
class AgreeingFixes {
 public:
  static constexpr std::size_t kAgreeing = 5;
  static constexpr double kNear = 1000;  ///< m, from the fix before

  /// Whether the newest `kAgreeing` fixes agree now. Throws std::invalid_argument for a latitude or
  /// longitude that is none.
  bool add(const sensor_msgs::msg::NavSatFix& fix);
  /// These, oldest first; begins again.
  [[nodiscard]] std::vector<sensor_msgs::msg::NavSatFix> take();
  void clear() { fixes_.clear(); }

 private:
  std::vector<sensor_msgs::msg::NavSatFix> fixes_{};
};

}  // namespace pipescout
