// SPDX-License-Identifier: Apache-2.0
#include "core/transform_text.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <numbers>

namespace pipescout::host {
namespace {

using Row = std::array<double, 3>;

template <class... Arguments>
std::string print(const char* format, Arguments... arguments) {
  const int size = std::snprintf(nullptr, 0, format, arguments...);
  std::string text(static_cast<std::size_t>(size), '\0');
  std::snprintf(text.data(), text.size() + 1, format, arguments...);
  return text;
}

std::array<Row, 3> matrix(const geometry_msgs::msg::Quaternion& q) {
  return {
      {{1 - 2 * (q.y * q.y + q.z * q.z), 2 * (q.x * q.y - q.z * q.w), 2 * (q.x * q.z + q.y * q.w)},
       {2 * (q.x * q.y + q.z * q.w), 1 - 2 * (q.x * q.x + q.z * q.z), 2 * (q.y * q.z - q.x * q.w)},
       {2 * (q.x * q.z - q.y * q.w), 2 * (q.y * q.z + q.x * q.w),
        1 - 2 * (q.x * q.x + q.y * q.y)}}};
}

/// Of rotations about the fixed axes x, y, z in this order; roll is 0 where it and yaw are one.
Row roll_pitch_yaw(const std::array<Row, 3>& r) {
  const double sine = std::clamp(0.0 - r[2][0], -1.0, 1.0);
  const double pitch = std::asin(sine);
  if (std::abs(sine) > 1 - 1e-9) {
    return {0, pitch, std::atan2(-r[0][1], r[1][1])};
  }
  return {std::atan2(r[2][1], r[2][2]), pitch, std::atan2(r[1][0], r[0][0])};
}

/// The frame, then its children below it.
void add_branch(const TransformFrame& frame,
                const std::multimap<std::string, const TransformFrame*>& children,
                const std::function<std::string(const Gid&)>& told_by, std::size_t depth,
                std::string& out) {
  out.append(2 * depth, ' ').append(frame.name);
  if (!frame.parent.empty()) {
    if (frame.is_static) {
      out += " (static";
    } else {
      const double span = to_seconds(frame.newest - frame.oldest);
      out +=
          print(" (%.3f s of history to %.3f", span, to_seconds(frame.newest.time_since_epoch()));
    }
    out += ", by " + told_by(frame.authority) + ")";
  }
  out += '\n';
  const auto [begin, end] = children.equal_range(frame.name);
  for (auto child = begin; child != end; ++child) {
    add_branch(*child->second, children, told_by, depth + 1, out);
  }
}

}  // namespace

std::string to_echo(const geometry_msgs::msg::TransformStamped& transform) {
  const auto& t = transform.transform.translation;
  const auto& q = transform.transform.rotation;
  const auto r = matrix(q);
  const Row angles = roll_pitch_yaw(r);
  constexpr double kDegrees = 180 / std::numbers::pi;
  std::string out = print("At time %d.%09u\n", static_cast<int>(transform.header.stamp.sec),
                          static_cast<unsigned>(transform.header.stamp.nanosec));
  out += print("- Translation: [%.3f, %.3f, %.3f]\n", t.x, t.y, t.z);
  out += print("- Rotation: in Quaternion [%.3f, %.3f, %.3f, %.3f]\n", q.x, q.y, q.z, q.w);
  out += print("- Rotation: in RPY (radian) [%.3f, %.3f, %.3f]\n", angles[0], angles[1], angles[2]);
  out += print("- Rotation: in RPY (degree) [%.3f, %.3f, %.3f]\n", angles[0] * kDegrees,
               angles[1] * kDegrees, angles[2] * kDegrees);
  out += "- Matrix:\n";
  const Row translation{t.x, t.y, t.z};
  for (std::size_t i = 0; i < 3; ++i) {
    out += print(" %6.3f %6.3f %6.3f %6.3f\n", r[i][0], r[i][1], r[i][2], translation[i]);
  }
  return out + print(" %6.3f %6.3f %6.3f %6.3f\n", 0.0, 0.0, 0.0, 1.0);
}

std::string to_tree(const std::vector<TransformFrame>& frames,
                    const std::function<std::string(const Gid&)>& told_by) {
  std::multimap<std::string, const TransformFrame*> children;
  for (const TransformFrame& frame : frames) {
    if (!frame.parent.empty()) {
      children.emplace(frame.parent, &frame);
    }
  }
  std::string out;
  for (const TransformFrame& frame : frames) {
    if (frame.parent.empty()) {
      add_branch(frame, children, told_by, 0, out);
    }
  }
  return out;
}

void DelayStatistics::add(double delay, SteadyTime arrival) {
  first_ = count_ == 0 ? arrival : first_;
  last_ = arrival;
  ++count_;
  sum_ += delay;
  most_ = count_ == 1 ? delay : std::max(most_, delay);
}

double DelayStatistics::average() const {
  return count_ == 0 ? 0 : sum_ / static_cast<double>(count_);
}

double DelayStatistics::rate() const {
  const double span = to_seconds(last_ - first_);
  return span > 0 ? static_cast<double>(count_ - 1) / span : 0;
}

}  // namespace pipescout::host
