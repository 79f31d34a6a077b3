// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "pipescout/bags/bag_maintenance.hpp"
#include "pipescout/files/testing/temporary_folder.hpp"
#include "test_bag.hpp"

namespace pipescout::bags {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using testing::Stored;
namespace fs = std::filesystem;

struct Case {
  std::string name;
  BagWriterOptions options;
};

class RoundTrip : public ::testing::TestWithParam<Case> {
 protected:
  pipescout::testing::TemporaryFolder folder_;
  fs::path bag_ = folder_.path() / "mission";
};

TEST_P(RoundTrip, GivesEveryMessageBack) {
  const auto written = testing::messages(300, 40'000);
  {
    BagWriter writer(bag_, GetParam().options);
    for (const Stored& each : written) {
      testing::write(writer, each);
    }
    writer.close();
    EXPECT_EQ(writer.metadata().messages, 300U);
    if (GetParam().options.max_file_size > 0) {
      EXPECT_GT(writer.metadata().files.size(), 10U);
    }
  }
  BagReader reader(bag_);
  EXPECT_EQ(testing::read(reader), written);
  EXPECT_EQ(reader.metadata().messages, 300U);
  EXPECT_EQ(reader.metadata().starting_time, written.front().log_time);
  EXPECT_EQ(reader.metadata().duration, written.back().log_time - written.front().log_time);
  ASSERT_EQ(reader.topics().size(), 2U);
  EXPECT_EQ(reader.topics()[0].name, "/image");
  EXPECT_EQ(reader.topics()[0].type, "std_msgs/msg/String");
  EXPECT_EQ(reader.topics()[0].offered_qos_profiles, "- history: 1\n  depth: 10\n");
  if (GetParam().options.storage == Storage::kMcap) {
    EXPECT_EQ(reader.topics()[0].schema_text, "string data\n");
  }
  const auto report = check_bag(bag_);
  EXPECT_THAT(report.faults, IsEmpty());
  const bool has_checksums =
      GetParam().options.storage == Storage::kMcap && GetParam().options.checksums;
  EXPECT_THAT(report.notes, ::testing::SizeIs(has_checksums ? 0 : 1));
}

TEST_P(RoundTrip, FiltersBySeekTopicAndTime) {
  const auto written = testing::messages(300, 20'000);
  {
    BagWriter writer(bag_, GetParam().options);
    for (const Stored& each : written) {
      testing::write(writer, each);
    }
  }
  BagReader reader(bag_);
  const auto expect = [&](auto keep) {
    std::vector<Stored> wanted;
    std::copy_if(written.begin(), written.end(), std::back_inserter(wanted), keep);
    EXPECT_EQ(testing::read(reader), wanted);
  };
  reader.set_filter({.topics = {{"/image", "/none"}}});
  expect([](const Stored& m) { return m.topic == "/image"; });
  const std::int64_t start = written[100].log_time;
  const std::int64_t end = written[200].log_time;
  reader.set_filter({.start = start, .end = end});
  expect([&](const Stored& m) { return m.log_time >= start && m.log_time <= end; });
  reader.seek(start + 1);
  expect([&](const Stored& m) { return m.log_time > start && m.log_time <= end; });
  reader.set_filter({.topics = {{}}});
  expect([](const Stored&) { return false; });
  reader.set_filter({});
  expect([](const Stored&) { return true; });
}

TEST_P(RoundTrip, ReadsWithoutMetadataAndReindexes) {
  const auto written = testing::messages(200, 20'000);
  {
    BagWriter writer(bag_, GetParam().options);
    for (const Stored& each : written) {
      testing::write(writer, each);
    }
  }
  const std::string metadata = pipescout::testing::content(bag_ / "metadata.yaml");
  fs::remove(bag_ / "metadata.yaml");
  EXPECT_EQ(testing::read(bag_), written);
  const auto report = check_bag(bag_);
  EXPECT_THAT(report.faults, IsEmpty());
  EXPECT_THAT(report.notes, ::testing::Contains(::testing::HasSubstr("has no metadata.yaml")));
  reindex_bag(bag_);
  EXPECT_EQ(pipescout::testing::content(bag_ / "metadata.yaml"), metadata);
}

std::vector<Case> cases() {
  using enum Storage;
  constexpr std::uint64_t kSmall = 200'000;
  const BagWriterOptions mcap{.storage = kMcap};
  const auto with = [](BagWriterOptions options, auto change) {
    change(options);
    return options;
  };
  return {
      {"sqlite", {.storage = kSqlite}},
      {"sqlite_split", {.storage = kSqlite, .max_file_size = kSmall}},
      {"sqlite_split_by_time",
       {.storage = kSqlite, .max_file_duration = std::chrono::milliseconds(300)}},
      {"sqlite_message_zstd", {.storage = kSqlite, .compression = Compression::kMessage}},
      {"sqlite_file_zstd",
       {.storage = kSqlite, .max_file_size = kSmall, .compression = Compression::kFile}},
      {"mcap", mcap},
      {"mcap_split", {.storage = kMcap, .max_file_size = kSmall}},
      {"mcap_split_by_time",
       {.storage = kMcap, .max_file_duration = std::chrono::milliseconds(300)}},
      {"mcap_message_zstd", {.storage = kMcap, .compression = Compression::kMessage}},
      {"mcap_file_zstd",
       {.storage = kMcap, .max_file_size = kSmall, .compression = Compression::kFile}},
      {"mcap_lz4", with(mcap, [](auto& o) { o.chunk_compression = ChunkCompression::kLz4; })},
      {"mcap_zstd", with(mcap,
                         [](auto& o) {
                           o.chunk_compression = ChunkCompression::kZstd;
                           o.compression_level = 5;
                         })},
      {"mcap_small_chunks", with(mcap, [](auto& o) { o.chunk_size = 1; })},
      {"mcap_without_crc", with(mcap, [](auto& o) { o.checksums = false; })},
  };
}

INSTANTIATE_TEST_SUITE_P(Options, RoundTrip, ::testing::ValuesIn(cases()),
                         [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace pipescout::bags
