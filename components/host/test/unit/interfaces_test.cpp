// SPDX-License-Identifier: Apache-2.0
#include "core/interfaces.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <set>
#include <stdexcept>
#include <string>

#include "core/ros2_export.hpp"
#include "pipescout/files/testing/temporary_folder.hpp"

namespace pipescout::host {
namespace {

namespace fs = std::filesystem;
using pipescout::testing::content;
using pipescout::testing::TemporaryFolder;
using ::testing::HasSubstr;
using ::testing::Not;

TEST(Interfaces, AreNamedOnceByKind) {
  std::vector<std::string> names;
  for (const auto& name : known_interfaces()) {
    names.push_back(name.text());
  }
  EXPECT_THAT(names, ::testing::IsSupersetOf({"sensor_msgs/msg/Image", "std_srvs/srv/Trigger",
                                              "nav2_msgs/action/NavigateToPose"}));
  EXPECT_TRUE(std::ranges::is_sorted(names));
  EXPECT_EQ(std::ranges::count(names, "nav2_msgs/action/NavigateToPose"), 1);
  for (const auto& name : names) {
    EXPECT_THAT(name, Not(HasSubstr("_Request")));
    EXPECT_THAT(name, Not(HasSubstr("SendGoal")));
  }
}

TEST(Interfaces, NamesThatAreNone) {
  for (const std::string name :
       {"", "a", "a/b", "/msg/T", "a//T", "a/msg/", "a/msg/T/x", "a/idl/T"}) {
    EXPECT_THROW(static_cast<void>(parse_interface_name(name)), std::invalid_argument) << name;
  }
}

TEST(Interfaces, ShowsNestedFields) {
  const auto name = parse_interface_name("geometry_msgs/msg/PointStamped");
  const auto text = show_interface(name, {});
  EXPECT_THAT(text, HasSubstr("std_msgs/Header header"));
  EXPECT_THAT(text,
              HasSubstr("\n\tbuiltin_interfaces/Time stamp\n\t\tint32 sec\n\t\tuint32 nanosec\n"
                        "\tstring frame_id\n"));
  EXPECT_THAT(show_interface(name, {.no_comments = true}), Not(HasSubstr("#")));
  EXPECT_THAT(show_interface(name, {.all_comments = true}), HasSubstr("\t\tuint32 nanosec  # "));
  EXPECT_EQ(show_interface(parse_interface_name("std_srvs/srv/SetBool"), {.no_comments = true}),
            "bool data\n---\nbool success\nstring message\n");
  EXPECT_THAT(
      show_interface(parse_interface_name("nav2_msgs/action/NavigateToPose"), {}),
      HasSubstr("---\nstd_msgs/Empty result\n---\ngeometry_msgs/PoseStamped current_pose\n"));
}

TEST(Ros2Export, WritesAPackage) {
  const TemporaryFolder folder;
  const auto exported = export_to_ros2("pipescout_msgs", folder.path());
  EXPECT_EQ(exported.folder, folder.path() / "pipescout_msgs");
  EXPECT_THAT(exported.dependencies,
              ::testing::IsSupersetOf({"builtin_interfaces", "geometry_msgs", "std_msgs"}));
  const auto manifest = content(exported.folder / "package.xml");
  EXPECT_THAT(manifest, HasSubstr("<name>pipescout_msgs</name>"));
  EXPECT_THAT(manifest, HasSubstr("<depend>std_msgs</depend>"));
  EXPECT_THAT(manifest, HasSubstr("<member_of_group>rosidl_interface_packages</member_of_group>"));
  const auto cmake = content(exported.folder / "CMakeLists.txt");
  EXPECT_THAT(cmake, HasSubstr("rosidl_generate_interfaces(${PROJECT_NAME}\n"));
  EXPECT_THAT(cmake, HasSubstr("  \"msg/LeakEvent.msg\"\n"));
  EXPECT_THAT(cmake, HasSubstr("find_package(std_msgs REQUIRED)\n"));
  const auto event = content(exported.folder / "msg/LeakEvent.msg");
  EXPECT_THAT(event, ::testing::StartsWith("# Something has become known of a leak.\n\n"));
  EXPECT_THAT(event, HasSubstr("uint8 RAISED=1  # it is believed to be a leak from now on\n"));
  EXPECT_THAT(event, HasSubstr("std_msgs/Header header  # stamp: "));
  EXPECT_THAT(event, HasSubstr("\nLeakFinding finding\n"));
}

TEST(Ros2Export, TheFolderMayBeThePackage) {
  const TemporaryFolder folder;
  const auto exported = export_to_ros2("std_srvs", folder.path() / "std_srvs" / "");
  EXPECT_EQ(exported.folder, folder.path() / "std_srvs");
  EXPECT_TRUE(exported.dependencies.empty());
  EXPECT_EQ(content(exported.folder / "srv/Empty.srv"), "---\n");
  EXPECT_THAT(content(exported.folder / "CMakeLists.txt"), Not(HasSubstr("DEPENDENCIES")));
}

TEST(Ros2Export, AnActionNeedsWhatItsServicesAreMadeOf) {
  const TemporaryFolder folder;
  const auto exported = export_to_ros2("nav2_msgs", folder.path());
  EXPECT_THAT(exported.dependencies,
              ::testing::ElementsAre("action_msgs", "builtin_interfaces", "geometry_msgs",
                                     "std_msgs", "unique_identifier_msgs"));
  EXPECT_THAT(content(exported.folder / "action/NavigateToPose.action"),
              HasSubstr("string behavior_tree"));
}

TEST(Ros2Export, EveryPackageIsPlainText) {
  const TemporaryFolder folder;
  std::set<std::string> packages;
  for (const auto& name : known_interfaces()) {
    packages.insert(name.package);
  }
  for (const auto& package : packages) {
    ASSERT_NO_THROW(export_to_ros2(package, folder.path())) << package;
  }
  for (const auto& entry : fs::recursive_directory_iterator(folder.path())) {
    if (entry.is_regular_file()) {
      const auto text = content(entry.path());
      EXPECT_TRUE(std::ranges::all_of(text, [](char c) {
        return static_cast<unsigned char>(c) < 0x80;
      })) << entry.path();
    }
  }
}

TEST(Ros2Export, AnUnknownPackageIsAnError) {
  const TemporaryFolder folder;
  EXPECT_THROW(export_to_ros2("no_msgs", folder.path()), ExportError);
}

}  // namespace
}  // namespace pipescout::host
