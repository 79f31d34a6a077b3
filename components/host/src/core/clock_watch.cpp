// SPDX-License-Identifier: Apache-2.0
#include "core/clock_watch.hpp"

#include <array>
#include <charconv>
#include <chrono>
#include <cmath>

#include "pipescout/files/utc_text.hpp"

namespace pipescout::host {
namespace {

/// From this offset on ntpd sets a clock instead of slewing it (its step threshold). A slew, of at
/// most 0.5 ms/s, changes far less between two looks.
constexpr Duration kLeastStep = std::chrono::milliseconds(128);

std::string utc(Time time) {
  return utc_text(std::chrono::floor<std::chrono::milliseconds>(time), UtcForm::kIso);
}

}  // namespace

std::optional<ClockStep> ClockWatch::look(Time system, SteadyTime steady) {
  std::optional<ClockStep> step;
  if (last_) {
    const Time expected = last_->system + (steady - last_->steady);
    if (const Duration by = system - expected; std::chrono::abs(by) >= kLeastStep) {
      step = {.by = by, .from = expected, .to = system};
    }
  }
  last_ = {system, steady};
  return step;
}

std::string to_text(const ClockStep& step) {
  std::array<char, 32> seconds{};
  const auto end = std::to_chars(seconds.data(), seconds.data() + seconds.size(),
                                 std::abs(to_seconds(step.by)), std::chars_format::fixed, 1);
  return "the system clock of this machine was set " +
         std::string(step.by < Duration::zero() ? "back" : "forward") + " by " +
         std::string(seconds.data(), end.ptr) + " s, from " + utc(step.from) + " to " +
         utc(step.to) + ": stamps go with it";
}

}  // namespace pipescout::host
