// SPDX-License-Identifier: Apache-2.0
// `pipescout inspect leaks`, on pictures made here: TIFF of 32-bit temperatures.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>

#include "pipescout/files/testing/temporary_folder.hpp"
#include "pipescout/testing/program.hpp"

namespace pipescout::inspect {
namespace {

using ::pipescout::testing::content;
using ::pipescout::testing::Finished;
using ::pipescout::testing::run_program;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
namespace fs = std::filesystem;

constexpr std::uint32_t kWidth = 160;
constexpr std::uint32_t kHeight = 120;

/// A pipe through the middle, with 0.25 of its length at 230 degC.
std::string picture(bool leaks, float pipe_temperature = 140) {
  struct Entry {
    std::uint16_t tag;
    std::uint16_t type;  // 3: 16 bits, 4: 32 bits
    std::uint32_t count;
    std::uint32_t value;
  };
  constexpr std::uint32_t kPixels = 8 + 2 + 10 * 12 + 4;
  constexpr std::uint32_t kBytes = kWidth * kHeight * 4;
  constexpr std::array<Entry, 10> kEntries = {{{256, 4, 1, kWidth},
                                               {257, 4, 1, kHeight},
                                               {258, 3, 1, 32},
                                               {259, 3, 1, 1},
                                               {262, 3, 1, 1},
                                               {273, 4, 1, kPixels},
                                               {277, 3, 1, 1},
                                               {278, 4, 1, kHeight},
                                               {279, 4, 1, kBytes},
                                               {339, 3, 1, 3}}};
  std::string tiff("II*\0\x08\0\0\0\x0a\0", 10);
  const auto add = [&tiff](const auto& value) {
    std::array<char, sizeof(value)> bytes{};
    std::memcpy(bytes.data(), &value, sizeof(value));
    tiff.append(bytes.data(), bytes.size());
  };
  for (const Entry& entry : kEntries) {
    add(entry.tag);
    add(entry.type);
    add(entry.count);
    add(entry.value);
  }
  add(std::uint32_t{0});
  for (std::uint32_t y = 0; y < kHeight; ++y) {
    for (std::uint32_t x = 0; x < kWidth; ++x) {
      const bool pipe = y >= 54 && y <= 66;
      const bool leak = leaks && pipe && x >= 60 && x < 100;
      add(leak   ? 230.0F
          : pipe ? pipe_temperature
                 : 15.0F + static_cast<float>((x * 7 + y * 13) % 5));
    }
  }
  return tiff;
}

class InspectCommand : public ::testing::Test {
 protected:
  InspectCommand() { fs::create_directories(path("night")); }
  [[nodiscard]] fs::path path(const std::string& name) const { return folder_.path() / name; }
  void write(const std::string& name, const std::string& bytes) const {
    std::ofstream(path(name), std::ios::binary) << bytes;
  }
  [[nodiscard]] Finished run(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), "leaks");
    return run_program(INSPECT_COMMAND, arguments, folder_.path());
  }

  ::pipescout::testing::TemporaryFolder folder_;
};

TEST_F(InspectCommand, WritesFindingsAndAReport) {
  for (const char* name : {"0.tiff", "1.tiff", "2.tiff", "3.tiff", "4.tiff"}) {
    write(std::string("night/") + name, picture(true));
  }
  const Finished done = run({"night", "--out", "found"});
  EXPECT_EQ(done.code(), 0) << done.err;
  EXPECT_THAT(done.out, AllOf(HasSubstr("5 images, 5 with pipes, 5 leaks in single images"),
                              HasSubstr("1 finding raised"), HasSubstr("found/report.html")));
  EXPECT_THAT(done.err, HasSubstr("[####################] 5 of 5 pictures"));
  EXPECT_THAT(content(path("found/report.html")), HasSubstr("id=\"leak1\""));
  EXPECT_THAT(content(path("found/leaks.csv")), HasSubstr("\n1,raised,"));
  for (const char* name : {"leaks.sqlite", "leaks.geojson", "leaks.kml"}) {
    EXPECT_TRUE(fs::exists(path("found") / name)) << name;
  }
}

TEST_F(InspectCommand, TellsWhatItCannotUseAndGoesOn) {
  write("night/0.tiff", picture(false));
  write("night/1.jpg", "");
  write("night/2.tiff", picture(false));
  const Finished done = run({"night", "--out", "found", "--preset", "torresol"});
  EXPECT_EQ(done.code(), 1);
  EXPECT_THAT(done.out, HasSubstr("2 images, 2 with pipes, 0 leaks in single images"));
  EXPECT_THAT(done.err, AllOf(HasSubstr("warning: night/1.jpg: is empty"),
                              HasSubstr("error: 1 image could not be used")));
}

TEST_F(InspectCommand, NamesThePresetThatFindsPipes) {
  for (const char* name : {"0.tiff", "1.tiff"}) {
    write(std::string("night/") + name, picture(false, 85));
  }
  const Finished done = run({"night", "--out", "found"});
  EXPECT_EQ(done.code(), 0) << done.err;
  EXPECT_THAT(done.out, HasSubstr("2 images, 0 with pipes"));
  EXPECT_THAT(done.err, AllOf(HasSubstr("note: no pipe in 2 images with preset collectors"),
                              HasSubstr("--preset hot_pipes finds pipes in 2")));
  EXPECT_THAT(run({"night", "--out", "found", "--preset", "hot_pipes"}).out,
              HasSubstr("2 images, 2 with pipes"));
}

TEST_F(InspectCommand, WhatCannotBegin) {
  EXPECT_EQ(run({"nowhere", "--out", "found"}).code(), 2);
  EXPECT_EQ(run({"night"}).code(), 2);
  EXPECT_EQ(run({"night", "--out", "found", "--preset", "warm"}).code(), 2);
  const Finished empty = run({"night", "--out", "found"});
  EXPECT_EQ(empty.code(), 1);
  EXPECT_THAT(empty.err, HasSubstr("error: night: contains no image"));
  EXPECT_THAT(empty.out, IsEmpty());
}

}  // namespace
}  // namespace pipescout::inspect
