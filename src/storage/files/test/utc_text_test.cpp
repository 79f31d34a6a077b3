// SPDX-License-Identifier: Apache-2.0
#include "pipescout/files/utc_text.hpp"

#include <gtest/gtest.h>

namespace pipescout {
namespace {

using namespace std::chrono_literals;
using Milliseconds = std::chrono::sys_time<std::chrono::milliseconds>;

TEST(UtcText, HasThreeForms) {
  const Milliseconds time{std::chrono::sys_days{2026y / 3 / 1} + 9h + 30min + 5s + 250ms};
  EXPECT_EQ(utc_text(time, UtcForm::kIso), "2026-03-01T09:30:05.250Z");
  EXPECT_EQ(utc_text(time, UtcForm::kFileName), "2026-03-01T09-30-05Z");
  EXPECT_EQ(utc_text(time, UtcForm::kReadable), "2026-03-01 09:30:05 UTC");
}

TEST(UtcText, GoesFromYear1To9999) {
  EXPECT_EQ(utc_text(Milliseconds(-1ms), UtcForm::kIso), "1969-12-31T23:59:59.999Z");
  EXPECT_EQ(utc_text(Milliseconds(-1ms), UtcForm::kReadable), "1969-12-31 23:59:59 UTC");
  const Milliseconds first{std::chrono::sys_days{1y / 1 / 1}};
  const Milliseconds behind_last{std::chrono::sys_days{10000y / 1 / 1}};
  EXPECT_EQ(utc_text(first, UtcForm::kIso), "0001-01-01T00:00:00.000Z");
  EXPECT_EQ(utc_text(first - 1ms, UtcForm::kIso), "");
  EXPECT_EQ(utc_text(behind_last - 1ms, UtcForm::kIso), "9999-12-31T23:59:59.999Z");
  EXPECT_EQ(utc_text(behind_last, UtcForm::kIso), "");
}

}  // namespace
}  // namespace pipescout
