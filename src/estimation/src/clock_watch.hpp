// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace pipescout::estimation {

/// Tells a clock that has jumped from a stamp that is wrong: the one goes on from where it is.
class ClockWatch {
 public:
  enum class Step {
    kNext,        // later than the newest, by not too much
    kLate,        // earlier, by not too much
    kDuplicate,   // the same
    kSuspicious,  // far off: a wrong stamp, or the first ones after a jump
    kJump,        // far off, as those before it: from now on this is the time
  };

  explicit ClockWatch(double longest_step) : longest_step_(longest_step) {}

  /// `time` must be finite. `bearing_out`: of consecutive times that are far off in the same way,
  /// the one that is a jump.
  Step judge(double time, std::size_t bearing_out = 5) noexcept {
    constexpr double kSame = 1e-6;
    const double step = time - newest_;
    if (std::isnan(newest_)) {
      newest_ = time;
      return Step::kNext;
    }
    if (std::abs(step) <= longest_step_) {
      suspects_ = 0;
      if (std::abs(step) < kSame) {
        return Step::kDuplicate;
      }
      newest_ = std::max(newest_, time);
      return step > 0 ? Step::kNext : Step::kLate;
    }
    suspects_ = suspects_ > 0 && std::abs(time - suspect_) <= longest_step_ ? suspects_ + 1 : 1;
    suspect_ = time;
    if (suspects_ < bearing_out) {
      return Step::kSuspicious;
    }
    suspects_ = 0;
    newest_ = time;
    return Step::kJump;
  }

  void forget() noexcept { *this = ClockWatch(longest_step_); }
  /// NaN before the first.
  [[nodiscard]] double newest() const noexcept { return newest_; }

 private:
  double longest_step_;
  double newest_ = std::numeric_limits<double>::quiet_NaN();
  double suspect_ = 0;
  std::size_t suspects_ = 0;
};

}  // namespace pipescout::estimation
