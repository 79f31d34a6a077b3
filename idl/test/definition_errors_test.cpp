// SPDX-License-Identifier: Apache-2.0
// What is wrong in a definition is said with its file, line and name.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <stdexcept>
#include <string>

#include "definitions.hpp"
#include "temporary_folder.hpp"

namespace pipescout::generator {
namespace {

/// A package `p` with the given files, "msg/T.msg"; what loading the first one says.
std::string error_of(const std::map<std::string, std::string>& files, const std::string& load) {
  const testing::TemporaryFolder folder;
  for (const auto& [name, text] : files) {
    const auto file = folder.path() / "p" / name;
    std::filesystem::create_directories(file.parent_path());
    std::ofstream(file) << text;
  }
  Definitions definitions({folder.path(), DEFINITIONS_DIR}, {});
  try {
    definitions.load(load);
  } catch (const std::exception& error) {
    std::string what = error.what();
    const auto root = (folder.path() / "p").string() + "/";
    if (what.starts_with(root)) {
      what.erase(0, root.size());
    }
    return what;
  }
  return "none";
}

std::string error_of_msg(const std::string& text) {
  return error_of({{"msg/T.msg", text}}, "p/msg/T");
}

std::string error_of_idl(const std::string& body) {
  return error_of({{"msg/T.idl", "module p { module msg {\n" + body + "\n}; };\n"}}, "p/msg/T");
}

TEST(DefinitionErrorsTest, UnknownTypes) {
  EXPECT_EQ(error_of_msg("# comment\nNothing x\n"), "msg/T.msg:2: x: unknown type p/msg/Nothing");
  EXPECT_EQ(error_of_msg("std_msgs/Nothing x\n"),
            "msg/T.msg:1: x: unknown type std_msgs/msg/Nothing");
  EXPECT_EQ(error_of_msg("int33 x\n"),
            "msg/T.msg:1: int33: a type name has letters and digits and "
            "begins with a capital letter");
  EXPECT_EQ(error_of_idl("struct T { q::msg::U x; };"), "msg/T.idl:2: x: unknown type q/msg/U");
  EXPECT_EQ(error_of_idl("struct T { q::U x; };"),
            "msg/T.idl:2: q::U: unknown type; a message is named package::msg::Type");
  EXPECT_EQ(error_of({}, "p/msg/T"), "there is no definition of p/msg/T");
}

TEST(DefinitionErrorsTest, Cycles) {
  EXPECT_EQ(error_of({{"msg/A.msg", "int8 x\nB b\n"}, {"msg/B.msg", "A[] a\n"}}, "p/msg/A"),
            "msg/B.msg:1: a: a type contains itself: p/msg/A -> p/msg/B -> p/msg/A");
  EXPECT_EQ(error_of_msg("T t\n"), "msg/T.msg:1: t: a type contains itself: p/msg/T -> p/msg/T");
}

TEST(DefinitionErrorsTest, Names) {
  const std::string rule =
      ": a field name has lower case letters, digits and single underscores, begins with a letter "
      "and does not end with an underscore";
  EXPECT_EQ(error_of_msg("int8 class\n"),
            "msg/T.msg:1: class: is a keyword of C++, which no field can be named");
  EXPECT_EQ(error_of_idl("struct T {\n int8 private; };"),
            "msg/T.idl:3: private: is a keyword of C++, which no field can be named");
  for (const std::string name : {"X", "x_", "x__y", "_x", "1x", "x-y"}) {
    EXPECT_EQ(error_of_msg("int8 " + name + "\n"), "msg/T.msg:1: " + name + rule);
  }
  EXPECT_EQ(error_of_msg("int8 x\nint16 x\n"), "msg/T.msg:2: x: a second field of this name");
  EXPECT_EQ(error_of_msg("int8 X=1\nint8 X=2\n"), "msg/T.msg:2: X: a second constant of this name");
  EXPECT_EQ(error_of_idl("struct T { int8 x;\nint8 x; };"),
            "msg/T.idl:3: x: a second field of this name");
  EXPECT_EQ(error_of_idl("struct T { int8 x; };\nstruct T { int8 x; };"),
            "msg/T.idl:3: p/msg/T: a second structure of this name");
  EXPECT_EQ(error_of({{"msg/t.msg", "int8 x\n"}}, "p/msg/t"),
            "msg/t.msg:1: t: a type name has letters and digits and begins with a capital letter");
  EXPECT_EQ(error_of_msg("int8\n"), "msg/T.msg:1: int8: a type without a name");
}

TEST(DefinitionErrorsTest, DefaultsAndConstants) {
  EXPECT_EQ(error_of_msg("int8 x 128\n"), "msg/T.msg:1: x: 128 does not fit into int8");
  EXPECT_EQ(error_of_msg("uint8 x -1\n"), "msg/T.msg:1: x: -1 does not fit into uint8");
  EXPECT_EQ(error_of_msg("uint64 X=18446744073709551616\n"),
            "msg/T.msg:1: X: '18446744073709551616' is not an integer of 64 bits");
  EXPECT_EQ(error_of_msg("bool x maybe\n"), "msg/T.msg:1: x: 'maybe' is neither true nor false");
  EXPECT_EQ(error_of_msg("float64 x 1,5\n"), "msg/T.msg:1: x: '1,5' is not a number");
  EXPECT_EQ(error_of_msg("float32 x 1e39\n"), "msg/T.msg:1: x: 1e39 does not fit into float32");
  EXPECT_EQ(error_of_msg("int8[2] x [1, 2, 3]\n"),
            "msg/T.msg:1: x: the default has 3 values for an array of 2");
  EXPECT_EQ(error_of_msg("int8[<=2] x [1, 2, 3]\n"),
            "msg/T.msg:1: x: the default has 3 values, the bound is 2");
  EXPECT_EQ(error_of_msg("int8[] x 1\n"),
            "msg/T.msg:1: x: '1' is not a list of values in brackets");
  EXPECT_EQ(error_of_msg("string<=2 x \"abc\"\n"),
            "msg/T.msg:1: x: the default is longer than the bound of 2 characters");
  EXPECT_EQ(error_of_msg("string x \"abc\n"), "msg/T.msg:1: x: the quotes of \"abc do not match");
  EXPECT_EQ(error_of_msg("Header x 1\n"), "msg/T.msg:1: x: a message cannot have a default value");
  EXPECT_EQ(error_of_msg("int8[] X=1\n"),
            "msg/T.msg:1: X: a constant is a number, a truth value or a string");
  EXPECT_EQ(error_of_msg("int8 X=\n"), "msg/T.msg:1: X: a constant without a value");
  EXPECT_EQ(error_of_idl("struct T { @default (value=1.5)\n int8 x; };"),
            "msg/T.idl:2: x: '1.5' is not an integer of 64 bits");
}

TEST(DefinitionErrorsTest, Sizes) {
  EXPECT_EQ(error_of_msg("int8[0] x\n"), "msg/T.msg:1: x: a size or bound is at least 1");
  EXPECT_EQ(error_of_msg("int8[<=0] x\n"), "msg/T.msg:1: x: a size or bound is at least 1");
  EXPECT_EQ(error_of_msg("int8<=3 x\n"),
            "msg/T.msg:1: x: only strings have a bound, int8 has none");
  EXPECT_EQ(error_of_idl("struct T { int8 x[0]; };"),
            "msg/T.idl:2: expected a size of at least 1, found '0'");
  EXPECT_EQ(error_of_idl("struct T { sequence<sequence<int8>> x; };"),
            "msg/T.idl:2: sequences of arrays or sequences are not supported");
}

TEST(DefinitionErrorsTest, WhatRosidlDoesNotRead) {
  EXPECT_EQ(
      error_of({{"msg/T.idl", "\n#ifndef T_IDL\n"}}, "p/msg/T"),
      "msg/T.idl:2: '#ifndef' is not supported, as rosidl does not; of the preprocessor there "
      "is #include only, and no file needs include guards");
  EXPECT_EQ(error_of_idl("enum Kind { A };"),
            "msg/T.idl:2: expected 'module', 'struct', 'const' or 'typedef', found 'enum': ROS 2 "
            "messages are made of structures and constants");
  EXPECT_EQ(error_of_idl("struct T { };"),
            "msg/T.idl:2: p/msg/T: has no member; a structure without fields gets uint8 "
            "structure_needs_at_least_one_member");
  EXPECT_EQ(error_of_idl("struct T { int8 x"), "msg/T.idl:3: expected ';', found '}'");
  EXPECT_EQ(error_of_idl("struct T { long double x; };"),
            "msg/T.idl:2: 'long double' is not supported");
}

TEST(DefinitionErrorsTest, AFileDefinesWhatItsPathPromises) {
  EXPECT_EQ(error_of_idl("struct U { int8 x; };"),
            "msg/T.idl:1: p::msg::T: the file does not define this structure, which its path "
            "promises");
  EXPECT_EQ(error_of_idl("struct T { int8 x; };\nstruct U { int8 x; };"),
            "msg/T.idl:3: p::msg::U: a file defines only the type that its path names");
  EXPECT_EQ(error_of({{"srv/S.srv", "int8 x\n"}}, "p/srv/S"),
            "srv/S.srv:1: has 0 lines '---', expected 1");
  EXPECT_EQ(error_of({{"srv/S.srv", "---\n---\n"}}, "p/srv/S"), "srv/S.srv:2: one '---' too many");
}

TEST(DefinitionErrorsTest, WhatIsRightHasNone) {
  EXPECT_EQ(error_of_msg("int8 x 1\nHeader header\nstring<=3[<=2] names ['a', \"b\"]\n"), "none");
  EXPECT_EQ(error_of_msg(""), "none");
  EXPECT_EQ(error_of({{"action/A.action", "---\n---\n"}}, "p/action/A"), "none");
}

}  // namespace
}  // namespace pipescout::generator
