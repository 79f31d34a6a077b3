// SPDX-License-Identifier: Apache-2.0
#include "pipescout/command_line/installed_share_folder.hpp"

#include <gtest/gtest.h>

namespace pipescout::command_line {
namespace {

TEST(InstalledShareFolder, LeavesNoPrefix) {
  EXPECT_FALSE(installed_share_folder(".."));
  EXPECT_FALSE(installed_share_folder("a/../b"));
  EXPECT_FALSE(installed_share_folder("no_such_package"));
}

}  // namespace
}  // namespace pipescout::command_line
