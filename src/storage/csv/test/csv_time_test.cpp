// SPDX-License-Identifier: Apache-2.0
#include "pipescout/csv/csv_time.hpp"

#include <gtest/gtest.h>

#include <chrono>

namespace pipescout {
namespace {

using std::chrono::nanoseconds;

TEST(CsvTime, UnitsByWordAndByName) {
  EXPECT_EQ(time_unit("ms"), TimeUnit::kMilliseconds);
  EXPECT_EQ(time_unit("µs"), TimeUnit::kMicroseconds);
  EXPECT_EQ(time_unit("min"), std::nullopt);
  EXPECT_STREQ(to_string(TimeUnit::kNanoseconds), "ns");
  EXPECT_EQ(time_unit_of_name("Zeit [ms]"), TimeUnit::kMilliseconds);
  EXPECT_EQ(time_unit_of_name("t_ns"), TimeUnit::kNanoseconds);
  EXPECT_EQ(time_unit_of_name("stamp"), std::nullopt);
  EXPECT_EQ(time_unit_of_name("wheels"), std::nullopt);
}

TEST(CsvTime, ExactToTheNanosecond) {
  EXPECT_EQ(parse_time("1700000000015000064", TimeUnit::kNanoseconds),
            nanoseconds(1'700'000'000'015'000'064));
  EXPECT_EQ(parse_time("1700000000015000.064", TimeUnit::kMicroseconds),
            nanoseconds(1'700'000'000'015'000'064));
  EXPECT_EQ(parse_time("-12.5", TimeUnit::kMilliseconds), nanoseconds(-12'500'000));
  EXPECT_EQ(parse_time("0.12345678951", TimeUnit::kSeconds), nanoseconds(123'456'790));
  EXPECT_EQ(parse_time("2147483648", TimeUnit::kSeconds), std::nullopt);
  EXPECT_EQ(parse_time("12345678901234567890", TimeUnit::kNanoseconds), std::nullopt);
  EXPECT_EQ(parse_time("1e3", TimeUnit::kSeconds), std::nullopt);
}

TEST(CsvTime, DatesOfIsoAndOfDots) {
  constexpr nanoseconds kTime{1'795'937'765'250'000'000};
  for (const char* text :
       {"2026-11-29T07:36:05.25Z", "2026-11-29 08:36:05,25+01:00", "2026-11-29T06:06:05.250-0130",
        "20261129T073605.25Z", "2026-11-29T09:36:05.25+02"}) {
    const auto time = parse_date_and_time(text);
    ASSERT_TRUE(time) << text;
    EXPECT_EQ(time->since_1970, kTime) << text;
    EXPECT_TRUE(time->has_zone) << text;
  }
  const auto german = parse_date_and_time("29.11.2026 07:36:05,25");
  ASSERT_TRUE(german);
  EXPECT_EQ(german->since_1970, kTime);
  EXPECT_FALSE(german->has_zone);
  EXPECT_EQ(parse_date_and_time("2026-11-29 07:36")->since_1970,
            kTime - std::chrono::milliseconds(5250));
}

TEST(CsvTime, DatesThatMayBeAnotherDayAreNone) {
  for (const char* text :
       {"11/12/2026 07:36:05", "2024-1-5 3:7:2", "2024-1-5_3-7-2", "5.1.2024 03:07:02",
        "2026-13-01T00:00:00", "2026-02-30T00:00:00", "2026-11-29", "07:36:05",
        "2026-11-29T24:00:00", "2026-11-29T07:36:05 CET", "1969-12-31T23:59:59Z",
        "2039-01-01T00:00:00Z", ""}) {
    EXPECT_FALSE(parse_date_and_time(text)) << text;
  }
}

}  // namespace
}  // namespace pipescout
