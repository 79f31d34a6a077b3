// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/composition.hpp"
#include "core/image_shrink.hpp"
#include "pipescout/files/yaml_location.hpp"

namespace pipescout::host {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::UnorderedElementsAre;

Composition parse_exports(const std::string& exports) {
  CompositionInputs inputs;
  inputs.ns = "/robot_1";
  return parse_composition("name: a\ncomponents:\n  - {type: pipescout::A, name: a}\n" + exports,
                           "a.yaml", inputs);
}

std::string complaint_about(const std::string& exports) {
  try {
    (void)parse_exports(exports);
  } catch (const YamlError& error) {
    return error.what();
  }
  return "";
}

TEST(Export, WithoutItAllTopicsMayLeave) {
  EXPECT_FALSE(parse_exports("").exports);
  EXPECT_FALSE(exported_topics(parse_exports("")));
}

TEST(Export, OfNothingKeepsAllTopics) {
  EXPECT_TRUE(exported_topics(parse_exports("export:\n"))->empty());
  EXPECT_TRUE(exported_topics(parse_exports("export: []\n"))->empty());
}

TEST(Export, NamesAreBelowTheNamespaceOfTheRobot) {
  const auto composition = parse_exports(
      "export:\n  - leak/events\n  - /map\n"
      "  - {topic: thermal/image_raw, as: thermal/preview, rate: 2, shrink: 4}\n");
  EXPECT_THAT(*exported_topics(composition),
              UnorderedElementsAre("/robot_1/leak/events", "/map", "/robot_1/thermal/preview"));
  const auto& reduced = composition.exports->back();
  EXPECT_EQ(reduced.topic, "/robot_1/thermal/image_raw");
  EXPECT_EQ(reduced.rate, 2.0);
  EXPECT_EQ(reduced.shrink, 4);
  EXPECT_EQ(reduced.location, "a.yaml:7:5");
}

TEST(Export, IsKeptInTheCompositionAsItWasRun) {
  const auto composition = parse_exports(
      "export:\n  - leak/events\n  - {topic: image, as: preview, rate: 0.5, shrink: 4}\n");
  const auto again = parse_composition(to_yaml(composition, {}), "a.yaml", {});
  ASSERT_EQ(again.exports->size(), 2U);
  EXPECT_EQ(again.exports->at(0).topic, "/robot_1/leak/events");
  EXPECT_EQ(again.exports->at(1).as, "/robot_1/preview");
  EXPECT_EQ(again.exports->at(1).rate, 0.5);
  EXPECT_EQ(again.exports->at(1).shrink, 4);
}

TEST(Export, FaultsAreNamed) {
  EXPECT_THAT(complaint_about("export: all\n"), HasSubstr("'export' must be a list of topics"));
  EXPECT_THAT(complaint_about("export:\n  - {as: b}\n"), HasSubstr("a.yaml:5:5: an entry"));
  EXPECT_THAT(complaint_about("export:\n  - {topic: a, rates: 2}\n"), HasSubstr("'rates'"));
  EXPECT_THAT(complaint_about("export:\n  - {topic: a, rate: 2}\n"),
              HasSubstr("needs a name of its own"));
  EXPECT_THAT(complaint_about("export:\n  - {topic: a, as: b}\n"), HasSubstr("'as' is for"));
  EXPECT_THAT(complaint_about("export:\n  - {topic: a, as: a, rate: 2}\n"),
              HasSubstr("the topic itself"));
  EXPECT_THAT(complaint_about("export:\n  - {topic: a, as: b, rate: 0}\n"),
              HasSubstr("'rate' must be a number of messages per second in [0.001, 1000]"));
  EXPECT_THAT(complaint_about("export:\n  - {topic: a, as: b, shrink: 100}\n"),
              HasSubstr("[1, 64]"));
  EXPECT_THAT(complaint_about("export:\n  - a b\n"), HasSubstr("a.yaml:5:5"));
}

sensor_msgs::msg::Image image(const std::string& encoding, std::uint32_t width,
                              std::uint32_t height, std::uint32_t step,
                              std::vector<std::uint8_t> data) {
  sensor_msgs::msg::Image result;
  result.encoding = encoding;
  result.width = width;
  result.height = height;
  result.step = step;
  result.data.assign(data.begin(), data.end());
  return result;
}

TEST(Shrink, TakesTheMeanOfEachBlock) {
  // 5 x 2 pixels with a padded row; the fifth column is cut off.
  const auto smaller =
      shrink(image("mono8", 5, 2, 6, {1, 2, 10, 20, 99, 0, 3, 5, 30, 41, 99, 0}), 2);
  ASSERT_TRUE(smaller);
  EXPECT_EQ(smaller->width, 2U);
  EXPECT_EQ(smaller->height, 1U);
  EXPECT_EQ(smaller->step, 2U);
  EXPECT_THAT(smaller->data, ElementsAre(3, 25));
}

TEST(Shrink, KeepsChannelsApart) {
  const auto smaller =
      shrink(image("rgb8", 2, 2, 6, {0, 10, 20, 4, 10, 20, 0, 10, 20, 4, 10, 60}), 2);
  ASSERT_TRUE(smaller);
  EXPECT_THAT(smaller->data, ElementsAre(2, 10, 30));
}

TEST(Shrink, KnowsTheOrderOfBytes) {
  auto thermal = image("mono16", 2, 1, 4, {0x00, 0x01, 0x02, 0x01});
  thermal.height = 2;
  thermal.data.insert(thermal.data.end(), {0x00, 0x01, 0x02, 0x01});
  EXPECT_THAT(shrink(thermal, 2)->data, ElementsAre(0x01, 0x01));
  thermal.is_bigendian = 1;  // 0x0001 and 0x0201
  EXPECT_THAT(shrink(thermal, 2)->data, ElementsAre(0x01, 0x01));
}

TEST(Shrink, RefusesWhatItCannotRead) {
  EXPECT_FALSE(shrink(image("32FC1", 2, 2, 8, std::vector<std::uint8_t>(16)), 2));
  EXPECT_FALSE(shrink(image("mono8", 1, 4, 1, {1, 2, 3, 4}), 2));
  EXPECT_FALSE(shrink(image("mono8", 2, 2, 2, {1, 2, 3}), 2));
  EXPECT_FALSE(shrink(image("mono8", 4, 2, 2, std::vector<std::uint8_t>(8)), 2));
}

}  // namespace
}  // namespace pipescout::host
