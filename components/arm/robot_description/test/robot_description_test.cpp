// SPDX-License-Identifier: Apache-2.0
#include "pipescout/robot_description/robot_description.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <tf2_msgs/msg/tf_message.hpp>

#include "pipescout/catalogue/topics.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "pipescout/testing/component_harness.hpp"

namespace pipescout {
namespace {

using sensor_msgs::msg::JointState;
using ::testing::HasSubstr;

constexpr auto kUrdf = R"(<robot name="r"><link name="base_link"/><link name="pan_link"/>
  <link name="camera"/><link name="drone"/>
  <joint name="pan" type="continuous"><parent link="base_link"/><child link="pan_link"/>
    <origin xyz="1 0 0"/><axis xyz="0 0 1"/></joint>
  <joint name="eye" type="fixed"><parent link="pan_link"/><child link="camera"/>
    <origin xyz="0 0 0.5"/></joint>
  <joint name="free" type="floating"><parent link="base_link"/><child link="drone"/></joint>
  </robot>)";

class RobotDescriptionTest : public ::testing::Test {
 protected:
  RobotDescriptionTest() { std::ofstream(file_) << kUrdf; }
  ~RobotDescriptionTest() override { std::filesystem::remove(file_); }

  RobotDescription& make(const std::string& file) {
    return harness_.make<RobotDescription>(
        {.name = "robot_description", .parameters = {{"urdf_file", file}}});
  }
  static JointState joints(double seconds, std::vector<std::string> names,
                           std::vector<double> positions) {
    JointState message;
    message.header.stamp = to_message(Time(from_seconds(seconds)));
    message.name = std::move(names);
    message.position = std::move(positions);
    return message;
  }

  const std::string file_ = ::testing::TempDir() + "robot_description_" +
                            ::testing::UnitTest::GetInstance()->current_test_info()->name() +
                            ".urdf";
  testing::ComponentHarness harness_;
};

TEST_F(RobotDescriptionTest, TellsTheDescriptionAndWhatIsFixedToWhoComesLater) {
  ASSERT_TRUE(harness_.bring_up(make(file_)).success);
  const auto description = harness_.collect(topics::kRobotDescription);
  const auto fixed = harness_.collect(topics::kTfStatic);
  harness_.spin();
  ASSERT_EQ(description.size(), 1U);
  EXPECT_EQ(description.at(0).data, kUrdf);
  ASSERT_EQ(fixed.size(), 1U);
  ASSERT_EQ(fixed.at(0).transforms.size(), 1U);
  EXPECT_EQ(fixed.at(0).transforms[0].child_frame_id, "camera");
  const auto logs = harness_.logs();
  EXPECT_TRUE(std::ranges::any_of(
      logs, [](const auto& log) { return log.text.starts_with("joint 'free' is planar"); }));
}

TEST_F(RobotDescriptionTest, JointsMoveTheirLinks) {
  ASSERT_TRUE(harness_.bring_up(make(file_)).success);
  Transforms& transforms = harness_.peer().transforms();
  harness_.publish(topics::kJointStates, joints(5, {"wheel", "pan"}, {9.0, 0.5}));
  harness_.spin();
  const TransformResult found =
      transforms.lookup("base_link", "camera", Time(std::chrono::seconds(5)));
  ASSERT_TRUE(found) << found.failure().text;
  EXPECT_NEAR(found->transform.translation.x, 1, 1e-12);
  EXPECT_NEAR(found->transform.translation.z, 0.5, 1e-12);
  EXPECT_NEAR(found->transform.rotation.z, std::sin(0.25), 1e-12);
}

TEST_F(RobotDescriptionTest, JointsOfOthersAreNothingAndBadOnesAreCounted) {
  auto& component = make(file_);
  ASSERT_TRUE(harness_.bring_up(component).success);
  const auto moved = harness_.collect(topics::kTf);
  harness_.publish(topics::kJointStates, joints(5, {"wheel"}, {9.0}));
  harness_.publish(topics::kJointStates, joints(6, {"pan"}, {}));
  harness_.publish(topics::kJointStates,
                   joints(7, {"pan"}, {std::numeric_limits<double>::infinity()}));
  harness_.spin();
  EXPECT_TRUE(moved.empty());
  EXPECT_EQ(component.diagnostics().counter("joint_states.refused"), 2U);
}

TEST_F(RobotDescriptionTest, AFileThatIsNoDescriptionIsNamed) {
  EXPECT_THAT(harness_.configure(make("")).message, HasSubstr("'urdf_file' is empty"));
  std::ofstream(file_) << "no robot";
  testing::ComponentHarness other;
  auto& component = other.make<RobotDescription>({.parameters = {{"urdf_file", file_}}});
  EXPECT_THAT(other.configure(component).message, HasSubstr(file_ + ": urdf"));
}

}  // namespace
}  // namespace pipescout
