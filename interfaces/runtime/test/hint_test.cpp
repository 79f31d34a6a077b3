// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/hint.hpp"

#include <gtest/gtest.h>

namespace pipescout {
namespace {

TEST(Hint, NamesWhatWasMeant) {
  EXPECT_EQ(did_you_mean("gian", "gain"), "; did you mean 'gain'?");
  EXPECT_EQ(did_you_mean("Gain", "gain"), "; did you mean 'gain'?");
}

TEST(Hint, ShowsTheDifferenceOfNamesThatLookTheSame) {
  EXPECT_EQ(did_you_mean("od\u043em", "odom"),
            "; did you mean 'odom'? Its character 3 is 'o' (U+006F), yours is U+043E.");
  EXPECT_EQ(did_you_mean("odom ", "odom"),
            "; did you mean 'odom'? Its character 5 is nothing, yours is U+0020.");
  EXPECT_EQ(did_you_mean("odom", "o\u200bdom"),
            "; did you mean 'o\u200bdom'? Its character 2 is U+200B, yours is 'd' (U+0064).");
  EXPECT_EQ(did_you_mean("Iidar", "lidar"),
            "; did you mean 'lidar'? Its character 1 is 'l' (U+006C), yours is 'I' (U+0049).");
}

TEST(Hint, TakesAnyBytes) {
  EXPECT_EQ(did_you_mean("\xe2\x80", "a"), "; did you mean 'a'?");
  EXPECT_EQ(did_you_mean("", ""), "; did you mean ''?");
}

}  // namespace
}  // namespace pipescout
