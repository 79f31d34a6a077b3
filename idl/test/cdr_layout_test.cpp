// SPDX-License-Identifier: Apache-2.0
// Bytes written out by hand from the CDR rules (OMG CDR, little-endian, alignment counted from the
// end of the encapsulation header), as ROS 2 puts them on the wire.
#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <pipescout_msgs/msg/odometer_readings.hpp>
#include <rcl_interfaces/msg/parameter_descriptor.hpp>
#include <rcl_interfaces/msg/parameter_value.hpp>
#include <rmw_dds_common/msg/participant_entities_info.hpp>
#include <sensor_msgs/msg/image.hpp>
#include <sensor_msgs/msg/nav_sat_fix.hpp>
#include <span>
#include <std_msgs/msg/empty.hpp>
#include <std_msgs/msg/header.hpp>
#include <std_msgs/msg/string.hpp>
#include <std_srvs/srv/set_bool.hpp>
#include <string>
#include <vector>

namespace pipescout {
namespace {

using Bytes = std::vector<std::byte>;

const Bytes kLittleEndian{std::byte{0}, std::byte{1}, std::byte{0}, std::byte{0}};

/// Joins the parts of a message in the order of its fields.
Bytes join(std::initializer_list<Bytes> parts) {
  Bytes joined;
  for (const Bytes& part : parts) {
    joined.insert(joined.end(), part.begin(), part.end());
  }
  return joined;
}

Bytes raw(std::initializer_list<unsigned> values) {
  Bytes bytes;
  for (const unsigned value : values) {
    bytes.push_back(static_cast<std::byte>(value));
  }
  return bytes;
}

Bytes padding(std::size_t count) {
  return Bytes(count, std::byte{0});
}

Bytes u32(std::uint32_t value) {
  return raw({value & 0xff, (value >> 8) & 0xff, (value >> 16) & 0xff, value >> 24});
}

/// Characters with the terminating NUL, which CDR counts in the length.
Bytes text(const std::string& value) {
  Bytes bytes = u32(static_cast<std::uint32_t>(value.size() + 1));
  for (const char c : value) {
    bytes.push_back(static_cast<std::byte>(c));
  }
  bytes.push_back(std::byte{0});
  return bytes;
}

const Bytes kOne = raw({0, 0, 0, 0, 0, 0, 0xf0, 0x3f});       // 1.0
const Bytes kMinusTwo = raw({0, 0, 0, 0, 0, 0, 0x00, 0xc0});  // -2.0
const Bytes kHalf = raw({0, 0, 0, 0, 0, 0, 0xe0, 0x3f});      // 0.5
const Bytes kZero = padding(8);

/// The message must serialise to these bytes, to the last one, and come back from them.
template <class T>
void expect_layout(const T& message, const Bytes& expected) {
  const MessageType& type = message_type<T>();
  EXPECT_EQ(type.serialized_size(&message), expected.size());
  Bytes bytes(expected.size() + 8);
  bytes.resize(type.serialize(&message, bytes));
  EXPECT_EQ(bytes, expected);
  T copy;
  ASSERT_TRUE(type.deserialize(expected, &copy));
  EXPECT_EQ(copy, message);
}

std_msgs::msg::Header header(const std::string& frame) {
  std_msgs::msg::Header value;
  value.stamp.sec = -2;
  value.stamp.nanosec = 0x01020304;
  value.frame_id = frame;
  return value;
}

Bytes header_bytes(const std::string& frame) {
  return join({raw({0xfe, 0xff, 0xff, 0xff}), raw({4, 3, 2, 1}), text(frame)});
}

TEST(CdrLayoutTest, String) {
  std_msgs::msg::String message;
  message.data = "hello";
  expect_layout(message, raw({0, 1, 0, 0, 6, 0, 0, 0, 'h', 'e', 'l', 'l', 'o', 0}));
}

TEST(CdrLayoutTest, EmptyStringHoldsItsNul) {
  expect_layout(std_msgs::msg::String(), raw({0, 1, 0, 0, 1, 0, 0, 0, 0}));
}

TEST(CdrLayoutTest, EmptyMessageHasOneByte) {
  expect_layout(std_msgs::msg::Empty(), raw({0, 1, 0, 0, 0}));
}

TEST(CdrLayoutTest, Header) {
  expect_layout(header("map"), join({kLittleEndian, header_bytes("map")}));
}

TEST(CdrLayoutTest, Image) {
  sensor_msgs::msg::Image message;
  message.header = header("camera");  // 19 bytes: the next number needs a byte of padding
  message.height = 1;
  message.width = 2;
  message.encoding = "mono16";
  message.is_bigendian = 0;
  message.step = 4;
  message.data = {1, 2, 3, 255};
  expect_layout(message, join({kLittleEndian, header_bytes("camera"), padding(1), u32(1), u32(2),
                               text("mono16"), raw({0}), u32(4), u32(4), raw({1, 2, 3, 255})}));
}

TEST(CdrLayoutTest, ImageWithNumbersAfterOddData) {
  // A sequence of bytes of odd length before an aligned field, in OdometerReadings's order.
  pipescout_msgs::msg::OdometerReadings message;
  message.header = header("base");
  message.name = {"a", "bc"};
  message.distance = {1.0, -2.0};
  message.standard_deviation = {0.5, 0.5};
  message.valid = {true, false};
  // Offsets: header ends at 17; names 20..24, a 24..30, bc 32..39; distance 40..48 .. 64.
  expect_layout(message, join({kLittleEndian, header_bytes("base"), padding(3), u32(2), text("a"),
                               padding(2), text("bc"), padding(1), u32(2), padding(4), kOne,
                               kMinusTwo, u32(2), padding(4), kHalf, kHalf, u32(2), raw({1, 0})}));
}

TEST(CdrLayoutTest, NavSatFix) {
  sensor_msgs::msg::NavSatFix message;
  message.header = header("gps");  // 16 bytes
  message.status.status = sensor_msgs::msg::NavSatStatus::STATUS_NO_FIX;
  message.status.service = 0x0102;
  message.latitude = 1.0;
  message.longitude = -2.0;
  message.altitude = 0.5;
  message.position_covariance = {1.0, 0.0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.0, -2.0};
  message.position_covariance_type = 3;
  expect_layout(message, join({kLittleEndian, header_bytes("gps"), raw({0xff}), padding(1),
                               raw({2, 1}), padding(4), kOne, kMinusTwo, kHalf, kOne, kZero, kZero,
                               kZero, kHalf, kZero, kZero, kZero, kMinusTwo, raw({3})}));
}

TEST(CdrLayoutTest, ParameterValue) {
  rcl_interfaces::msg::ParameterValue message;
  message.type = 8;
  message.bool_value = true;
  message.integer_value = -1;
  message.double_value = 1.0;
  message.string_value = "x";
  message.byte_array_value = {9};
  message.bool_array_value = {true};
  message.integer_array_value = {};  // no elements, hence no padding to their alignment
  message.double_array_value = {0.5};
  message.string_array_value = {"", "y"};
  expect_layout(message, join({kLittleEndian, raw({8, 1}), padding(6), Bytes(8, std::byte{0xff}),
                               kOne,  // 0..24
                               text("x"),     padding(2),  u32(1),     raw({9}),
                               padding(3),    u32(1),      raw({1}),           // 24..45
                               padding(3),    u32(0),      u32(1),     kHalf,  // 45..64
                               u32(2),        u32(1),      raw({0}),   padding(3),
                               text("y")}));
}

TEST(CdrLayoutTest, ParameterDescriptorRanges) {
  rcl_interfaces::msg::ParameterDescriptor message;
  message.name = "p";
  message.type = 3;
  message.read_only = true;
  rcl_interfaces::msg::FloatingPointRange range;
  range.from_value = -2.0;
  range.to_value = 1.0;
  range.step = 0.5;
  message.floating_point_range = {range};
  expect_layout(message, join({kLittleEndian, text("p"), raw({3}), padding(1),  // 0..8
                               u32(1), raw({0}), padding(3), u32(1), raw({0}),  // 8..21
                               raw({1, 0}), padding(1), u32(1), padding(4),     // 21..32
                               kMinusTwo, kOne, kHalf, u32(0)}));
}

TEST(CdrLayoutTest, GidHas24Bytes) {
  std::array<std::uint8_t, 24> gid{};
  for (std::size_t i = 0; i < gid.size(); ++i) {
    gid[i] = static_cast<std::uint8_t>(i + 1);
  }
  Bytes gid_bytes;
  for (const auto value : gid) {
    gid_bytes.push_back(std::byte{value});
  }
  rmw_dds_common::msg::Gid one;
  one.data = gid;
  rmw_dds_common::msg::NodeEntitiesInfo node;
  node.node_namespace = "/";
  node.node_name = "n";
  node.writer_gid_seq = {one, one};
  rmw_dds_common::msg::ParticipantEntitiesInfo message;
  message.gid = one;
  message.node_entities_info_seq = {node};
  expect_layout(message, join({kLittleEndian, gid_bytes, u32(1), text("/"), padding(2), text("n"),
                               padding(2), u32(0), u32(2), gid_bytes, gid_bytes}));
}

TEST(CdrLayoutTest, HalvesOfAService) {
  std_srvs::srv::SetBool_Request request;
  request.data = true;
  expect_layout(request, join({kLittleEndian, raw({1})}));
  std_srvs::srv::SetBool_Response response;
  response.success = true;
  response.message = "ok";
  expect_layout(response, join({kLittleEndian, raw({1}), padding(3), text("ok")}));
}

TEST(CdrLayoutTest, ReadsBigEndian) {
  const Bytes bytes = raw({0,    0,    0,    0,                         // encapsulation
                           0xff, 0xff, 0xff, 0xfe,                      // sec
                           1,    2,    3,    4,                         // nanosec
                           0,    0,    0,    4,    'm', 'a', 'p', 0});  // frame_id
  std_msgs::msg::Header message;
  ASSERT_TRUE(message_type<std_msgs::msg::Header>().deserialize(bytes, &message));
  EXPECT_EQ(message, header("map"));
}

TEST(CdrLayoutTest, ReadsBigEndianSequences) {
  const Bytes bytes =
      join({raw({0, 0, 0, 0}), raw({0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0}), padding(3),  // header
            raw({0, 0, 0, 0}),                                                            // name
            raw({0, 0, 0, 1}), raw({0x3f, 0xf0, 0, 0, 0, 0, 0, 0}),  // distance
            raw({0, 0, 0, 0}),                                       // deviation
            raw({0, 0, 0, 2, 0, 1})});                               // valid
  pipescout_msgs::msg::OdometerReadings message;
  ASSERT_TRUE(message_type<pipescout_msgs::msg::OdometerReadings>().deserialize(bytes, &message));
  EXPECT_EQ(message.distance, std::vector<double>{1.0});
  EXPECT_EQ(message.valid, (std::vector<bool>{false, true}));
}

TEST(CdrLayoutTest, IgnoresBytesBehindTheMessage) {
  const Bytes bytes = raw({0, 1, 0, 2, 2, 0, 0, 0, 'a', 0, 0, 0});
  std_msgs::msg::String message;
  ASSERT_TRUE(message_type<std_msgs::msg::String>().deserialize(bytes, &message));
  EXPECT_EQ(message.data, "a");
}

TEST(CdrLayoutTest, AStringEndsAtItsFirstNul) {
  const MessageType& type = message_type<std_msgs::msg::String>();
  std_msgs::msg::String message;
  message.data = std::string("ab\0cd", 5);
  Bytes bytes(type.serialized_size(&message));
  bytes.resize(type.serialize(&message, bytes));
  EXPECT_EQ(bytes, raw({0, 1, 0, 0, 3, 0, 0, 0, 'a', 'b', 0}));
}

TEST(CdrLayoutTest, ReadingReplacesWhatTheMessageHeld) {
  const MessageType& type = message_type<rmw_dds_common::msg::ParticipantEntitiesInfo>();
  rmw_dds_common::msg::ParticipantEntitiesInfo small;
  small.node_entities_info_seq.resize(1);
  small.node_entities_info_seq[0].node_name = "kept";
  Bytes bytes(type.serialized_size(&small));
  ASSERT_EQ(type.serialize(&small, bytes), bytes.size());

  rmw_dds_common::msg::ParticipantEntitiesInfo large;
  large.node_entities_info_seq.resize(3);
  for (auto& node : large.node_entities_info_seq) {
    node.node_name = "old";
    node.reader_gid_seq.resize(5);
  }
  ASSERT_TRUE(type.deserialize(bytes, &large));
  EXPECT_EQ(large, small);
}

}  // namespace
}  // namespace pipescout
