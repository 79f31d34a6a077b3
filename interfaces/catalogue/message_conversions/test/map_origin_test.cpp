// SPDX-License-Identifier: Apache-2.0
#include "pipescout/message_conversions/map_origin.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>

namespace pipescout {
namespace {

TEST(MapOrigin, ThereAndBack) {
  const geometry::GeodeticPosition places[] = {{36.66, -5.83, 60},
                                               {-33.9, 151.2, 5},
                                               {89.9, 170, -100},
                                               {0, 180, 4000},
                                               {-89.9, -120, 2800}};
  for (const geometry::GeodeticPosition& origin : places) {
    tf2_msgs::msg::TFMessage message;
    message.transforms.emplace_back().child_frame_id = "base_link";
    message.transforms.push_back(
        map_origin_transform(geometry::LocalFrame(origin), "map", Time(std::chrono::seconds(5))));
    EXPECT_EQ(message.transforms[1].header.frame_id, "map");
    EXPECT_EQ(message.transforms[1].header.stamp.sec, 5);
    const auto found = map_origin(message);
    ASSERT_TRUE(found.has_value());
    EXPECT_LT(geometry::straight_distance(*found, origin), 1e-3) << origin.latitude;
  }
}

TEST(MapOrigin, OtherTransformsTellNone) {
  tf2_msgs::msg::TFMessage message;
  message.transforms.emplace_back().child_frame_id = "base_link";
  EXPECT_FALSE(map_origin(message).has_value());
  message.transforms[0] = map_origin_transform(geometry::LocalFrame({47, 8, 400}), "map",
                                               Time(std::chrono::seconds(5)));
  message.transforms[0].transform.translation.x = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW((void)map_origin(message), std::invalid_argument);
}

}  // namespace
}  // namespace pipescout
