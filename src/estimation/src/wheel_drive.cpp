// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation/wheel_drive.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "pipescout/validation/check.hpp"

namespace pipescout::estimation {

namespace {

using validation::refuse;

constexpr double kLargestLength = 100;  // m, of a radius or a track
constexpr double kLargestSpread = 10;   // s

void check_length(const char* field, std::size_t values, std::size_t names) {
  if (values != 0 && values != names) {
    refuse(field, " has ", values, " values for ", names, " names");
  }
}

}  // namespace

void WheelDriveParameters::validate() const {
  std::set<std::string> names;
  for (const auto* side : {&left, &right}) {
    const char* const field = side == &left ? "left" : "right";
    if (side->empty()) {
      refuse("WheelDriveParameters.", field, " is empty, expected the name of a joint at least");
    }
    for (const std::string& name : *side) {
      if (name.empty() || !names.insert(name).second) {
        refuse("WheelDriveParameters.", field, ": '", name, "' is empty or stands twice");
      }
    }
  }
  validation::check_above("WheelDriveParameters.wheel_radius", wheel_radius, 0, kLargestLength);
  validation::check_above("WheelDriveParameters.track", track, 0, kLargestLength);
  validation::check_above("WheelDriveParameters.largest_spread", largest_spread, 0, kLargestSpread);
}

WheelDrive::WheelDrive(WheelDriveParameters parameters)
    : parameters_(std::move(parameters)),
      wheels_(parameters_.left.size() + parameters_.right.size()) {
  parameters_.validate();
}

std::optional<std::size_t> WheelDrive::place_of(const std::string& joint) const {
  const auto& left = parameters_.left;
  const auto& right = parameters_.right;
  if (const auto found = std::ranges::find(left, joint); found != left.end()) {
    return static_cast<std::size_t>(found - left.begin());
  }
  if (const auto found = std::ranges::find(right, joint); found != right.end()) {
    return left.size() + static_cast<std::size_t>(found - right.begin());
  }
  return std::nullopt;
}

template <class HasRate>
void WheelDrive::check_wheels(double time, std::span<const std::string> names,
                              std::span<const double> positions, HasRate&& has_rate) const {
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto place = place_of(names[i]);
    if (!place) {
      continue;
    }
    const Wheel& wheel = wheels_[*place];
    if (wheel.time && !(time > *wheel.time)) {
      refuse("wheel '", names[i], "': time ", time, " s is not after the last one, ", *wheel.time);
    }
    if (std::find(names.begin(), names.begin() + static_cast<std::ptrdiff_t>(i), names[i]) !=
        names.begin() + static_cast<std::ptrdiff_t>(i)) {
      refuse("wheel '", names[i], "' stands twice in one message");
    }
    if (!has_rate(i) && (positions.empty() || !std::isfinite(positions[i]))) {
      refuse("wheel '", names[i], "' has neither a finite velocity nor a finite position");
    }
  }
}

std::optional<WheelMotion> WheelDrive::add(double time, std::span<const std::string> names,
                                           std::span<const double> positions,
                                           std::span<const double> velocities) {
  check_length("position", positions.size(), names.size());
  check_length("velocity", velocities.size(), names.size());
  // A rate that a driver does not know is missing or not finite.
  const auto has_rate = [&](std::size_t i) {
    return !velocities.empty() && std::isfinite(velocities[i]);
  };
  check_wheels(time, names, positions, has_rate);
  bool any = false;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto place = place_of(names[i]);
    if (!place) {
      continue;
    }
    any = true;
    Wheel& wheel = wheels_[*place];
    if (has_rate(i)) {
      wheel.rate = velocities[i];
      wheel.rate_time = time;
    } else if (wheel.time && wheel.angle) {
      wheel.rate = (positions[i] - *wheel.angle) / (time - *wheel.time);
      wheel.rate_time = (time + *wheel.time) / 2;
    }
    wheel.time = time;
    wheel.angle = positions.empty() ? std::nullopt : std::optional(positions[i]);
  }
  return any ? motion() : std::nullopt;
}

std::optional<WheelMotion> WheelDrive::motion() {
  double newest = -std::numeric_limits<double>::infinity();
  for (const Wheel& wheel : wheels_) {
    newest = std::max(newest, wheel.rate_time.value_or(newest));
  }
  bool all = true;
  for (Wheel& wheel : wheels_) {
    if (wheel.rate_time && newest - *wheel.rate_time > parameters_.largest_spread) {
      wheel.rate_time.reset();  // of a round whose other wheels never came
    }
    all = all && wheel.rate_time;
  }
  if (!all) {
    return std::nullopt;
  }
  double time = 0;
  double left = 0;
  double right = 0;
  for (std::size_t i = 0; i < wheels_.size(); ++i) {
    time += *std::exchange(wheels_[i].rate_time, std::nullopt);
    (i < parameters_.left.size() ? left : right) += wheels_[i].rate;
  }
  left *= parameters_.wheel_radius / static_cast<double>(parameters_.left.size());
  right *= parameters_.wheel_radius / static_cast<double>(parameters_.right.size());
  return WheelMotion{.time = time / static_cast<double>(wheels_.size()),
                     .speed = (left + right) / 2,
                     .yaw_rate = (right - left) / parameters_.track};
}

}  // namespace pipescout::estimation
