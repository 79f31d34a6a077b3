// SPDX-License-Identifier: Apache-2.0
// Types of packages that this program was not built with.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "ament_prefix.hpp"
#include "pipescout/idl/field_access.hpp"
#include "pipescout/idl/message_type.hpp"

namespace pipescout {
namespace {

namespace fs = std::filesystem;

/// A prefix with lists of types.
class Prefix : public testing::AmentPrefix {
 public:
  void write_list(const std::string& package, const std::string& text) const {
    write_entry("pipescout_messages", package, text);
  }
  void add_library(const fs::path& library) const {
    fs::create_directories(path() / "lib");
    fs::copy_file(library, path() / "lib" / library.filename());
  }
};

std::string error_of(std::string_view name) {
  try {
    static_cast<void>(load_message_type(name));
  } catch (const MessageTypeError& error) {
    return error.what();
  }
  return "none";
}

bool ends_with(const std::string& text, std::string_view end) {
  return text.size() >= end.size() && text.ends_with(end);
}

TEST(InstalledTypesTest, AreLoadedWhenAskedFor) {
  const Prefix prefix;
  prefix.add_library(OUTSIDE_LIBRARY);
  const auto library = "lib/" + fs::path(OUTSIDE_LIBRARY).filename().string();
  prefix.write_list("outside_msgs", "outside_msgs/msg/Reading;" + library + "\n");
  const auto known = known_message_types();
  EXPECT_TRUE(std::ranges::binary_search(known, "outside_msgs/msg/Reading"));
  EXPECT_TRUE(std::ranges::binary_search(known, "std_msgs/msg/String"));
  const auto* const type = find_message_type("outside_msgs/msg/Reading");
  ASSERT_NE(type, nullptr);
  EXPECT_EQ(type->name, "outside_msgs/msg/Reading");
  EXPECT_EQ(&load_message_type("outside_msgs/msg/Reading"), type);
  // Its fields are of types that the program has itself.
  const auto* const header = find_field(*type, "header");
  ASSERT_NE(header, nullptr);
  EXPECT_EQ(&header->message(), find_message_type("std_msgs/msg/Header"));
  const auto message = type->create();
  std::vector<std::byte> bytes(type->serialized_size(message.get()));
  EXPECT_EQ(type->serialize(message.get(), bytes), bytes.size());
}

TEST(InstalledTypesTest, WhatIsWrongIsSaid) {
  const Prefix prefix;
  EXPECT_EQ(error_of("nowhere_msgs/msg/Type"),
            "unknown type 'nowhere_msgs/msg/Type': no package nowhere_msgs with messages is "
            "installed; is its prefix in AMENT_PREFIX_PATH?");
  EXPECT_EQ(error_of("std_msgs/msg/Strin"),
            "unknown type 'std_msgs/msg/Strin': its package has no such type");
  EXPECT_EQ(error_of("../../etc/passwd"), "'../../etc/passwd' is no type name: package/msg/Type");
  prefix.write_list("listed_msgs", "listed_msgs/msg/Other;lib/libnone.so\n");
  EXPECT_TRUE(ends_with(error_of("listed_msgs/msg/Type"), "/listed_msgs does not list it"));
  EXPECT_NE(error_of("listed_msgs/msg/Other").find("cannot be loaded"), std::string::npos);
  EXPECT_EQ(find_message_type("listed_msgs/msg/Other"), nullptr);
  prefix.write_list("broken_msgs", "broken_msgs/msg/Type;lib/x.so\nno semicolon\n");
  EXPECT_TRUE(ends_with(error_of("broken_msgs/msg/Type"),
                        "/broken_msgs:2: expected TYPE;LIBRARY, found 'no semicolon'"));
  prefix.add_library(OUTSIDE_LIBRARY);
  const auto library = "lib/" + fs::path(OUTSIDE_LIBRARY).filename().string();
  prefix.write_list("foreign_msgs", "foreign_msgs/msg/Type;" + library + "\n");
  EXPECT_TRUE(ends_with(error_of("foreign_msgs/msg/Type"),
                        "holds no messages of foreign_msgs: it has no symbol "
                        "pipescout_message_objects_of_foreign_msgs"));
  // The lists of other packages are read all the same.
  EXPECT_TRUE(std::ranges::binary_search(known_message_types(), "listed_msgs/msg/Other"));
}

}  // namespace
}  // namespace pipescout
