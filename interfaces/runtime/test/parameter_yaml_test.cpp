// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/parameter_yaml.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>
#include <unistd.h>
#include <yaml-cpp/yaml.h>

#include <bit>
#include <filesystem>
#include <fstream>
#include <map>

namespace pipescout {
namespace {

ParameterFile parse(const std::string& text) {
  return parse_parameter_yaml(text, "f.yaml");
}

std::map<std::string, ParameterValue> values_for(const std::string& text, std::string_view node) {
  std::map<std::string, ParameterValue> result;
  for (const ParameterOverride& parameter : parse(text).overrides_for(node)) {
    result[parameter.name] = parameter.value;
  }
  return result;
}

std::string error_of(const std::string& text) {
  try {
    (void)parse(text);
  } catch (const YamlError& error) {
    return error.what();
  }
  return "no error";
}

TEST(ParameterYaml, ReadsEveryLayoutOfRos) {
  const std::string text = R"(
/**:
  ros__parameters:
    everywhere: 1
/ns/*/node:
  ros__parameters:
    one_between: 2
/**/node:
  ros__parameters:
    any_depth: 3
node:
  ros__parameters:
    root: 4
ns:
  a:
    node:
      ros__parameters:
        nested: 5
)";
  using Values = std::map<std::string, ParameterValue>;
  EXPECT_EQ(values_for(text, "/other"), (Values{{"everywhere", 1}}));
  EXPECT_EQ(values_for(text, "/node"), (Values{{"everywhere", 1}, {"any_depth", 3}, {"root", 4}}));
  EXPECT_EQ(values_for(text, "/ns/a/node"),
            (Values{{"everywhere", 1}, {"one_between", 2}, {"any_depth", 3}, {"nested", 5}}));
  EXPECT_EQ(values_for(text, "/ns/a/b/node"), (Values{{"everywhere", 1}, {"any_depth", 3}}));
}

TEST(ParameterYaml, FlattensAndTypes) {
  const auto overrides = parse(R"(n:
  ros__parameters:
    flag: yes
    count: 3
    rate: 2.5
    name: lidar
    quoted: "3"
    empty: ""
    block: |
      two
      lines
    group:
      inner: {deep: [1, 2], text: [a, b]}
    dotted.name: 7
    none: []
)")
                             .overrides_for("/n");
  const std::vector<ParameterOverride> expected = {
      {"flag", true, "f.yaml:3"},
      {"count", 3, "f.yaml:4"},
      {"rate", 2.5, "f.yaml:5"},
      {"name", "lidar", "f.yaml:6"},
      {"quoted", "3", "f.yaml:7"},
      {"empty", "", "f.yaml:8"},
      {"block", "two\nlines\n", "f.yaml:9"},
      {"group.inner.deep", std::vector<std::int64_t>{1, 2}, "f.yaml:13"},
      {"group.inner.text", std::vector<std::string>{"a", "b"}, "f.yaml:13"},
      {"dotted.name", 7, "f.yaml:14"},
      {"none", std::vector<bool>{}, "f.yaml:15"}};
  EXPECT_EQ(overrides, expected);
}

TEST(ParameterYaml, TheLaterOfTwoMatchesWins) {
  const std::string specific_last = R"(
/**: {ros__parameters: {a: 1, b: 1}}
/n: {ros__parameters: {a: 2}}
)";
  const std::string wildcard_last = R"(
/n: {ros__parameters: {a: 2}}
/**: {ros__parameters: {a: 1, b: 1}}
)";
  EXPECT_EQ(values_for(specific_last, "/n").at("a"), ParameterValue(2));
  EXPECT_EQ(values_for(wildcard_last, "/n").at("a"), ParameterValue(1));

  const auto overrides = parse(specific_last).overrides_for("/n");
  ASSERT_EQ(overrides.size(), 2U);
  EXPECT_EQ(overrides[0], (ParameterOverride{"a", 2, "f.yaml:3", false}));
  EXPECT_EQ(overrides[1], (ParameterOverride{"b", 1, "f.yaml:2", true}));
}

TEST(ParameterYaml, TellsItsNodes) {
  const ParameterFile file =
      parse("/a/b: {ros__parameters: {}}\nc:\n  d: {ros__parameters: {x: 1}}\n");
  ASSERT_EQ(file.nodes().size(), 2U);
  EXPECT_EQ(file.nodes()[0].pattern, "/a/b");
  EXPECT_EQ(file.nodes()[0].source, "f.yaml:1");
  EXPECT_EQ(file.nodes()[1].pattern, "/c/d");
  EXPECT_EQ(file.nodes()[1].source, "f.yaml:3");
}

TEST(ParameterYaml, AnEmptyFileHasNoParameters) {
  EXPECT_TRUE(parse("").nodes().empty());
  EXPECT_TRUE(parse("# all\n# comments\n").nodes().empty());
  EXPECT_TRUE(parse("{}").nodes().empty());
  EXPECT_TRUE(parse("---\n").nodes().empty());
}

TEST(NodePatterns, MatchWholeParts) {
  EXPECT_TRUE(matches_node_pattern("/**", "/a"));
  EXPECT_TRUE(matches_node_pattern("/**", "/a/b/c"));
  EXPECT_TRUE(matches_node_pattern("/*", "/a"));
  EXPECT_FALSE(matches_node_pattern("/*", "/a/b"));
  EXPECT_TRUE(matches_node_pattern("a/b", "/a/b"));
  EXPECT_FALSE(matches_node_pattern("/a", "/a/b"));
  EXPECT_FALSE(matches_node_pattern("/a", "/ab"));
  EXPECT_TRUE(matches_node_pattern("/a/**/c", "/a/c"));
  EXPECT_TRUE(matches_node_pattern("/a/**/c", "/a/b/b/c"));
  EXPECT_TRUE(matches_node_pattern("/**/b/**/d", "/a/b/c/b/d"));
  EXPECT_FALSE(matches_node_pattern("/**/b/*/d", "/a/b/d"));
}

TEST(NodePatterns, ManyWildcardsTakeNoExponentialTime) {
  std::string pattern;
  std::string name;
  for (int i = 0; i < 200; ++i) {
    pattern += "/**/a";
    name += "/a";
  }
  EXPECT_TRUE(matches_node_pattern(pattern, name));
  EXPECT_FALSE(matches_node_pattern(pattern + "/b", name));
}

TEST(ParameterYamlErrors, SayWhereAndWhat) {
  const std::string head = "n:\n  ros__parameters:\n";
  EXPECT_EQ(error_of(head + "    a:\n"), "f.yaml:3:5: parameter 'a' has no value");
  EXPECT_EQ(error_of(head + "    a: ~\n"), "f.yaml:3:5: parameter 'a' has no value");
  EXPECT_EQ(error_of(head + "    a: null\n"), "f.yaml:3:5: parameter 'a' has no value");
  EXPECT_EQ(error_of(head + "    a: [1, 2.0]\n"),
            "f.yaml:3:12: mixed types in an array: element 2 (2.0) is of type double, the first is "
            "of type integer; write every number of a double array with a '.'");
  EXPECT_EQ(error_of(head + "    a: [1, [2]]\n"),
            "f.yaml:3:12: an array contains plain values only, no arrays or maps");
  EXPECT_EQ(error_of(head + "    a: [1, ~]\n"), "f.yaml:3:12: an array element has no value");
  EXPECT_EQ(error_of(head + "    a: 1\n    b: 2\n    a: 3\n"),
            "f.yaml:5:5: duplicate key 'a', first given in line 3");
  EXPECT_EQ(error_of(head + "    a: {b: 1}\n    a.b: 2\n"),
            "f.yaml:4:5: parameter 'a.b' is given twice, first at f.yaml:3");
  EXPECT_EQ(error_of(head + "    a: 9223372036854775808\n"),
            "f.yaml:3:8: integer 9223372036854775808 does not fit 64 bits; a double is written "
            "with a '.'");
  EXPECT_EQ(error_of(head + "    .a: 1\n"),
            "f.yaml:3:5: '.a': a part of a parameter name is empty");
  EXPECT_EQ(error_of("n:\n  ros__parameters: 3\n"),
            "f.yaml:2:3: 'ros__parameters' must be a map of parameters");
  EXPECT_EQ(error_of("n:\n  ros__parameters:\n"),
            "f.yaml:2:3: 'ros__parameters' must be a map of parameters");
  EXPECT_EQ(error_of("ros__parameters:\n  a: 1\n"),
            "f.yaml:1:1: 'ros__parameters' must be below the name of a node");
  EXPECT_EQ(error_of("n:\n  ros_parameters:\n    a: 1\n"),
            "f.yaml:3:5: 'a' is neither a node nor a namespace: it needs a 'ros__parameters' with "
            "the parameters below it");
  EXPECT_EQ(error_of("n: {}\n"), "f.yaml:1:1: '/n' has no 'ros__parameters'");
  EXPECT_EQ(error_of("n:\n"),
            "f.yaml:1:1: 'n' is neither a node nor a namespace: it needs a 'ros__parameters' with "
            "the parameters below it");
  EXPECT_EQ(error_of("- a\n"), "f.yaml:1:1: the top level must be a map of node names");
  EXPECT_EQ(error_of("text\n"), "f.yaml:1:1: the top level must be a map of node names");
  EXPECT_EQ(
      error_of("no-node: {ros__parameters: {}}\n"),
      "f.yaml:1:1: '/no-node' is not a node name: invalid node name 'no-node': must have only "
      "letters, digits and '_' (at position 2)");
  EXPECT_EQ(error_of("/a*: {ros__parameters: {}}\n"),
            "f.yaml:1:1: '/a*': '*' and '**' replace whole parts of a node name");
  EXPECT_EQ(error_of("a:\n  /b: {ros__parameters: {}}\n"),
            "f.yaml:2:3: '/b' under '/a': a nested name must not begin with '/'");
}

TEST(ParameterYamlErrors, TextThatIsNoYamlHasALineToo) {
  EXPECT_TRUE(error_of("n:\n  a: b: c\n").starts_with("f.yaml:2:7: "))
      << error_of("n:\n  a: b: c\n");
  EXPECT_TRUE(error_of("n:\n  [1, 2\n").starts_with("f.yaml:")) << error_of("n:\n  [1, 2\n");
  EXPECT_TRUE(error_of("a: 'b\n").starts_with("f.yaml:")) << error_of("a: 'b\n");
  EXPECT_EQ(error_of("a: 1\n---\nb: 2\n"), "f.yaml:2:1: a second document; one file holds one");
  EXPECT_EQ(error_of("a: &x {b: 1}\nc: *x\n"),
            "f.yaml:2:4: aliases are not supported; write the value again");
  EXPECT_EQ(error_of("? [a, b]\n: 1\n"), "f.yaml:1:3: a key must be a plain name");
  EXPECT_EQ(error_of(std::string("a: 1\nb:\0 2\n", 11)),
            "f.yaml:2:3: control character 0; the file is not UTF-8 text");
  EXPECT_EQ(error_of("a: \x04 1\n"), "f.yaml:1:4: control character 4; the file is not UTF-8 text");
}

TEST(ParameterYamlErrors, DeepNestingIsBounded) {
  const std::string open(100, '[');
  const std::string closed = open + std::string(100, ']');
  EXPECT_EQ(error_of(closed), "f.yaml:1:65: nested more than 64 levels deep");
  EXPECT_NE(error_of(std::string(100000, '[')).find("nested more than 64"), std::string::npos);
  std::string maps;
  for (std::size_t i = 0; i < 100; ++i) {
    maps += std::string(i, ' ') + "a:\n";
  }
  EXPECT_EQ(error_of(maps), "f.yaml:65:65: nested more than 64 levels deep");
}

TEST(ParameterYamlErrors, AQuoteThatIsNeverClosedSwallowsNothing) {
  for (const char* quote : {"'", "\""}) {
    for (const char* rest : {"", "\n", "x", "x\n", "x\n    b: 1\n"}) {
      const std::string error =
          error_of(std::string("n:\n  ros__parameters:\n    a: ") + quote + rest);
      EXPECT_NE(error.find("illegal EOF in scalar"), std::string::npos) << quote << rest << error;
    }
  }
  EXPECT_EQ(values_for("n: {ros__parameters: {a: 'x'}}\n# it's", "/n").at("a"),
            ParameterValue("x"));
  EXPECT_EQ(values_for("n:\n  ros__parameters:\n    a: |\n      it's\n", "/n").at("a"),
            ParameterValue("it's\n"));
}

class ParameterYamlFile : public ::testing::Test {
 protected:
  void SetUp() override { std::filesystem::create_directories(folder_); }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  [[nodiscard]] std::string write(const std::string& text) const {
    const std::string path = (folder_ / "p.yaml").string();
    std::ofstream(path) << text;
    return path;
  }

  std::filesystem::path folder_ = std::filesystem::temp_directory_path() /
                                  ("parameter_yaml_test_" + std::to_string(::getpid()) + "_" +
                                   ::testing::UnitTest::GetInstance()->current_test_info()->name());
};

TEST_F(ParameterYamlFile, IsReadAndNamedInSources) {
  const std::string path = write("n:\n  ros__parameters:\n    a: 1\n");
  EXPECT_EQ(load_parameter_yaml(path).overrides_for("/n"),
            (std::vector<ParameterOverride>{{"a", 1, path + ":3"}}));
}

TEST_F(ParameterYamlFile, MayBeEmpty) {
  EXPECT_TRUE(load_parameter_yaml(write("")).nodes().empty());
}

TEST_F(ParameterYamlFile, ThatCannotBeReadIsAnError) {
  const auto error_for = [](const std::string& path) {
    try {
      (void)load_parameter_yaml(path);
    } catch (const YamlError& error) {
      EXPECT_EQ(error.line(), 0);
      EXPECT_EQ(error.path(), path);
      return std::string(error.what());
    }
    return std::string("no error");
  };
  const std::string missing = (folder_ / "missing.yaml").string();
  EXPECT_EQ(error_for(missing), missing + ": cannot be read: No such file or directory");
  EXPECT_EQ(error_for(folder_.string()), folder_.string() + ": cannot be read: Is a directory");
}

TEST(YamlLocation, CountsFromOne) {
  const YAML::Node node = parse_yaml("a:\n  b: 1\n", "x.yaml");
  EXPECT_EQ(location("x.yaml", node["a"]["b"].Mark()), "x.yaml:2:6");
  EXPECT_EQ(line_location("x.yaml", node["a"]["b"].Mark()), "x.yaml:2");
  EXPECT_EQ(location("x.yaml", YAML::Mark::null_mark()), "x.yaml");
  EXPECT_EQ(line_location("x.yaml", YAML::Mark::null_mark()), "x.yaml");
  const YamlError error("x.yaml", node["a"]["b"].Mark(), "wrong");
  EXPECT_STREQ(error.what(), "x.yaml:2:6: wrong");
  EXPECT_EQ(error.line(), 2);
  EXPECT_EQ(error.column(), 6);
}

TEST(ParameterMaps, StandInOtherFilesToo) {
  const YAML::Node node = parse_yaml("parameters: {a: {b: 1}}\n", "c.yaml");
  EXPECT_EQ(read_parameter_map(node["parameters"], "c.yaml"),
            (std::vector<ParameterOverride>{{"a.b", 1, "c.yaml:1"}}));
  EXPECT_THROW((void)read_parameter_map(node["parameters"]["a"]["b"], "c.yaml"), YamlError);
}

TEST(ParameterDump, HasTheLayoutOfRos2ParamDump) {
  EXPECT_EQ(dump_parameter_yaml("/ns/n", {{"use_sim_time", false},
                                          {"group.b", 1.0},
                                          {"group.a", std::vector<std::int64_t>{1, 2}},
                                          {"name", "1"},
                                          {"none", std::vector<std::string>{}},
                                          {"unset", {}}}),
            R"(/ns/n:
  ros__parameters:
    group:
      a:
      - 1
      - 2
      b: 1.0
    name: "1"
    none: []
    use_sim_time: false
)");
  EXPECT_EQ(dump_parameter_yaml("/n", {}), "/n:\n  ros__parameters: {}\n");
}

TEST(ParameterDump, KeepsNamesFlatBelowAParameter) {
  const std::vector<NamedParameter> parameters = {
      {"a", 1}, {"a.b", 2}, {"a.b.c", 3}, {"a.x.y", 4}, {"z.z", 5}};
  const std::string text = dump_parameter_yaml("/n", parameters);
  std::map<std::string, ParameterValue> expected;
  for (const NamedParameter& parameter : parameters) {
    expected[parameter.name] = parameter.value;
  }
  EXPECT_EQ(values_for(text, "/n"), expected) << text;
}

rc::Gen<std::string> any_string() {
  // All of ASCII, and two characters of more than one byte.
  const auto character = rc::gen::oneOf(
      rc::gen::map(rc::gen::inRange('\x01', '\x7f'), [](char c) { return std::string(1, c); }),
      rc::gen::element<std::string>("\xc3\xa4", "\xe2\x82\xac"));
  return rc::gen::map(rc::gen::container<std::vector<std::string>>(character),
                      [](const std::vector<std::string>& characters) {
                        std::string text;
                        for (const std::string& c : characters) {
                          text += c;
                        }
                        return text;
                      });
}

rc::Gen<double> any_double() {
  return rc::gen::map(rc::gen::suchThat(rc::gen::arbitrary<std::uint64_t>(),
                                        [](std::uint64_t bits) {
                                          const auto value = std::bit_cast<double>(bits);
                                          return value == value;
                                        }),
                      [](std::uint64_t bits) { return std::bit_cast<double>(bits); });
}

// Empty arrays lose their type in YAML, which ParameterDump states.
template <class T>
rc::Gen<ParameterValue> any_array(const rc::Gen<T>& element) {
  return rc::gen::map(rc::gen::nonEmpty(rc::gen::container<std::vector<T>>(element)),
                      [](const std::vector<T>& values) { return ParameterValue(values); });
}

rc::Gen<ParameterValue> any_value() {
  const auto wrap = [](auto generator) {
    return rc::gen::map(generator, [](const auto& value) { return ParameterValue(value); });
  };
  return rc::gen::oneOf(
      wrap(rc::gen::arbitrary<bool>()), wrap(rc::gen::arbitrary<std::int64_t>()),
      wrap(any_double()), wrap(any_string()), wrap(rc::gen::arbitrary<std::vector<std::uint8_t>>()),
      any_array(rc::gen::arbitrary<bool>()), any_array(rc::gen::arbitrary<std::int64_t>()),
      any_array(any_double()), any_array(any_string()));
}

std::string any_name() {
  std::string name;
  const int parts = *rc::gen::inRange(1, 5);
  for (int i = 0; i < parts; ++i) {
    // A small choice makes names that are prefixes of others likely.
    name += (i > 0 ? "." : "") +
            *rc::gen::element<std::string>("a", "b", "1", "true", "null", "x_y", "/t", "-", "é");
  }
  return name;
}

RC_GTEST_PROP(ParameterYamlProperties, WhatIsDumpedIsReadBack, ()) {
  std::map<std::string, ParameterValue> parameters;
  const int count = *rc::gen::inRange(0, 12);
  for (int i = 0; i < count; ++i) {
    parameters[any_name()] = *any_value();
  }
  std::vector<NamedParameter> named;
  for (const auto& [name, value] : parameters) {
    named.push_back({name, value});
  }
  const std::string text = dump_parameter_yaml("/a/n", named);
  RC_LOG() << text;
  RC_ASSERT(values_for(text, "/a/n") == parameters);
}

RC_GTEST_PROP(ParameterYamlProperties, AnyTextIsReadOrRefused, ()) {
  // Pieces of the syntax reach further than arbitrary bytes.
  const auto pieces = *rc::gen::container<std::vector<std::string>>(
      rc::gen::element<std::string>("a", "b:", ": ", "\n", "  ", "- ", "[", "]", "{", "}", ",",
                                    "ros__parameters", "/**", "'", "\"", "&x ", "*x", "!!int ", "1",
                                    "1.5", "|", ">", "#", "?", "---\n", "\t", "%", "~", "\x01"));
  std::string text;
  for (const std::string& piece : pieces) {
    text += piece;
  }
  try {
    (void)parse(text).overrides_for("/a");
  } catch (const YamlError& error) {
    RC_ASSERT(std::string(error.what()).starts_with("f.yaml"));
  }
}

}  // namespace
}  // namespace pipescout
