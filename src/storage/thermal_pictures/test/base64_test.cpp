// SPDX-License-Identifier: Apache-2.0
#include "base64.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace pipescout {
namespace {

using ::testing::ElementsAre;
using ::testing::Optional;

TEST(Base64, DecodesTheExamplesOfItsStandard) {
  EXPECT_THAT(decode_base64(""), Optional(ElementsAre()));
  EXPECT_THAT(decode_base64("Zg=="), Optional(ElementsAre('f')));
  EXPECT_THAT(decode_base64("Zm8="), Optional(ElementsAre('f', 'o')));
  EXPECT_THAT(decode_base64("Zm9v"), Optional(ElementsAre('f', 'o', 'o')));
  EXPECT_THAT(decode_base64("Zm9vYg=="), Optional(ElementsAre('f', 'o', 'o', 'b')));
  EXPECT_THAT(decode_base64("+/8A"), Optional(ElementsAre(0xfb, 0xff, 0x00)));
}

TEST(Base64, RefusesOtherTexts) {
  for (const char* text : {"Z", "Zg=", "Zg", "====", "Z===", "Zm 9v===", "Zm9%", "Zg==Zg=="}) {
    EXPECT_FALSE(decode_base64(text).has_value()) << text;
  }
}

}  // namespace
}  // namespace pipescout
