// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

#include "pipescout/files/testing/temporary_folder.hpp"
#include "test_bag.hpp"

namespace pipescout::bags {
namespace {

TEST(Example, ThinsOut) {
  const pipescout::testing::TemporaryFolder folder;
  {
    BagWriter writer(folder.path() / "bag");
    for (const auto& message : testing::messages(30, 100)) {
      testing::write(writer, message);
    }
  }
  const std::string base = folder.path().string();
  std::string command = THIN_OUT;
  command += " " + base + "/bag " + base + "/thin 5 > " + base + "/said";
  ASSERT_EQ(std::system(command.c_str()), 0);
  EXPECT_EQ(pipescout::testing::content(folder.path() / "said"), "6 of 30 messages\n");
  EXPECT_EQ(testing::read(folder.path() / "thin").size(), 6U);
}

}  // namespace
}  // namespace pipescout::bags
