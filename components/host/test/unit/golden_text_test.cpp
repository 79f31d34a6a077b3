// SPDX-License-Identifier: Apache-2.0
// Messages as text: as the reader of .idl files wrote them that there was before the field tables.
#include <gtest/gtest.h>

#include <golden_file.hpp>

#include "cli/message_text.hpp"
#include "cli/yaml_message.hpp"
#include "pipescout/idl/message_type.hpp"

namespace pipescout::host {
namespace {

constexpr MessageFormat kWhole{.truncate = std::nullopt};

TEST(GoldenText, YamlAndCsvOfEveryTypeAreAsBefore) {
  const auto messages = pipescout::testing::read_golden_files(GOLDEN_DIR);
  ASSERT_EQ(messages.size(), 290u);
  for (const auto& golden : messages) {
    SCOPED_TRACE(golden.type + " " + golden.kind);
    const auto& type = load_message_type(golden.type);
    const auto message = type.create();
    ASSERT_TRUE(type.deserialize(golden.cdr, message.get()));
    EXPECT_EQ(to_yaml({&type, message.get()}, kWhole), golden.yaml);
    EXPECT_EQ(to_csv({&type, message.get()}, kWhole), golden.csv);
  }
}

/// What is shown can be published: both forms are read back as the same bytes.
TEST(GoldenText, YamlIsReadBackAsTheSameMessage) {
  for (const auto& golden : pipescout::testing::read_golden_files(GOLDEN_DIR)) {
    SCOPED_TRACE(golden.type + " " + golden.kind);
    const auto& type = load_message_type(golden.type);
    const auto message = type.create();
    ASSERT_TRUE(type.deserialize(golden.cdr, message.get()));
    for (const bool flow : {false, true}) {
      const auto yaml = to_yaml({&type, message.get()}, {.truncate = std::nullopt, .flow = flow});
      const auto copy = type.create();
      ASSERT_NO_THROW(set_from_yaml(yaml, type, copy.get())) << yaml;
      EXPECT_EQ(to_yaml({&type, copy.get()}, kWhole), golden.yaml);
    }
  }
}

}  // namespace
}  // namespace pipescout::host
