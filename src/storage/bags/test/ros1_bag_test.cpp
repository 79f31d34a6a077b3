// SPDX-License-Identifier: Apache-2.0
#include <bzlib.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "bytes.hpp"
#include "compression.hpp"
#include "mcap_records.hpp"
#include "pipescout/bags/bag_maintenance.hpp"
#include "pipescout/bags/topic_choice.hpp"
#include "pipescout/files/testing/temporary_folder.hpp"
#include "ros1_message.hpp"
#include "test_bag.hpp"

namespace pipescout::bags {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
namespace fs = std::filesystem;

constexpr const char* kPoseDefinition =
    "# A pose.\n"
    "Header header\n"
    "uint8 FRONT=1\n"
    "string NAME=a # b\n"
    "uint8 side\n"
    "Point[] points\n"
    "float64[2] limits\n"
    "time[] seen\n"
    "duration age\n"
    "string[] labels\n"
    "int16 turnCount\n"
    "===============================================================================\n"
    "MSG: std_msgs/Header\n"
    "uint32 seq\n"
    "time stamp\n"
    "string frame_id\n"
    "===============================================================================\n"
    "MSG: survey_msgs/Point\n"
    "float64 x\n"
    "float32 y\n";

template <class... Values>
Bytes packed(Values... values) {
  Bytes result;
  const auto add = [&result](auto value) {
    if constexpr (std::is_convertible_v<decltype(value), std::string_view>) {
      append_text(result, value);
    } else {
      append_number(result, value);
    }
  };
  (add(values), ...);
  return result;
}

Bytes pose() {
  return packed(std::uint32_t{7}, std::uint32_t{12}, std::uint32_t{34}, "map",    // header
                std::uint8_t{1}, std::uint32_t{2}, 1.5, 2.5F, 3.5, 4.5F,          // side, points
                -1.0, 1.0, std::uint32_t{1}, std::uint32_t{5}, std::uint32_t{6},  // limits, seen
                std::int32_t{-2}, std::int32_t{3}, std::uint32_t{2}, "a", "bcd",  // age, labels
                std::int16_t{-9});
}

using Fields = std::vector<std::pair<std::string, std::string>>;

std::string record(const Fields& header, std::string_view data) {
  Bytes fields;
  for (const auto& [name, value] : header) {
    append_text(fields, name + "=" + value);
  }
  Bytes result;
  append_text(result, text_of(fields));
  append_text(result, data);
  return std::string(text_of(result));
}

template <class T>
std::string raw(T value) {
  return {reinterpret_cast<const char*>(&value), sizeof(value)};
}

std::string connection(std::uint32_t id, const std::string& topic, const std::string& type,
                       const std::string& definition, bool latching = false) {
  Bytes details;
  for (const auto& [name, value] : Fields{{"topic", topic},
                                          {"type", type},
                                          {"md5sum", "*"},
                                          {"message_definition", definition},
                                          {"latching", latching ? "1" : "0"}}) {
    append_text(details, name + "=" + value);
  }
  return record({{"op", "\x07"}, {"conn", raw(id)}, {"topic", topic}}, text_of(details));
}

std::string message(std::uint32_t id, std::uint32_t sec, std::uint32_t nsec,
                    std::string_view data) {
  return record({{"op", "\x02"}, {"conn", raw(id)}, {"time", raw(sec) + raw(nsec)}}, data);
}

std::string chunk(const std::string& compression, const std::string& content) {
  std::string data = content;
  if (compression == "lz4") {
    Bytes bytes;
    compress_lz4(bytes_of(content), bytes);
    data = text_of(bytes);
  } else if (compression == "bz2") {
    auto size = static_cast<unsigned>(content.size() * 2 + 1000);
    data.resize(size);
    EXPECT_EQ(BZ2_bzBuffToBuffCompress(data.data(), &size, const_cast<char*>(content.data()),
                                       static_cast<unsigned>(content.size()), 9, 0, 0),
              BZ_OK);
    data.resize(size);
  }
  return record({{"op", "\x05"},
                 {"compression", compression},
                 {"size", raw(static_cast<std::uint32_t>(content.size()))}},
                data);
}

class Ros1Bag : public ::testing::Test {
 protected:
  void write(const std::string& records) const {
    testing::write_file(bag_, "#ROSBAG V2.0\n" + record({{"op", "\x03"}}, "    ") + records);
  }
  pipescout::testing::TemporaryFolder folder_;
  fs::path bag_ = folder_.path() / "old.bag";
};

TEST(Ros1Message, BecomesCdr) {
  const Ros1Message converter("survey_msgs/Pose", kPoseDefinition);
  Bytes cdr;
  ASSERT_TRUE(converter.to_cdr(pose(), cdr));
  const Bytes expected = packed(
      std::uint32_t{0x100}, std::uint32_t{12}, std::uint32_t{34}, std::uint32_t{4},   // to frame_id
      std::uint32_t{0x0070616d}, std::uint8_t{1}, std::uint8_t{0}, std::uint16_t{0},  // map, side
      std::uint32_t{2}, 1.5, 2.5F, std::uint32_t{0}, 3.5, 4.5F,                       // points
      std::uint32_t{0}, -1.0, 1.0, std::uint32_t{1}, std::uint32_t{5}, std::uint32_t{6},
      std::int32_t{-2}, std::int32_t{3}, std::uint32_t{2}, std::uint32_t{2}, std::uint16_t{'a'},
      std::uint16_t{0}, std::uint32_t{4}, std::uint32_t{0x00646362}, std::int16_t{-9});
  EXPECT_EQ(cdr, expected);
  EXPECT_EQ(converter.ros2_definition(),
            "std_msgs/Header header\nuint8 FRONT=1\nstring NAME=a # b\nuint8 side\n"
            "survey_msgs/Point[] points\nfloat64[2] limits\nbuiltin_interfaces/Time[] seen\n"
            "builtin_interfaces/Duration age\nstring[] labels\nint16 turn_count\n" +
                std::string(80, '=') + "\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\n" +
                "string frame_id\n" + std::string(80, '=') +
                "\nMSG: survey_msgs/Point\nfloat64 x\nfloat32 y\n" + std::string(80, '=') +
                "\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n" +
                std::string(80, '=') +
                "\nMSG: builtin_interfaces/Duration\nint32 sec\nuint32 nanosec\n");
  const Bytes whole = pose();
  for (std::size_t size = 0; size < whole.size(); ++size) {
    EXPECT_FALSE(converter.to_cdr(std::span(whole).first(size), cdr)) << size;
  }
}

TEST(Ros1Message, RefusesDefinitionsThatMakeNoSense) {
  for (const char* definition :
       {"Point p\n", "float64\n", "float64[x] a\n", "float64[0] a\n",
        "Loop l\n=====\nMSG: a/Loop\nMain m\n=====\nMSG: a/Main\n", "a/Main self\n"}) {
    EXPECT_THROW(Ros1Message("a/Main", definition), std::invalid_argument) << definition;
  }
  // Two of the one above in each: 2^40 bytes from none.
  std::string bomb = "T0 a\n";
  for (int k = 0; k < 40; ++k) {
    const std::string next = "T" + std::to_string(k + 1);
    bomb += "=====\nMSG: a/T" + std::to_string(k) + "\n";
    bomb += k == 39 ? "" : next + " a\n" + next + " b\n";
  }
  Bytes cdr;
  EXPECT_FALSE(Ros1Message("a/Main", bomb).to_cdr({}, cdr));
}

TEST_F(Ros1Bag, IsReadByTimeAndConverted) {
  const auto data = [](std::uint32_t value) { return raw(value); };
  const std::string number = "uint32 data\n";
  write(connection(0, "/pose", "survey_msgs/Pose", kPoseDefinition) +
        chunk("none", connection(1, "/count", "std_msgs/UInt32", number, true) +
                          message(1, 20, 5, data(1)) + message(0, 10, 0, text_of(pose()))) +
        chunk("bz2", message(1, 15, 0, data(2))) + chunk("lz4", message(1, 20, 5, data(3))));
  BagReader reader(bag_);
  std::vector<std::tuple<std::string, std::int64_t, std::size_t>> read;
  while (const auto each = reader.next()) {
    read.emplace_back(reader.topics()[each->topic].name, each->log_time, each->data.size());
  }
  EXPECT_THAT(read, ElementsAre(std::tuple("/pose", 10'000'000'000, 118),
                                std::tuple("/count", 15'000'000'000, 8),
                                std::tuple("/count", 20'000'000'005, 8),
                                std::tuple("/count", 20'000'000'005, 8)));
  EXPECT_EQ(reader.metadata().storage, Storage::kRos1);
  EXPECT_EQ(reader.metadata().messages, 4U);
  EXPECT_EQ(reader.topics()[0].type, "survey_msgs/msg/Pose");
  EXPECT_THAT(reader.topics()[1].offered_qos_profiles, HasSubstr("durability: 1"));
  EXPECT_THAT(check_bag(bag_).faults, IsEmpty());
}

TEST_F(Ros1Bag, SaysWhatItCannotRead) {
  const std::string number = "uint32 data\n";
  write(connection(0, "/bad", "a/Bad", "Missing m\n") +
        connection(1, "/count", "std_msgs/UInt32", number) +
        chunk("xz", message(1, 1, 0, raw(1U))) + chunk("bz2", message(1, 2, 0, raw(2U))) +
        chunk("none", message(1, 3, 0, "short") + message(9, 4, 0, "") + message(0, 4, 0, "")));
  const auto report = check_bag(bag_);
  EXPECT_EQ(report.messages, 1U);
  EXPECT_THAT(
      report.faults,
      ::testing::IsSupersetOf(
          {HasSubstr("the definition of a/Missing is missing"), HasSubstr("'xz' is not known"),
           HasSubstr("does not fit its definition"), HasSubstr("no known connection")}));
  testing::write_file(bag_, "#ROSBAG V1.2\n");
  EXPECT_THAT(check_bag(bag_).faults, ElementsAre(HasSubstr("is not that of a ROS 1 bag")));
}

TEST_F(Ros1Bag, CutAndChangedBagsGiveErrors) {
  write(connection(1, "/count", "std_msgs/UInt32", "uint32 data\n") +
        chunk("none", message(1, 1, 0, raw(1U)) + message(1, 2, 0, raw(2U))) +
        chunk("lz4", message(1, 3, 0, raw(3U))) + chunk("bz2", message(1, 4, 0, raw(4U))));
  const std::string whole = pipescout::testing::content(bag_);
  for (std::size_t size = whole.size(); size-- > 0;) {
    fs::resize_file(bag_, size);
    const auto report = check_bag(bag_);
    // Between two records nothing tells that there was more.
    ASSERT_TRUE(!report.faults.empty() || report.messages < 4) << size;
  }
  std::mt19937 random(1);
  for (int k = 0; k < 1000; ++k) {
    testing::write_file(bag_, testing::mutated(whole, random));
    const BagReport report = check_bag(bag_);
    for (const std::string& fault : report.faults) {
      ASSERT_THAT(fault, HasSubstr(bag_.filename().string()));
    }
    try {
      BagReader reader(bag_);
      std::string error;
      (void)testing::read(reader, &error);
    } catch (const BagError&) {
      ASSERT_THAT(report.faults, ::testing::Not(::testing::IsEmpty()));
    }
  }
}

/// An MCAP file with one topic of ROS 1.
std::string mcap_of_ros1(const std::string& encoding, const std::string& schema_encoding,
                         const std::string& definition, ByteView data) {
  using namespace mcap;
  Bytes file;
  append(file, std::as_bytes(std::span(kMagic)));
  append_record(file, Opcode::kHeader, [](Bytes& content) {
    append_text(content, "ros1");
    append_text(content, "test");
  });
  append_schema(
      file, {.id = 1, .name = "survey_msgs/Pose", .encoding = schema_encoding, .data = definition});
  append_channel(file, {.id = 3,
                        .schema = 1,
                        .topic = "/pose",
                        .message_encoding = encoding,
                        .metadata = {{"latching", "1"}}});
  append_message_head(file, {.channel = 3, .log_time = 8}, data.size());
  append(file, data);
  append_record(file, Opcode::kDataEnd, [](Bytes& content) { append_number(content, 0U); });
  append_record(file, Opcode::kFooter,
                [](Bytes& content) { content.resize(content.size() + kFooterSize, std::byte{0}); });
  append(file, std::as_bytes(std::span(kMagic)));
  return std::string(text_of(file));
}

TEST_F(Ros1Bag, MessagesOfRos1InMcapBecomeThoseOfRos2) {
  const fs::path path = folder_.path() / "old.mcap";
  testing::write_file(path, mcap_of_ros1("ros1", "ros1msg", kPoseDefinition, pose()));
  BagReader reader(path);
  const auto messages = testing::read(reader);
  ASSERT_EQ(messages.size(), 1U);
  const BagTopic& topic = reader.topics().front();
  EXPECT_EQ(topic.type, "survey_msgs/msg/Pose");
  EXPECT_EQ(topic.serialization_format, "cdr");
  EXPECT_EQ(topic.schema_encoding, "ros2msg");
  EXPECT_THAT(topic.offered_qos_profiles, HasSubstr("durability: 1"));
  const Ros1Message converter("survey_msgs/Pose", kPoseDefinition);
  Bytes cdr;
  ASSERT_TRUE(converter.to_cdr(pose(), cdr));
  EXPECT_EQ(messages.front().data, testing::Data(cdr.begin(), cdr.end()));
  EXPECT_EQ(topic.schema_text, converter.ros2_definition());
}

TEST_F(Ros1Bag, MessagesInMcapThatCannotBecomeThoseOfRos2AreNamed) {
  const fs::path path = folder_.path() / "old.mcap";
  const auto faults = [&](const std::string& content) {
    testing::write_file(path, content);
    return check_bag(path).faults;
  };
  EXPECT_THAT(faults(mcap_of_ros1("ros1", "", "", pose())),
              Contains(HasSubstr("channel of /pose: its messages are of ROS 1, and their "
                                 "definition is '', not ros1msg")));
  EXPECT_THAT(faults(mcap_of_ros1("ros1", "ros1msg", "Unknown thing\n", pose())),
              Contains(HasSubstr("the definition of survey_msgs/Unknown is missing")));
  EXPECT_THAT(faults(mcap_of_ros1("ros1", "ros1msg", kPoseDefinition, Bytes(3))),
              Contains(HasSubstr("a message does not fit its definition")));
  // Any other encoding keeps its name, which who chooses a topic is told.
  testing::write_file(path, mcap_of_ros1("protobuf", "protobuf", "", pose()));
  const BagReader reader(path);
  try {
    (void)choose_topic(reader, path, {"survey_msgs/msg/Pose"}, "");
    FAIL() << "a topic was chosen";
  } catch (const BagError& error) {
    EXPECT_THAT(error.what(), HasSubstr("in an encoding that is not read: /pose (protobuf)"));
  }
}

}  // namespace
}  // namespace pipescout::bags
