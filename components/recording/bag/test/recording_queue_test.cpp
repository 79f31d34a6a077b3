// SPDX-License-Identifier: Apache-2.0
#include "recording_queue.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <future>
#include <limits>
#include <string>
#include <thread>
#include <vector>

#include "pipescout/files/testing/temporary_folder.hpp"
#include "support.hpp"

namespace pipescout {
namespace {

using bag_test::read_bag;
using bag_test::text_bytes;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr std::uint64_t kSmallestFile = 86016;

class RecordingQueueTest : public ::testing::Test {
 protected:
  [[nodiscard]] std::unique_ptr<bags::BagWriter> writer(std::uint64_t max_file_size = 0) const {
    return std::make_unique<bags::BagWriter>(
        bag_,
        bags::BagWriterOptions{.storage = bags::Storage::kMcap, .max_file_size = max_file_size});
  }
  static bags::BagTopic topic(const std::string& name) {
    return make_bag_topic(name, "std_msgs/msg/String", {});
  }
  /// More than half of the smallest file, so that every second one begins another.
  static std::shared_ptr<const SerializedMessage> large(char filling) {
    return text_bytes(std::string(50'000, filling));
  }

  const ::pipescout::testing::TemporaryFolder temporary_;
  const std::filesystem::path bag_ = temporary_.path() / "bag";
  RecordingQueue::Events silent_{.split = [](const auto&, const auto&) {},
                                 .failed = [](const std::string&) {}};
};

TEST_F(RecordingQueueTest, WritesWhatItIsGivenInItsOrder) {
  RecordingQueue queue(writer(), {}, silent_);
  const auto a = queue.add_topic(topic("/a"));
  EXPECT_TRUE(queue.push(a, 10, 9, text_bytes("one")));
  const auto b = queue.add_topic(topic("/b"));
  EXPECT_TRUE(queue.push(b, 10, 8, text_bytes("two")));
  EXPECT_TRUE(queue.push(a, 20, 19, text_bytes("three")));
  queue.finish();
  const auto bag = read_bag(bag_);
  ASSERT_EQ(bag.messages.size(), 3U);
  EXPECT_EQ(bag.messages[0].text(), "one");
  EXPECT_EQ(bag.messages[0].publish_time, 9);
  EXPECT_EQ(bag.messages[1].text(), "two");
  EXPECT_EQ(bag.messages[1].topic, "/b");
  EXPECT_EQ(bag.messages[2].log_time, 20);
  EXPECT_EQ(queue.counts().written, 3U);
  EXPECT_EQ(queue.counts().dropped, 0U);
}

/// Holds the writing thread at the first split until it is told to go on.
struct HeldWriter {
  RecordingQueue::Events events() {
    return {.split =
                [this](const auto&, const auto&) {
                  if (!held) {
                    held = true;
                    reached.set_value();
                    go_on.get_future().wait();
                  }
                },
            .failed = [](const std::string&) {}};
  }
  bool held = false;
  std::promise<void> reached;
  std::promise<void> go_on;
};

TEST_F(RecordingQueueTest, AFullQueueDropsWhatComesAndNobodyWaits) {
  HeldWriter held;
  RecordingQueue queue(writer(kSmallestFile), {.limit = 120'000}, held.events());
  const auto index = queue.add_topic(topic("/a"));
  EXPECT_TRUE(queue.push(index, 1, 1, large('a')));
  EXPECT_TRUE(queue.push(index, 2, 2, large('b')));
  held.reached.get_future().wait();  // both are written
  EXPECT_TRUE(queue.push(index, 3, 3, large('c')));
  EXPECT_TRUE(queue.push(index, 4, 4, large('d')));
  EXPECT_FALSE(queue.push(index, 5, 5, large('e')));
  held.go_on.set_value();
  queue.finish();
  EXPECT_EQ(queue.counts().dropped, 1U);
  EXPECT_EQ(read_bag(bag_).messages.size(), 4U);
}

TEST_F(RecordingQueueTest, OneMessageIsTakenHoweverLargeItIs) {
  RecordingQueue queue(writer(), {.limit = 0}, silent_);
  EXPECT_TRUE(queue.push(queue.add_topic(topic("/a")), 1, 1, large('a')));
  queue.finish();
  EXPECT_EQ(read_bag(bag_).messages.size(), 1U);
}

TEST_F(RecordingQueueTest, AFullQueueThatMayMakesThePublisherWait) {
  HeldWriter held;
  RecordingQueue queue(writer(kSmallestFile), {.limit = 120'000, .repeatable = true},
                       held.events());
  const auto index = queue.add_topic(topic("/a"));
  std::thread publisher([&] {
    for (std::int64_t i = 1; i <= 20; ++i) {
      EXPECT_TRUE(queue.push(index, i, i, large('x')));
    }
  });
  held.reached.get_future().wait();
  held.go_on.set_value();
  publisher.join();
  queue.finish();
  EXPECT_EQ(queue.counts().dropped, 0U);
  EXPECT_EQ(read_bag(bag_).messages.size(), 20U);
}

TEST_F(RecordingQueueTest, WhatComesBeforeThereIsATimeGetsTheFirstOne) {
  RecordingQueue queue(writer(), {}, silent_);
  const auto index = queue.add_topic(topic("/a"));
  queue.push(index, 0, 0, text_bytes("early"));
  queue.push(index, 7, 7, text_bytes("first"));
  queue.push(index, 0, 0, text_bytes("time jumped"));
  queue.finish();
  const auto bag = read_bag(bag_);
  EXPECT_THAT(bag.texts("/a"), ElementsAre("time jumped", "early", "first"));
  EXPECT_EQ(bag.messages[1].log_time, 7);
}

TEST_F(RecordingQueueTest, TheCountIsWhatIsInTheBagAlsoOverSplits) {
  for (const auto storage : {bags::Storage::kMcap, bags::Storage::kSqlite}) {
    for (const auto compression :
         {bags::Compression::kNone, bags::Compression::kMessage, bags::Compression::kFile}) {
      const auto folder = bag_.string() + "_" + std::string(bags::storage_identifier(storage)) +
                          std::to_string(static_cast<int>(compression));
      RecordingQueue queue(std::make_unique<bags::BagWriter>(
                               folder, bags::BagWriterOptions{.storage = storage,
                                                              .max_file_size = kSmallestFile,
                                                              .compression = compression}),
                           {}, silent_);
      const auto index = queue.add_topic(topic("/a"));
      for (std::int64_t i = 1; i <= 7; ++i) {
        queue.push(index, i, i, large('x'));
      }
      queue.finish();
      EXPECT_EQ(queue.counts().written, 7U);
      EXPECT_EQ(queue.counts().lost, 0U);
      EXPECT_EQ(read_bag(folder).messages.size(), 7U) << folder;
    }
  }
}

TEST_F(RecordingQueueTest, WithoutAnyTimeAllIsAtZero) {
  RecordingQueue queue(writer(), {}, silent_);
  queue.push(queue.add_topic(topic("/a")), 0, 0, text_bytes("early"));
  queue.finish();
  EXPECT_EQ(read_bag(bag_).messages.at(0).log_time, 0);
}

TEST_F(RecordingQueueTest, ASnapshotIsTheLastOfWhatCame) {
  RecordingQueue queue(writer(), {.limit = 120'000, .snapshot = true}, silent_);
  const auto index = queue.add_topic(topic("/a"));
  for (std::int64_t i = 1; i <= 5; ++i) {
    EXPECT_TRUE(queue.push(index, i, i, large('x')));
  }
  EXPECT_TRUE(queue.take_snapshot());
  queue.push(index, 6, 6, large('x'));
  queue.finish();
  EXPECT_EQ(queue.counts().dropped, 0U);
  const auto bag = read_bag(bag_);
  ASSERT_EQ(bag.messages.size(), 2U);
  EXPECT_EQ(bag.messages[0].log_time, 4);
  EXPECT_EQ(bag.messages[1].log_time, 5);
}

TEST_F(RecordingQueueTest, TakesASnapshotOnlyInThatMode) {
  RecordingQueue queue(writer(), {}, silent_);
  EXPECT_FALSE(queue.take_snapshot());
}

TEST_F(RecordingQueueTest, AFullDiskEndsTheRecordingWithAReadableBag) {
  for (const auto storage : {bags::Storage::kMcap, bags::Storage::kSqlite}) {
    SCOPED_TRACE(bags::storage_identifier(storage));
    const auto folder = bag_ / bags::storage_identifier(storage);
    std::filesystem::create_directory(bag_);
    std::promise<std::string> failed;
    RecordingQueue::Counts counts;
    {
      const bag_test::SmallDisk disk(32 * 1024 * 1024);
      RecordingQueue queue(
          std::make_unique<bags::BagWriter>(folder, bags::BagWriterOptions{.storage = storage}),
          {.limit = std::numeric_limits<std::uint64_t>::max()},
          {.split = [](const auto&, const auto&) {},
           .failed = [&](const std::string& why) { failed.set_value(why); }});
      const auto index = queue.add_topic(topic("/a"));
      for (std::int64_t i = 1; i <= 1000; ++i) {
        EXPECT_TRUE(queue.push(index, i, i, large('x')));
      }
      queue.finish();
      counts = queue.counts();
      EXPECT_THAT(queue.error(), HasSubstr(folder.string()));
    }
    EXPECT_THAT(failed.get_future().get(), HasSubstr(folder.string()));
    EXPECT_LT(counts.written, 1000U);
    EXPECT_EQ(counts.written + counts.lost, 1000U);
    std::size_t readable = 0;
    bags::BagReader reader(folder);
    try {
      while (reader.next()) {
        ++readable;
      }
    } catch (const bags::BagError&) {
      // The last chunk may be cut.
    }
    EXPECT_EQ(readable, counts.written);
    if (storage == bags::Storage::kMcap) {
      EXPECT_GT(readable, 30U);
    }  // SQLite has made nothing permanent yet: all of this takes less than a second
  }
}

}  // namespace
}  // namespace pipescout
