// SPDX-License-Identifier: Apache-2.0
#include "pipescout/mission_folder/mission_section.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace pipescout {
namespace {

MissionSection example() {
  return {.title = "Odometry",
          .columns = {"reading", "fused [m]", "support set", "good"},
          .rows = {{std::int64_t{1}, 5.5099, std::string("2 3"), true},
                   {std::int64_t{2}, std::monostate{}, std::string(), false}},
          .figures = {{"odometry_readings", 2.0}},
          .notes = {"Complete."}};
}

TEST(MissionSection, HasTheDocumentedForm) {
  const auto json = nlohmann::json::parse(to_json(example()));
  EXPECT_EQ(json.at("title"), "Odometry");
  EXPECT_EQ(json.at("table").at("columns").size(), 4U);
  EXPECT_EQ(json.at("table").at("rows").at(0),
            nlohmann::json::parse(R"([1, 5.5099, "2 3", true])"));
  EXPECT_EQ(json.at("table").at("rows").at(1), nlohmann::json::parse(R"([2, null, "", false])"));
  EXPECT_EQ(json.at("figures").at("odometry_readings"), 2.0);
  EXPECT_EQ(json.at("notes").at(0), "Complete.");
  EXPECT_EQ(json.size(), 4U);
}

TEST(MissionSection, EmptySectionHasAllMembers) {
  const auto json = nlohmann::json::parse(
      to_json({.title = "Nothing", .columns = {}, .rows = {}, .figures = {}, .notes = {}}));
  EXPECT_TRUE(json.at("table").at("columns").is_array());
  EXPECT_TRUE(json.at("table").at("rows").is_array());
  EXPECT_TRUE(json.at("figures").is_object());
  EXPECT_TRUE(json.at("notes").is_array());
}

TEST(MissionSection, WhatJsonCannotHoldBecomesNull) {
  MissionSection section = example();
  section.rows[0][1] = std::numeric_limits<double>::quiet_NaN();
  section.figures["bad_m"] = std::numeric_limits<double>::infinity();
  section.notes[0] = "\xFF";
  const auto json = nlohmann::json::parse(to_json(section));
  EXPECT_TRUE(json.at("table").at("rows").at(0).at(1).is_null());
  EXPECT_TRUE(json.at("figures").at("bad_m").is_null());
  EXPECT_EQ(json.at("notes").at(0), "\xEF\xBF\xBD");
}

TEST(MissionSection, RowsFitTheColumns) {
  MissionSection section = example();
  section.rows[1].pop_back();
  EXPECT_THROW((void)to_json(section), std::invalid_argument);
}

TEST(MissionSection, NamedAfterItsNode) {
  EXPECT_EQ(mission_section_name("/recorder"), "recorder");
  EXPECT_EQ(mission_section_name("/robot_1/arm/recorder"), "robot_1.arm.recorder");
}

}  // namespace
}  // namespace pipescout
