// SPDX-License-Identifier: Apache-2.0
// Types that are made at run time from the definitions of a ROS 2 installation.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <builtin_interfaces/msg/time.hpp>
#include <cstddef>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "all_types.hpp"
#include "ament_prefix.hpp"
#include "pipescout/idl/field_access.hpp"
#include "pipescout/idl/message_type.hpp"
#include "random_message.hpp"

namespace pipescout {
namespace {

using testing::AmentPrefix;
using ::testing::HasSubstr;
using testing::TwinTypes;

using Bytes = std::vector<std::byte>;

Bytes serialized(const MessageType& type, const void* message) {
  Bytes bytes(type.serialized_size(message));
  EXPECT_EQ(type.serialize(message, bytes), bytes.size());
  return bytes;
}

std::string error_of(std::string_view name) {
  try {
    static_cast<void>(load_message_type(name));
  } catch (const MessageTypeError& error) {
    return error.what();
  }
  return "none";
}

TEST(LoadedTypesTest, DescribeWhatTheGeneratedOnesDo) {
  ASSERT_GE(testing::twin_types().size(), 14u);
  for (const auto& [generated, loaded] : testing::twin_types()) {
    SCOPED_TRACE(generated->name);
    ASSERT_NE(loaded, generated);
    EXPECT_EQ(loaded->name, generated->name);
    EXPECT_EQ(loaded->dds_name, generated->dds_name);
    EXPECT_EQ(loaded->definition, generated->definition);
    ASSERT_EQ(loaded->fields.size(), generated->fields.size());
    for (std::size_t i = 0; i < loaded->fields.size(); ++i) {
      const auto& field = loaded->fields[i];
      const auto& twin = generated->fields[i];
      SCOPED_TRACE(twin.name);
      EXPECT_EQ(field.name, twin.name);
      EXPECT_EQ(field.kind, twin.kind);
      EXPECT_EQ(field.shape, twin.shape);
      EXPECT_EQ(field.length, twin.length);
      EXPECT_EQ(field.string_length, twin.string_length);
      EXPECT_EQ(field.default_value, twin.default_value);
      if (field.kind == FieldKind::kMessage) {
        EXPECT_EQ(field.message().name, twin.message().name);
      }
    }
    ASSERT_EQ(loaded->constants.size(), generated->constants.size());
    for (std::size_t i = 0; i < loaded->constants.size(); ++i) {
      EXPECT_EQ(loaded->constants[i].name, generated->constants[i].name);
      EXPECT_EQ(loaded->constants[i].kind, generated->constants[i].kind);
      EXPECT_EQ(loaded->constants[i].value, generated->constants[i].value);
    }
  }
}

TEST(LoadedTypesTest, ANewMessageHasTheDefaults) {
  for (const auto& [generated, loaded] : testing::twin_types()) {
    EXPECT_EQ(serialized(*loaded, loaded->create().get()),
              serialized(*generated, generated->create().get()))
        << generated->name;
  }
}

// Both ways: what one form writes the other reads as the same.
RC_GTEST_PROP(LoadedTypesTest, AnyMessageHasTheSameBytes, ()) {
  for (const auto& [generated, loaded] : testing::twin_types()) {
    const auto original = *testing::any_message(*generated);
    const Bytes bytes = serialized(*generated, original.message.get());
    const auto read = loaded->create();
    RC_ASSERT(loaded->deserialize(bytes, read.get()));
    RC_ASSERT(serialized(*loaded, read.get()) == bytes);

    const auto filled = *testing::any_message(*loaded);  // through the field table
    const Bytes own = serialized(*loaded, filled.message.get());
    const auto back = generated->create();
    RC_ASSERT(generated->deserialize(own, back.get()));
    RC_ASSERT(serialized(*generated, back.get()) == own);
  }
}

// In either byte order; most of these bytes are refused.
RC_GTEST_PROP(LoadedTypesTest, AnyBytesAreReadOrRefusedAlike, ()) {
  const auto words = *rc::gen::container<std::vector<std::uint8_t>>(
      rc::gen::weightedElement<std::uint8_t>({{12, 0}, {6, 1}, {1, 3}, {1, 200}}));
  for (const std::byte order : {std::byte{0}, std::byte{1}}) {
    Bytes bytes{std::byte{0}, order, std::byte{0}, std::byte{0}};
    for (const auto word : words) {
      bytes.push_back(std::byte{word});
    }
    for (const auto& twins : testing::twin_types()) {
      const auto generated = twins.generated->create();
      const auto loaded = twins.loaded->create();
      const bool accepted = twins.generated->deserialize(bytes, generated.get());
      RC_ASSERT(twins.loaded->deserialize(bytes, loaded.get()) == accepted);
      if (accepted) {
        RC_ASSERT(serialized(*twins.loaded, loaded.get()) ==
                  serialized(*twins.generated, generated.get()));
      }
    }
  }
}

TEST(LoadedTypesTest, ASequenceKeepsItsElementsAndItsBound) {
  static_cast<void>(testing::twin_types());
  const auto& type = load_message_type("test_msgs/msg/Everything");
  const auto message = type.create();
  const auto editor = [&](std::string_view name) {
    return FieldEditor(*find_field(type, name), message.get());
  };
  auto inners = editor("inners");
  inners.resize(2);
  const auto& inner = find_field(type, "inners")->message();
  FieldEditor(*find_field(inner, "name"), inners.message(1))
      .set(0, std::string_view("a text that is too long to lie in the object itself"));
  inners.resize(50);
  inners.resize(3);
  EXPECT_EQ(FieldView(*find_field(inner, "name"), inners.message(1)).text(),
            "a text that is too long to lie in the object itself");
  EXPECT_EQ(FieldView(*find_field(inner, "name"), inners.message(2)).text(), "");
  EXPECT_THROW(editor("few_inners").resize(4), std::length_error);
  EXPECT_THROW(editor("few_truths").resize(4), std::length_error);
  EXPECT_THROW(editor("few_texts").resize(4), std::length_error);
  EXPECT_THROW(editor("short_text").set(0, std::string_view("six456")), std::length_error);
}

TEST(LoadedTypesTest, NestedTypesOfTheProgramAreItsOwn) {
  const AmentPrefix prefix;
  prefix.write_definition("valve_msgs", "msg/Valve.msg",
                          "std_msgs/Header header\nHandle[2] handles\nsensor_msgs/Image[] views\n");
  prefix.write_definition("valve_msgs", "msg/Handle.msg",
                          "geometry_msgs/Pose pose\nstring name \"handle\"\nuint8 OPEN=1\n");
  const auto& valve = load_message_type("valve_msgs/msg/Valve");
  EXPECT_EQ(&load_message_type("valve_msgs/msg/Valve"), &valve);
  EXPECT_EQ(&find_field(valve, "header")->message(), find_message_type("std_msgs/msg/Header"));
  EXPECT_EQ(&find_field(valve, "handles")->message(), find_message_type("valve_msgs/msg/Handle"));
  const auto message = valve.create();
  // Code that knows the nested class uses it.
  const auto stamp = find_field({&valve, message.get()}, "header.stamp").message();
  ASSERT_EQ(stamp.type, &message_type<builtin_interfaces::msg::Time>());
  EXPECT_EQ(static_cast<const builtin_interfaces::msg::Time*>(stamp.message)->sec, 0);
  EXPECT_EQ(FieldView(*find_field(find_field(valve, "handles")->message(), "name"),
                      FieldView(*find_field(valve, "handles"), message.get()).message(1).message)
                .text(),
            "handle");
  FieldEditor views(*find_field(valve, "views"), message.get());
  views.resize(3);
  const auto bytes = serialized(valve, message.get());
  const auto copy = valve.create();
  ASSERT_TRUE(valve.deserialize(bytes, copy.get()));
  EXPECT_EQ(serialized(valve, copy.get()), bytes);
}

TEST(LoadedTypesTest, ServicesActionsAndIdlFilesAreFound) {
  const AmentPrefix prefix;
  prefix.write_definition("pump_msgs", "srv/Start.srv", "float32 speed 1.5\n---\nbool done\n");
  // What an older rosidl puts beside a service, and what it makes of a message.
  prefix.write_definition("pump_msgs", "srv/Start_Request.msg", "float32 speed 1.5\n");
  prefix.write_definition("pump_msgs", "action/Fill.action", "uint8 level\n---\n---\nuint8 now\n");
  prefix.write_definition("pump_msgs", "msg/Level.idl",
                          "#include \"std_msgs/msg/Header.idl\"\nmodule pump_msgs { module msg {\n"
                          "typedef double double__3[3];\nstruct Level { std_msgs::msg::Header "
                          "header; double__3 levels; wstring unit; }; }; };\n");
  const auto& request = load_message_type("pump_msgs/srv/Start_Request");
  EXPECT_EQ(request.dds_name, "pump_msgs::srv::dds_::Start_Request_");
  EXPECT_EQ(find_field(request, "speed")->default_value, "1.5");
  const auto& feedback = load_message_type("pump_msgs/action/Fill_FeedbackMessage");
  EXPECT_EQ(find_field(feedback, "feedback")->message().fields[0].name, "now");
  EXPECT_EQ(load_message_type("pump_msgs/action/Fill_Result").fields[0].name,
            "structure_needs_at_least_one_member");
  EXPECT_EQ(find_field(load_message_type("pump_msgs/msg/Level"), "levels")->length, 3u);

  const auto known = known_message_types();
  const auto count = std::ranges::count_if(
      known, [](const std::string& name) { return name.starts_with("pump_msgs/"); });
  EXPECT_EQ(count, 2 + 8 + 1);
  EXPECT_TRUE(std::ranges::binary_search(known, "pump_msgs/action/Fill_SendGoal_Request"));
}

TEST(LoadedTypesTest, APackageOfTheProgramCanHaveMoreTypes) {
  const AmentPrefix prefix;
  prefix.write_definition("std_msgs", "msg/Header.msg", "string other\n");
  prefix.write_definition("std_msgs", "msg/OfALaterRelease.msg", "Header header\n");
  EXPECT_EQ(load_message_type("std_msgs/msg/Header").fields.size(), 2u);
  EXPECT_EQ(&load_message_type("std_msgs/msg/OfALaterRelease").fields[0].message(),
            find_message_type("std_msgs/msg/Header"));
}

TEST(LoadedTypesTest, WhatIsMissingOrWrongIsSaidWithItsFile) {
  const AmentPrefix prefix;
  const auto share = (std::filesystem::canonical(prefix.path()) / "share").string() + "/";
  prefix.write_definition("bad_msgs", "msg/Uses.msg", "# comment\nother_msgs/Part part\n");
  EXPECT_EQ(error_of("bad_msgs/msg/Uses"),
            share +
                "bad_msgs/msg/Uses.msg:2: part: unknown type 'other_msgs/msg/Part': no package "
                "other_msgs with messages is installed; is its prefix in AMENT_PREFIX_PATH?");
  // Once it is there, all is well.
  prefix.write_definition("other_msgs", "msg/Part.msg", "int8 x\n");
  EXPECT_EQ(error_of("bad_msgs/msg/Uses"), "none");

  prefix.write_definition("bad_msgs", "msg/Broken.msg", "int32 x\nint32 x\n");
  prefix.write_definition("bad_msgs", "msg/UsesBroken.msg", "Broken b\n");
  EXPECT_EQ(error_of("bad_msgs/msg/UsesBroken"),
            share + "bad_msgs/msg/Broken.msg:2: x: a second field of this name");
  prefix.write_definition("bad_msgs", "msg/First.msg", "Second second\n");
  prefix.write_definition("bad_msgs", "msg/Second.msg", "First[] firsts\n");
  EXPECT_EQ(error_of("bad_msgs/msg/First"),
            share +
                "bad_msgs/msg/Second.msg:1: firsts: a type contains itself: bad_msgs/msg/First "
                "-> bad_msgs/msg/Second -> bad_msgs/msg/First");
  EXPECT_THAT(error_of("bad_msgs/msg/Absent"),
              HasSubstr("/rosidl_interfaces/bad_msgs does not list it"));
  std::filesystem::remove(prefix.path() / "share/bad_msgs/msg/Broken.msg");
  EXPECT_THAT(error_of("bad_msgs/msg/Broken"), HasSubstr("Broken.msg is missing"));
}

}  // namespace
}  // namespace pipescout
