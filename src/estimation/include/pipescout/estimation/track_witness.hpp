// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <limits>
#include <optional>

namespace pipescout::estimation {

/// A measured position and the same point by dead reckoning, turned into the axes of the map.
struct TrackPair {
  double time = 0;
  Eigen::Vector3d measured = Eigen::Vector3d::Zero();  ///< m, in the map
  Eigen::Vector3d reckoned = Eigen::Vector3d::Zero();  ///< m, in `odom`
  double deviation = 1;                                ///< m, of `measured`, per axis
  double way = 0;                                      ///< m, by dead reckoning so far
};

/// Whether a track of measured positions goes on as dead reckoning says that the vehicle went, over
/// spans of 1, 2, 4, ... 256 s, however sure the state is; and how far the two usually part over
/// each span, which is learnt from pairs that were believed. It is the structure function of the
/// errors of both: those of the positions saturate, those of dead reckoning grow.
///
/// Horizontal only. Constant memory; pure.
class TrackWitness {
 public:
  /// Learns from a pair that is believed. `yaw`: rad, of the map from `odom`. Pairs that are not
  /// newer than the last one are ignored.
  void learn(const TrackPair& pair, double yaw) noexcept;
  /// Whether the pair lies where those that were believed and dead reckoning have it, over every
  /// span of which there is one; nothing before any. `gate` is that of the squared distance over
  /// the variance per axis; dead reckoning is off by `share` of the way and `floor` m at least.
  [[nodiscard]] std::optional<bool> bears_out(const TrackPair& pair, double yaw, double gate,
                                              double share, double floor) const noexcept;
  /// m, one standard deviation per axis: how far both usually part in `elapsed` s; 0 when that is
  /// not known. Beyond the spans that were seen it grows with the time.
  [[nodiscard]] double parts_by(double elapsed) const noexcept;
  void forget() noexcept { *this = {}; }

 private:
  static constexpr std::size_t kSpans = 9;

  struct Span {
    std::optional<TrackPair> anchor{};  // older than the span, by twice at most
    std::optional<TrackPair> next{};
    double square = 0;  // m^2, mean per axis, of what both part by
    std::size_t count = 0;
  };

  std::array<Span, kSpans> spans_{};
  double newest_ = -std::numeric_limits<double>::infinity();  // s
};

}  // namespace pipescout::estimation
