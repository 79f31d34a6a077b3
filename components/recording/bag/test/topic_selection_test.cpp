// SPDX-License-Identifier: Apache-2.0
#include "topic_selection.hpp"

#include <gtest/gtest.h>

namespace pipescout {
namespace {

TEST(TopicSelectionTest, FollowsTheRulesOfRosbag2) {
  const TopicSelection named{.topics = {"/a", "/_hidden/b"}};
  EXPECT_TRUE(named.selects("/a"));
  EXPECT_FALSE(named.selects("/a/b"));
  EXPECT_TRUE(named.selects("/_hidden/b"));  // it was asked for

  const TopicSelection all{.all = true};
  EXPECT_TRUE(all.selects("/a"));
  EXPECT_FALSE(all.selects("/x/_hidden"));
  EXPECT_TRUE((TopicSelection{.all = true, .hidden = true}).selects("/x/_hidden"));

  // In place of all, beside those named; found anywhere.
  const TopicSelection regex{.all = true, .topics = {"/a"}, .regex = std::regex("cam[0-9]")};
  EXPECT_TRUE(regex.selects("/front/cam1/image"));
  EXPECT_TRUE(regex.selects("/a"));
  EXPECT_FALSE(regex.selects("/b"));

  const TopicSelection exclude{
      .all = true, .topics = {"/image/raw"}, .exclude = std::regex("/image")};
  EXPECT_FALSE(exclude.selects("/image/raw"));
  EXPECT_TRUE(exclude.selects("/b"));
  EXPECT_FALSE(TopicSelection{}.selects("/a"));
}

TEST(TopicSelectionTest, AllOfARobotAreThoseOfItsNamespaceAndOfThoseAroundIt) {
  const TopicSelection robot{.all = true, .ns = "/site/robot_1"};
  for (const char* topic : {"/site/robot_1/weld", "/site/robot_1/camera/image_raw",
                            "/site/robot_1x", "/site/weather", "/diagnostics", "/clock"}) {
    EXPECT_TRUE(robot.selects(topic)) << topic;
  }
  for (const char* topic :
       {"/site/robot_2/weld", "/site/robot_10/weld", "/robot_1/weld", "/weather/wind"}) {
    EXPECT_FALSE(robot.selects(topic)) << topic;
  }
  EXPECT_TRUE((TopicSelection{.all = true, .ns = "/"}).selects("/site/robot_2/weld"));
  // Who asks for more gets it.
  EXPECT_TRUE(
      (TopicSelection{.ns = "/robot_1", .topics = {"/robot_2/weld"}}).selects("/robot_2/weld"));
  EXPECT_TRUE(
      (TopicSelection{.ns = "/robot_1", .regex = std::regex(".")}).selects("/robot_2/weld"));
}

}  // namespace
}  // namespace pipescout
