// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/conversions.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

namespace pipescout {
namespace {

using std::chrono::nanoseconds;
using std::chrono::seconds;

TEST(TimeConversion, RoundsSecondsDown) {
  const auto message = to_message(Time(nanoseconds(-1)));
  EXPECT_EQ(message.sec, -1);
  EXPECT_EQ(message.nanosec, 999'999'999U);
  EXPECT_EQ(from_message(message), Time(nanoseconds(-1)));
}

TEST(TimeConversion, SaturatesWhereTheMessageEnds) {
  constexpr std::int64_t kMax = std::numeric_limits<std::int32_t>::max();
  EXPECT_EQ(to_message(Time(seconds(kMax + 1))).sec, kMax);
  EXPECT_EQ(to_message(Time(seconds(kMax + 1))).nanosec, 999'999'999U);
  EXPECT_EQ(to_message(Duration(seconds(-kMax - 2))).sec, -kMax - 1);
  EXPECT_EQ(to_message(Duration(seconds(-kMax - 2))).nanosec, 0U);
  EXPECT_EQ(to_message(Time::max()).sec, kMax);
  EXPECT_EQ(to_message(Duration::min()).sec, -kMax - 1);
}

TEST(TimeConversion, CountsASurplusOfNanoseconds) {
  builtin_interfaces::msg::Duration message;
  message.sec = 1;
  message.nanosec = 4'000'000'000U;
  EXPECT_EQ(from_message(message), seconds(5));
}

RC_GTEST_PROP(TimeConversionProperties, SurvivesTheWayThereAndBack, ()) {
  const auto count =
      *rc::gen::inRange<std::int64_t>(-2'147'483'648'000'000'000LL, 2'147'483'647'999'999'999LL);
  RC_ASSERT(from_message(to_message(Time(nanoseconds(count)))) == Time(nanoseconds(count)));
  RC_ASSERT(from_message(to_message(Duration(count))) == Duration(count));
  RC_ASSERT(to_message(Duration(count)).nanosec < 1'000'000'000U);
}

rc::Gen<ParameterValue> any_value() {
  return rc::gen::oneOf(
      rc::gen::just(ParameterValue()),
      rc::gen::construct<ParameterValue>(rc::gen::arbitrary<bool>()),
      rc::gen::construct<ParameterValue>(rc::gen::arbitrary<std::int64_t>()),
      rc::gen::construct<ParameterValue>(rc::gen::arbitrary<double>()),
      rc::gen::construct<ParameterValue>(rc::gen::arbitrary<std::string>()),
      rc::gen::construct<ParameterValue>(rc::gen::arbitrary<std::vector<std::uint8_t>>()),
      rc::gen::construct<ParameterValue>(rc::gen::arbitrary<std::vector<bool>>()),
      rc::gen::construct<ParameterValue>(rc::gen::arbitrary<std::vector<std::int64_t>>()),
      rc::gen::construct<ParameterValue>(rc::gen::arbitrary<std::vector<double>>()),
      rc::gen::construct<ParameterValue>(rc::gen::arbitrary<std::vector<std::string>>()));
}

RC_GTEST_PROP(ParameterConversionProperties, SurvivesTheWayThereAndBack, ()) {
  const NamedParameter parameter{*rc::gen::arbitrary<std::string>(), *any_value()};
  const auto message = to_message(parameter);
  RC_ASSERT(message.value.type == static_cast<std::uint8_t>(parameter.value.type()));
  RC_ASSERT(from_message(message) == parameter);
}

TEST(ParameterConversion, RefusesATypeThatDoesNotExist) {
  rcl_interfaces::msg::Parameter message;
  message.name = "gain";
  message.value.type = 10;
  try {
    (void)from_message(message);
    FAIL() << "type 10 was accepted";
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("'gain'"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("10"), std::string::npos) << error.what();
  }
}

TEST(DescriptorConversion, SurvivesTheWayThereAndBack) {
  const ParameterDescriptor descriptor{.name = "gain",
                                       .type = ParameterType::kDouble,
                                       .description = "of the controller",
                                       .additional_constraints = "not above the other",
                                       .read_only = true,
                                       .dynamic_typing = false,
                                       .floating_point_range = FloatingPointRange{0.5, 2.0, 0.25},
                                       .integer_range = std::nullopt};
  EXPECT_EQ(from_message(to_message(descriptor)), descriptor);
  const ParameterDescriptor integer{.name = "count",
                                    .type = ParameterType::kInteger,
                                    .description = "",
                                    .additional_constraints = "",
                                    .read_only = false,
                                    .dynamic_typing = true,
                                    .floating_point_range = std::nullopt,
                                    .integer_range = IntegerRange{2, 16, 2}};
  EXPECT_EQ(from_message(to_message(integer)), integer);
}

TEST(DescriptorConversion, RefusesATypeThatDoesNotExist) {
  rcl_interfaces::msg::ParameterDescriptor message;
  message.type = 200;
  EXPECT_THROW((void)from_message(message), std::invalid_argument);
}

TEST(GidConversion, SurvivesTheWayThereAndBack) {
  Gid gid;
  for (std::size_t i = 0; i < gid.bytes.size(); ++i) {
    gid.bytes.at(i) = static_cast<std::uint8_t>(i + 1);
  }
  const auto message = to_message(gid);
  EXPECT_EQ(message.data.at(15), 16);
  EXPECT_EQ(message.data.at(16), 0);
  EXPECT_EQ(from_message(message), gid);
}

TEST(ResultConversion, SurvivesTheWayThereAndBack) {
  const SetResult refused = SetResult::refuse("too large");
  EXPECT_EQ(from_message(to_message(refused)), refused);
  const ParameterList list{{"a.b", "a.c"}, {"a"}};
  EXPECT_EQ(from_message(to_message(list)), list);
}

}  // namespace
}  // namespace pipescout
