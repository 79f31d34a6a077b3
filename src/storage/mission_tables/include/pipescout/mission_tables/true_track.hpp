// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <deque>
#include <optional>

#include "pipescout/csv/csv_stamp.hpp"
#include "pipescout/geometry/se3.hpp"

namespace pipescout {

/// Recent true poses of a simulated robot. Bounded in memory. Pure; not thread-safe.
class TrueTrack {
 public:
  /// Stamps increase; otherwise the clock was restarted, all earlier poses are discarded, and it
  /// returns false.
  bool add(Stamp stamp, const geometry::SE3& pose);

  /// Interpolated between two poses. Nothing outside the stored ones, and between two that are more
  /// than 0.2 s apart.
  [[nodiscard]] std::optional<geometry::SE3> at(Stamp stamp) const;

 private:
  struct Place {
    Stamp stamp{};
    geometry::SE3 pose;
  };

  std::deque<Place> places_;
};

/// Pairs each estimate with the truth at its stamp, in any order of arrival: the last 1024
/// estimates without a truth are queued. `Estimate` has a `stamp`. Pure; not thread-safe.
template <class Estimate>
class TruthPairing {
 public:
  /// `use(estimate, truth)` is called once for an estimate when its truth is known, now or later;
  /// never for an estimate without a truth.
  template <class Use>
  void add_estimate(const Estimate& estimate, const Use& use) {
    if (const auto truth = track_.at(estimate.stamp)) {
      use(estimate, *truth);
      return;
    }
    if (waiting_.size() == kMaximumWaiting) {
      waiting_.pop_front();
    }
    waiting_.push_back(estimate);
  }

  template <class Use>
  void add_truth(Stamp stamp, const geometry::SE3& pose, const Use& use) {
    if (!track_.add(stamp, pose)) {
      waiting_.clear();
    }
    std::erase_if(waiting_, [&](const Estimate& estimate) {
      if (estimate.stamp > stamp) {
        return false;
      }
      if (const auto truth = track_.at(estimate.stamp)) {
        use(estimate, *truth);
      }
      return true;  // no truth of its time will come any more
    });
  }

 private:
  static constexpr std::size_t kMaximumWaiting = 1024;

  TrueTrack track_;
  std::deque<Estimate> waiting_;
};

}  // namespace pipescout
