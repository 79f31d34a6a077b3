// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/introspection.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <geometry_msgs/msg/pose_with_covariance.hpp>
#include <pipescout_msgs/msg/fused_odometer.hpp>
#include <random>
#include <rcl_interfaces/msg/parameter_descriptor.hpp>
#include <sensor_msgs/msg/image.hpp>
#include <sensor_msgs/msg/nav_sat_fix.hpp>
#include <std_msgs/msg/string.hpp>

#include "pipescout/files/testing/temporary_folder.hpp"

namespace pipescout {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

template <class T>
std::vector<std::byte> to_cdr(const T& message) {
  const auto& type = message_type<T>();
  std::vector<std::byte> bytes(type.serialized_size(&message));
  bytes.resize(type.serialize(&message, bytes));
  return bytes;
}

template <class T>
DynamicMessage read(const T& message) {
  return read_message(MessageDescriptions::installed().find(message_type<T>().name),
                      to_cdr(message));
}

template <class T>
T get(const DynamicMessage& message, std::string_view path) {
  const auto& value = *find_field(message, path).value;
  if constexpr (std::is_same_v<T, std::string>) {
    return std::get<std::string>(value);
  } else {
    return std::get<T>(std::get<ScalarValue>(value));
  }
}

/// What a call throws as IdlError, or "".
template <class F>
std::string error_of(F call) {
  try {
    call();
  } catch (const std::exception& error) {
    return error.what();
  }
  return "";
}

/// A folder of .idl files that goes with the object.
class IdlTree {
 public:
  void add(const std::string& file, const std::string& text) const {
    std::filesystem::create_directories((root() / file).parent_path());
    std::ofstream(root() / file) << text;
  }
  [[nodiscard]] const std::filesystem::path& root() const { return folder_.path(); }

 private:
  testing::TemporaryFolder folder_;
};

/// The error of reading type p/msg/T from this text of its file, without the file's name.
std::string error_in(const std::string& text) {
  const IdlTree tree;
  tree.add("p/msg/T.idl", text);
  MessageDescriptions descriptions(tree.root());
  auto error = error_of([&] { static_cast<void>(descriptions.find("p/msg/T")); });
  const auto file = (tree.root() / "p/msg/T.idl").string() + ":";
  return error.starts_with(file) ? error.substr(file.size()) : error;
}

TEST(MessageDescriptions, DescribesEveryInstalledType) {
  for (const auto* type : message_types()) {
    const auto description = MessageDescriptions::installed().find(type->name);
    EXPECT_EQ(description->name, type->name);
    EXPECT_FALSE(description->fields.empty()) << type->name;
  }
}

TEST(MessageDescriptions, ReadsFieldsShapesAndConstants) {
  const auto fix = MessageDescriptions::installed().find("sensor_msgs/msg/NavSatFix");
  ASSERT_EQ(fix->fields.size(), 7U);
  EXPECT_EQ(fix->fields[0].name, "header");
  EXPECT_EQ(fix->fields[0].message->name, "std_msgs/msg/Header");
  EXPECT_EQ(fix->fields[5].shape, FieldShape::kArray);
  EXPECT_EQ(fix->fields[5].length, 9U);
  EXPECT_EQ(fix->fields[5].kind, FieldKind::kFloat64);
  ASSERT_EQ(fix->constants.size(), 4U);
  EXPECT_EQ(fix->constants[3].name, "COVARIANCE_TYPE_KNOWN");
  EXPECT_EQ(std::get<ScalarValue>(fix->constants[3].value), ScalarValue{std::uint64_t{3}});

  const auto descriptor =
      MessageDescriptions::installed().find("rcl_interfaces/msg/ParameterDescriptor");
  EXPECT_EQ(descriptor->fields[6].shape, FieldShape::kSequence);
  EXPECT_EQ(descriptor->fields[6].length, 1U);
}

TEST(MessageDescriptions, ReadsTheWholeSubset) {
  const IdlTree tree;
  tree.add("p/msg/Inner.idl", "module p { module msg { struct Inner { octet x; }; }; };");
  tree.add("p/msg/T.idl", R"idl(// comment
#ifndef GUARD
#define GUARD
#include "p/msg/Inner.idl"
/* block
   comment */
module p { module msg {
typedef double double__9[9];
module T_Constants {
  const int8 LOWEST = -128; const uint8 HEX = 0xff; const int32 OCTAL = 010;
  const double REAL = -1.5e-3; const boolean YES = TRUE; const string TEXT = "a \"b\"" "c";
  const unsigned long long LARGEST = 18446744073709551615;
};
@verbatim (language="comment", text="says (much)")
struct T {
  @default (value=-1.0) @unit("m")
  double__9 covariance;
  Inner inner;
  p::msg::Inner scoped;
  ::p::msg::Inner absolute;
  sequence<Inner, 3> inners;
  string<4> bounded;
  sequence<string<2>> words;
  unsigned short us; long long ll; long l; float f; char c; boolean _union;
}; }; };
#endif
)idl");
  MessageDescriptions descriptions(tree.root());
  const auto type = descriptions.find("p/msg/T");
  ASSERT_EQ(type->fields.size(), 13U);
  EXPECT_EQ(type->fields[0].length, 9U);
  EXPECT_EQ(type->fields[1].message, type->fields[2].message);
  EXPECT_EQ(type->fields[1].message, type->fields[3].message);
  EXPECT_EQ(type->fields[4].length, 3U);
  EXPECT_EQ(type->fields[5].string_length, 4U);
  EXPECT_EQ(type->fields[6].string_length, 2U);
  EXPECT_EQ(type->fields[8].kind, FieldKind::kInt64);
  EXPECT_EQ(type->fields[12].name, "union");
  ASSERT_EQ(type->constants.size(), 7U);
  EXPECT_EQ(std::get<ScalarValue>(type->constants[0].value), ScalarValue{std::int64_t{-128}});
  EXPECT_EQ(std::get<ScalarValue>(type->constants[1].value), ScalarValue{std::uint64_t{255}});
  EXPECT_EQ(std::get<ScalarValue>(type->constants[2].value), ScalarValue{std::int64_t{8}});
  EXPECT_EQ(std::get<ScalarValue>(type->constants[3].value), ScalarValue{-1.5e-3});
  EXPECT_EQ(std::get<std::string>(type->constants[5].value), "a \"b\"c");
  EXPECT_EQ(std::get<ScalarValue>(type->constants[6].value),
            ScalarValue{std::numeric_limits<std::uint64_t>::max()});
}

TEST(MessageDescriptions, NamesFileLineAndColumnOfAnError) {
  EXPECT_EQ(error_in("module p { module msg {\nstruct T { int9 x; }; }; };"),
            "2:12: unknown type 'int9'");
  EXPECT_EQ(error_in("module p { module msg {\n struct T { };\n}; };"),
            "2:9: struct 'p::msg::T' has no member");
  EXPECT_EQ(error_in("module p {\n/* open"), "2:1: comment is not closed");
  EXPECT_EQ(error_in("struct T { uint8 a uint8 b; };"), "1:20: expected ';', found 'uint8'");
  EXPECT_EQ(error_in("struct T { uint8 a[0]; };"),
            "1:20: expected a size of at least 1, found '0'");
  EXPECT_EQ(error_in("struct T { uint8 a[2][2]; };"),
            "1:22: arrays of more than one dimension are not supported");
  EXPECT_EQ(error_in("const uint8 A = 256;"), "1:17: 256 does not fit into uint8");
  EXPECT_EQ(error_in("const int8 A = -129;"), "1:17: -129 does not fit into int8");
  EXPECT_EQ(error_in("union U switch (long) { };"),
            "1:1: expected 'module', 'struct', 'const' or 'typedef', found 'union'");
  EXPECT_EQ(error_in("module p {"),
            "1:11: expected 'module', 'struct', 'const' or 'typedef', found 'end of file'");
  EXPECT_EQ(error_in("struct T { uint8 a; uint8 a; };"), "1:27: a second member 'a'");
  EXPECT_EQ(error_in("const string A = \"x\n\";"), "1:18: string is not closed");
  EXPECT_EQ(error_in("module p { $ };"), "1:12: unexpected character '$'");
}

TEST(MessageDescriptions, RefusesWhatIsNotThere) {
  auto& installed = MessageDescriptions::installed();
  const auto find = [&](std::string_view type) {
    return error_of([&] { static_cast<void>(installed.find(type)); });
  };
  EXPECT_THAT(find("sensor_msgs/msg/Imag"), StartsWith("unknown type 'sensor_msgs/msg/Imag'"));
  EXPECT_THAT(find(""), HasSubstr("is no type name"));
  EXPECT_THAT(find("/etc/passwd"), HasSubstr("is no type name"));
  EXPECT_THAT(find("../../x"), HasSubstr("is no type name"));
  EXPECT_THAT(error_in("module p { struct U { uint8 x; }; };"), HasSubstr("no struct 'p/msg/T'"));
  EXPECT_THAT(error_in("#include \"p/msg/T.idl\"\n"), HasSubstr("includes itself"));
  EXPECT_THAT(error_in("#include \"p/msg/U.idl\"\n"), HasSubstr("p/msg/U.idl: cannot be read"));
}

TEST(MessageDescriptions, AFileWithAnErrorLeavesNothingBehind) {
  const IdlTree tree;
  tree.add("p/msg/T.idl", "module p { module msg { struct T { uint8 x; }; }; }; nonsense");
  MessageDescriptions descriptions(tree.root());
  EXPECT_THROW(static_cast<void>(descriptions.find("p/msg/T")), IdlError);
  EXPECT_THROW(static_cast<void>(descriptions.find("p/msg/T")), IdlError);
  tree.add("p/msg/T.idl", "module p { module msg { struct T { uint8 x; }; }; };");
  EXPECT_EQ(descriptions.find("p/msg/T")->fields.size(), 1U);
}

TEST(ReadMessage, ReadsNestedFieldsArraysAndSequences) {
  pipescout_msgs::msg::FusedOdometer message;
  message.header.stamp.sec = -7;
  message.header.stamp.nanosec = 123456789;
  message.header.frame_id = "base_link";
  message.distance = 5.51;
  message.name = {"left", "", "right"};
  message.in_fusion_set = {true, false, true};
  message.support = {1, 0, 255};
  message.confidence_distance = {0.25, -1.0};
  message.status = 1;

  const auto read_back = read(message);
  EXPECT_EQ(get<std::int64_t>(read_back, "header.stamp.sec"), -7);
  EXPECT_EQ(get<std::uint64_t>(read_back, "header.stamp.nanosec"), 123456789U);
  EXPECT_EQ(get<std::string>(read_back, "header.frame_id"), "base_link");
  EXPECT_EQ(get<double>(read_back, "distance"), 5.51);
  EXPECT_THAT(std::get<std::vector<std::string>>(*find_field(read_back, "name").value),
              ::testing::ElementsAre("left", "", "right"));
  const auto& in_set = std::get<PrimitiveArray>(*find_field(read_back, "in_fusion_set").value);
  ASSERT_EQ(in_set.size(), 3U);
  EXPECT_EQ(in_set[1], ScalarValue{false});
  EXPECT_EQ(in_set[2], ScalarValue{true});
  const auto& support = std::get<PrimitiveArray>(*find_field(read_back, "support").value);
  EXPECT_EQ(support[2], ScalarValue{std::uint64_t{255}});
  const auto& distance =
      std::get<PrimitiveArray>(*find_field(read_back, "confidence_distance").value);
  ASSERT_EQ(distance.size(), 2U);
  EXPECT_EQ(distance[1], ScalarValue{-1.0});
  EXPECT_EQ(get<std::uint64_t>(read_back, "status"), 1U);
}

TEST(ReadMessage, ReadsSequencesOfMessagesAndFixedArrays) {
  rcl_interfaces::msg::ParameterDescriptor message;
  message.name = "epsilon";
  rcl_interfaces::msg::FloatingPointRange range;
  range.from_value = 0.5;
  range.to_value = 1.5;
  message.floating_point_range = {range};
  const auto read_back = read(message);
  const auto& ranges =
      std::get<std::vector<DynamicMessage>>(*find_field(read_back, "floating_point_range").value);
  ASSERT_EQ(ranges.size(), 1U);
  EXPECT_EQ(get<double>(ranges[0], "to_value"), 1.5);

  geometry_msgs::msg::PoseWithCovariance pose;
  pose.pose.orientation.w = 1.0;
  pose.covariance[35] = 0.125;
  const auto pose_back = read(pose);
  const auto& covariance = std::get<PrimitiveArray>(*find_field(pose_back, "covariance").value);
  ASSERT_EQ(covariance.size(), 36U);
  EXPECT_EQ(covariance[35], ScalarValue{0.125});
}

TEST(ReadMessage, ReadsBigEndianBytes) {
  // std_msgs/msg/String "hi" and an int16 array would differ; a Header exercises 4-byte integers.
  const std::vector<unsigned> numbers{0, 0, 0, 0, 0, 0, 1, 2, 0, 0, 0, 5, 0, 0, 0, 3, 'h', 'i', 0};
  std::vector<std::byte> bytes;
  for (const auto number : numbers) {
    bytes.push_back(static_cast<std::byte>(number));
  }
  const auto header =
      read_message(MessageDescriptions::installed().find("std_msgs/msg/Header"), bytes);
  EXPECT_EQ(get<std::int64_t>(header, "stamp.sec"), 258);
  EXPECT_EQ(get<std::uint64_t>(header, "stamp.nanosec"), 5U);
  EXPECT_EQ(get<std::string>(header, "frame_id"), "hi");
}

TEST(ReadMessage, DefaultOfEveryTypeIsReadable) {
  for (const auto* type : message_types()) {
    const auto message = type->create();
    std::vector<std::byte> bytes(type->serialized_size(message.get()));
    bytes.resize(type->serialize(message.get(), bytes));
    const auto description = MessageDescriptions::installed().find(type->name);
    EXPECT_EQ(read_message(description, bytes).values.size(), description->fields.size())
        << type->name;
  }
}

TEST(ReadMessage, EveryTruncationIsAnErrorThatNamesTheField) {
  pipescout_msgs::msg::FusedOdometer message;
  message.header.frame_id = "base_link";
  message.name = {"left", "right"};
  message.confidence_distance = {1.0, 2.0};
  message.rejection_reason = {0, 1};
  const auto bytes = to_cdr(message);
  const auto type = MessageDescriptions::installed().find("pipescout_msgs/msg/FusedOdometer");
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    // A buffer of its own lets the sanitizer see any read past the end.
    const std::vector<std::byte> truncated(bytes.begin(),
                                           bytes.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_THROW(static_cast<void>(read_message(type, truncated)), MalformedMessage) << size;
  }
  const auto error =
      error_of([&] { static_cast<void>(read_message(type, std::span(bytes).subspan(0, 18))); });
  EXPECT_EQ(error, "header.frame_id: string of 10 bytes at byte 16, 2 bytes are left");
}

TEST(ReadMessage, HostileLengthsAllocateNothing) {
  sensor_msgs::msg::Image image;
  auto bytes = to_cdr(image);
  // The length of `data` is the last word.
  std::fill(bytes.end() - 4, bytes.end(), std::byte{0xff});
  const auto error = error_of([&] {
    static_cast<void>(
        read_message(MessageDescriptions::installed().find("sensor_msgs/msg/Image"), bytes));
  });
  EXPECT_THAT(error, StartsWith("data: 4294967295 x uint8"));
}

TEST(ReadMessage, SurvivesFlippedBytes) {
  rcl_interfaces::msg::ParameterDescriptor message;
  message.name = "epsilon";
  message.description = "largest confidence distance";
  message.floating_point_range.resize(1);
  const auto bytes = to_cdr(message);
  const auto type = MessageDescriptions::installed().find("rcl_interfaces/msg/ParameterDescriptor");
  std::mt19937 engine(7);
  std::size_t read_well = 0;
  constexpr std::size_t kRounds = 20000;
  for (std::size_t round = 0; round < kRounds; ++round) {
    auto damaged = bytes;
    for (int flips = 0; flips < 3; ++flips) {
      damaged[engine() % damaged.size()] = static_cast<std::byte>(engine() & 0xffU);
    }
    try {
      static_cast<void>(read_message(type, damaged));
      ++read_well;
    } catch (const MalformedMessage&) {
    }
  }
  EXPECT_GT(read_well, 0U);
  EXPECT_LT(read_well, kRounds);
}

TEST(ReadMessage, RefusesOtherEncapsulations) {
  auto bytes = to_cdr(std_msgs::msg::String{});
  bytes[1] = std::byte{3};  // parameter list
  EXPECT_EQ(error_of([&] {
              static_cast<void>(read_message(
                  MessageDescriptions::installed().find("std_msgs/msg/String"), bytes));
            }),
            "encapsulation 3 is not plain CDR");
}

TEST(FindField, NamesThePartThatIsNoField) {
  const auto message = read(pipescout_msgs::msg::FusedOdometer{});
  const auto error = [&](std::string_view path) {
    return error_of([&] { static_cast<void>(find_field(message, path)); });
  };
  EXPECT_EQ(error("header.stmp.sec"), "'stmp' is no field of std_msgs/msg/Header");
  EXPECT_EQ(error(""), "'' is no field of pipescout_msgs/msg/FusedOdometer");
  EXPECT_EQ(error("distance.x"), "'distance' is no message, so it has no field 'x'");
}

}  // namespace
}  // namespace pipescout
