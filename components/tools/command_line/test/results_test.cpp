// SPDX-License-Identifier: Apache-2.0
#include "pipescout/command_line/results.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <functional>
#include <string>

#include "pipescout/command_line/command.hpp"
#include "pipescout/files/testing/temporary_folder.hpp"

namespace pipescout::command_line {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

class Results : public ::testing::Test {
 protected:
  [[nodiscard]] fs::path in_folder(const std::string& name) const { return folder_.path() / name; }
  static std::string refusal(const std::function<void()>& check) {
    try {
      check();
    } catch (const CommandError& error) {
      return error.what();
    }
    return "";
  }

  testing::TemporaryFolder folder_;
};

TEST_F(Results, AFileMayNotExist) {
  EXPECT_EQ(refusal([&] { require_new_file(in_folder("new.csv")); }), "");
  EXPECT_EQ(refusal([] { require_new_file(""); }), "");
  std::ofstream(in_folder("old.csv")) << "of another run";
  EXPECT_THAT(refusal([&] { require_new_file(in_folder("old.csv")); }),
              AllOf(HasSubstr(in_folder("old.csv").string() + ": exists already"),
                    HasSubstr("never overwritten")));
  EXPECT_THAT(refusal([&] { require_new_file(folder_.path()); }), HasSubstr("is a folder"));
}

TEST_F(Results, WhatKeepsNothingMayBeWrittenTo) {
  EXPECT_EQ(refusal([] { require_new_file("/dev/null"); }), "");
}

TEST_F(Results, AFolderMayExistAndBeEmpty) {
  EXPECT_EQ(refusal([&] { require_new_folder(in_folder("new")); }), "");
  fs::create_directory(in_folder("empty"));
  EXPECT_EQ(refusal([&] { require_new_folder(in_folder("empty")); }), "");
  std::ofstream(in_folder("file")) << "no folder";
  EXPECT_THAT(refusal([&] { require_new_folder(in_folder("file")); }), HasSubstr("is no folder"));
  EXPECT_THAT(refusal([&] { require_new_folder(folder_.path()); }),
              HasSubstr(folder_.path().string() + ": is not empty ("));
}

TEST(NumberedPicture, HasNumberAndName) {
  EXPECT_EQ(numbered_picture("out", 12, "a.jpg"), "out/000012_a.jpg.png");
  EXPECT_EQ(numbered_picture("out", 1, "/camera/image 3"), "out/000001__camera_image_3.png");
}

}  // namespace
}  // namespace pipescout::command_line
