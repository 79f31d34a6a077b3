// SPDX-License-Identifier: Apache-2.0
#include "core/substitution.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace pipescout::host {
namespace {

SubstitutionSources sources() {
  SubstitutionSources sources;
  sources.arguments = {{"file", "a.csv"}, {"sly", "$(env HOME)"}};
  sources.environment = [](const std::string& name) -> std::optional<std::string> {
    return name == "HOME" ? std::optional<std::string>("/home/p") : std::nullopt;
  };
  sources.share = [](const std::string& package) -> std::optional<std::string> {
    return package == "p" ? std::optional<std::string>("/prefix/share/p") : std::nullopt;
  };
  sources.mission_folder = "/m";
  return sources;
}

std::string error_of(const std::string& text) {
  try {
    static_cast<void>(substitute(text, sources()));
  } catch (const SubstitutionError& error) {
    return error.what();
  }
  return "";
}

TEST(Substitute, ReplacesEachKind) {
  EXPECT_EQ(substitute("", sources()), "");
  EXPECT_EQ(substitute("plain $ (text)", sources()), "plain $ (text)");
  EXPECT_EQ(substitute("$(share p)/$(arg file)", sources()), "/prefix/share/p/a.csv");
  EXPECT_EQ(substitute("x$(env HOME)y", sources()), "x/home/py");
  EXPECT_EQ(substitute("$( mission_folder )/out", sources()), "/m/out");
}

TEST(Substitute, TakesDefaults) {
  EXPECT_EQ(substitute("$(arg none b c)", sources()), "b c");
  EXPECT_EQ(substitute("$(env NONE $(arg file))", sources()), "a.csv");
  EXPECT_EQ(substitute("$(env NONE f(x))", sources()), "f(x)");
}

TEST(Substitute, LooksAtValuesOnce) {
  EXPECT_EQ(substitute("$(arg sly)", sources()), "$(env HOME)");
}

TEST(Substitute, SaysWhatIsWrong) {
  EXPECT_EQ(error_of("a $(arg file"), "'$(arg file' has no closing ')'");
  EXPECT_EQ(error_of("$(arg none)"), "'$(arg none)': there is no argument 'none'");
  EXPECT_EQ(error_of("$(env NONE)"), "'$(env NONE)': the environment has no 'NONE'");
  EXPECT_EQ(error_of("$(share q)"),
            "'$(share q)': no installed package 'q' with a share folder; is its prefix in "
            "AMENT_PREFIX_PATH?");
  EXPECT_EQ(error_of("$(find p)"),
            "'$(find p)': known substitutions are arg, env, share, mission_folder");
  EXPECT_EQ(error_of("$(arg)"), "'$(arg)' needs a name after 'arg'");
  EXPECT_EQ(error_of("$(mission_folder x)"),
            "'$(mission_folder x)' allows nothing after 'mission_folder'");
  EXPECT_EQ(error_of("$()"), "'$()': known substitutions are arg, env, share, mission_folder");
}

TEST(HasTypeOfItsValue, NeedsOneArgumentOrVariableAndNothingElse) {
  EXPECT_TRUE(has_type_of_its_value("$(arg a)"));
  EXPECT_TRUE(has_type_of_its_value("$(env A $(arg b))"));
  EXPECT_FALSE(has_type_of_its_value("$(arg a)$(arg b)"));
  EXPECT_FALSE(has_type_of_its_value("x$(arg a)"));
  EXPECT_FALSE(has_type_of_its_value(""));
  EXPECT_FALSE(has_type_of_its_value("$(mission_folder)"));
  EXPECT_FALSE(has_type_of_its_value("$(share p)"));
}

TEST(TypedText, LosesNothing) {
  EXPECT_EQ(typed_text("5"), ParameterValue(5));
  EXPECT_EQ(typed_text(" 5 "), ParameterValue(5));
  EXPECT_EQ(typed_text("yes"), ParameterValue(true));
  EXPECT_EQ(typed_text(".inf").type(), ParameterType::kDouble);
  EXPECT_EQ(typed_text(".nan").type(), ParameterType::kDouble);
  EXPECT_EQ(typed_text("'5'"), ParameterValue("5"));
  EXPECT_EQ(typed_text("!!str 5"), ParameterValue("5"));
  EXPECT_EQ(typed_text("[1.0, 2.0]"), ParameterValue(std::vector<double>{1.0, 2.0}));
  for (const char* text : {"", "a", "/data/run #3/a.csv", "5 #3", " a", "a: b", "a\nb", "a\n#b"}) {
    EXPECT_EQ(typed_text(text), ParameterValue(text)) << text;
  }
}

}  // namespace
}  // namespace pipescout::host
