// SPDX-License-Identifier: Apache-2.0
// The commands on transforms, with publishers in this process.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "pipescout/dds/dds_transport.hpp"
#include "pipescout/files/testing/temporary_folder.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "pipescout/runtime/executor_thread.hpp"
#include "pipescout/runtime/transform_broadcaster.hpp"
#include "program.hpp"

namespace pipescout::host {
namespace {

using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::StartsWith;

class TfCommand : public ::testing::Test {
 protected:
  TfCommand() { fixed_.send(transform("base", "mast", 1)); }

  [[nodiscard]] geometry_msgs::msg::TransformStamped transform(const std::string& parent,
                                                               const std::string& child,
                                                               double x) const {
    geometry_msgs::msg::TransformStamped result;
    result.header.stamp = to_message(node_.now());
    result.header.frame_id = parent;
    result.child_frame_id = child;
    result.transform.translation.x = x;
    result.transform.rotation.w = 1;
    return result;
  }
  Finished run(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin() + 2, {"--spin-time", "30", "--namespace", "robot"});
    return run_program(arguments, folder_.path());
  }

  ::pipescout::testing::TemporaryFolder folder_;
  std::shared_ptr<Context> context_ =
      Context::create(create_dds_transport(DdsOptions::from_environment()));
  Executor executor_;
  Node node_{{.context = context_,
              .executor = &executor_,
              .name = {"/robot", "arm"},
              .standard_interfaces = false}};
  StaticTransformBroadcaster fixed_{node_};
  TransformBroadcaster moving_{node_};
  std::shared_ptr<Timer> timer_ = node_.create_timer(
      std::chrono::milliseconds(20), [this] { moving_.send(transform("mast", "camera", 2)); });
  ExecutorThread thread_{executor_, {}};
};

TEST_F(TfCommand, EchoPrintsTheComposedTransform) {
  const auto finished = run({"tf", "echo", "base", "camera", "-n", "1"});
  EXPECT_EQ(finished.code(), 0) << finished.err;
  EXPECT_THAT(finished.out, StartsWith("At time "));
  EXPECT_THAT(finished.out, HasSubstr("\n- Translation: [3.000, 0.000, 0.000]\n"
                                      "- Rotation: in Quaternion [0.000, 0.000, 0.000, 1.000]\n"));
}

TEST_F(TfCommand, TreeAndMonitorNameThePublishers) {
  const auto tree = run({"tf", "tree", "--gather", "1"});
  EXPECT_EQ(tree.code(), 0) << tree.err;
  EXPECT_THAT(tree.out, StartsWith("base\n  mast (static, by /robot/arm)\n    camera ("));
  EXPECT_THAT(tree.out, HasSubstr(", by /robot/arm)\n"));
  const auto monitor = run({"tf", "monitor", "-n", "1", "--every", "2"});
  EXPECT_EQ(monitor.code(), 0) << monitor.err;
  EXPECT_THAT(monitor.out, HasSubstr("\nFrame: camera, published by /robot/arm, Average Delay: "));
  EXPECT_THAT(monitor.out, ContainsRegex("Node: /robot/arm [0-9.]+ Hz, Average Delay: "));
}

TEST_F(TfCommand, ARobotWithoutTransformsIsAnError) {
  const auto finished =
      run_program({"tf", "tree", "--gather", "0", "--spin-time", "0.5", "--namespace", "nobody"},
                  folder_.path());
  EXPECT_EQ(finished.code(), 1);
  EXPECT_EQ(finished.err, "nobody sends transforms on /nobody/tf or /nobody/tf_static\n");
}

}  // namespace
}  // namespace pipescout::host
