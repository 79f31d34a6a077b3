// SPDX-License-Identifier: Apache-2.0
#include "pipescout/command_line/map_texts.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <functional>

#include "pipescout/files/yaml_location.hpp"

namespace pipescout::command_line {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

const YAML::Node kMap = YAML::Load("one: text\nmany: [a, b]\nempty: ''\nnone: []\nmap: {a: b}\n");

std::string refusal_of(const std::function<void()>& read) {
  try {
    read();
  } catch (const YamlError& error) {
    return error.what();
  }
  return "";
}

TEST(MapTexts, AreReadByTheirKey) {
  EXPECT_EQ(map_text(kMap, "one", "f.yaml"), "text");
  EXPECT_EQ(map_text(kMap, "missing", "f.yaml"), std::nullopt);
  EXPECT_EQ(required_map_text(kMap, "one", "f.yaml"), "text");
  EXPECT_THAT(map_texts(kMap, "one", "f.yaml"), ElementsAre("text"));
  EXPECT_THAT(map_texts(kMap, "many", "f.yaml"), ElementsAre("a", "b"));
}

TEST(MapTexts, NameFileKeyAndProblem) {
  for (const char* key : {"many", "empty", "map"}) {
    EXPECT_THAT(refusal_of([&] { (void)map_text(kMap, key, "f.yaml"); }),
                HasSubstr(std::string(key) + " must be a text"));
  }
  for (const char* key : {"none", "map"}) {
    EXPECT_THAT(refusal_of([&] { (void)map_texts(kMap, key, "f.yaml"); }),
                HasSubstr(std::string(key) + " must be a text or a list of texts"));
  }
  EXPECT_THAT(refusal_of([] { (void)required_map_text(kMap, "missing", "f.yaml"); }),
              HasSubstr("f.yaml"));
  EXPECT_THAT(refusal_of([] { (void)map_texts(kMap, "missing", "f.yaml"); }),
              HasSubstr("key 'missing' is missing"));
}

}  // namespace
}  // namespace pipescout::command_line
