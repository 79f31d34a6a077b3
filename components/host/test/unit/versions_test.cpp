// SPDX-License-Identifier: Apache-2.0
#include "core/versions.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "pipescout/files/testing/temporary_folder.hpp"

namespace pipescout::host {
namespace {

using ::testing::AllOf;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

TEST(Versions, NameWhatRanAMission) {
  const ::pipescout::testing::TemporaryFolder temporary;
  fs::create_directories(temporary.path() / "share/rover");
  std::ofstream(temporary.path() / "share/rover/package.xml")
      << "<?xml version=\"1.0\"?>\n<package><name>rover</name><version>1.2.3</version></package>";
  const auto yaml = versions_yaml({"rover", "of_nobody"}, {"/nowhere", temporary.path()});
  EXPECT_THAT(yaml, AllOf(HasSubstr("packages:\n"), HasSubstr("  rover: \"1.2.3\"\n"),
                          HasSubstr("  of_nobody: unknown\n")));
  EXPECT_THAT(yaml, AllOf(ContainsRegex("pipescout: \"?[0-9]+\\."), ContainsRegex("revision: "),
                          ContainsRegex("fast_dds: \"?2\\."), ContainsRegex("system: \"?Linux")));
  EXPECT_THAT(versions_yaml({}, {}), HasSubstr("packages: {}\n"));
}

}  // namespace
}  // namespace pipescout::host
