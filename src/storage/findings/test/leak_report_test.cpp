// SPDX-License-Identifier: Apache-2.0
#include "pipescout/leak_store/leak_report.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <vector>

#include "example_findings.hpp"

namespace pipescout {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

LeakReport example() {
  const test::ExamplePicture picture;
  LeakReport report;
  report.title = "Loop 7 <b>& \"8\"</b>";
  report.made = "Made by a test";
  for (std::uint64_t id = 1; id <= 4; ++id) {
    report.findings.push_back(
        {test::example_finding(id),
         make_evidence(picture.view(), picture.detections, 0, picture.parameters.profile,
                       1381300000, "night/0\"1.png")});
  }
  report.findings.push_back({test::bare_finding(9), std::nullopt});
  report.pipes = {{{0, 5, 1}, {60, 5, 1}}};
  report.track = {{0, 0}, {20, 0.4}, {60, -0.2}};
  report.datum = geometry::GeodeticPosition{.latitude = 36.66, .longitude = -5.8, .altitude = 60};
  report.conditions = {{.time = 1381300000,
                        .source = "night",
                        .camera = "A20",
                        .parameters = "emissivity 0.04\ndistance 10 m",
                        .doubts = "emissivity 0.04: below 0.8 <!>"}};
  report.pictures_read = 12;
  report.pictures_failed = 1;
  report.pictures = {{.name = "broken.jpg", .problem = "is empty"},
                     {.name = "0\"1.png",
                      .summary = "160 x 120",
                      .doubts = "a\nb",
                      .overview = make_overview(picture.view(), picture.detections, 320)}};
  return report;
}

/// Whether every element that is opened is closed, in order.
bool balanced(const std::string& html) {
  std::vector<std::string> open;
  for (std::size_t at = html.find('<'); at != std::string::npos; at = html.find('<', at + 1)) {
    const std::size_t end = html.find('>', at);
    if (end == std::string::npos) {
      return false;
    }
    const std::string tag = html.substr(at + 1, end - at - 1);
    const std::string name = tag.substr(0, tag.find_first_of(" /\n", 1));
    if (tag[0] == '!' || tag.back() == '/' || name == "meta") {
      continue;
    }
    if (tag[0] != '/') {
      open.push_back(name);
    } else if (open.empty() || "/" + open.back() != tag) {
      return false;
    } else {
      open.pop_back();
    }
  }
  return open.empty();
}

TEST(LeakReport, HoldsAll) {
  const std::string html = leak_report_html(example());
  EXPECT_TRUE(balanced(html));
  EXPECT_THAT(html, HasSubstr("<title>Loop 7 &lt;b&gt;&amp; &quot;8&quot;&lt;/b&gt;</title>"));
  EXPECT_THAT(html, HasSubstr("Map of the findings"));
  EXPECT_THAT(html, HasSubstr("<ellipse"));
  EXPECT_THAT(html, HasSubstr("95.5 (90.2 to 100.8)"));
  EXPECT_THAT(html, HasSubstr("C  Parts and their labels"));
  EXPECT_THAT(html, HasSubstr("class=\"leak-mark\""));
  EXPECT_THAT(html, HasSubstr("emissivity 0.04\ndistance 10 m"));
  EXPECT_THAT(html, HasSubstr("below 0.8 &lt;!&gt;"));
  EXPECT_THAT(html, HasSubstr("1 could not be used"));
  EXPECT_THAT(html, HasSubstr("WGS 84: 36.66"));
}

TEST(LeakReport, NeedsNothingElse) {
  const std::string html = leak_report_html(example());
  for (const char* reference : {"http:", "https:", "<script", "<link", "src=", "url(", "@import"}) {
    EXPECT_THAT(html, Not(HasSubstr(reference)));
  }
  for (std::size_t at = html.find("href=\""); at != std::string::npos;
       at = html.find("href=\"", at + 1)) {
    const std::string target = html.substr(at + 6, 22);
    EXPECT_TRUE(target[0] == '#' || target == "data:image/png;base64,") << target;
  }
}

TEST(LeakReport, TheWorstComesFirst) {
  const std::string html = leak_report_html(example());
  std::size_t last = 0;
  // By severity: critical 3, severe 2, moderate 1, minor 4; what was cleared at the end.
  for (const char* id : {"leak3", "leak2", "leak1", "leak4", "leak9"}) {
    const std::size_t at = html.find(std::string("id=\"") + id);
    ASSERT_NE(at, std::string::npos);
    EXPECT_GT(at, last);
    last = at;
  }
}

TEST(LeakReport, OfNothing) {
  const std::string html = leak_report_html({});
  EXPECT_TRUE(balanced(html));
  EXPECT_THAT(html, HasSubstr("No finding has a position"));
  EXPECT_THAT(html, HasSubstr("No finding."));
  EXPECT_THAT(html, HasSubstr("No entries."));
}

TEST(LeakReport, IsTheSameOfTheSame) {
  EXPECT_EQ(leak_report_html(example()), leak_report_html(example()));
}

}  // namespace
}  // namespace pipescout
