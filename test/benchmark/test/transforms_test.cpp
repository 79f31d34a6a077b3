// SPDX-License-Identifier: Apache-2.0
// The transform buffer and tf2 say the same of random trees.
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "pipescout/runtime/conversions.hpp"
#include "pipescout/runtime/transform_buffer.hpp"
#include "tf2_peer.hpp"

namespace pipescout::benchmarks {
namespace {

constexpr std::int64_t kMillisecond = 1'000'000;
constexpr std::int64_t kStart = 1'000'000 * kMillisecond;
constexpr std::int64_t kHistory = 10'000 * kMillisecond;

std::string frame(int number) {
  return "frame_" + std::to_string(number);
}

double draw_number(double most) {
  return *rc::gen::inRange(-1'000'000, 1'000'001) * 1e-6 * most;
}

Tf2Peer::Pose draw_pose() {
  Tf2Peer::Pose pose;
  for (double& value : pose.translation) {
    value = draw_number(10);
  }
  double norm = 0;
  do {
    norm = 0;
    for (double& value : pose.rotation) {
      value = draw_number(1);
      norm += value * value;
    }
  } while (norm < 0.01);
  for (double& value : pose.rotation) {
    value /= std::sqrt(norm);
  }
  return pose;
}

/// Both buffers with the same trees: the parent of each frame is one before it, or none.
class Both {
 public:
  explicit Both(int frames) : theirs_(kHistory) {
    for (int child = 1; child < frames; ++child) {
      const int parent = *rc::gen::inRange(-1, child);
      if (parent < 0) {
        continue;
      }
      const bool is_static = *rc::gen::inRange(0, 4) == 0;
      const int samples = is_static ? 1 : *rc::gen::inRange(1, 30);
      std::int64_t time = kStart + *rc::gen::inRange(0, 2000) * kMillisecond;
      for (int i = 0; i < samples; ++i) {
        insert(parent, child, time, is_static);
        time += *rc::gen::inRange(1, 800) * kMillisecond;
      }
    }
  }

  /// Checks one lookup. tf2 has one kind of error for each of ours, but for the direction in time;
  /// and it says of frames that are not connected sometimes one, sometimes the other.
  void compare(int target, int source, std::int64_t time) const {
    const TransformResult ours = ours_.lookup(frame(target), frame(source), Time(Duration(time)));
    Tf2Peer::Pose expected;
    const Tf2Peer::Outcome theirs = theirs_.lookup(frame(target), frame(source), time, expected);
    RC_ASSERT(ours.has_value() == (theirs == Tf2Peer::Outcome::kFound));
    if (!ours) {
      return;
    }
    const auto& t = ours->transform.translation;
    const auto& q = ours->transform.rotation;
    const std::array<double, 3> translation{t.x, t.y, t.z};
    const std::array<double, 4> rotation{q.x, q.y, q.z, q.w};
    double dot = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      dot += rotation[i] * expected.rotation[i];
    }
    RC_ASSERT(std::abs(std::abs(dot) - 1) < 1e-9);
    for (std::size_t i = 0; i < 3; ++i) {
      RC_ASSERT(std::abs(translation[i] - expected.translation[i]) < 1e-6);
    }
  }

 private:
  void insert(int parent, int child, std::int64_t time, bool is_static) {
    const Tf2Peer::Pose pose = draw_pose();
    geometry_msgs::msg::TransformStamped message;
    message.header.stamp = to_message(Time(Duration(time)));
    message.header.frame_id = frame(parent);
    message.child_frame_id = frame(child);
    auto& [translation, rotation] = message.transform;
    translation.x = pose.translation[0];
    translation.y = pose.translation[1];
    translation.z = pose.translation[2];
    rotation.x = pose.rotation[0];
    rotation.y = pose.rotation[1];
    rotation.z = pose.rotation[2];
    rotation.w = pose.rotation[3];
    RC_ASSERT(!ours_.insert(message, is_static));
    RC_ASSERT(theirs_.insert(frame(parent), frame(child), time, pose, is_static));
  }

  TransformBuffer ours_;
  Tf2Peer theirs_;
};

RC_GTEST_PROP(TransformsOfRandomTrees, AreThoseOfTf2, ()) {
  const int frames = *rc::gen::inRange(2, 15);
  const Both both(frames);
  for (int i = 0; i < 40; ++i) {
    const int target = *rc::gen::inRange(0, frames);
    const int source = *rc::gen::inRange(0, frames);
    if (target == source) {
      continue;  // tf2 knows a frame in itself even when nobody has sent it
    }
    const bool latest = *rc::gen::inRange(0, 4) == 0;
    both.compare(target, source, latest ? 0 : kStart + *rc::gen::inRange(0, 12'000) * kMillisecond);
  }
}

}  // namespace
}  // namespace pipescout::benchmarks
