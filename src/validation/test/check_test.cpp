// SPDX-License-Identifier: Apache-2.0
#include "pipescout/validation/check.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

namespace pipescout::validation {
namespace {

using testing::ThrowsMessage;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

template <typename Check>
auto refused(Check check, const char* message) {
  EXPECT_THAT(check, ThrowsMessage<std::invalid_argument>(message));
}

TEST(Check, BoundsBelongToTheRangeOrNot) {
  EXPECT_NO_THROW(check_within("lag", 1, 1, 2));
  EXPECT_NO_THROW(check_within("lag", 2, 1, 2));
  EXPECT_NO_THROW(check_above("lag", 2, 1, 2));
  EXPECT_NO_THROW(check_between("lag", 1.5, 1, 2));
  refused([] { check_within("lag", 2.5, 1, 2); }, "lag: 2.5 is outside [1, 2]");
  refused([] { check_above("lag", 1, 1, 2); }, "lag: 1 is outside (1, 2]");
  refused([] { check_between("lag", 2, 1, 2); }, "lag: 2 is outside (1, 2)");
}

TEST(Check, WhatIsNotFiniteIsOutsideEveryRange) {
  refused([] { check_within("lag", kNan, 1, 2); }, "lag: nan is outside [1, 2]");
  refused([] { check_within("lag", kInfinity, 1, kInfinity); }, "lag: inf is outside [1, inf]");
  refused([] { check_above("lag", kInfinity, 0, kInfinity); }, "lag: inf is outside (0, inf]");
  refused([] { require("lag", kNan, true, "(-inf, inf)"); }, "lag: nan is outside (-inf, inf)");
}

TEST(Check, RequiresAConditionOfTheCaller) {
  EXPECT_NO_THROW(require("order", 2, true, "{2, 4}"));
  refused([] { require("order", 3, false, "{2, 4}"); }, "order: 3 is outside {2, 4}");
}

TEST(Check, FieldsOfPartsAreNamedByBoth) {
  refused([] { check_within({"health.", "ratio"}, 3, 0, 1); }, "health.ratio: 3 is outside [0, 1]");
}

TEST(Check, RefusesWithTheParts) {
  refused([] { refuse("knots[", 3, "]: ", 0.5, " does not rise"); }, "knots[3]: 0.5 does not rise");
}

}  // namespace
}  // namespace pipescout::validation
