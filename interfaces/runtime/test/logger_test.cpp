// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/logger.hpp"

#include <gtest/gtest.h>

#include <regex>
#include <string>
#include <utility>
#include <vector>

namespace pipescout {
namespace {

TEST(Logger, WritesTheConsoleFormatOfRosWithoutColoursToAFile) {
  ::testing::internal::CaptureStderr();
  Logger("robot_1.fusion").warn("sigma {} is negative");
  const std::string line = ::testing::internal::GetCapturedStderr();
  EXPECT_TRUE(std::regex_match(
      line,
      std::regex(R"(\[WARN\] \[\d{10,}\.\d{9}\] \[robot_1\.fusion\]: sigma \{\} is negative\n)")))
      << line;
}

TEST(Logger, HandsItsMessagesToTheSink) {
  Logger logger("node");
  std::vector<std::pair<LogSeverity, std::string>> heard;
  logger.set_sink([&heard](LogSeverity severity, const std::string& text, const auto&) {
    heard.emplace_back(severity, text);
  });
  ::testing::internal::CaptureStderr();
  logger.debug("below the threshold");
  logger.info("one");
  logger.error("two");
  logger.fatal("three");
  logger.set_sink({});
  logger.info("nobody hears");
  (void)::testing::internal::GetCapturedStderr();
  EXPECT_EQ(heard,
            (std::vector<std::pair<LogSeverity, std::string>>{{LogSeverity::kInfo, "one"},
                                                              {LogSeverity::kError, "two"},
                                                              {LogSeverity::kFatal, "three"}}));
}

TEST(Logger, SaysWhereInTheCodeAMessageWasLogged) {
  Logger logger("node");
  std::vector<Logger::Location> heard;
  logger.set_sink([&heard](LogSeverity, const std::string&, const Logger::Location& where) {
    heard.push_back(where);
  });
  ::testing::internal::CaptureStderr();
  const auto here = Logger::Location::current();
  logger.warn("one line below");
  logger.log(LogSeverity::kError, "where somebody else was", here);
  (void)::testing::internal::GetCapturedStderr();
  ASSERT_EQ(heard.size(), 2U);
  EXPECT_STREQ(heard[0].file_name(), here.file_name());
  EXPECT_STREQ(heard[0].function_name(), here.function_name());
  EXPECT_EQ(heard[0].line(), here.line() + 1);
  EXPECT_EQ(heard[1].line(), here.line());
}

TEST(Logger, CopiesShareThresholdAndSink) {
  Logger logger("node");
  Logger copy = logger;
  int heard = 0;
  copy.set_sink([&heard](LogSeverity, const std::string&, const auto&) { ++heard; });
  copy.set_threshold(LogSeverity::kError);
  ::testing::internal::CaptureStderr();
  logger.warn("too little");
  logger.error("enough");
  logger.set_threshold(LogSeverity::kDebug);
  copy.debug("now this too");
  const std::string output = ::testing::internal::GetCapturedStderr();
  EXPECT_EQ(heard, 2);
  EXPECT_EQ(output.find("too little"), std::string::npos);
  EXPECT_NE(output.find("[DEBUG]"), std::string::npos);
  EXPECT_EQ(logger.name(), "node");
}

TEST(Logger, ASinkMayLog) {
  Logger logger("node");
  int depth = 0;
  logger.set_sink([&](LogSeverity, const std::string&, const auto&) {
    if (++depth < 3) {
      logger.info("again");
    }
  });
  ::testing::internal::CaptureStderr();
  logger.info("first");
  (void)::testing::internal::GetCapturedStderr();
  EXPECT_EQ(depth, 3);
}

}  // namespace
}  // namespace pipescout
