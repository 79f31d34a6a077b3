// SPDX-License-Identifier: Apache-2.0
#include "core/transform_text.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace pipescout::host {
namespace {

TEST(TransformText, AnEchoIsThatOfTf2Echo) {
  geometry_msgs::msg::TransformStamped transform;
  transform.header.stamp.sec = 12;
  transform.header.stamp.nanosec = 500000000;
  transform.transform.translation.x = 1.25;
  transform.transform.rotation.z = 0.6;
  transform.transform.rotation.w = 0.8;
  EXPECT_EQ(to_echo(transform),
            "At time 12.500000000\n"
            "- Translation: [1.250, 0.000, 0.000]\n"
            "- Rotation: in Quaternion [0.000, 0.000, 0.600, 0.800]\n"
            "- Rotation: in RPY (radian) [0.000, 0.000, 1.287]\n"
            "- Rotation: in RPY (degree) [0.000, 0.000, 73.740]\n"
            "- Matrix:\n"
            "  0.280 -0.960  0.000  1.250\n"
            "  0.960  0.280  0.000  0.000\n"
            "  0.000  0.000  1.000  0.000\n"
            "  0.000  0.000  0.000  1.000\n");
}

TEST(TransformText, ATreeShowsEachFrameBelowItsParent) {
  const Time newest{std::chrono::seconds(20)};
  std::vector<TransformFrame> frames(4);
  frames[0].name = "base";
  frames[0].parent = "odom";
  frames[0].oldest = newest - std::chrono::seconds(2);
  frames[0].newest = newest;
  frames[1].name = "camera";
  frames[1].parent = "base";
  frames[1].is_static = true;
  frames[2].name = "mast";
  frames[3].name = "odom";
  EXPECT_EQ(to_tree(frames, [](const Gid&) { return "/robot"; }),
            "mast\n"
            "odom\n"
            "  base (2.000 s of history to 20.000, by /robot)\n"
            "    camera (static, by /robot)\n");
}

TEST(TransformText, DelaysAreAveragedAndCounted) {
  DelayStatistics delays;
  EXPECT_EQ(delays.rate(), 0);
  const SteadyTime start{};
  for (int i = 0; i < 5; ++i) {
    delays.add(0.1 * i, start + std::chrono::milliseconds(500 * i));
  }
  EXPECT_NEAR(delays.average(), 0.2, 1e-12);
  EXPECT_NEAR(delays.most(), 0.4, 1e-12);
  EXPECT_NEAR(delays.rate(), 2, 1e-12);
}

}  // namespace
}  // namespace pipescout::host
