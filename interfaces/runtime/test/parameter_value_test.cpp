// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/parameter_value.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <bit>
#include <cmath>

namespace pipescout {
namespace {

using Bytes = std::vector<std::uint8_t>;
using Bools = std::vector<bool>;
using Integers = std::vector<std::int64_t>;
using Doubles = std::vector<double>;
using Strings = std::vector<std::string>;

TEST(ParameterValue, HasTheTypeNumbersOfRos) {
  EXPECT_EQ(static_cast<int>(ParameterValue().type()), 0);
  EXPECT_EQ(static_cast<int>(ParameterValue(true).type()), 1);
  EXPECT_EQ(static_cast<int>(ParameterValue(1).type()), 2);
  EXPECT_EQ(static_cast<int>(ParameterValue(1.0).type()), 3);
  EXPECT_EQ(static_cast<int>(ParameterValue("a").type()), 4);
  EXPECT_EQ(static_cast<int>(ParameterValue(Bytes{1}).type()), 5);
  EXPECT_EQ(static_cast<int>(ParameterValue(Bools{true}).type()), 6);
  EXPECT_EQ(static_cast<int>(ParameterValue(Integers{1}).type()), 7);
  EXPECT_EQ(static_cast<int>(ParameterValue(Doubles{1}).type()), 8);
  EXPECT_EQ(static_cast<int>(ParameterValue(Strings{"a"}).type()), 9);
}

TEST(ParameterValue, EveryIntegerIsAnInt64OrTooLarge) {
  EXPECT_EQ(ParameterValue(std::uint8_t{7}).get<std::int64_t>(), 7);
  EXPECT_EQ(ParameterValue(-7L).get<std::int64_t>(), -7);
  EXPECT_EQ(ParameterValue(std::size_t{7}).get<std::int64_t>(), 7);
  EXPECT_THROW(ParameterValue(std::numeric_limits<std::uint64_t>::max()), std::out_of_range);
}

TEST(ParameterValue, GivesOnlyItsOwnType) {
  const ParameterValue value(1);
  EXPECT_THROW((void)value.get<double>(), std::bad_variant_access);
  EXPECT_EQ(value.get_if<double>(), nullptr);
  EXPECT_EQ(*value.get_if<std::int64_t>(), 1);
  EXPECT_NE(value, ParameterValue(1.0));
}

TEST(ParameterValue, PrintsLikeRos2ParamGet) {
  EXPECT_EQ(to_string(ParameterValue()), "None");
  EXPECT_EQ(to_string(ParameterValue(true)), "True");
  EXPECT_EQ(to_string(ParameterValue(false)), "False");
  EXPECT_EQ(to_string(ParameterValue(-3)), "-3");
  EXPECT_EQ(to_string(ParameterValue("it's")), "it's");
  EXPECT_EQ(to_string(ParameterValue(Bools{true, false})), "[True, False]");
  EXPECT_EQ(to_string(ParameterValue(Integers{1, 2})), "array('q', [1, 2])");
  EXPECT_EQ(to_string(ParameterValue(Integers{})), "array('q')");
  EXPECT_EQ(to_string(ParameterValue(Doubles{0.5, 2})), "array('d', [0.5, 2.0])");
  EXPECT_EQ(to_string(ParameterValue(Strings{"a", "it's", "\"'\n"})), R"(['a', "it's", '"\'\n'])");
  EXPECT_EQ(to_string(ParameterValue(Bytes{0, 65, 39, 92, 255})),
            R"([b'\x00', b'A', b"'", b'\\', b'\xff'])");
  EXPECT_STREQ(value_label(ParameterType::kInteger), "Integer value is:");
  EXPECT_STREQ(value_label(ParameterType::kStringArray), "String values are:");
  EXPECT_STREQ(value_label(ParameterType::kNotSet), "Parameter not set.");
}

// The right-hand sides are what Python prints.
TEST(ParameterValue, PrintsDoublesLikePython) {
  const std::pair<double, const char*> cases[] = {{1.0, "1.0"},
                                                  {0.1, "0.1"},
                                                  {-0.0, "-0.0"},
                                                  {100000.0, "100000.0"},
                                                  {123456789.125, "123456789.125"},
                                                  {1e15, "1000000000000000.0"},
                                                  {1e16, "1e+16"},
                                                  {1.5e300, "1.5e+300"},
                                                  {0.0001, "0.0001"},
                                                  {0.00001, "1e-05"},
                                                  {1.25e-7, "1.25e-07"},
                                                  {5e-324, "5e-324"},
                                                  {INFINITY, "inf"},
                                                  {-INFINITY, "-inf"},
                                                  {NAN, "nan"}};
  for (const auto& [value, text] : cases) {
    EXPECT_EQ(to_string(ParameterValue(value)), text);
  }
}

TEST(ParameterValue, YamlKeepsTheType) {
  EXPECT_EQ(to_yaml(1.0), "1.0");
  EXPECT_EQ(to_yaml(1e-7), "1.0e-07");
  EXPECT_EQ(to_yaml(1e16), "1.0e+16");
  EXPECT_EQ(to_yaml(NAN), ".nan");
  EXPECT_EQ(to_yaml(-INFINITY), "-.inf");
  EXPECT_EQ(to_yaml(true), "true");
  EXPECT_EQ(to_yaml("base_link"), "base_link");
  EXPECT_EQ(to_yaml("/a/b.yaml"), "/a/b.yaml");
  for (const char* text :
       {"true", "no",  "y",    "1",   "0x1F", "1.5", "nan", "inf",        "null", "~",
        "",     "a b", "a: b", "- a", "#a",   "*a",  "[a]", "2020-01-01", ".inf", "1:30"}) {
    EXPECT_EQ(to_yaml(text), "\"" + std::string(text) + "\"");
  }
  EXPECT_EQ(to_yaml(Strings{"a", "1"}), "[a, \"1\"]");
  EXPECT_EQ(to_yaml(Bytes{1, 2, 3, 4}), "!!binary \"AQIDBA==\"");
}

TEST(ScalarTyping, FollowsRcl) {
  for (const char* text : {"true", "True", "TRUE", "yes", "on", "y", "Y"}) {
    EXPECT_EQ(type_yaml_scalar(text), ParameterValue(true)) << text;
  }
  for (const char* text : {"false", "no", "Off", "N"}) {
    EXPECT_EQ(type_yaml_scalar(text), ParameterValue(false)) << text;
  }
  EXPECT_EQ(type_yaml_scalar("42"), ParameterValue(42));
  EXPECT_EQ(type_yaml_scalar("+42"), ParameterValue(42));
  EXPECT_EQ(type_yaml_scalar("-42"), ParameterValue(-42));
  EXPECT_EQ(type_yaml_scalar("0"), ParameterValue(0));
  EXPECT_EQ(type_yaml_scalar("-0x1f"), ParameterValue(-31));
  EXPECT_EQ(type_yaml_scalar("010"), ParameterValue(8));
  EXPECT_EQ(type_yaml_scalar("08"), ParameterValue(8.0));
  EXPECT_EQ(type_yaml_scalar("1.0"), ParameterValue(1.0));
  EXPECT_EQ(type_yaml_scalar("1."), ParameterValue(1.0));
  EXPECT_EQ(type_yaml_scalar(".5"), ParameterValue(0.5));
  EXPECT_EQ(type_yaml_scalar("-1e3"), ParameterValue(-1000.0));
  EXPECT_EQ(type_yaml_scalar("+.inf"), ParameterValue(INFINITY));
  EXPECT_EQ(type_yaml_scalar("-.INF"), ParameterValue(-INFINITY));
  EXPECT_EQ(type_yaml_scalar("inf"), ParameterValue(INFINITY));
  EXPECT_TRUE(std::isnan(type_yaml_scalar(".nan").get<double>()));
  EXPECT_TRUE(std::isnan(type_yaml_scalar("nan").get<double>()));
  for (const char* text : {"", "-", "+", "--1", "+-1", "0x", "1 2", "1,5", "e5", ".", "tRUE",
                           "0x1g", "1.0.0", "-.nan", "1_000"}) {
    EXPECT_EQ(type_yaml_scalar(text), ParameterValue(text)) << text;
  }
}

TEST(ScalarTyping, NumbersOutOfRangeDoNotChangeTheirType) {
  EXPECT_EQ(type_yaml_scalar("9223372036854775807").get<std::int64_t>(),
            std::numeric_limits<std::int64_t>::max());
  EXPECT_EQ(type_yaml_scalar("-9223372036854775808").get<std::int64_t>(),
            std::numeric_limits<std::int64_t>::min());
  for (const char* text : {"9223372036854775808", "-9223372036854775809", "0x10000000000000000",
                           "99999999999999999999999", "1e999", "-1e999"}) {
    EXPECT_THROW((void)type_yaml_scalar(text), std::out_of_range) << text;
  }
  EXPECT_EQ(type_yaml_scalar("5e-324"), ParameterValue(5e-324));
}

TEST(CommandLineValues, AreTypedLikeRos2ParamSet) {
  EXPECT_EQ(parse_parameter_value("1"), ParameterValue(1));
  EXPECT_EQ(parse_parameter_value("1.0"), ParameterValue(1.0));
  EXPECT_EQ(parse_parameter_value("true"), ParameterValue(true));
  EXPECT_EQ(parse_parameter_value("text"), ParameterValue("text"));
  EXPECT_EQ(parse_parameter_value("two words"), ParameterValue("two words"));
  EXPECT_EQ(parse_parameter_value("'1'"), ParameterValue("1"));
  EXPECT_EQ(parse_parameter_value("\"true\""), ParameterValue("true"));
  EXPECT_EQ(parse_parameter_value("!!str 1"), ParameterValue("1"));
  EXPECT_EQ(parse_parameter_value("!!float 1"), ParameterValue(1.0));
  EXPECT_EQ(parse_parameter_value("!!binary AQI="), ParameterValue(Bytes{1, 2}));
  EXPECT_EQ(parse_parameter_value("[1, 2]"), ParameterValue(Integers{1, 2}));
  EXPECT_EQ(parse_parameter_value("[1.0, .inf]"), ParameterValue(Doubles{1.0, INFINITY}));
  EXPECT_EQ(parse_parameter_value("[a, 'b c']"), ParameterValue(Strings{"a", "b c"}));
  EXPECT_EQ(parse_parameter_value("[true, no]"), ParameterValue(Bools{true, false}));
  EXPECT_EQ(parse_parameter_value("[]"), ParameterValue(Bools{}));
  // What is no YAML, or no value in it, is a string as typed.
  for (const char* text : {"", "null", "~", "[1, 2", "a: b", "{a: 1}", "*a", "#a", "'", "\x04"}) {
    EXPECT_EQ(parse_parameter_value(text), ParameterValue(text)) << text;
  }
}

TEST(CommandLineValues, RefuseWhatCannotBeMeant) {
  for (const char* text : {"[1, 2.0]", "[a, 1]", "[[1], [2]]", "[~]", "[{a: 1}]", "[!!binary AQ==]",
                           "99999999999999999999", "!!int 1.5", "!!binary '***'", "!mine 1"}) {
    EXPECT_THROW((void)parse_parameter_value(text), std::invalid_argument) << text;
  }
}

TEST(ParameterRules, NameAParameterAndMaybeANode) {
  const ParameterRule all = ParameterRule::parse("a.b:=1");
  EXPECT_EQ(all.node, "");
  EXPECT_EQ(all.parameter, (ParameterOverride{"a.b", 1, "command line", true}));
  const ParameterRule one = ParameterRule::parse("camera:path:=x:=y", "here");
  EXPECT_EQ(one.node, "camera");
  EXPECT_EQ(one.parameter, (ParameterOverride{"path", "x:=y", "here", false}));
  EXPECT_EQ(ParameterRule::parse("path:=").parameter.value, ParameterValue(""));
  for (const char* text : {"", "a", "a=1", ":=1", "1n:a:=1", ":a:=1", "n::=1", "a:=[1, b]"}) {
    EXPECT_THROW((void)ParameterRule::parse(text), std::invalid_argument) << text;
  }
}

RC_GTEST_PROP(ParameterValueProperties, DoublesComeBackBitForBit, (std::uint64_t bits)) {
  const double value = std::bit_cast<double>(bits);
  RC_PRE(!std::isnan(value));
  RC_ASSERT(parse_parameter_value(to_yaml(value)) == ParameterValue(value));
  RC_ASSERT(type_yaml_scalar(to_string(ParameterValue(value))) == ParameterValue(value));
}

RC_GTEST_PROP(ParameterValueProperties, IntegersComeBack, (std::int64_t value)) {
  RC_ASSERT(parse_parameter_value(to_yaml(value)) == ParameterValue(value));
}

RC_GTEST_PROP(ParameterValueProperties, BytesComeBack, (const Bytes& bytes)) {
  RC_ASSERT(parse_parameter_value(to_yaml(bytes)) == ParameterValue(bytes));
}

RC_GTEST_PROP(ParameterValueProperties, StringsComeBack, ()) {
  const auto text = *rc::gen::container<std::string>(rc::gen::inRange('\x01', '\x7f'));
  RC_ASSERT(parse_parameter_value(to_yaml(text)) == ParameterValue(text));
  const Strings both = {text, "true"};
  RC_ASSERT(parse_parameter_value(to_yaml(both)) == ParameterValue(both));
}

RC_GTEST_PROP(ParameterValueProperties, AnyTextIsTypedOrRefused, (const std::string& text)) {
  try {
    (void)parse_parameter_value(text);
  } catch (const std::invalid_argument&) {
  }
}

}  // namespace
}  // namespace pipescout
