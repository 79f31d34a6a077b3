// SPDX-License-Identifier: Apache-2.0
// Compositions of compositions, conditions, and what each component has of its own.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "core/composition.hpp"
#include "pipescout/files/testing/temporary_folder.hpp"
#include "pipescout/files/yaml_location.hpp"

namespace pipescout::host {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::MatchesRegex;

class CompositionOfFiles : public ::testing::Test {
 protected:
  void write(const std::string& name, const std::string& text) const {
    std::filesystem::create_directories(path(name).parent_path());
    std::ofstream(path(name)) << text;
  }
  [[nodiscard]] std::filesystem::path path(const std::string& name) const {
    return folder_.path() / name;
  }
  [[nodiscard]] Composition load(const std::string& name = "c.yaml",
                                 CompositionInputs inputs = {}) const {
    inputs.mission_folder = [](const std::string& mission) { return "/missions/" + mission; };
    return load_composition(path(name).string(), inputs);
  }
  /// With the folder left out.
  [[nodiscard]] std::string error(const CompositionInputs& inputs = {}) const {
    try {
      static_cast<void>(load("c.yaml", inputs));
    } catch (const std::exception& error) {
      std::string text = error.what();
      const auto folder = folder_.path().string() + "/";
      for (auto at = text.find(folder); at != std::string::npos; at = text.find(folder)) {
        text.erase(at, folder.size());
      }
      return text;
    }
    return "no error";
  }
  static std::vector<std::string> names(const Composition& composition) {
    std::vector<std::string> names;
    for (const auto& entry : composition.components) {
      names.push_back(entry.name.fully_qualified());
    }
    return names;
  }
  static std::string parameter(const ComponentEntry& entry, const std::string& name) {
    std::string text = "none";
    for (const auto& one : entry.parameters) {
      text = one.name == name ? to_yaml(one.value) : text;
    }
    return text;
  }

 private:
  ::pipescout::testing::TemporaryFolder folder_;
};

TEST_F(CompositionOfFiles, IncludedComponentsComeFirstWithNamespaceAndArguments) {
  write("robots/robot.yaml", R"(
name: robot
executor: {type: multi_threaded, threads: 9}
arguments: {wheel: 0.3, side: left, folder: $(mission_folder)}
components:
  - {type: a::Base, name: base, parameters: {wheel: $(arg wheel), folder: $(arg folder)},
     parameter_files: [p.yaml]}
  - {type: a::Arm, name: arm, namespace: $(arg side)}
complete_when: [arm]
)");
  write("robots/p.yaml", "/**:\n  ros__parameters: {of_file: 7}\n");
  write("c.yaml", R"(
name: fleet
arguments: {first: robot_1, wheel: 0.5}
include:
  - {file: robots/robot.yaml, namespace: $(arg first), arguments: {wheel: $(arg wheel)}}
  - {file: robots/robot.yaml, namespace: robot_2, arguments: {side: right}}
components:
  - {type: a::Map, name: map}
complete_when: [/robot_2/base]
)");
  const auto composition = load();
  EXPECT_EQ(composition.name, "fleet");
  EXPECT_EQ(composition.executor, ExecutorSettings{});
  EXPECT_THAT(composition.arguments,
              ElementsAre(std::pair<std::string, std::string>("first", "robot_1"),
                          std::pair<std::string, std::string>("wheel", "0.5")));
  EXPECT_THAT(names(composition), ElementsAre("/robot_1/base", "/robot_1/left/arm", "/robot_2/base",
                                              "/robot_2/right/arm", "/map"));
  EXPECT_EQ(parameter(composition.components[0], "wheel"), "0.5");
  EXPECT_EQ(parameter(composition.components[2], "wheel"), "0.3");
  EXPECT_EQ(parameter(composition.components[2], "of_file"), "7");
  EXPECT_EQ(parameter(composition.components[2], "folder"), "/missions/fleet");
  std::vector<std::string> awaited;
  for (const auto& name : composition.complete_when) {
    awaited.push_back(name.fully_qualified());
  }
  EXPECT_THAT(awaited, ElementsAre("/robot_1/left/arm", "/robot_2/right/arm", "/robot_2/base"));
  EXPECT_THAT(composition.components[1].location, MatchesRegex(".*robots/robot.yaml:8:5"));
}

TEST_F(CompositionOfFiles, TheCommandLineReachesIncludedComponents) {
  write("robot.yaml", "components: [{type: a::Base, name: base}]\n");
  write("c.yaml", "include: [robot.yaml]\n");
  const auto composition = load("c.yaml", {.arguments = {},
                                           .ns = "/field",
                                           .parameters = {"base.wheel:=0.1", "x:=1"},
                                           .parameter_files = {},
                                           .sources = {},
                                           .mission_folder = {}});
  EXPECT_THAT(names(composition), ElementsAre("/field/base"));
  EXPECT_EQ(parameter(composition.components[0], "wheel"), "0.1");
  EXPECT_EQ(parameter(composition.components[0], "x"), "1");
}

TEST_F(CompositionOfFiles, CyclesAreErrors) {
  write("c.yaml", "include:\n  - sub/a.yaml\ncomponents: []\n");
  write("sub/a.yaml", "include:\n  - file: ../sub/b.yaml\n");
  write("sub/b.yaml", "include: [a.yaml]\n");
  EXPECT_EQ(error(),
            "sub/../sub/b.yaml:1:11: sub/../sub/a.yaml includes itself: a.yaml -> b.yaml -> "
            "a.yaml");
  write("c.yaml", "include: [c.yaml]\n");
  EXPECT_EQ(error(), "c.yaml:1:11: c.yaml includes itself: c.yaml -> c.yaml");
  // A condition ends it.
  write("c.yaml",
        "arguments: {again: true}\n"
        "include: [{file: a.yaml, if: $(arg again)}]\ncomponents: [{type: a::B, name: b}]\n");
  write("a.yaml", "components: []\n");
  EXPECT_EQ(error(), "no error");
}

TEST_F(CompositionOfFiles, ErrorsOfIncludes) {
  write("a.yaml", "arguments: {x: 1, needed: }\ncomponents: []\n");
  write("c.yaml", "include: [none.yaml]\n");
  EXPECT_EQ(error(), "c.yaml:1:11: there is no composition none.yaml");
  write("c.yaml", "include: [.]\n");
  EXPECT_EQ(error(), "c.yaml:1:11: . is a folder, and no composition");
  write("c.yaml", "include: ['']\n");
  EXPECT_EQ(error(), "c.yaml:1:11: the name of a composition is empty");
  write("c.yaml", "include: [" + std::string(300, 'x') + "]\n");
  EXPECT_THAT(error(), HasSubstr("c.yaml:1:11: there is no composition xxx"));
  write("c.yaml", "include: [$(arg robot)]\n");
  EXPECT_EQ(error(), "c.yaml:1:11: '$(arg robot)': there is no argument 'robot'");
  write("empty.yaml", "");
  write("c.yaml", "include: [empty.yaml]\n");
  EXPECT_THAT(error(), HasSubstr("empty.yaml"));
  write("c.yaml", "include: [a.yaml]\n");
  EXPECT_EQ(error(),
            "a.yaml:1:19: argument 'needed' has no default: give it where a.yaml is included");
  write("c.yaml", "include:\n  - file: a.yaml\n    arguments: {needed: 1, y: 1}\n");
  EXPECT_EQ(error(), "c.yaml:3:16: argument y:=1: a.yaml has no argument 'y'");
  write("c.yaml", "include: [{files: a.yaml}]\n");
  EXPECT_THAT(error(), HasSubstr("c.yaml:1:11: an entry of 'include' is a file, or a map"));
  write("c.yaml", "include: [{file: a.yaml, name: b}]\n");
  EXPECT_THAT(error(), HasSubstr("unknown key 'name' in an entry of 'include'"));
  write("c.yaml", "include: a.yaml\n");
  EXPECT_EQ(error(), "c.yaml:1:10: 'include' must be a list of compositions");
  write("c.yaml", "include: [{file: a.yaml, arguments: [needed]}]\n");
  EXPECT_THAT(error(), HasSubstr("'arguments' of an include must be a map"));
  write("b.yaml", "components: [{type: a::B, name: b}]\n");
  write("c.yaml", "include: [b.yaml, b.yaml]\n");
  EXPECT_EQ(error(),
            "b.yaml:1:33: component '/b' is there twice, since this file is included more than "
            "once: give each include a namespace of its own");
  write("c.yaml", "include: [b.yaml]\ncomponents: [{type: a::B, name: b}]\n");
  EXPECT_EQ(error(), "c.yaml:2:33: two components have the name '/b'; the other is at b.yaml:1:14");
  write("b.yaml", "components: []\ncomplete_when: [c]\n");
  write("c.yaml", "include: [b.yaml]\ncomponents: [{type: a::C, name: c}]\n");
  EXPECT_EQ(error(), "b.yaml:2:17: no component 'c' in this composition");
}

TEST_F(CompositionOfFiles, ConditionsLeaveComponentsOut) {
  write("p.yaml", "camera:\n  ros__parameters: {rate: 5}\n");
  write("c.yaml", R"(
arguments: {with_camera: "no", simulated: true}
components:
  - {type: a::Camera, name: camera, if: $(arg with_camera), parameter_files: [none.yaml]}
  - {type: a::Driver, name: driver, unless: $(arg simulated)}
  - {type: a::Simulation, name: driver, if: $(arg simulated)}
  - {type: a::Map, name: map, if: true, unless: false}
complete_when: [camera, map]
)");
  CompositionInputs inputs;
  inputs.parameters = {"camera.rate:=3"};
  inputs.parameter_files = {path("p.yaml").string()};
  const auto composition = load("c.yaml", inputs);
  EXPECT_THAT(names(composition), ElementsAre("/driver", "/map"));
  EXPECT_EQ(composition.components[0].type, "a::Simulation");
  EXPECT_EQ(composition.complete_when.size(), 1U);

  inputs.arguments = {{"with_camera", "perhaps"}};
  EXPECT_EQ(error(inputs), "c.yaml:4:41: 'if' must be true or false, not '$(arg with_camera)'");
  inputs.arguments = {{"with_camera", "true"}};
  EXPECT_THAT(error(inputs), HasSubstr("there is no parameter file none.yaml"));
  write("c.yaml", "components: [{type: a::B, name: b, if: true, unles: false}]\n");
  EXPECT_THAT(error(), HasSubstr("unknown key 'unles' in a component; did you mean 'unless'?"));
}

TEST_F(CompositionOfFiles, ErrorsOfConditionsNameTheirPlace) {
  write("a.yaml", "components: [{type: a::A, name: a, unless: $(arg outer)}]\n");
  const std::vector<std::pair<std::string, std::string>> cases{
      {"components:\n  - {type: a::B, name: b, if: $(arg nowhere)}\n",
       "c.yaml:2:31: '$(arg nowhere)': there is no argument 'nowhere'"},
      {"components:\n  - {type: a::B, name: b, unless: $(env NOWHERE)}\n",
       "c.yaml:2:35: '$(env NOWHERE)': the environment has no 'NOWHERE'"},
      {"components:\n  - {type: a::B, name: b, if: [true]}\n", "c.yaml:2:31: 'if' must be a text"},
      {"components:\n  - {type: a::B, name: b, if: }\n", "c.yaml:2:31: 'if' must be a text"},
      {"include:\n  - {file: a.yaml, if: $(arg nowhere)}\n",
       "c.yaml:2:24: '$(arg nowhere)': there is no argument 'nowhere'"},
      {"include:\n  - {file: a.yaml, if: 1}\n", "c.yaml:2:24: 'if' must be true or false, not '1'"},
      // The arguments of the file that includes are not those of the file that is included.
      {"arguments: {outer: true}\ninclude: [a.yaml]\n",
       "a.yaml:1:44: '$(arg outer)': there is no argument 'outer'"},
  };
  for (const auto& [text, message] : cases) {
    write("c.yaml", text);
    EXPECT_EQ(error(), message);
  }
}

TEST_F(CompositionOfFiles, LogLevelsAndExecutorsOfComponents) {
  write("c.yaml", R"(
executor: {nice: 5}
components:
  - {type: a::A, name: a, log_level: debug, executor: {}}
  - {type: a::B, name: b, log_level: WARN, executor: {type: multi_threaded, threads: 2, fifo: 40}}
  - {type: a::C, name: c}
)");
  const auto composition = load();
  EXPECT_EQ(composition.executor, (ExecutorSettings{.threads = 1, .nice = 5, .fifo = {}}));
  const auto& components = composition.components;
  EXPECT_EQ(components[0].log_level, LogSeverity::kDebug);
  EXPECT_EQ(components[0].executor, ExecutorSettings{});
  EXPECT_EQ(components[1].executor, (ExecutorSettings{.threads = 2, .nice = {}, .fifo = 40}));
  EXPECT_EQ(components[2].log_level, std::nullopt);
  EXPECT_EQ(components[2].executor, std::nullopt);

  write("c.yaml", to_yaml(composition, {}));
  const auto again = load();
  for (std::size_t k = 0; k < components.size(); ++k) {
    EXPECT_EQ(again.components[k].log_level, components[k].log_level);
    EXPECT_EQ(again.components[k].executor, components[k].executor);
  }
  EXPECT_EQ(again.executor, composition.executor);

  for (const auto& [executor, message] : std::vector<std::pair<std::string, std::string>>{
           {"{fifo: 0}", "'fifo' must be a whole number in [1, 99], not '0'"},
           {"{nice: 20}", "'nice' must be a whole number in [-20, 19], not '20'"},
           {"{nice: 1, fifo: 1}",
            "'nice' means nothing to threads with the real-time priority 'fifo'"},
           {"{priority: 1}", "unknown key 'priority' in 'executor'"},
           {"own", "'executor' must be a map with the keys type, threads, nice, fifo"}}) {
    write("c.yaml", "components: [{type: a::A, name: a, executor: " + executor + "}]\n");
    EXPECT_THAT(error(), HasSubstr(message));
  }
  write("c.yaml", "components: [{type: a::A, name: a, log_level: loud}]\n");
  EXPECT_THAT(error(),
              HasSubstr("'log_level' must be debug, info, warn, error or fatal, not 'loud'"));
}

}  // namespace
}  // namespace pipescout::host
