// SPDX-License-Identifier: Apache-2.0
// Our bags read by @mcap/core and @foxglove/rosbag2, and theirs by us, message for message.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "pipescout/bags/bag_maintenance.hpp"
#include "pipescout/bags/bag_reader.hpp"
#include "pipescout/bags/bag_writer.hpp"
#include "pipescout/files/testing/temporary_folder.hpp"
#include "pipescout/testing/program.hpp"

namespace pipescout::bags {
namespace {

using ::testing::IsEmpty;
namespace fs = std::filesystem;

/// FNV-1a, 32 bits.
std::uint32_t hash(std::span<const std::byte> data) {
  std::uint32_t value = 0x811C9DC5U;
  for (const std::byte each : data) {
    value = (value ^ std::to_integer<std::uint32_t>(each)) * 0x01000193U;
  }
  return value;
}

/// As checksum.cjs writes it.
std::string line(const BagTopic& topic, const BagMessage& message) {
  return topic.name + " " + topic.type + " " + std::to_string(message.log_time) + " " +
         std::to_string(message.data.size()) + " " + std::to_string(hash(message.data)) + "\n";
}

class IndependentReaders : public ::testing::Test {
 protected:
  void SetUp() override {
    for (const char* package :
         {"@mcap/core", "@mcap/nodejs", "@mcap/support", "@foxglove/rosbag2", "sql.js"}) {
      if (!fs::exists(scripts_ / "node_modules" / package)) {
        GTEST_SKIP() << "NOT TESTED against independent readers: " << package
                     << " is missing; test/interoperability/bag_readers/install.sh installs it";
      }
    }
  }

  [[nodiscard]] std::string node(const std::string& script, const fs::path& file) const {
    const auto finished = testing::run_program(
        "/usr/bin/env", {"node", (scripts_ / script).string(), file.string()}, folder_.path());
    EXPECT_EQ(finished.code(), 0) << finished.err;
    return finished.out;
  }

  /// Writes a bag and returns what a reader should say of it.
  std::string record(const BagWriterOptions& options) const {
    BagWriter writer(folder_.path() / "bag", options);
    std::string expected;
    for (std::size_t k = 0; k < 500; ++k) {
      const BagTopic topic{.name = k % 3 == 0 ? "/large" : "/small",
                           .type = "std_msgs/msg/String",
                           .offered_qos_profiles =
                               "- history: 1\n  depth: 10\n  reliability: 1\n  durability: 2\n"
                               "  deadline:\n    sec: 0\n    nsec: 0\n  lifespan:\n    sec: 0\n"
                               "    nsec: 0\n  liveliness: 1\n  liveliness_lease_duration:\n"
                               "    sec: 0\n    nsec: 0\n"
                               "  avoid_ros_namespace_conventions: false",
                           .schema_encoding = "ros2msg",
                           .schema_text = "string data\n"};
      const std::string text(k % 3 == 0 ? 3000 * (k % 60) : k, static_cast<char>('a' + k % 26));
      std::vector<std::byte> data(8 + text.size() + 1);
      data[1] = std::byte{1};
      const auto size = static_cast<std::uint32_t>(text.size() + 1);
      std::memcpy(data.data() + 4, &size, sizeof(size));
      std::memcpy(data.data() + 8, text.data(), text.size());
      const auto time = static_cast<std::int64_t>(1'700'000'000'000'000'000 + k * 1'000'003);
      const BagMessage message{
          .topic = writer.add_topic(topic), .log_time = time, .publish_time = time, .data = data};
      writer.write(message);
      expected += line(topic, message);
    }
    writer.close();
    return expected;
  }

  fs::path scripts_ = BAG_READERS;
  pipescout::testing::TemporaryFolder folder_;
};

TEST_F(IndependentReaders, McapCoreReadsEachChunkCompression) {
  for (const auto compression :
       {ChunkCompression::kNone, ChunkCompression::kLz4, ChunkCompression::kZstd}) {
    fs::remove_all(folder_.path() / "bag");
    const std::string expected =
        record({.storage = Storage::kMcap, .chunk_compression = compression, .chunk_size = 50'000});
    EXPECT_EQ(node("read_mcap.cjs", folder_.path() / "bag" / "bag_0.mcap"), expected);
  }
}

TEST_F(IndependentReaders, FoxgloveRosbag2ReadsSqlite) {
  const std::string expected = record({.storage = Storage::kSqlite});
  EXPECT_EQ(node("read_db3.cjs", folder_.path() / "bag" / "bag_0.db3"), expected);
}

TEST_F(IndependentReaders, WhatMcapCoreWritesIsRead) {
  const fs::path file = folder_.path() / "theirs.mcap";
  const std::string expected = node("write_mcap.cjs", file);
  BagReader reader(file);
  std::string read;
  while (const auto message = reader.next()) {
    read += line(reader.topics()[message->topic], *message);
  }
  EXPECT_EQ(read, expected);
  EXPECT_THAT(check_bag(file).faults, IsEmpty());
}

}  // namespace
}  // namespace pipescout::bags
