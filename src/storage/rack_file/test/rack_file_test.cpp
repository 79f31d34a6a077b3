// SPDX-License-Identifier: Apache-2.0
#include "pipescout/rack_file/rack_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "pipescout/files/yaml_location.hpp"

namespace pipescout {
namespace {

using rack_vision::RackModel;
using ::testing::HasSubstr;
using ::testing::StartsWith;

TEST(RackFile, ThePapersRackHasFivePipes) {
  const RackModel model = read_rack(RACKS "/paper_rack.yaml");
  ASSERT_EQ(model.pipes.size(), 5U);
  EXPECT_TRUE(model.supports.empty());
  EXPECT_EQ(model.pipes[0].radii.size(), 4U);
  EXPECT_DOUBLE_EQ(model.pipes[0].start.x(), 0.2);
  EXPECT_DOUBLE_EQ(model.pipes[1].start.x(), 0.4 + 0.1 + 0.15);
  EXPECT_DOUBLE_EQ(model.pipes[3].start.x() + 0.18, 1.76);
  for (const rack_vision::Pipe& pipe : model.pipes) {
    EXPECT_EQ(pipe.length(), 10);
  }
  EXPECT_EQ(model.pipes[4].direction, Eigen::Vector3d::UnitX());
  EXPECT_FALSE(model.pipes[0].movable);
  EXPECT_TRUE(model.pipes[1].movable);
  EXPECT_FALSE(model.pipes[4].movable);
}

TEST(RackFile, AllRacksThatAreInstalledAreValid) {
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(RACKS)) {
    EXPECT_NO_THROW((void)read_rack(entry.path().string())) << entry.path();
    ++files;
  }
  EXPECT_GE(files, 2);
}

TEST(RackFile, VesselsAreCylindersThatStayInPlace) {
  const RackModel model = parse_rack(R"(row: [{name: a, radius: 0.1, length: 5}]
vessels:
  - {name: drum, start: [1, 2, 0.4], direction: [1, 1, 0], radius: 0.4, length: 2}
  - {name: column, start: [-2, 1, 0], direction: [0, 0, 1], radii: [{along: 0, radius: 0.5},
     {along: 3, radius: 0.2}]}
)",
                                     "rack.yaml");
  ASSERT_EQ(model.pipes.size(), 3U);
  EXPECT_EQ(model.pipes[1].name, "drum");
  EXPECT_FALSE(model.pipes[1].movable);
  EXPECT_EQ(model.pipes[2].direction, Eigen::Vector3d::UnitZ());
  EXPECT_THAT([] { (void)parse_rack("vessels: [{name: a, movable: true}]", "rack.yaml"); },
              ::testing::ThrowsMessage<YamlError>(HasSubstr("unknown field 'movable'")));
}

TEST(RackFile, PipesMayStandForThemselves) {
  const RackModel model = parse_rack(R"(pipes:
  - {name: a, start: [0, 0, 0], direction: [0, 2, 0], radius: 0.1, length: 5}
  - {name: b, start: [1, 0, 0], direction: [0, 1, 1], radius: 0.1, length: 5, movable: false}
  - {name: c, start: [2, 0, 0], direction: [0, 1, 0], radii: [{along: 0, radius: 0.1},
     {along: 2, radius: 0.1}, {along: 2, radius: 0.2}, {along: 3, radius: 0.2}]}
supports: [{name: beam, lowest_corner: [-1, 0, -1], highest_corner: [3, 1, -0.1]}])",
                                     "rack.yaml");
  ASSERT_EQ(model.pipes.size(), 3U);
  EXPECT_EQ(model.pipes[0].direction, Eigen::Vector3d::UnitY());
  EXPECT_NEAR(model.pipes[1].direction.norm(), 1, 1e-15);
  EXPECT_FALSE(model.pipes[0].movable);
  EXPECT_FALSE(model.pipes[1].movable);
  EXPECT_TRUE(model.pipes[2].movable);
  EXPECT_EQ(model.pipes[2].length(), 3);
  ASSERT_EQ(model.supports.size(), 1U);
  EXPECT_EQ(model.supports[0].highest_corner, Eigen::Vector3d(3, 1, -0.1));
}

TEST(RackFile, DeviationsOfShapesArrive) {
  const RackModel model = parse_rack(R"(row:
  - {name: a, radius: 0.1, length: 5}
  - {name: b, radius: 0.1, length: 5, height_deviation: 0.03, radius_deviation: 0.02}
pipes:
  - {name: c, start: [2, 0, 0], direction: [0, 1, 0], radius: 0.1, length: 5,
     direction_deviation: 0.006}
vessels:
  - {name: column, start: [-2, 1, 0], direction: [0, 0, 1], radius: 0.5, length: 3,
     direction_deviation: 0.01, radius_deviation: 0.05}
  - {name: drum, start: [4, 1, 0], direction: [0, 1, 0], radius: 0.5, length: 3,
     height_deviation: 0.04}
)",
                                     "rack.yaml");
  ASSERT_EQ(model.pipes.size(), 5U);
  EXPECT_FALSE(model.pipes[0].shape_deviation.any());
  EXPECT_EQ(model.pipes[1].shape_deviation.height, 0.03);
  EXPECT_EQ(model.pipes[1].shape_deviation.direction, 0);
  EXPECT_EQ(model.pipes[1].shape_deviation.radius, 0.02);
  EXPECT_EQ(model.pipes[2].shape_deviation.height, 0);
  EXPECT_EQ(model.pipes[2].shape_deviation.direction, 0.006);
  EXPECT_EQ(model.pipes[3].shape_deviation.height, 0);
  EXPECT_EQ(model.pipes[3].shape_deviation.direction, 0.01);
  EXPECT_EQ(model.pipes[3].shape_deviation.radius, 0.05);
  EXPECT_EQ(model.pipes[4].shape_deviation.height, 0.04);
}

void expect_error(const std::string& text, const std::string& where, const std::string& what) {
  try {
    (void)parse_rack(text, "rack.yaml");
    ADD_FAILURE() << "accepted:\n" << text;
  } catch (const YamlError& error) {
    EXPECT_THAT(error.what(), StartsWith("rack.yaml:" + where + ":")) << text;
    EXPECT_THAT(error.what(), HasSubstr(what)) << text;
  }
}

/// A good first pipe in line 2, then the line given.
std::string row(const std::string& line) {
  return "row:\n  - {name: a, radius: 0.1, length: 5}\n  - " + line + "\n";
}

TEST(RackFile, SaysInWhichLineAPipeIsWrong) {
  expect_error(row("{name: b, radius: -0.1, length: 5}"), "3:23",
               "radius is -0.1; it must be above 0 m");
  expect_error(row("{name: b, radius: 0, length: 5}"), "3:23", "above 0 m");
  expect_error(row("{name: b, radius: .nan, length: 5}"), "3:23", "finite number, not '.nan'");
  expect_error(row("{name: b, radius: nan, length: 5}"), "3:23", "finite number");
  expect_error(row("{name: b, radius: 1e999, length: 5}"), "3:23", "finite number");
  expect_error(row("{name: b, radius: 0.1 m, length: 5}"), "3:23", "finite number, not '0.1 m'");
  expect_error(row("{name: b, radius: '0.1', length: 5}"), "3:23", "finite number");
  expect_error(row("{name: b, radius: , length: 5}"), "3", "finite number");
  expect_error(row("{name: b, radius: [0.1], length: 5}"), "3:23", "finite number");
  expect_error(row("{name: b, radius: 0.1}"), "3:5", "field 'length' is missing");
  expect_error(row("{name: b, length: 5}"), "3:5", "'radii' is missing");
  expect_error(row("{radius: 0.1, length: 5}"), "3:5", "field 'name' is missing");
  expect_error(row("{name: , radius: 0.1, length: 5}"), "3", "name must be a text");
  expect_error(row("{name: a, radius: 0.1, length: 5}"), "3:5", "name is also that of number 0");
  expect_error(row("{name: b, diameter: 0.1, length: 5}"), "3:15",
               "unknown field 'diameter' of a pipe of the row (known: name, radius");
  expect_error(row("{name: b, radius: 0.1, length: 5, gap: -0.1}"), "3:44", "at least 0 m");
  expect_error(row("{name: b, radius: 0.1, length: 5, movable: maybe}"), "3:48", "true or false");
  expect_error(row("just text"), "3:5", "a pipe of the row must be a map");
  expect_error("row:\n  - {name: a, radius: 0.1, length: 5, gap: 0.1}\n", "2:44", "no gap");
  expect_error("row:\n  - {name: a, radius: 0.1, length: 5, movable: true}\n" +
                   row("{name: b, radius: 0.1, length: 5}").substr(43),
               "2:5", "for the first pipe");
}

TEST(RackFile, SaysInWhichLineADeviationOfAShapeIsWrong) {
  expect_error(row("{name: b, radius: 0.1, length: 5, height_deviation: high}"), "3:57",
               "height_deviation must be a finite number, not 'high'");
  expect_error(row("{name: b, radius: 0.1, length: 5, direction_deviation: '0.01'}"), "3:60",
               "direction_deviation must be a finite number");
  expect_error(row("{name: b, radius: 0.1, length: 5, radius_deviation: [0.01]}"), "3:57",
               "radius_deviation must be a finite number");
  expect_error(row("{name: b, radius: 0.1, length: 5, height_deviation: .nan}"), "3:57",
               "height_deviation must be a finite number");
  expect_error(row("{name: b, radius: 0.1, length: 5, height_deviation: -0.01}"), "3:5",
               "pipe 1 'b': height_deviation is -0.01; it must be 0 to 0.3 m");
  expect_error(row("{name: b, radius: 0.1, length: 5, direction_deviation: 0.2}"), "3:5",
               "pipe 1 'b': direction_deviation is 0.2; it must be 0 to 0.1 rad");
  expect_error(row("{name: b, radius: 0.1, length: 5, radius_deviation: 0.05}"), "3:5",
               "pipe 1 'b': radius_deviation is 0.05; it must be at least 0 m");
  expect_error("row:\n  - {name: a, radius: 0.1, length: 5, radius_deviation: 0.01}\n", "2:5",
               "pipe 0 'a': deviations of its shape must be 0 for the first pipe");
  expect_error(
      "pipes:\n  - {name: a, start: [0, 0, 0], direction: [0, 1, 0], radius: 0.1, length: "
      "5, height_deviation: 0.01}\n",
      "2:5", "for the first pipe");
  const std::string upright = "{name: v, start: [3, 1, 0], direction: [0, 0, 1], radius: 0.1, ";
  for (const char* list : {"pipes:", "vessels:"}) {
    expect_error(row("{name: b, radius: 0.1, length: 5}") + list + "\n  - " + upright +
                     "length: 2, height_deviation: 0.01}",
                 "5:5", "pipe 2 'v': height_deviation must be 0 for a pipe steeper than 45");
  }
}

TEST(RackFile, SaysInWhichLineRadiiAreWrong) {
  const auto radii = [](const std::string& lines) {
    return "row:\n  - {name: a, radius: 0.1, length: 5}\n  - name: b\n    radii:\n" + lines;
  };
  expect_error(radii("      - {along: 0, radius: 0.1}\n      - {along: 5, radius: -0.2}\n"), "6:28",
               "radius is -0.2");
  expect_error(radii("      - {along: 0, radius: 0.1}\n      - {along: 5}\n"), "6:9",
               "field 'radius' is missing");
  expect_error(radii("      - {along: 0, radius: 0.1, colour: red}\n"), "5:33",
               "unknown field 'colour'");
  expect_error(radii("      - {along: 0, radius: 0.1}\n"), "3:5", "at least 2");
  expect_error(radii("      - {along: 1, radius: 0.1}\n      - {along: 5, radius: 0.2}\n"), "3:5",
               "radii[0].along is 1; it must be 0");
  expect_error(radii("      - {along: 0, radius: 0.1}\n      - {along: 5, radius: 0.1}\n"
                     "      - {along: 4, radius: 0.1}\n"),
               "3:5", "radii[2].along is 4");
  expect_error(radii("      - {along: 0, radius: 0.1}\n      - {along: 5, radius: 0.1}\n"
                     "    length: 5\n"),
               "7:13", "exclude each other");
  expect_error(row("{name: b, radii: 0.1}"), "3:22", "radii must be a list");
}

TEST(RackFile, SaysInWhichLineAPipeOfItsOwnOrASupportIsWrong) {
  const auto pipe = [](const std::string& line) { return row(line).replace(0, 3, "pipes"); };
  const std::string good =
      "row:\n  - {name: a, radius: 0.1, length: 5}\n"
      "  - {name: b, radius: 0.1, length: 5}\n";
  expect_error(pipe("{name: b, start: [0, 0, 0]}"), "2:5", "field 'start' is missing");
  expect_error(good +
                   "pipes:\n  - {name: c, start: [0, 0], direction: [0, 1, 0], radius: 1, "
                   "length: 1}",
               "5:22", "start must be a list of 3 numbers");
  expect_error(good +
                   "pipes:\n  - {name: c, start: [0, 0, x], direction: [0, 1, 0], radius: 1, "
                   "length: 1}",
               "5:29", "start must be a finite number, not 'x'");
  expect_error(good +
                   "pipes:\n  - {name: c, start: [5, 0, 1], direction: [0, 0, 0], radius: 1, "
                   "length: 1}",
               "5:44", "direction must not be zero");
  expect_error(good +
                   "pipes:\n  - {name: c, start: [5, 0, 1], direction: [0, 1, 0], radius: 1, "
                   "length: 1, gap: 1}",
               "5:77", "unknown field 'gap'");
  expect_error(good +
                   "supports:\n  - {name: s, lowest_corner: [0, 0, 0], highest_corner: [1, 0, "
                   "1]}",
               "5:5", "support 0 's': highest_corner.y is 0");
  expect_error(good + "supports: none\n", "4:11", "supports must be a list");
  expect_error(good + "beams: []\n", "4:1", "unknown field 'beams' of a rack");
}

TEST(RackFile, RefusesWhatIsNoRack) {
  expect_error("- a\n", "1:1", "a rack must be a map");
  EXPECT_THROW((void)parse_rack("row: [\n", "rack.yaml"), YamlError);
  EXPECT_THROW((void)parse_rack("", "rack.yaml"), YamlError);
  EXPECT_THROW((void)parse_rack("row: []\n", "rack.yaml"), YamlError);
  EXPECT_THROW((void)read_rack("/nowhere/rack.yaml"), YamlError);
}

TEST(RackFile, RefusesOnePipeAndPipesThatRunIntoEachOther) {
  const auto error_of = [](const std::string& path) -> std::string {
    try {
      (void)read_rack(path);
    } catch (const YamlError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(error_of(BAD_RACKS "/no_pipe.yaml"),
            BAD_RACKS "/no_pipe.yaml:1:1: the rack has 0 pipes; it must have 1 to 32");
  EXPECT_EQ(error_of(BAD_RACKS "/overlap.yaml"),
            BAD_RACKS "/overlap.yaml:6:5: pipe 2 'across': intersects pipe 1 'right'");
}

}  // namespace
}  // namespace pipescout
