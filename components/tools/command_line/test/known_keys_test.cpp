// SPDX-License-Identifier: Apache-2.0
#include "pipescout/command_line/known_keys.hpp"

#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include "pipescout/files/yaml_location.hpp"

namespace pipescout::command_line {
namespace {

std::string error_of(const std::string& text) {
  try {
    require_known_keys(parse_yaml(text, "f.yaml"), "f.yaml", "'export'", {"topic", "rate"});
  } catch (const YamlError& error) {
    return error.what();
  }
  return "";
}

TEST(KnownKeys, NameThePlaceAndWhatIsPossible) {
  EXPECT_EQ(error_of("topic: /a\nrate: 1\n"), "");
  EXPECT_EQ(error_of("topic: /a\nrat: 1\n"),
            "f.yaml:2:1: unknown key 'rat' in 'export'; did you mean 'rate'? (known: topic, rate)");
  EXPECT_EQ(error_of("- topic\n"), "f.yaml:1:1: 'export' must be a map with the keys topic, rate");
  EXPECT_EQ(error_of(""), "f.yaml: 'export' must be a map with the keys topic, rate");
}

}  // namespace
}  // namespace pipescout::command_line
