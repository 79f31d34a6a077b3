// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <random>
#include <string>

#include "pipescout/bags/bag_maintenance.hpp"
#include "pipescout/files/testing/temporary_folder.hpp"
#include "test_bag.hpp"

namespace pipescout::bags {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;
using testing::Stored;
namespace fs = std::filesystem;

struct Case {
  std::string name;
  BagWriterOptions options;
};

std::vector<Case> cases() {
  using enum ChunkCompression;
  return {
      {"sqlite", {.storage = Storage::kSqlite}},
      {"mcap", {.storage = Storage::kMcap, .chunk_size = 400}},
      {"mcap_lz4", {.storage = Storage::kMcap, .chunk_compression = kLz4, .chunk_size = 400}},
      {"mcap_zstd", {.storage = Storage::kMcap, .chunk_compression = kZstd, .chunk_size = 400}}};
}

class DamagedBag : public ::testing::TestWithParam<Case> {
 protected:
  void make(std::size_t count, std::size_t largest) {
    written_ = testing::messages(count, largest);
    BagWriter writer(bag_, GetParam().options);
    for (const Stored& each : written_) {
      testing::write(writer, each);
    }
    writer.close();
    file_ = bag_ / writer.metadata().files.front().path;
    content_ = pipescout::testing::content(file_);
  }

  [[nodiscard]] bool is_sqlite() const { return GetParam().options.storage == Storage::kSqlite; }

  /// Where the file must reach for each message to be in it.
  [[nodiscard]] std::vector<std::size_t> ends() const {
    constexpr std::size_t kPage = 4096;
    std::vector<std::size_t> result;
    for (const Stored& each : written_) {
      const std::string data(reinterpret_cast<const char*>(each.data.data()), each.data.size());
      const std::size_t place = content_.find(data);
      EXPECT_NE(place, std::string::npos);
      const std::size_t end = place + data.size();
      result.push_back(is_sqlite() ? (end + kPage - 1) / kPage * kPage : end);
    }
    return result;
  }

  /// Whether what was read is some of what was written, in its order.
  [[nodiscard]] bool is_part(const std::vector<Stored>& read) const {
    auto from = written_.begin();
    return std::all_of(read.begin(), read.end(), [&](const Stored& each) {
      from = std::find(from, written_.end(), each);
      return from != written_.end();
    });
  }

  /// What cannot be mended is said, and what was written is a whole bag.
  void try_to_mend() const {
    const fs::path mended = folder_.path() / "mended";
    try {
      (void)recover_bag(bag_, mended, GetParam().options);
      EXPECT_THAT(check_bag(mended).faults, IsEmpty());
    } catch (const BagError&) {
    }
    fs::remove_all(mended);
  }

  pipescout::testing::TemporaryFolder folder_;
  fs::path bag_ = folder_.path() / "mission";
  fs::path file_;
  std::string content_;
  std::vector<Stored> written_;
};

TEST_P(DamagedBag, CutAtEveryByteKeepsWhatStandsBefore) {
  make(12, 60);
  const bool packed = GetParam().options.chunk_compression != ChunkCompression::kNone;
  const auto ends = packed ? std::vector<std::size_t>() : this->ends();
  for (std::size_t size = content_.size(); size-- > 0;) {
    fs::resize_file(file_, size);
    const BagReport report = check_bag(bag_);
    ASSERT_THAT(report.faults, Not(IsEmpty())) << size;
    ASSERT_LE(report.messages, written_.size()) << size;
    const auto expected =
        std::count_if(ends.begin(), ends.end(), [size](std::size_t end) { return end <= size; });
    ASSERT_GE(report.messages, static_cast<std::uint64_t>(expected)) << size;
  }
}

TEST_P(DamagedBag, IsRecoveredToAWholeBag) {
  make(200, 3000);
  fs::resize_file(file_, content_.size() * 2 / 3);
  std::string error;
  std::vector<Stored> read;
  {
    BagReader reader(bag_);
    read = testing::read(reader, &error);
  }
  EXPECT_THAT(error, HasSubstr(file_.filename().string()));
  EXPECT_TRUE(is_part(read));
  EXPECT_GT(read.size(), 100U);
  const fs::path mended = folder_.path() / "mended";
  const auto report = recover_bag(bag_, mended, GetParam().options);
  EXPECT_EQ(report.messages, read.size());
  EXPECT_THAT(report.faults, Not(IsEmpty()));
  EXPECT_THAT(check_bag(mended).faults, IsEmpty());
  EXPECT_EQ(testing::read(mended), read);
  EXPECT_THROW(reindex_bag(bag_), BagError);
}

TEST_P(DamagedBag, ThousandMutationsGiveClearErrors) {
  make(60, 900);
  constexpr int kPerRecovery = 10;  // it writes a bag
  std::mt19937 random(7);
  int unseen = 0;
  for (int k = 0; k < 1000; ++k) {
    testing::write_file(file_, testing::mutated(content_, random));
    const BagReport report = check_bag(bag_);
    for (const std::string& fault : report.faults) {
      ASSERT_THAT(fault, HasSubstr("mission"));
    }
    try {
      BagReader reader(bag_);
      std::string error;
      const auto read = testing::read(reader, &error);
      ASSERT_EQ(error.empty() && read == written_, report.faults.empty() && read == written_)
          << error;
      unseen += report.faults.empty() && read != written_ ? 1 : 0;
      reader.seek(written_[written_.size() / 2].log_time);
      (void)testing::read(reader, &error);
    } catch (const BagError&) {
      ASSERT_THAT(report.faults, Not(IsEmpty()));
    }
    if (k % kPerRecovery == 0) {
      try_to_mend();
    }
  }
  if (!is_sqlite()) {
    EXPECT_EQ(unseen, 0) << "changes that no checksum told";
  }
}

TEST_P(DamagedBag, ThousandMutationsOfTheMetadataGiveClearErrors) {
  make(6, 60);
  const fs::path file = bag_ / "metadata.yaml";
  const std::string whole = pipescout::testing::content(file);
  std::mt19937 random(8);
  for (int k = 0; k < 1000; ++k) {
    testing::write_file(file, testing::mutated(whole, random));
    const BagReport report = check_bag(bag_);
    for (const std::string& fault : report.faults) {
      ASSERT_THAT(fault, HasSubstr("mission"));
    }
    try {
      BagReader reader(bag_);
      std::string error;
      (void)testing::read(reader, &error);
    } catch (const BagError&) {
      ASSERT_THAT(report.faults, Not(IsEmpty()));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Formats, DamagedBag, ::testing::ValuesIn(cases()),
                         [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace pipescout::bags
