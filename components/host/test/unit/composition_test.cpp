// SPDX-License-Identifier: Apache-2.0
#include "core/composition.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "pipescout/files/testing/temporary_folder.hpp"
#include "pipescout/files/yaml_location.hpp"

namespace pipescout::host {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

CompositionInputs inputs() {
  CompositionInputs inputs;
  inputs.sources.environment = [](const std::string& name) -> std::optional<std::string> {
    return name == "ROBOT" ? std::optional<std::string>("crawler") : std::nullopt;
  };
  inputs.sources.share = [](const std::string& package) -> std::optional<std::string> {
    return package == "pipescout_odometry" ? std::optional<std::string>("/prefix/share/x")
                                           : std::nullopt;
  };
  inputs.mission_folder = [](const std::string& mission) { return "/missions/" + mission; };
  return inputs;
}

Composition parse(const std::string& text, const CompositionInputs& given = inputs()) {
  return parse_composition(text, "c.yaml", given);
}

std::string error_of(const std::string& text, const CompositionInputs& given = inputs()) {
  try {
    static_cast<void>(parse(text, given));
  } catch (const std::exception& error) {
    return error.what();
  }
  return "";
}

const ParameterValue& value(const ComponentEntry& entry, const std::string& name) {
  const ParameterOverride* found = nullptr;
  for (const auto& parameter : entry.parameters) {
    found = parameter.name == name ? &parameter : found;
  }
  if (found == nullptr) {
    throw std::out_of_range("no parameter " + name);
  }
  return found->value;
}

constexpr const char* kWhole = R"(name: survey
arguments:
  readings: $(share pipescout_odometry)/table.csv
  rate: 2.5
  sigmas: "[0.06, 0.055]"
executor: {type: multi_threaded, threads: 4}
components:
  - type: pipescout::OdometerReplay
    name: replay
    namespace: front
    parameters:
      file: $(arg readings)
      rate: $(arg rate)
      sigmas: $(arg sigmas)
      title: rate $(arg rate) of $(env ROBOT)
      names: [$(env ROBOT), b]
      folder: $(mission_folder)/out
      limits: {low: 1, high: 2.0}
    remappings: {odometer/readings: other}
  - type: pipescout::OdometryFusion
    name: fusion
    isolate: true
    restart: {limit: 3, backoff: 2}
complete_when: [fusion]
)";

TEST(Composition, ReadsTheWholeFormat) {
  const auto composition = parse(kWhole);
  EXPECT_EQ(composition.name, "survey");
  EXPECT_EQ(composition.executor.threads, 4U);
  EXPECT_EQ(composition.mission_folder, "/missions/survey");
  EXPECT_THAT(composition.arguments,
              ElementsAre(std::pair("readings", "/prefix/share/x/table.csv"),
                          std::pair("rate", "2.5"), std::pair("sigmas", "[0.06, 0.055]")));
  ASSERT_EQ(composition.components.size(), 2U);
  const auto& replay = composition.components[0];
  EXPECT_EQ(replay.type, "pipescout::OdometerReplay");
  EXPECT_EQ(replay.name.fully_qualified(), "/front/replay");
  EXPECT_EQ(replay.location, "c.yaml:8:5");
  EXPECT_EQ(replay.type_location, "c.yaml:8:11");
  EXPECT_FALSE(replay.isolate);
  ASSERT_EQ(replay.remappings.size(), 1U);
  EXPECT_EQ(replay.remappings[0].to, "other");
  const auto& fusion = composition.components[1];
  EXPECT_TRUE(fusion.isolate);
  EXPECT_EQ(fusion.restart, (RestartPolicy{3, std::chrono::seconds(2)}));
  EXPECT_THAT(composition.complete_when, ElementsAre(NodeName{"/", "fusion"}));
}

TEST(Composition, SubstitutesAndTypesParameters) {
  const auto composition = parse(kWhole);
  const auto& replay = composition.components.at(0);
  EXPECT_EQ(value(replay, "file"), ParameterValue("/prefix/share/x/table.csv"));
  EXPECT_EQ(value(replay, "rate"), ParameterValue(2.5));
  EXPECT_EQ(value(replay, "sigmas"), ParameterValue(std::vector<double>{0.06, 0.055}));
  EXPECT_EQ(value(replay, "title"), ParameterValue("rate 2.5 of crawler"));
  EXPECT_EQ(value(replay, "names"), ParameterValue(std::vector<std::string>{"crawler", "b"}));
  EXPECT_EQ(value(replay, "folder"), ParameterValue("/missions/survey/out"));
  EXPECT_EQ(value(replay, "limits.high"), ParameterValue(2.0));
  EXPECT_EQ(replay.parameters.front().source, "c.yaml:12:13");
  EXPECT_EQ(replay.parameters.back().source, "c.yaml:18:30");
}

TEST(Composition, TakesArgumentsFromTheCommandLine) {
  auto given = inputs();
  given.arguments = {{"rate", "7"}, {"readings", "own.csv"}};
  const auto composition = parse(kWhole, given);
  EXPECT_EQ(value(composition.components.at(0), "rate"), ParameterValue(7));
  EXPECT_EQ(value(composition.components.at(0), "file"), ParameterValue("own.csv"));

  given.arguments = {{"raet", "7"}};
  EXPECT_EQ(error_of(kWhole, given),
            "argument raet:=7: c.yaml has no argument 'raet'; did you mean 'rate'?");
  given.arguments = {{"rate", "7"}, {"rate", "8"}};
  EXPECT_EQ(error_of(kWhole, given), "argument rate:=8: 'rate' is given twice, first as '7'");
  EXPECT_EQ(error_of("arguments: {file: }\ncomponents: []"),
            "c.yaml:1:13: argument 'file' has no default: give file:=VALUE");
}

TEST(Composition, DefaultsAreModest) {
  const auto composition = parse("components: [{type: A, name: a}]");
  EXPECT_EQ(composition.name, "c");
  EXPECT_EQ(composition.executor.threads, 1U);
  EXPECT_THAT(composition.complete_when, IsEmpty());
  EXPECT_EQ(composition.components.at(0).name.fully_qualified(), "/a");
  EXPECT_EQ(composition.components.at(0).restart, RestartPolicy{});
  EXPECT_THAT(parse("components: []").components, IsEmpty());
}

TEST(Composition, PutsComponentsBelowTheNamespaceOfTheCommandLine) {
  auto given = inputs();
  given.ns = "/robot_1";
  const auto composition = parse(
      "components: [{type: A, name: a}, {type: A, name: a, namespace: arm}, "
      "{type: A, name: a, namespace: /base}]",
      given);
  EXPECT_EQ(composition.components.at(0).name.fully_qualified(), "/robot_1/a");
  EXPECT_EQ(composition.components.at(1).name.fully_qualified(), "/robot_1/arm/a");
  EXPECT_EQ(composition.components.at(2).name.fully_qualified(), "/base/a");
}

TEST(Composition, LaterSourcesOfParametersCount) {
  auto given = inputs();
  given.parameters = {"gain:=3", "a.gain:=4", "b:limit.low:=5", "limit.low:=6"};
  const auto composition = parse(
      "components:\n- {type: A, name: a, parameters: {gain: 1}}\n- {type: A, name: b}", given);
  const auto& a = composition.components.at(0);
  const auto& b = composition.components.at(1);
  EXPECT_EQ(value(a, "gain"), ParameterValue(4));
  EXPECT_EQ(value(b, "gain"), ParameterValue(3));
  EXPECT_EQ(value(a, "limit.low"), ParameterValue(6));
  EXPECT_EQ(value(b, "limit.low"), ParameterValue(6));
  EXPECT_EQ(a.parameters.at(1).source, "--param gain:=3");
  EXPECT_TRUE(a.parameters.at(1).from_wildcard);
  EXPECT_FALSE(a.parameters.at(2).from_wildcard);

  given.parameters = {"c:gain:=1"};
  EXPECT_EQ(error_of("components: [{type: A, name: b}]", given),
            "--param c:gain:=1: no component 'c' in c.yaml");
  given.parameters = {"gain"};
  EXPECT_THAT(error_of("components: []", given), HasSubstr("must have the form name:=value"));
}

TEST(Composition, NamesFileLineAndColumnOfAnError) {
  const std::pair<const char*, const char*> cases[] = {
      {"", "c.yaml: a composition must be a map with the keys name"},
      {"[1]", "c.yaml:1:1: a composition must be a map"},
      {"name: x", "c.yaml:1:1: key 'components' is missing"},
      {"components: []\ncomplet_when: []",
       "c.yaml:2:1: unknown key 'complet_when' in a composition; did you mean 'complete_when'?"},
      {"name: a/b\ncomponents: []", "c.yaml:1:7: 'name' must consist of letters"},
      {"components: 3", "c.yaml:1:13: 'components' must be a list"},
      {"components:\n  - 3", "c.yaml:2:5: a component must be a map"},
      {"components:\n  - {type: A}", "c.yaml:2:5: key 'name' of a component is missing"},
      {"components:\n  - {name: a}", "c.yaml:2:5: key 'type' of a component is missing"},
      {"components:\n  - {type: A, name: 1a}", "c.yaml:2:21: "},
      {"components:\n  - {type: A, name: a, isolte: true}",
       "c.yaml:2:24: unknown key 'isolte' in a component; did you mean 'isolate'?"},
      {"components:\n  - {type: A, name: a, isolate: maybe}",
       "c.yaml:2:33: 'isolate' must be true or false, not 'maybe'"},
      {"components:\n  - {type: A, name: a, restart: {limit: 1}}",
       "c.yaml:2:33: 'restart' is for a component with 'isolate: true'"},
      {"components:\n  - {type: A, name: a, isolate: true, restart: {limit: -1}}",
       "c.yaml:2:56: 'limit' must be a whole number in [0, 1000000], not '-1'"},
      {"components:\n  - {type: A, name: a, isolate: true, restart: {backoff: x}}",
       "c.yaml:2:58: 'backoff' must be a number of seconds in [0, 3600], not 'x'"},
      {"components:\n  - {type: A, name: a}\n  - {type: B, name: a}",
       "c.yaml:3:21: two components have the name '/a'; the other is at c.yaml:2:5"},
      {"components:\n  - {type: A, name: a, parameters: 3}",
       "c.yaml:2:36: a map of parameters is expected"},
      {"components:\n  - {type: A, name: a, parameters: {x: [1, a]}}", "c.yaml:2:"},
      {"components:\n  - {type: A, name: a, parameters: {x: $(arg y)}}",
       "c.yaml:2:40: parameter 'x': '$(arg y)': there is no argument 'y'"},
      {"components:\n  - {type: A, name: a, remappings: {__node: b}}",
       "c.yaml:2:37: a component is renamed by its 'name' and 'namespace'"},
      {"components:\n  - {type: A, name: a, parameter_files: [none.yaml]}",
       "c.yaml:2:42: there is no parameter file none.yaml"},
      {"components:\n  - {type: A, name: alpha}\ncomplete_when: [alpa]",
       "c.yaml:3:17: no component 'alpa' in this composition; did you mean 'alpha'?"},
      {"components: []\nexecutor: {type: fast}",
       "c.yaml:2:18: 'type' must be single_threaded or multi_threaded, not 'fast'"},
      {"components: []\nexecutor: {type: single_threaded, threads: 2}",
       "c.yaml:2:44: a single_threaded executor has one thread"},
      {"components: []\nexecutor: {type: multi_threaded, threads: 0}",
       "c.yaml:2:43: 'threads' must be a whole number in [1, 256], not '0'"},
      {"components: [\n", "c.yaml:"},
      {"components: []\ncomponents: []", "c.yaml:2:1: "},
  };
  for (const auto& [text, message] : cases) {
    EXPECT_THAT(error_of(text), ::testing::StartsWith(message)) << text;
  }
}

TEST(Composition, RemapsForAllComponentsBehindTheirOwnRules) {
  const auto composition = parse(R"(
components:
  - {type: A, name: a}
  - {type: A, name: b, remappings: {/clock: other}}
remappings: {/clock: clock}
)");
  const auto clock_of = [&](std::size_t k) {
    const auto& entry = composition.components.at(k);
    return resolve_topic_name("/clock", {"/robot_1", entry.name.name}, entry.remappings);
  };
  EXPECT_EQ(clock_of(0), "/robot_1/clock");
  EXPECT_EQ(clock_of(1), "/robot_1/other");
  EXPECT_THAT(error_of("components: [{type: A, name: a}]\nremappings: {__node: b}"),
              ::testing::StartsWith("c.yaml:2:14: a component is renamed"));
}

TEST(Composition, CompleteWhenNeedsTheNamespaceOfAnAmbiguousName) {
  const std::string components =
      "components:\n- {type: A, name: a}\n- {type: A, name: a, namespace: x}\n";
  EXPECT_THAT(error_of(components + "complete_when: [a]"),
              HasSubstr("several components have the name 'a'"));
  EXPECT_THAT(parse(components + "complete_when: [/x/a]").complete_when,
              ElementsAre(NodeName{"/x", "a"}));
}

TEST(Composition, ReadsParameterFilesBesideItself) {
  const ::pipescout::testing::TemporaryFolder temporary;
  const auto& folder = temporary.path();
  std::ofstream(folder / "a.yaml") << "/**:\n  ros__parameters: {gain: 1, rate: 2}\n";
  std::ofstream(folder / "b.yaml") << "other:\n  ros__parameters: {gain: 1}\n";
  const auto path = (folder / "c.yaml").string();
  const auto text = [](const std::string& file) {
    return "components:\n- {type: A, name: a, parameter_files: [" + file +
           "], parameters: {gain: 3}}";
  };
  const auto composition = parse_composition(text("a.yaml"), path, inputs());
  EXPECT_EQ(value(composition.components.at(0), "rate"), ParameterValue(2));
  EXPECT_EQ(value(composition.components.at(0), "gain"), ParameterValue(3));
  EXPECT_THROW(static_cast<void>(parse_composition(text("b.yaml"), path, inputs())), YamlError);
}

TEST(Composition, ParameterFilesOfTheCommandLineNameItsComponents) {
  const ::pipescout::testing::TemporaryFolder temporary;
  const auto file = (temporary.path() / "p.yaml").string();
  auto given = inputs();
  given.parameter_files = {file};
  const auto write = [&](const std::string& node) {
    std::ofstream(file) << "# one node\n" << node << ":\n  ros__parameters: {gain: 7}\n";
  };
  const std::string text = "components: [{type: A, name: fusion, namespace: front}]";
  for (const char* node : {"/front/fusion", "front/fusion", "/**", "/*/fusion"}) {
    write(node);
    EXPECT_EQ(value(parse(text, given).components.at(0), "gain"), ParameterValue(7)) << node;
  }
  write("/other/**");
  EXPECT_THAT(parse(text, given).components.at(0).parameters, IsEmpty());
  write("/front/fusin");
  EXPECT_EQ(error_of(text, given), file +
                                       ":2: no component '/front/fusin' in c.yaml; did you mean "
                                       "'/front/fusion'?");
  write("fusion");
  EXPECT_EQ(error_of(text, given),
            file + ":2: no component '/fusion' in c.yaml; did you mean '/front/fusion'?");
}

TEST(Composition, KeepsPathsWhole) {
  auto given = inputs();
  given.arguments = {{"file", "/runs/day #3/a.csv"}};
  given.mission_folder = [](const std::string&) { return "/missions/day #3"; };
  given.sources.share = [](const std::string&) { return "/opt/5"; };
  const auto composition = parse(R"(arguments: {file: }
components:
  - {type: A, name: a, parameters: {file: $(arg file), out: $(mission_folder), data: $(share p)}}
)",
                                 given);
  const auto& entry = composition.components.at(0);
  EXPECT_EQ(value(entry, "file"), ParameterValue("/runs/day #3/a.csv"));
  EXPECT_EQ(value(entry, "out"), ParameterValue("/missions/day #3"));
  EXPECT_EQ(value(entry, "data"), ParameterValue("/opt/5"));
}

TEST(Composition, TakesAsManyThreadsAsAMachineHasUpToALimit) {
  EXPECT_EQ(default_threads(0), 2U);
  EXPECT_EQ(default_threads(8), 8U);
  EXPECT_EQ(default_threads(1024), 256U);
}

TEST(Composition, WritesItselfAsItWasRun) {
  const auto composition = parse(kWhole);
  const std::vector<std::vector<NamedParameter>> parameters{
      {{"file", "a: b"}, {"rate", 2.5}, {"limits.low", 1}, {"unset", {}}},
      {{"names", std::vector<std::string>{"x", "1"}}}};
  const auto text = to_yaml(composition, parameters);
  const auto again = parse(text);
  EXPECT_EQ(again.name, composition.name);
  EXPECT_EQ(again.arguments, composition.arguments);
  EXPECT_EQ(again.executor.threads, composition.executor.threads);
  EXPECT_EQ(again.complete_when, composition.complete_when);
  ASSERT_EQ(again.components.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(again.components[i].name, composition.components[i].name);
    EXPECT_EQ(again.components[i].type, composition.components[i].type);
    EXPECT_EQ(again.components[i].remappings, composition.components[i].remappings);
    EXPECT_EQ(again.components[i].isolate, composition.components[i].isolate);
    EXPECT_EQ(again.components[i].restart, composition.components[i].restart);
  }
  EXPECT_EQ(value(again.components[0], "file"), ParameterValue("a: b"));
  EXPECT_EQ(value(again.components[0], "limits.low"), ParameterValue(1));
  EXPECT_EQ(value(again.components[1], "names"),
            ParameterValue(std::vector<std::string>{"x", "1"}));
}

TEST(Composition, OptionsOfTheSummaryAreSubstitutedAndWrittenAsTheyWereRun) {
  const auto composition = parse(R"yaml(
name: c
arguments: {file: "true", rows: 7}
components: []
summary:
  odometry:
    reference_columns: ["$(arg file)"]
    table_rows: $(arg rows)
  rack.rack: $(share pipescout_odometry)/rack.yaml
)yaml");
  const std::string text = to_yaml(composition, {});
  EXPECT_THAT(text, HasSubstr("summary:\n"));
  const auto again = parse(text);
  ASSERT_EQ(again.summary.size(), 3U);
  EXPECT_EQ(again.summary[0].name, "odometry.reference_columns");
  EXPECT_EQ(again.summary[0].value, ParameterValue(std::vector<std::string>{"true"}));
  EXPECT_EQ(again.summary[1].value, ParameterValue(std::int64_t{7}));
  EXPECT_EQ(again.summary[2].value, ParameterValue("/prefix/share/x/rack.yaml"));
}

TEST(Composition, ComponentsStopInReverseWithThoseThatStopLastBehindTheOthers) {
  const auto composition = parse(R"(
name: c
components:
  - {type: T, name: a}
  - {type: T, name: recorder, stops_last: true}
  - {type: T, name: b}
)");
  EXPECT_THAT(stop_order(composition.components), ElementsAre(2U, 0U, 1U));
  EXPECT_TRUE(parse(to_yaml(composition, {})).components.at(1).stops_last);
}

TEST(ParseArgument, SplitsAtTheFirstSeparator) {
  EXPECT_EQ(parse_argument("a:=b:=c"), std::pair(std::string("a"), std::string("b:=c")));
  EXPECT_EQ(parse_argument("a:=").second, "");
  EXPECT_THROW(static_cast<void>(parse_argument("a=b")), CompositionError);
  EXPECT_THROW(static_cast<void>(parse_argument(":=b")), CompositionError);
}

TEST(Composition, ARobotDescriptionIsShortForTheComponentThatTellsIt) {
  const ::pipescout::testing::TemporaryFolder folder;
  const auto urdf = folder.path() / "robot.urdf";
  std::ofstream(urdf) << "<robot/>";
  const auto path = (folder.path() / "c.yaml").string();
  auto given = inputs();
  given.ns = "/robot_1";
  const auto composition = parse_composition(
      "robot_description: robot.urdf\ncomponents:\n  - {type: a::B, name: b}", path, given);
  ASSERT_EQ(composition.components.size(), 2U);
  const auto& first = composition.components.front();
  EXPECT_EQ(first.type, "pipescout::RobotDescription");
  EXPECT_EQ(first.name.fully_qualified(), "/robot_1/robot_description");
  EXPECT_EQ(value(first, "urdf_file"), ParameterValue(urdf.string()));
  EXPECT_EQ(first.location, path + ":1:20");
  EXPECT_THAT(error_of("robot_description: no.urdf\ncomponents: []"),
              HasSubstr("c.yaml:1:20: there is no robot description"));
  EXPECT_THAT(error_of("robot_description: " + urdf.string() +
                       "\ncomponents:\n  - {type: a::B, name: robot_description}"),
              HasSubstr("two components have the name '/robot_description'"));
}

}  // namespace
}  // namespace pipescout::host
