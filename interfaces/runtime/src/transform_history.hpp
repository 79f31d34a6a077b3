// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "pipescout/runtime/time.hpp"
#include "rigid_transform.hpp"

namespace pipescout {

using rigid::RigidTransform;

/// The transforms of one child to its parent over the last seconds, by time. Bounded. Not
/// thread-safe.
class TransformHistory {
 public:
  struct Sample {
    Time time;
    RigidTransform transform;
  };
  enum class Insertion {
    kTaken,
    kRepeated,  ///< there is one of that time already, which stays
    kBeganAnew  ///< it is older than the history reaches back: the clock of its publisher was set
                ///< back
  };

  Insertion insert(const Sample& sample, Duration reach, std::size_t capacity);
  void clear();

  [[nodiscard]] bool empty() const noexcept { return samples_.size() == first_; }
  [[nodiscard]] std::size_t size() const noexcept { return samples_.size() - first_; }
  /// Of the oldest and the newest sample; undefined while empty.
  [[nodiscard]] Time oldest() const noexcept { return oldest_; }
  [[nodiscard]] Time newest() const noexcept { return newest_; }

  /// Between two samples interpolated; `gap` becomes the time between them if that is longer.
  /// `time` must not lie before the oldest, nor after the newest.
  [[nodiscard]] RigidTransform at(Time time, Duration& gap) const noexcept;

 private:
  /// Index of the first sample that is not before `time`, which the newest is not.
  [[nodiscard]] std::size_t not_before(Time time) const noexcept;

  // Also here, so that a check of the times touches no sample.
  Time oldest_{};
  Time newest_{};
  std::vector<Sample> samples_;
  std::size_t first_ = 0;  // those before it are gone, and removed when they are the half
};

}  // namespace pipescout
