// SPDX-License-Identifier: Apache-2.0
#include "pipescout/command_line/mission_summary.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <sstream>

#include "core/mission_folder.hpp"
#include "pipescout/files/testing/temporary_folder.hpp"

namespace pipescout::host {
namespace {

using command_line::print_summary;
using command_line::read_summary;
using command_line::write_summary;
using nlohmann::json;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
namespace fs = std::filesystem;

class MissionFolderTest : public ::testing::Test {
 protected:
  void write(const std::string& file, const std::string& text) const {
    fs::create_directories((root_ / file).parent_path());
    std::ofstream(root_ / file) << text;
  }
  [[nodiscard]] std::string read(const std::string& file) const {
    std::ifstream stream(root_ / file);
    return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
  }
  static std::string section(const std::string& title, const std::string& figure, double value) {
    return json{{"title", title},
                {"table",
                 {{"columns", {"reading", "fused [m]", "ok"}},
                  {"rows", {{1, 5.5, true}, {2, nullptr, false}, {10, 5.4375, true}}}}},
                {"figures", {{figure, value}}},
                {"notes", {"Complete."}}}
        .dump();
  }

  ::pipescout::testing::TemporaryFolder temporary_;
  const fs::path root_ = temporary_.path();
};

TEST_F(MissionFolderTest, MergesSections) {
  write("mission.yaml", "name: survey\ncomponents: []\n");
  write("sections/b.json", section("Second", "b_m", 0.5));
  write("sections/a.json", section("First", "a_m", 0.25));
  write("sections/readme.txt", "no section");
  const auto summary = read_summary(root_);
  EXPECT_EQ(summary.mission, "survey");
  EXPECT_THAT(summary.problems, IsEmpty());
  EXPECT_EQ(summary.figures, (json{{"a_m", 0.25}, {"b_m", 0.5}}));
  EXPECT_EQ(summary.sections["b"]["title"], "Second");
  write_summary(root_, summary);
  EXPECT_EQ(json::parse(read("summary.json")), summary.to_json());
  EXPECT_FALSE(fs::exists(root_ / "summary.json.part"));
}

TEST_F(MissionFolderTest, PrintsFiguresWithSixDigits) {
  const auto printed = [this](double value) {
    write("sections/a.json", section("First", "a_m", value));
    std::ostringstream out;
    print_summary(out, read_summary(root_));
    return out.str();
  };
  EXPECT_THAT(printed(0.018447532461), HasSubstr("a_m = 0.0184475\n"));
  EXPECT_THAT(printed(27051.0), HasSubstr("a_m = 27051\n"));
  EXPECT_THAT(printed(123456789.0), HasSubstr("a_m = 123456789\n"));
}

TEST_F(MissionFolderTest, PrintsTablesFiguresAndNotes) {
  write("mission.yaml", "name: survey\n");
  write("sections/a.json", section("First", "a_m", 0.25));
  std::ostringstream out;
  print_summary(out, read_summary(root_));
  EXPECT_EQ(out.str(), R"(Mission survey

First (a)

  reading  fused [m]  ok
  -------  ---------  ---
        1     5.5000  yes
        2          -  no
       10     5.4375  yes

  a_m = 0.25
  Complete.
)");
}

TEST_F(MissionFolderTest, NamesBadSectionsAndKeepsTheOthers) {
  write("sections/good.json", section("Good", "x_m", 1.0));
  write("sections/half.json", "{\"title\": \"Ha");
  write("sections/same.json", section("Same", "x_m", 2.0));
  const std::pair<const char*, const char*> bad[] = {
      {"list", "[]"},
      {"title",
       R"({"title": 1, "table": {"columns": [], "rows": []}, "figures": {}, "notes": []})"},
      {"table", R"({"title": "", "figures": {}, "notes": []})"},
      {"rows", R"({"title": "", "table": {"columns": ["a"], "rows": [[1, 2]]}, "figures": {},
                   "notes": []})"},
      {"cell", R"({"title": "", "table": {"columns": ["a"], "rows": [[{}]]}, "figures": {},
                   "notes": []})"},
      {"figures", R"({"title": "", "table": {"columns": [], "rows": []}, "figures": {"a": "b"},
                      "notes": []})"},
      {"notes", R"({"title": "", "table": {"columns": [], "rows": []}, "figures": {},
                    "notes": [1]})"}};
  for (const auto& [name, text] : bad) {
    write("sections/" + std::string(name) + ".json", text);
  }
  const auto summary = read_summary(root_);
  EXPECT_THAT(summary.problems,
              ElementsAre(HasSubstr("cell.json: has a table cell that is neither number"),
                          HasSubstr("figures.json: figure 'a' is not a number"),
                          HasSubstr("half.json: "), HasSubstr("list.json: is not an object"),
                          HasSubstr("notes.json: has no list of texts 'notes'"),
                          HasSubstr("rows.json: has a row that is not as long"),
                          HasSubstr("same.json: figure 'x_m' is also one of section 'good'"),
                          HasSubstr("table.json: has no object 'table'"),
                          HasSubstr("title.json: has no text 'title'")));
  EXPECT_EQ(summary.sections.size(), 2U);
  EXPECT_EQ(summary.figures["x_m"], 1.0);
  EXPECT_EQ(summary.mission, root_.filename().string());
}

TEST_F(MissionFolderTest, AFolderThatIsNotThereIsAnError) {
  EXPECT_THROW(static_cast<void>(read_summary(root_ / "none")), MissionFolderError);
}

TEST_F(MissionFolderTest, IsMadeAndLogged) {
  MissionFolder folder(root_ / "a" / "b");
  folder.write_composition("name: x\n");
  folder.log(LogSeverity::kWarn, Time(std::chrono::nanoseconds(1718000000000000007)),
             "robot.fusion", "text");
  EXPECT_EQ(read("a/b/mission.yaml"), "name: x\n");
  EXPECT_EQ(read("a/b/mission.log"), "[WARN] [1718000000.000000007] [robot.fusion]: text\n");
  EXPECT_TRUE(fs::is_directory(root_ / "a/b/sections"));
}

TEST_F(MissionFolderTest, DoesNotMixTwoMissions) {
  { const MissionFolder first(root_ / "a"); }
  EXPECT_THROW(MissionFolder(root_ / "a"), MissionFolderError);
  write("file", "");
  EXPECT_THROW(MissionFolder(root_ / "file"), MissionFolderError);
}

TEST_F(MissionFolderTest, DiscardsWhatItMade) {
  {
    MissionFolder folder(root_ / "a" / "b");
    folder.write_composition("name: x\n");
    fs::create_directories(root_ / "a/b/bag");
    folder.discard();
  }
  EXPECT_TRUE(fs::is_empty(root_));
  write("c/notes", "of the user");
  {
    MissionFolder folder(root_ / "c");
    folder.write_composition("name: x\n");
    folder.discard();
  }
  EXPECT_EQ(read("c/notes"), "of the user");
  EXPECT_FALSE(fs::exists(root_ / "c/mission.yaml"));
  EXPECT_FALSE(fs::exists(root_ / "c/sections"));
  write("d/notes", "of the user");
  { MissionFolder(root_ / "d/e").discard(); }
  EXPECT_TRUE(fs::exists(root_ / "d/notes"));
  EXPECT_FALSE(fs::exists(root_ / "d/e"));
}

TEST_F(MissionFolderTest, IsReservedWithTheTimeInItsName) {
  const Time time(std::chrono::seconds(1772357400));
  {
    const ReservedMissionFolder first(root_, "survey", time);
    EXPECT_EQ(first.path(), root_ / "missions/survey_2026-03-01T09-30-00Z");
    const ReservedMissionFolder second(root_, "survey", time);
    EXPECT_EQ(second.path(), root_ / "missions/survey_2026-03-01T09-30-00Z_2");
    EXPECT_TRUE(fs::is_directory(second.path()));
    const MissionFolder used(first.path());
  }
  // Only what was used stays.
  EXPECT_TRUE(fs::exists(root_ / "missions/survey_2026-03-01T09-30-00Z/sections"));
  EXPECT_FALSE(fs::exists(root_ / "missions/survey_2026-03-01T09-30-00Z_2"));
}

TEST_F(MissionFolderTest, AnUnusedReservationLeavesNothing) {
  { const ReservedMissionFolder unused(root_, "survey", Time{}); }
  EXPECT_TRUE(fs::is_empty(root_));
  write("missions", "a file");
  EXPECT_THROW(ReservedMissionFolder(root_, "survey", Time{}), MissionFolderError);
}

}  // namespace
}  // namespace pipescout::host
