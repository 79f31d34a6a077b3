// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <deque>
#include <optional>

#include "pipescout/geometry/se3.hpp"
#include "pipescout/runtime/time.hpp"

namespace pipescout {

/// Where a simulated robot really was, at any time of the last while. Bounded in memory. Pure; not
/// thread-safe.
class TrueTrack {
 public:
  /// Stamps rise; one that does not means that the clock began again, and all before is forgotten:
  /// then it is false.
  bool add(Time stamp, const geometry::SE3& pose);

  /// Between two poses interpolated. Nothing outside of those that are remembered, and between two
  /// that are more than 0.2 s apart, which say nothing of what is between them.
  [[nodiscard]] std::optional<geometry::SE3> at(Time stamp) const;

 private:
  struct Place {
    Time stamp{};
    geometry::SE3 pose;
  };

  std::deque<Place> places_;
};

/// Brings each estimate together with the truth of its stamp, in whatever order they come: of
/// estimates without a truth yet the last 1024 wait for it. `Estimate` has a `stamp`. Pure; not
/// thread-safe.
template <class Estimate>
class TruthPairing {
 public:
  /// `use(estimate, truth)` is called once for an estimate whose truth is known, now or later;
  /// never for one whose truth does not come.
  template <class Use>
  void add_estimate(const Estimate& estimate, const Use& use) {
    if (const auto truth = track_.at(estimate.stamp)) {
      use(estimate, *truth);
      return;
    }
    if (waiting_.size == kMaximumWaiting) {
      waiting_.pop_front();
    }
    waiting_.push_back(estimate);
  }

  template <class Use>
  void add_truth(Time stamp, const geometry::SE3& pose, const Use& use) {
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
