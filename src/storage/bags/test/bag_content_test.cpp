// SPDX-License-Identifier: Apache-2.0
// What other programs write, and what makes no sense.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "file_access.hpp"
#include "mcap_records.hpp"
#include "pipescout/bags/bag_maintenance.hpp"
#include "pipescout/bags/bag_metadata.hpp"
#include "pipescout/bags/topic_choice.hpp"
#include "pipescout/files/testing/temporary_folder.hpp"
#include "sqlite_database.hpp"
#include "test_bag.hpp"

namespace pipescout::bags {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::Stored;
namespace fs = std::filesystem;

class BagContent : public ::testing::Test {
 protected:
  void record(const BagWriterOptions& options, const std::vector<Stored>& messages) const {
    BagWriter writer(bag_, options);
    for (const Stored& each : messages) {
      testing::write(writer, each);
    }
    writer.close();
  }
  void replace(const std::string& from, const std::string& to) const {
    const fs::path path = bag_ / "metadata.yaml";
    std::string text = pipescout::testing::content(path);
    const std::size_t place = text.find(from);
    ASSERT_NE(place, std::string::npos) << from;
    testing::write_file(path, text.replace(place, from.size(), to));
  }
  [[nodiscard]] std::string error() const {
    try {
      (void)testing::read(bag_);
    } catch (const BagError& fault) {
      return fault.what();
    }
    return "";
  }

  pipescout::testing::TemporaryFolder folder_;
  fs::path bag_ = folder_.path() / "mission";
};

TEST_F(BagContent, HumbleFindsItsTables) {
  record({}, testing::messages(3, 10));
  SqliteDatabase database(bag_ / "mission_0.db3", SqliteDatabase::Mode::kRead);
  EXPECT_EQ(database.number("SELECT schema_version FROM schema"), 3);
  EXPECT_EQ(database.number("SELECT metadata_version FROM metadata"), 5);
  EXPECT_EQ(database.number("SELECT COUNT(*) FROM messages JOIN topics ON topics.id = topic_id"),
            3);
  EXPECT_EQ(database.number("SELECT COUNT(*) FROM sqlite_master WHERE name = 'timestamp_idx'"), 1);
  const std::string metadata = pipescout::testing::content(bag_ / "metadata.yaml");
  for (const char* line :
       {"rosbag2_bagfile_information:", "  version: 5", "  storage_identifier: sqlite3",
        "    nanoseconds: 20000000", "    nanoseconds_since_epoch: 1700000000000000000",
        "  message_count: 3", "        name: /image", "        serialization_format: cdr",
        "        offered_qos_profiles: \"- history: 1\\n  depth: 10\\n\"",
        "  compression_format: \"\"", "  compression_mode: \"\"", "    - mission_0.db3",
        "    - path: mission_0.db3"}) {
    EXPECT_THAT(metadata, HasSubstr(line));
  }
}

TEST_F(BagContent, EqualAndJumpingTimesKeepTheOrderOfTheFile) {
  for (const BagWriterOptions& options :
       {BagWriterOptions{.storage = Storage::kSqlite},
        BagWriterOptions{.storage = Storage::kMcap, .chunk_size = 1},
        BagWriterOptions{.storage = Storage::kMcap}}) {
    fs::remove_all(bag_);
    const auto at = [](std::int64_t time, const std::string& text) {
      return Stored{"/t", time, time, testing::bytes(text)};
    };
    record(options, {at(5, "a"), at(0, "b"), at(5, "c"), at(9, "d"), at(0, "e"), at(5, "f")});
    std::string order;
    for (const Stored& each : testing::read(bag_)) {
      order += static_cast<char>(each.data.front());
    }
    EXPECT_EQ(order, "beacfd");
    const auto report = check_bag(bag_);
    EXPECT_THAT(report.faults, IsEmpty());
    EXPECT_THAT(report.notes, Contains(HasSubstr("2 messages have the log time 0")));
  }
}

TEST_F(BagContent, FilesThatOverlapAreMerged) {
  BagWriter writer(bag_, {.storage = Storage::kMcap});
  for (const std::int64_t time : {1, 4, 7}) {
    testing::write(writer, {"/t", time, time, testing::bytes("first")});
  }
  writer.split();
  for (const std::int64_t time : {2, 4, 9}) {
    testing::write(writer, {"/t", time, time, testing::bytes("second")});
  }
  writer.close();
  std::vector<std::int64_t> times;
  for (const Stored& each : testing::read(bag_)) {
    times.push_back(each.log_time * 10 + static_cast<std::int64_t>(each.data.size() == 6));
  }
  EXPECT_THAT(times, ElementsAre(10, 21, 40, 41, 70, 91));
}

TEST_F(BagContent, PublishTimeIsKeptByMcap) {
  record({.storage = Storage::kMcap}, {{"/t", 10, 7, testing::bytes("x")}});
  EXPECT_EQ(testing::read(bag_).front().publish_time, 7);
}

TEST_F(BagContent, EmptyBagsAndEmptyMessagesAreBags) {
  for (const Storage storage : {Storage::kSqlite, Storage::kMcap}) {
    fs::remove_all(bag_);
    record({.storage = storage}, {});
    EXPECT_THAT(check_bag(bag_).faults, IsEmpty());
    fs::remove_all(bag_);
    record({.storage = storage}, {{"/t", 1, 1, {}}});
    EXPECT_THAT(check_bag(bag_).faults, IsEmpty());
    EXPECT_EQ(testing::read(bag_).size(), 1U);
  }
}

TEST_F(BagContent, McapWithoutChunksAndIndexIsRead) {
  using namespace mcap;
  Bytes file;
  append(file, std::as_bytes(std::span(kMagic)));
  append_record(file, Opcode::kHeader, [](Bytes& content) {
    append_text(content, "ros2");
    append_text(content, "test");
  });
  append_channel(file, {.id = 3, .topic = "/t", .message_encoding = "cdr"});
  for (const auto& [time, text] : {std::pair(8U, "later"), std::pair(2U, "first")}) {
    append_message_head(file, {.channel = 3, .log_time = time}, 5);
    append(file, bytes_of(text));
  }
  append_record(file, Opcode::kAttachment, [](Bytes& content) { append_text(content, "any"); });
  append_record(file, Opcode::kMetadata, [](Bytes& content) { append_text(content, "any"); });
  append_record(file, static_cast<Opcode>(0x90), [](Bytes& content) { append_text(content, "?"); });
  append_record(file, Opcode::kDataEnd, [](Bytes& content) { append_number(content, 0U); });
  append_record(file, Opcode::kFooter,
                [](Bytes& content) { content.resize(content.size() + kFooterSize, std::byte{0}); });
  append(file, std::as_bytes(std::span(kMagic)));
  const fs::path path = folder_.path() / "plain.mcap";
  OutputFile(path).write({file});
  EXPECT_THAT(check_bag(path).faults, IsEmpty());
  const auto read = testing::read(path);
  ASSERT_EQ(read.size(), 2U);
  EXPECT_EQ(read[0].log_time, 2);
  EXPECT_EQ(read[1].data, testing::bytes("later"));
}

TEST_F(BagContent, NewerMetadataAreRead) {
  record({}, testing::messages(3, 10));
  replace("version: 5", "version: 9");
  replace("offered_qos_profiles: \"- history: 1\\n  depth: 10\\n\"",
          "offered_qos_profiles:\n          - {history: keep_all, depth: 3, reliability: "
          "best_effort, durability: transient_local, liveliness: automatic}\n        "
          "type_description_hash: RIHS01_00");
  BagReader reader(bag_);
  EXPECT_EQ(testing::read(reader).size(), 3U);
  const BagTopic& topic = reader.metadata().topics.front().topic;
  EXPECT_THAT(topic.offered_qos_profiles, HasSubstr("history: 2"));
  EXPECT_THAT(topic.offered_qos_profiles, HasSubstr("reliability: 2"));
  EXPECT_THAT(topic.offered_qos_profiles, HasSubstr("durability: 1"));
  EXPECT_EQ(topic.type_description_hash, "RIHS01_00");
}

TEST_F(BagContent, OldMetadataAreRead) {
  record({}, testing::messages(3, 10));
  // The first versions had the folder's name in the paths, no QoS, no list of files.
  testing::write_file(bag_ / "metadata.yaml",
                      "rosbag2_bagfile_information:\n  version: 1\n  storage_identifier: sqlite3\n"
                      "  relative_file_paths: [mission/mission_0.db3]\n  duration: {nanoseconds: "
                      "20000000}\n  starting_time: {nanoseconds_since_epoch: "
                      "1700000000000000000}\n  message_count: 3\n  topics_with_message_count:\n"
                      "    - topic_metadata: {name: /image, type: std_msgs/msg/String}\n      "
                      "message_count: 1\n    - topic_metadata: {name: /pose, type: "
                      "std_msgs/msg/String}\n      message_count: 2\n");
  EXPECT_EQ(testing::read(bag_).size(), 3U);
  EXPECT_THAT(check_bag(bag_).faults, IsEmpty());
}

TEST_F(BagContent, UnknownVersionsAndCompressionsAreRefused) {
  record({}, testing::messages(3, 10));
  replace("version: 5", "version: 10");
  EXPECT_THAT(error(), HasSubstr("metadata.yaml:2: version 10 is not known"));
  replace("version: 10", "version: 5");
  replace("storage_identifier: sqlite3", "storage_identifier: tape");
  EXPECT_THAT(error(), HasSubstr("storage_identifier: 'tape' is not known"));
  replace("storage_identifier: tape", "storage_identifier: sqlite3");
  replace("compression_mode: \"\"", "compression_mode: FILE");
  replace("compression_format: \"\"", "compression_format: xz");
  EXPECT_THAT(error(), HasSubstr("compression_format: 'xz' is not known"));
  EXPECT_THAT(check_bag(bag_).faults, ElementsAre(HasSubstr("'xz'")));
}

TEST_F(BagContent, WithoutAStorageIdentifierTheFilesTell) {
  // As `ros2 bag reindex` of Humble writes it.
  for (const Storage storage : {Storage::kSqlite, Storage::kMcap}) {
    fs::remove_all(bag_);
    record({.storage = storage}, testing::messages(3, 10));
    replace("storage_identifier: " + std::string(storage_identifier(storage)),
            "storage_identifier: \"\"");
    BagReader reader(bag_);
    EXPECT_EQ(reader.metadata().storage, storage);
    EXPECT_EQ(testing::read(reader).size(), 3U);
    EXPECT_THAT(check_bag(bag_).faults, IsEmpty());
  }
  replace("- mission_0.mcap", "- mission_0");
  EXPECT_THAT(error(), HasSubstr("storage_identifier: is empty, and no file"));
}

TEST_F(BagContent, ContradictionsAreFound) {
  record({}, testing::messages(3, 10));
  replace("name: /pose\n        type: std_msgs/msg/String",
          "name: /pose\n        type: std_msgs/msg/Int32");
  EXPECT_THAT(check_bag(bag_).faults,
              Contains(HasSubstr("/pose: the files say std_msgs/msg/String, the metadata "
                                 "std_msgs/msg/Int32")));
  reindex_bag(bag_);
  EXPECT_THAT(check_bag(bag_).faults, IsEmpty());
  replace("message_count: 3", "message_count: 4");
  EXPECT_THAT(check_bag(bag_).faults, Contains(HasSubstr("4 messages by the metadata, 3 can")));
  fs::copy(bag_ / "mission_0.db3", bag_ / "mission_1.db3");
  EXPECT_THAT(check_bag(bag_).faults, Contains(HasSubstr("mission_1.db3: is not in the metadata")));
  fs::remove(bag_ / "mission_0.db3");
  EXPECT_THAT(error(), HasSubstr("mission_0.db3: cannot be opened: No such file"));
}

TEST_F(BagContent, WhatIsNoBagIsSaid) {
  EXPECT_THAT(error(), HasSubstr("there is no such file or folder"));
  fs::create_directory(bag_);
  EXPECT_THAT(error(), HasSubstr("holds no metadata.yaml, no .db3 and no .mcap"));
  testing::write_file(bag_ / "metadata.yaml", "rosbag2_bagfile_information: [1, 2");
  testing::write_file(bag_ / "x_0.db3", "");
  EXPECT_THAT(check_bag(bag_).faults, Contains(HasSubstr("metadata.yaml:")));
  testing::write_file(bag_ / "x.txt", "hello");
  EXPECT_THROW(BagReader(bag_ / "x.txt"), BagError);
  {
    SqliteDatabase other(folder_.path() / "other.db3", SqliteDatabase::Mode::kNew);
    other.execute("CREATE TABLE cats(id INTEGER)");
  }
  EXPECT_THAT(check_bag(folder_.path() / "other.db3").faults,
              Contains(HasSubstr("has no table 'topics': it is no bag")));
}

TEST_F(BagContent, OneInputIsChosenByTypeAndName) {
  BagWriter writer(bag_, {.storage = Storage::kMcap});
  for (const char* name : {"/front", "/back"}) {
    writer.add_topic(testing::topic(name, "sensor_msgs/msg/Image"));
  }
  writer.add_topic(testing::topic("/info", "sensor_msgs/msg/CameraInfo"));
  writer.add_topic({.name = "/old", .type = "sensor_msgs/msg/Imu", .serialization_format = "cbor"});
  writer.close();
  const BagReader reader(bag_);
  const auto chosen = [&](std::initializer_list<const char*> types, const std::string& wanted) {
    try {
      return choose_topic(reader, bag_, types, wanted).topic.name;
    } catch (const BagError& error) {
      EXPECT_EQ(error.fault(), BagFault::kUsage);
      return std::string(error.what());
    }
  };
  EXPECT_EQ(chosen({"sensor_msgs/msg/CameraInfo"}, ""), "/info");
  EXPECT_EQ(chosen({"sensor_msgs/msg/Image"}, "back"), "/back");
  EXPECT_THAT(chosen({"sensor_msgs/msg/Image"}, ""),
              HasSubstr("several topics of sensor_msgs/msg/Image; choose one with --topic: /front, "
                        "/back"));
  EXPECT_THAT(chosen({"sensor_msgs/msg/Image"}, "/info"), HasSubstr("has no topic '/info' of"));
  EXPECT_THAT(chosen({"sensor_msgs/msg/Imu", "sensor_msgs/msg/Range"}, ""),
              HasSubstr("has no topic of sensor_msgs/msg/Imu or sensor_msgs/msg/Range"));
  EXPECT_TRUE(is_bag(bag_));
  EXPECT_EQ(storage_by_name("a.mcap.zstd"), Storage::kMcap);
  EXPECT_EQ(storage_by_name("a.csv"), std::nullopt);
  EXPECT_FALSE(is_bag(bag_.parent_path()));
}

TEST_F(BagContent, WriterRefusesWhatABagCannotHold) {
  EXPECT_THROW(BagWriter(bag_, {.storage = Storage::kRos1}), std::invalid_argument);
  EXPECT_THROW(BagWriter(bag_, {.max_file_size = 10}), std::invalid_argument);
  EXPECT_THROW(BagWriter(bag_, {.compression_level = 0}), std::invalid_argument);
  EXPECT_THROW(BagWriter(bag_, {.chunk_size = 0}), std::invalid_argument);
  BagWriter writer(bag_);
  EXPECT_THROW(BagWriter{bag_}, BagError);
  EXPECT_EQ(writer.add_topic(testing::topic("/a")), 0U);
  EXPECT_EQ(writer.add_topic(testing::topic("/b")), 1U);
  EXPECT_EQ(writer.add_topic(testing::topic("/a")), 0U);
  EXPECT_THROW(writer.add_topic(testing::topic("/a", "std_msgs/msg/Int32")), BagError);
  EXPECT_THROW(writer.add_topic({.name = "/c"}), BagError);
  EXPECT_THROW(writer.write({.topic = 2}), BagError);
  EXPECT_THROW(writer.write({.topic = 0, .log_time = -1}), BagError);
  writer.write({.topic = 0, .log_time = 1, .publish_time = 1});
  writer.close();
  writer.close();
  EXPECT_THROW(writer.flush(), BagError);
  EXPECT_EQ(testing::read(bag_).size(), 1U);
}

}  // namespace
}  // namespace pipescout::bags
