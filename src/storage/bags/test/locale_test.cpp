// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "pipescout/bags/bag_metadata.hpp"
#include "pipescout/files/testing/comma_locale.hpp"

namespace pipescout::bags {
namespace {

TEST(BagMetadata, IsTheSameInALocaleThatGroupsDigits) {
  BagMetadata metadata;
  metadata.messages = 1234567;
  metadata.starting_time = 1700000000123456789;
  metadata.duration = 9876543210;
  const std::string before = metadata_to_yaml(metadata);
  const ::pipescout::testing::CommaLocale locale;
  EXPECT_EQ(metadata_to_yaml(metadata), before);
}

}  // namespace
}  // namespace pipescout::bags
