// SPDX-License-Identifier: Apache-2.0
#include "markup.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace pipescout {
namespace {

TEST(Escaped, LeavesNoMarkup) {
  EXPECT_EQ(escaped("<script>\"x\" & 'y'</script>"),
            "&lt;script&gt;&quot;x&quot; &amp; &#39;y&#39;&lt;/script&gt;");
  EXPECT_EQ(escaped("a\nb\tc"), "a\nb\tc");
  EXPECT_EQ(escaped("\x01\x7f"), "\xef\xbf\xbd\xef\xbf\xbd");
}

TEST(Escaped, IsUtf8Always) {
  EXPECT_EQ(escaped("M\xc3\xbcnchen \xe2\x82\xac \xf0\x9f\x94\xa5"),
            "M\xc3\xbcnchen \xe2\x82\xac \xf0\x9f\x94\xa5");
  const std::string bad = "\xef\xbf\xbd";
  EXPECT_EQ(escaped("\xff"), bad);
  EXPECT_EQ(escaped("\xc3"), bad);
  EXPECT_EQ(escaped("\xc3<"), bad + "&lt;");
  EXPECT_EQ(escaped("\xc0\xaf"), bad + bad);
  EXPECT_EQ(escaped("\xed\xa0\x80"), bad + bad + bad);
  EXPECT_EQ(escaped("\xf4\x90\x80\x80"), bad + bad + bad + bad);
}

TEST(Fixed, IsANumberOrADash) {
  EXPECT_EQ(fixed(1.005, 1), "1.0");
  EXPECT_EQ(fixed(-0.04, 1), "0.0");
  EXPECT_EQ(fixed(-0.06, 1), "-0.1");
  EXPECT_EQ(fixed(NAN, 1), "-");
  EXPECT_EQ(fixed(INFINITY, 1), "-");
}

TEST(PngUri, IsBase64) {
  const std::vector<std::uint8_t> bytes = {'f', 'o', 'o', 'b'};
  EXPECT_EQ(png_uri(bytes), "data:image/png;base64,Zm9vYg==");
  EXPECT_EQ(png_uri({}), "data:image/png;base64,");
}

TEST(RoundStep, DividesIntoFewSteps) {
  EXPECT_DOUBLE_EQ(round_step(10, 5), 2);
  EXPECT_DOUBLE_EQ(round_step(11, 5), 5);
  EXPECT_DOUBLE_EQ(round_step(0.3, 4), 0.1);
  EXPECT_DOUBLE_EQ(round_step(700, 8), 100);
}

}  // namespace
}  // namespace pipescout
