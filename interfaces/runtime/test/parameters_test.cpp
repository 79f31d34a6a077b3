// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/parameters.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <future>
#include <thread>

namespace pipescout {
namespace {

using Doubles = std::vector<double>;

template <class Call>
std::string error_of(const Call& call) {
  try {
    call();
  } catch (const ParameterError& error) {
    return error.what();
  }
  return "no error";
}

ParameterOverride given(const std::string& name, ParameterValue value) {
  return {name, std::move(value), "robot.yaml:7"};
}

TEST(ParameterDeclaration, GivesTheDefault) {
  Parameters parameters;
  EXPECT_EQ(parameters.declare({.name = "gain"}, 1.5), ParameterValue(1.5));
  EXPECT_TRUE(parameters.has("gain"));
  EXPECT_EQ(parameters.get("gain"), ParameterValue(1.5));
  EXPECT_FALSE(parameters.has("other"));
  EXPECT_EQ(parameters.get_optional("other"), std::nullopt);
  EXPECT_EQ(error_of([&] { (void)parameters.get("other"); }),
            "parameter 'other': it is not declared");
}

TEST(ParameterDeclaration, TheLastOverrideWins) {
  Parameters parameters({given("gain", 2.0), {"gain", 3.0, "command line"}});
  EXPECT_EQ(parameters.declare({.name = "gain"}, 1.5), ParameterValue(3.0));
}

TEST(ParameterDeclaration, TypesAreStrictAndErrorsSayWhatToWrite) {
  Parameters parameters({given("gain", 1), given("name", 5), given("count", 1.0),
                         given("weights", std::vector<std::int64_t>{1, 2})});
  EXPECT_EQ(error_of([&] { parameters.declare<double>("gain", 1.5); }),
            "robot.yaml:7: parameter 'gain': value 1 is of type integer, expected double; write "
            "1.0");
  EXPECT_EQ(error_of([&] { parameters.declare<std::string>("name", "x"); }),
            "robot.yaml:7: parameter 'name': value 5 is of type integer, expected string; put it "
            "in quotes");
  EXPECT_EQ(error_of([&] { parameters.declare<int>("count", 1); }),
            "robot.yaml:7: parameter 'count': value 1.0 is of type double, expected integer");
  EXPECT_EQ(error_of([&] { parameters.declare<Doubles>("weights", {}); }),
            "robot.yaml:7: parameter 'weights': value [1, 2] is of type integer array, expected "
            "double array; write every number with a '.'");
  EXPECT_FALSE(parameters.has("gain"));
}

TEST(ParameterDeclaration, RangesHoldForOverridesAndDefaults) {
  Parameters parameters({given("gain", 11.0), given("count", 4), given("limits", Doubles{1, -1})});
  EXPECT_EQ(error_of([&] {
              parameters.declare<double>("gain", 1.0,
                                         {.floating_point_range = FloatingPointRange{0, 10}});
            }),
            "robot.yaml:7: parameter 'gain': value 11.0 is out of range, expected [0.0, 10.0]");
  EXPECT_EQ(error_of([&] {
              parameters.declare<int>("count", 3, {.integer_range = IntegerRange{1, 9, 2}});
            }),
            "robot.yaml:7: parameter 'count': value 4 is out of range, expected [1, 9] in steps of "
            "2");
  EXPECT_EQ(error_of([&] {
              parameters.declare<Doubles>("limits", {},
                                          {.floating_point_range = FloatingPointRange{.from = 0}});
            }),
            "robot.yaml:7: parameter 'limits': element 2: value -1.0 is out of range, expected at "
            "least 0.0");
  EXPECT_EQ(error_of([&] {
              parameters.declare<int>("other", 0, {.integer_range = IntegerRange{1, 9}});
            }),
            "parameter 'other': default value 0 is out of range, expected [1, 9]");
}

TEST(ParameterDeclaration, AnEmptyArrayFitsEveryArray) {
  Parameters parameters({given("names", std::vector<bool>{}), given("gain", std::vector<bool>{})});
  const auto names = parameters.declare<std::vector<std::string>>("names", {"a"});
  EXPECT_TRUE(names.get().empty());
  EXPECT_EQ(parameters.get("names").type(), ParameterType::kStringArray);
  EXPECT_NE(error_of([&] { parameters.declare<double>("gain", 1.0); }), "no error");
}

// `ros2 param load` of a file with 4.0e-09 sends "4e-09".
TEST(ParameterDeclaration, ADoubleTakesATextThatIsWhollyANumber) {
  Parameters parameters({{"small", std::string("4e-09")}});
  const auto small = parameters.declare<double>("small", 1.0);
  EXPECT_EQ(small.get(), 4e-09);
  for (const auto& [text, value] : std::vector<std::pair<std::string, double>>{
           {"-2.5E+3", -2500.0}, {"7", 7.0}, {"4.0e-09", 4e-09}, {"inf", HUGE_VAL}}) {
    EXPECT_TRUE(parameters.set("small", text).successful) << text;
    EXPECT_EQ(small.get(), value) << text;
  }
  for (const auto* text : {"4e-09 m", "", "fast", "1,5", "true", "[1.0]", "1e999", "0x"}) {
    EXPECT_FALSE(parameters.set("small", std::string(text)).successful) << text;
  }
}

TEST(ParameterDeclaration, ADoubleArrayTakesTextsThatAreNumbers) {
  Parameters parameters;
  const auto bias = parameters.declare<std::vector<double>>("bias", {1.0});
  EXPECT_TRUE(parameters.set("bias", std::vector<std::string>{"4e-09", "1.0"}).successful);
  EXPECT_EQ(bias.get(), (std::vector<double>{4e-09, 1.0}));
  EXPECT_TRUE(parameters.set("bias", std::string("[2e-07, 3.0, -1]")).successful);
  EXPECT_EQ(bias.get(), (std::vector<double>{2e-07, 3.0, -1.0}));
  for (const auto* text : {"[4e-09, x]", "[1.0, ]", "1.0, 2.0", "[1.0"}) {
    EXPECT_FALSE(parameters.set("bias", std::string(text)).successful) << text;
  }
}

TEST(ParameterDeclaration, ATextIsNoOtherType) {
  Parameters parameters;
  parameters.declare<std::int64_t>("count", 1);
  parameters.declare<std::string>("name", std::string());
  EXPECT_FALSE(parameters.set("count", std::string("2")).successful);
  EXPECT_TRUE(parameters.set("name", std::string("2")).successful);
  EXPECT_EQ(parameters.get("name"), ParameterValue(std::string("2")));
}

// What `ros2 param dump` cannot write, since it makes maps of the names.
TEST(ParameterDeclaration, RefusesANameThatBeginsAnother) {
  Parameters parameters;
  parameters.declare<double>("line.deviation", 1.0);
  parameters.declare<double>("line2", 1.0);
  parameters.declare<double>("gain", 1.0);
  for (const auto* name : {"line", "gain.p", "gain.p.start", "line.deviation.across"}) {
    try {
      parameters.declare<double>(name, 1.0);
      ADD_FAILURE() << name;
    } catch (const ParameterError& error) {
      EXPECT_EQ(error.name(), name);
      EXPECT_THAT(error.what(), testing::HasSubstr("begins the other"));
    }
  }
  parameters.declare<double>("line.d", 1.0);
  parameters.declare<double>("line3.deviation", 1.0);
}

TEST(ParameterDeclaration, RefusesWhatMakesNoSense) {
  Parameters parameters;
  for (const char* name : {"", ".a", "a.", "a..b", "a b", "a\n"}) {
    EXPECT_THROW(parameters.declare({.name = name}, 1), ParameterError) << name;
  }
  parameters.declare({.name = "a"}, 1);
  EXPECT_EQ(error_of([&] { parameters.declare({.name = "a"}, 1); }),
            "parameter 'a': it is already declared");
  EXPECT_THROW(parameters.declare({.name = "b"}), ParameterError);
  EXPECT_THROW(parameters.declare({.name = "b", .type = ParameterType::kDouble}, 1),
               ParameterError);
  EXPECT_THROW(parameters.declare<int>("b", 1, {.dynamic_typing = true}), ParameterError);

  const auto with_range = [&](FloatingPointRange range) {
    parameters.declare<double>("b", 1, {.floating_point_range = range});
  };
  EXPECT_THROW(with_range({2, 1}), ParameterError);
  EXPECT_THROW(with_range({NAN, 1}), ParameterError);
  EXPECT_THROW(with_range({0, 1, -0.1}), ParameterError);
  EXPECT_THROW(with_range({0, 1, NAN}), ParameterError);
  EXPECT_THROW(with_range({.step = 0.5}), ParameterError);
  EXPECT_THROW(parameters.declare<int>("b", 1, {.integer_range = IntegerRange{2, 1}}),
               ParameterError);
  EXPECT_THROW(parameters.declare<int>("b", 1, {.floating_point_range = FloatingPointRange{}}),
               ParameterError);
  EXPECT_THROW(parameters.declare<double>("b", 1, {.integer_range = IntegerRange{}}),
               ParameterError);
  EXPECT_FALSE(parameters.has("b"));
}

TEST(ParameterDeclaration, MayLackAValue) {
  Parameters parameters;
  parameters.declare({.name = "path", .type = ParameterType::kString});
  EXPECT_TRUE(parameters.has("path"));
  EXPECT_EQ(parameters.get_optional("path"), std::nullopt);
  EXPECT_EQ(error_of([&] { (void)parameters.get("path"); }),
            "parameter 'path': it has no value yet");
  EXPECT_THROW((void)parameters.handle<std::string>("path"), ParameterError);
  EXPECT_EQ(parameters.types({"path"}), (std::vector{ParameterType::kNotSet}));
  EXPECT_TRUE(parameters.set("path", "x").successful);
  EXPECT_EQ(parameters.get("path"), ParameterValue("x"));
}

TEST(ParameterDeclaration, RequiredOnesMustBeGiven) {
  Parameters parameters({given("path", "/data")});
  EXPECT_EQ(parameters.declare_required<std::string>("path").get(), "/data");
  EXPECT_EQ(error_of([&] { parameters.declare_required<int>("count"); }),
            "parameter 'count': it has no default: a value of type integer must be given");
  EXPECT_FALSE(parameters.has("count"));
}

TEST(ParameterHandle, FollowsTheValue) {
  Parameters parameters;
  const auto gain = parameters.declare<double>("gain", 1.5);
  const auto flag = parameters.declare<bool>("flag", true);
  const auto count = parameters.declare<std::int64_t>("count", -1);
  const auto name = parameters.declare<std::string>("name", "a");
  const auto weights = parameters.declare<Doubles>("weights", {1, 2});
  EXPECT_EQ(gain.name(), "gain");
  EXPECT_EQ(gain.get(), 1.5);
  EXPECT_TRUE(flag.get());
  EXPECT_EQ(count.get(), -1);
  const std::shared_ptr<const std::string> before = name.share();
  EXPECT_TRUE(parameters
                  .set_atomically({{"gain", -0.5},
                                   {"flag", false},
                                   {"count", 7},
                                   {"name", "b"},
                                   {"weights", Doubles{3}}})
                  .successful);
  EXPECT_EQ(gain.get(), -0.5);
  EXPECT_FALSE(flag.get());
  EXPECT_EQ(count.get(), 7);
  EXPECT_EQ(name.get(), "b");
  EXPECT_EQ(*before, "a");
  EXPECT_EQ(weights.get(), (Doubles{3}));
}

TEST(ParameterHandle, OfANarrowIntegerKeepsItsLimits) {
  Parameters parameters;
  const auto small = parameters.declare<std::uint8_t>("small", 200);
  const auto size = parameters.declare<std::size_t>("size", 5);
  EXPECT_EQ(parameters.describe({"small"})[0].integer_range, (IntegerRange{0, 255}));
  EXPECT_EQ(parameters.describe({"size"})[0].integer_range, (IntegerRange{.from = 0}));
  EXPECT_FALSE(parameters.set("small", 256).successful);
  EXPECT_FALSE(parameters.set("size", -1).successful);
  EXPECT_TRUE(parameters.set("small", 255).successful);
  EXPECT_EQ(small.get(), 255);
  EXPECT_EQ(size.get(), 5U);
  EXPECT_THROW(parameters.declare<std::uint8_t>("x", 1, {.integer_range = IntegerRange{0, 256}}),
               ParameterError);
}

TEST(ParameterHandle, CanBeMadeLater) {
  Parameters parameters;
  parameters.declare<int>("count", 3);
  parameters.declare({.name = "any", .dynamic_typing = true}, 1);
  EXPECT_EQ(parameters.handle<int>("count").get(), 3);
  EXPECT_EQ(parameters.handle<std::int64_t>("count").get(), 3);
  EXPECT_THROW((void)parameters.handle<double>("count"), ParameterError);
  EXPECT_THROW((void)parameters.handle<std::uint8_t>("count"), ParameterError);
  EXPECT_THROW((void)parameters.handle<int>("any"), ParameterError);
  EXPECT_THROW((void)parameters.handle<int>("none"), ParameterError);
}

TEST(ParameterHandle, OutlivesItsNodeAndMayBeEmpty) {
  Parameter<double> gain;
  EXPECT_FALSE(gain);
  EXPECT_THROW((void)gain.get(), std::logic_error);
  {
    Parameters parameters;
    gain = parameters.declare<double>("gain", 1.5);
  }
  EXPECT_TRUE(gain);
  EXPECT_EQ(gain.get(), 1.5);
}

TEST(ParameterSet, RefusesOneByOneOrAll) {
  Parameters parameters;
  parameters.declare<double>("gain", 1.0, {.floating_point_range = FloatingPointRange{0, 10}});
  parameters.declare<int>("count", 1);
  parameters.declare<int>("fixed", 1, {.read_only = true});

  const auto results =
      parameters.set({{"gain", 2.0}, {"gain", 11.0}, {"none", 1}, {"fixed", 2}, {"count", "x"}});
  ASSERT_EQ(results.size(), 5U);
  EXPECT_EQ(results[0], SetResult::accept());
  EXPECT_EQ(results[1].reason,
            "parameter 'gain': value 11.0 is out of range, expected [0.0, 10.0]");
  EXPECT_EQ(results[2].reason, "parameter 'none' cannot be set because it was not declared");
  EXPECT_EQ(results[3].reason, "parameter 'fixed' cannot be set because it is read-only");
  EXPECT_EQ(results[4].reason, "parameter 'count': value x is of type string, expected integer");
  EXPECT_EQ(parameters.get("gain"), ParameterValue(2.0));

  EXPECT_FALSE(parameters.set_atomically({{"gain", 3.0}, {"count", 1.0}}).successful);
  EXPECT_EQ(parameters.get("gain"), ParameterValue(2.0));
  EXPECT_TRUE(parameters.set_atomically({{"gain", 3.0}, {"count", 5}}).successful);
  EXPECT_EQ(parameters.get_many({"gain", "count"}), (std::vector<ParameterValue>{3.0, 5}));
  EXPECT_FALSE(parameters.set_atomically({{"count", 6}, {"count", 7}}).successful);
  EXPECT_TRUE(parameters.set_atomically({}).successful);
}

TEST(ParameterSet, NanIsInNoRange) {
  Parameters parameters;
  parameters.declare<double>("free", 1.0);
  parameters.declare<double>("ranged", 1.0, {.floating_point_range = FloatingPointRange{}});
  EXPECT_TRUE(parameters.set("free", NAN).successful);
  EXPECT_EQ(parameters.set("ranged", NAN).reason,
            "parameter 'ranged': value .nan is out of range, expected [-.inf, .inf]");
  EXPECT_TRUE(parameters.set("ranged", INFINITY).successful);
}

TEST(ParameterSet, StepsAllowForRoundingAndTheEnd) {
  Parameters parameters;
  parameters.declare<double>("x", 0.0, {.floating_point_range = FloatingPointRange{-1, 1.05, 0.1}});
  for (const double value : {-1.0, -0.9, -0.7, 0.1, 0.3, 1.0, 1.05}) {
    EXPECT_TRUE(parameters.set("x", value).successful) << value;
  }
  for (const double value : {0.05, 0.1001, 1.04, -1.0000001, 1.0500001}) {
    EXPECT_FALSE(parameters.set("x", value).successful) << value;
  }
  constexpr auto kMin = std::numeric_limits<std::int64_t>::min();
  constexpr auto kMax = std::numeric_limits<std::int64_t>::max();
  parameters.declare<std::int64_t>("n", kMin,
                                   {.integer_range = IntegerRange{kMin, kMax, 1ULL << 63U}});
  EXPECT_TRUE(parameters.set("n", 0).successful);
  EXPECT_TRUE(parameters.set("n", kMax).successful);
  EXPECT_FALSE(parameters.set("n", 1).successful);
}

TEST(ParameterSet, DynamicTypesChangeAndGo) {
  Parameters parameters;
  parameters.declare({.name = "any", .dynamic_typing = true}, 1);
  parameters.declare<int>("count", 1);
  EXPECT_TRUE(parameters.set("any", "text").successful);
  EXPECT_EQ(parameters.types({"any"}), (std::vector{ParameterType::kString}));
  EXPECT_EQ(parameters.describe({"any"})[0].type, ParameterType::kString);
  EXPECT_FALSE(parameters.set("count", {}).successful);
  EXPECT_TRUE(parameters.set("any", {}).successful);
  EXPECT_FALSE(parameters.has("any"));
}

TEST(ParameterUndeclaration, IsForDynamicTypesOnly) {
  Parameters parameters;
  parameters.declare<int>("count", 1);
  parameters.declare({.name = "any", .dynamic_typing = true}, 1);
  parameters.declare({.name = "fixed", .read_only = true, .dynamic_typing = true}, 1);
  EXPECT_EQ(error_of([&] { parameters.undeclare("count"); }),
            "parameter 'count': cannot be undeclared because it is statically typed");
  EXPECT_THROW(parameters.undeclare("fixed"), ParameterError);
  EXPECT_THROW(parameters.undeclare("none"), ParameterError);
  parameters.undeclare("any");
  EXPECT_FALSE(parameters.has("any"));
}

TEST(ParameterList, FollowsHumble) {
  Parameters parameters;
  for (const char* name : {"top", "a.one", "a.two", "a.b.three", "ab.four", "a.b.c.five"}) {
    parameters.declare<int>(name, 0);
  }
  using Names = std::vector<std::string>;
  EXPECT_EQ(parameters.list().names,
            (Names{"a.b.c.five", "a.b.three", "a.one", "a.two", "ab.four", "top"}));
  EXPECT_EQ(parameters.list().prefixes, (Names{"a", "a.b", "a.b.c", "ab"}));
  EXPECT_EQ(parameters.list({}, 1).names, (Names{"top"}));
  EXPECT_EQ(parameters.list({}, 2).names, (Names{"a.one", "a.two", "ab.four", "top"}));
  EXPECT_EQ(parameters.list({"a"}).names, (Names{"a.b.c.five", "a.b.three", "a.one", "a.two"}));
  EXPECT_EQ(parameters.list({"a"}, 1).names, (Names{}));
  EXPECT_EQ(parameters.list({"a"}, 2).names, (Names{"a.one", "a.two"}));
  EXPECT_EQ(parameters.list({"a.b", "top"}, 2).names, (Names{"a.b.three", "top"}));
  EXPECT_EQ(parameters.list({"none"}), (pipescout::ParameterList{}));
}

TEST(ParameterDescription, IsWhatWasDeclared) {
  Parameters parameters;
  const ParameterDescriptor descriptor{.name = "gain",
                                       .type = ParameterType::kDouble,
                                       .description = "of the controller, 1/s",
                                       .additional_constraints = "less than limit",
                                       .read_only = true,
                                       .floating_point_range = FloatingPointRange{0, 1, 0.5}};
  parameters.declare(descriptor, 0.5);
  EXPECT_EQ(parameters.describe({"gain"}), (std::vector{descriptor}));
  EXPECT_THROW((void)parameters.describe({"gain", "none"}), ParameterError);
  EXPECT_THROW((void)parameters.types({"none"}), ParameterError);
  EXPECT_EQ(parameters.all(), (std::vector<NamedParameter>{{"gain", 0.5}}));
}

TEST(ParameterCallbacks, MayAdjust) {
  Parameters parameters;
  const auto gain = parameters.declare<double>("gain", 1.0);
  const auto half = parameters.declare<double>("half", 0.5);
  const auto handle = parameters.on_adjust([](std::vector<NamedParameter>& proposed) {
    for (std::size_t i = proposed.size(); i-- > 0;) {
      if (proposed[i].name == "gain") {
        proposed.push_back({"half", proposed[i].value.get<double>() / 2});
      }
    }
  });
  EXPECT_TRUE(parameters.set("gain", 4.0).successful);
  EXPECT_EQ(gain.get(), 4.0);
  EXPECT_EQ(half.get(), 2.0);
}

TEST(ParameterCallbacks, WhatAdjustsIsCheckedToo) {
  Parameters parameters;
  const auto gain = parameters.declare<double>("gain", 1.0);
  auto handle =
      parameters.on_adjust([](std::vector<NamedParameter>& proposed) { proposed.clear(); });
  EXPECT_FALSE(parameters.set("gain", 4.0).successful);
  handle =
      parameters.on_adjust([](std::vector<NamedParameter>& proposed) { proposed[0].value = 1; });
  EXPECT_FALSE(parameters.set("gain", 4.0).successful);
  handle = parameters.on_adjust([](std::vector<NamedParameter>& proposed) {
    proposed.push_back({"none", 1});
  });
  EXPECT_FALSE(parameters.set("gain", 4.0).successful);
  EXPECT_EQ(gain.get(), 1.0);
}

TEST(ParameterCallbacks, MayRefuse) {
  Parameters parameters({given("low", -1.0)});
  const auto gain = parameters.declare<double>("gain", 1.0);
  const auto handle = parameters.on_validate([](const std::vector<NamedParameter>& proposed) {
    return proposed[0].value.get<double>() < 0 ? SetResult::refuse("negative")
                                               : SetResult::accept();
  });
  EXPECT_EQ(parameters.set("gain", -1.0), SetResult::refuse("negative"));
  EXPECT_EQ(gain.get(), 1.0);
  EXPECT_EQ(error_of([&] { parameters.declare<double>("low", 1.0); }),
            "robot.yaml:7: parameter 'low': value -1.0 is refused: negative");
  EXPECT_FALSE(parameters.has("low"));
}

TEST(ParameterCallbacks, HearOfChangesAfterwards) {
  Parameters parameters;
  const auto gain = parameters.declare<double>("gain", 1.0);
  std::vector<double> heard;
  const auto handle = parameters.on_changed([&](const std::vector<NamedParameter>& changed) {
    EXPECT_EQ(changed, (std::vector<NamedParameter>{{"gain", gain.get()}}));
    heard.push_back(parameters.get("gain").get<double>());
  });
  EXPECT_TRUE(parameters.set("gain", 2.0).successful);
  EXPECT_FALSE(parameters.set("gain", 2).successful);
  parameters.declare<double>("other", 1.0);
  EXPECT_EQ(heard, (std::vector{2.0}));
}

TEST(ParameterCallbacks, ExceptionsRefuse) {
  Parameters parameters;
  const auto gain = parameters.declare<double>("gain", 1.0);
  {
    const auto handle = parameters.on_adjust(
        [](std::vector<NamedParameter>&) { throw std::runtime_error("no adjusting"); });
    EXPECT_EQ(parameters.set("gain", 2.0), SetResult::refuse("no adjusting"));
  }
  {
    const auto handle =
        parameters.on_validate([](const std::vector<NamedParameter>&) -> SetResult { throw 5; });
    EXPECT_FALSE(parameters.set("gain", 2.0).successful);
  }
  EXPECT_EQ(gain.get(), 1.0);
  int calls = 0;
  const auto counts = parameters.on_changed([&](const auto&) { ++calls; });
  const auto fails = parameters.on_changed(
      [](const std::vector<NamedParameter>&) { throw std::runtime_error("too late"); });
  EXPECT_EQ(parameters.set("gain", 2.0),
            (SetResult{true, "set, but a callback then failed: too late"}));
  EXPECT_EQ(gain.get(), 2.0);
  EXPECT_EQ(calls, 1);
}

TEST(ParameterCallbacks, RunLastRegisteredFirstUntilTheirHandleGoes) {
  Parameters parameters;
  parameters.declare<int>("n", 0);
  std::string order;
  const auto first = parameters.on_changed([&](const auto&) { order += "1"; });
  {
    const auto second = parameters.on_changed([&](const auto&) { order += "2"; });
    parameters.set("n", 1);
  }
  parameters.set("n", 2);
  EXPECT_EQ(order, "211");
  EXPECT_THROW((void)parameters.on_changed({}), std::invalid_argument);
}

TEST(ParameterCallbacks, MayUnregisterThemselvesAndOthers) {
  Parameters parameters;
  parameters.declare<int>("n", 0);
  int victim_calls = 0;
  int own_calls = 0;
  auto victim = parameters.on_changed([&](const auto&) { ++victim_calls; });
  ParameterCallbackHandle own;
  own = parameters.on_changed([&](const auto&) {
    ++own_calls;
    victim.reset();
    own.reset();
    ++own_calls;
  });
  parameters.set("n", 1);
  parameters.set("n", 2);
  EXPECT_EQ(own_calls, 2);
  EXPECT_EQ(victim_calls, 0);
}

TEST(ParameterCallbacks, HandlesMayOutliveTheParameters) {
  ParameterCallbackHandle handle;
  {
    Parameters parameters;
    handle = parameters.on_changed([](const auto&) {});
  }
  handle.reset();
}

TEST(ParameterCallbacks, MayReadButNotSet) {
  Parameters parameters;
  parameters.declare<int>("n", 0);
  SetResult inner;
  ParameterValue seen;
  std::string declare_error;
  std::string undeclare_error;
  const auto handle = parameters.on_validate([&](const auto&) {
    seen = parameters.get("n");
    EXPECT_EQ(parameters.list().names.size(), 1U);
    EXPECT_EQ(parameters.describe({"n"}).size(), 1U);
    inner = parameters.set("n", 5);
    declare_error = error_of([&] { parameters.declare<int>("m", 0); });
    undeclare_error = error_of([&] { parameters.undeclare("n"); });
    return SetResult::accept();
  });
  EXPECT_TRUE(parameters.set("n", 1).successful);
  EXPECT_EQ(seen, ParameterValue(0));
  EXPECT_EQ(inner,
            SetResult::refuse("parameters cannot be changed from within a parameter callback"));
  EXPECT_NE(declare_error, "no error");
  EXPECT_NE(undeclare_error, "no error");
  EXPECT_EQ(parameters.get("n"), ParameterValue(1));
  EXPECT_TRUE(parameters.set("n", 2).successful);
}

TEST(ParameterCallbacks, DoNotKeepOtherThreadsFromReading) {
  Parameters parameters;
  const auto n = parameters.declare<int>("n", 0);
  const auto handle = parameters.on_validate([&](const auto&) {
    // Would never come back if reading waited for the set.
    const ParameterValue seen =
        std::async(std::launch::async, [&] { return parameters.get("n"); }).get();
    EXPECT_EQ(seen, ParameterValue(0));
    return SetResult::accept();
  });
  EXPECT_TRUE(parameters.set("n", 1).successful);
}

TEST(ParameterEvents, TellWhatIsNewChangedAndDeleted) {
  Parameters parameters;
  std::vector<ParameterChange> events;
  parameters.set_event_sink([&](const ParameterChange& change) { events.push_back(change); });
  parameters.declare({.name = "a", .dynamic_typing = true}, 1);
  parameters.declare({.name = "unset", .type = ParameterType::kDouble});
  parameters.set("a", 2);
  parameters.set("none", 2);
  parameters.set("a", {});
  parameters.declare({.name = "b", .dynamic_typing = true}, 3);
  parameters.undeclare("b");
  const std::vector<ParameterChange> expected = {{.new_parameters = {{"a", 1}}},
                                                 {.changed_parameters = {{"a", 2}}},
                                                 {.deleted_parameters = {{"a", 2}}},
                                                 {.new_parameters = {{"b", 3}}},
                                                 {.deleted_parameters = {{"b", 3}}}};
  EXPECT_EQ(events, expected);
  parameters.set_event_sink({});
  parameters.declare<int>("c", 1);
  EXPECT_EQ(events.size(), expected.size());
}

TEST(ParameterEvents, AFailingSinkReachesTheCallerAndTheValueStays) {
  Parameters parameters;
  const auto n = parameters.declare<int>("n", 0);
  parameters.set_event_sink([](const ParameterChange&) { throw std::runtime_error("no network"); });
  EXPECT_THROW(parameters.set("n", 1), std::runtime_error);
  EXPECT_EQ(n.get(), 1);
  parameters.set_event_sink({});
  EXPECT_TRUE(parameters.set("n", 2).successful);
}

TEST(UnusedOverrides, NameTheNearestDeclaredParameter) {
  Parameters parameters({given("gian", 1.0), given("gain", 2.0), given("zzzz", 3)});
  parameters.declare<double>("gain", 1.0);
  const std::vector<UnusedOverride> unused = parameters.unused_overrides();
  ASSERT_EQ(unused.size(), 2U);
  EXPECT_EQ(unused[0].parameter, given("gian", 1.0));
  EXPECT_EQ(to_string(unused[0]), "robot.yaml:7: no parameter 'gian'; did you mean 'gain'?");
  EXPECT_EQ(to_string(unused[1]), "robot.yaml:7: no parameter 'zzzz'");
}

TEST(ParameterThreads, ReadersSeeWholeAtomicSets) {
  Parameters parameters;
  const auto a = parameters.declare<int>("a", 0);
  const auto b = parameters.declare<int>("b", 0);
  const auto text = parameters.declare<std::string>("text", "0");
  constexpr int kSets = 2000;
  std::atomic<bool> done = false;
  const auto read = [&] {
    int last = 0;
    while (!done) {
      const auto both = parameters.get_many({"a", "b"});
      EXPECT_EQ(both[0], both[1]);
      const int now = a.get();
      EXPECT_GE(now, last);
      last = now;
      EXPECT_FALSE(text.get().empty());
    }
  };
  std::thread reader_1(read);
  std::thread reader_2(read);
  for (int i = 1; i <= kSets; ++i) {
    const auto handle = parameters.on_changed([](const auto&) {});
    parameters.set_atomically({{"a", i}, {"b", i}, {"text", std::to_string(i)}});
  }
  done = true;
  reader_1.join();
  reader_2.join();
  EXPECT_EQ(b.get(), kSets);
}

TEST(ParameterThreads, AHandleThatIsGoneIsNotCalledAnyMore) {
  Parameters parameters;
  parameters.declare<int>("n", 0);
  std::atomic<bool> done = false;
  std::thread writer([&] {
    while (!done) {
      parameters.set("n", 1);
    }
  });
  for (int i = 0; i < 500; ++i) {
    auto alive = std::make_unique<std::atomic<bool>>(true);
    auto handle = parameters.on_changed([&flag = *alive](const auto&) { EXPECT_TRUE(flag); });
    handle.reset();
    *alive = false;
  }
  done = true;
  writer.join();
}

}  // namespace
}  // namespace pipescout
