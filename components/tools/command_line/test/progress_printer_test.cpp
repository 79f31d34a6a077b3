// SPDX-License-Identifier: Apache-2.0
#include "pipescout/command_line/progress_printer.hpp"

#include <gtest/gtest.h>

#include <sstream>

namespace pipescout::command_line {
namespace {

using std::chrono::milliseconds;

TEST(ProgressPrinter, RewritesOneLineOnATerminal) {
  std::ostringstream out;
  ProgressPrinter printer(out, true);
  SteadyTime now{};
  printer.show("1/3", 0.3, now);
  printer.show("2/3", 0.6, now + milliseconds(50));
  EXPECT_EQ(out.str(), "\r\x1b[K1/3\r");
  EXPECT_EQ(printer.due(), now + milliseconds(100));
  printer.show("2/3", 0.6, now + milliseconds(100));
  EXPECT_FALSE(printer.due());
  EXPECT_EQ(out.str(), "\r\x1b[K1/3\r\r\x1b[K2/3\r");
  printer.show("3/3", 1.0, now + milliseconds(110));
  printer.finish();
  EXPECT_EQ(out.str(), "\r\x1b[K1/3\r\r\x1b[K2/3\r\r\x1b[K3/3\r\n");
}

TEST(ProgressPrinter, PrintsFewLinesElsewhere) {
  std::ostringstream out;
  ProgressPrinter printer(out, false);
  // A minute, in which 1 % is done every 100 ms for ten seconds, then nothing.
  SteadyTime now{};
  for (int percent = 0; percent <= 100; ++percent) {
    printer.show(std::to_string(percent), percent / 100.0, now);
    now += milliseconds(100);
  }
  for (int i = 0; i < 500; ++i) {
    printer.show("100", 1.0, now);
    now += milliseconds(100);
  }
  printer.finish();
  EXPECT_EQ(out.str(), "0\n10\n20\n30\n40\n50\n60\n70\n80\n90\n100\n");
}

TEST(ProgressPrinter, PrintsOncePerSecondWhenTheShareIsUnknown) {
  std::ostringstream out;
  ProgressPrinter printer(out, false);
  SteadyTime now{};
  for (int i = 0; i < 25; ++i) {
    printer.show(std::to_string(i), std::nullopt, now);
    now += milliseconds(100);
  }
  printer.finish();
  EXPECT_EQ(out.str(), "0\n10\n20\n24\n");
}

TEST(ProgressPrinter, ShowsNothingOfNothing) {
  std::ostringstream out;
  ProgressPrinter printer(out, true);
  printer.show("", std::nullopt, SteadyTime{});
  printer.finish();
  EXPECT_EQ(out.str(), "");
}

}  // namespace
}  // namespace pipescout::command_line
