// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <random>
#include <vector>

#include "pipescout/geometry/se3.hpp"

/// A satellite positioning receiver with its errors. Positions in the map frame, m; seconds. East,
/// north and up errors are independent.
namespace pipescout::simulation {

/// No fixes in [begin, begin + duration).
struct GpsOutage {
  double begin = 0;     ///< s
  double duration = 0;  ///< s, >= 0
};

/// In [begin, begin + duration) fixes are consistent with each other but wrong: reflections or a
/// wrong reference. Their stated standard deviations are those of good fixes.
struct GpsTrap {
  double begin = 0;                                     ///< s
  double duration = 0;                                  ///< s, >= 0
  Eigen::Vector3d offset = Eigen::Vector3d(700, 0, 0);  ///< m, relative to the antenna
  bool moves_along = false;  ///< moves with the antenna; otherwise constant
};

struct GpsParameters {
  double period = 0.2;          ///< s, [0.01, 1000]
  double latency = 0.1;         ///< s, [0, 10], least
  double latency_spread = 0.1;  ///< s, [0, 10]: largest additional latency
  Eigen::Vector3d white_deviation = Eigen::Vector3d(0.4, 0.4, 0.8);  ///< m, [0, 100]
  Eigen::Vector3d correlated_deviation =
      Eigen::Vector3d(0.4, 0.4, 0.8);  ///< m, [0, 100]: multipath
  double correlation_time = 30;        ///< s, [0.01, 1e5]
  double outlier_share = 0;            ///< [0, 1]: of the fixes
  double outlier_least = 10;           ///< m, [0, 1e5]: smallest horizontal error
  double outlier_most = 100;           ///< m, [outlier_least, 1e5]
  double stated_share = 1;  ///< [0.01, 100]: stated deviation / that of white and correlated error
  Eigen::Vector3d antenna = Eigen::Vector3d::Zero();  ///< m, in the body
  std::vector<GpsOutage> outages{};
  std::vector<GpsTrap> traps{};

  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

enum class GpsFixKind : std::uint8_t { kGood, kOutlier, kTrap };

struct GpsFix {
  double time = 0;                                       ///< s, of the measurement
  double arrival = 0;                                    ///< s; later fixes may arrive earlier
  Eigen::Vector3d position = Eigen::Vector3d::Zero();    ///< m, of the antenna
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< m^2, as stated
  GpsFixKind kind = GpsFixKind::kGood;                   ///< the truth about it
};

/// The same parameters, seed and truth give the same bits. Allocates nothing after construction.
class GpsReceiver {
 public:
  /// Throws what `GpsParameters::validate` throws.
  GpsReceiver(const GpsParameters& parameters, std::uint64_t seed);

  /// Time of the next fix; the first at 0, each a period after the one before.
  [[nodiscard]] double due() const noexcept;
  /// The due fix for this motion of the body; none in an outage.
  std::optional<GpsFix> measure(const geometry::SE3& T_map_body);

 private:
  GpsParameters parameters_;
  std::mt19937_64 engine_;
  Eigen::Vector3d correlated_ = Eigen::Vector3d::Zero();    ///< m
  std::vector<std::optional<Eigen::Vector3d>> trapped_at_;  ///< of each trap
  std::uint64_t fixes_ = 0;
};

}  // namespace pipescout::simulation
