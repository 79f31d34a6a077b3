// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>

#include "pipescout/bags/bag_types.hpp"

namespace pipescout::bags {

struct BagWriterOptions {
  Storage storage = Storage::kSqlite;
  /// A new file is begun before the message that would make the current one larger, bytes; 0:
  /// never. No message is lost at a split. At least 86016 where it is not 0, as rosbag2 asks.
  std::uint64_t max_file_size = 0;
  /// A new file is begun at the first message that is so much later than the file's first one, by
  /// log time; 0: never.
  std::chrono::nanoseconds max_file_duration{0};
  Compression compression = Compression::kNone;
  /// Of zstd, where `compression` or `chunk_compression` say so: 1 (fast) to 19 (small).
  int compression_level = 1;

  /// MCAP only.
  ChunkCompression chunk_compression = ChunkCompression::kNone;
  /// A chunk is written out when its messages reach this size, bytes before compression.
  /// 1 to 1 GiB.
  std::uint64_t chunk_size = 1024 * 1024;
  /// CRC32 of each chunk and of the summary.
  bool checksums = true;

  /// Flush once in a second too, so that a kill loses no more. Otherwise only what is full goes to
  /// the file: the same messages then give the same bytes, however long they take.
  bool flush_by_time = true;

  /// SQLite only: memory for changed pages before they go to the file, bytes.
  std::uint64_t cache_size = 10 * 1024 * 1024;
};

/// Writes a bag: a folder with `metadata.yaml` and files `NAME_0.db3`, `NAME_1.db3`, ... (or .mcap,
/// or these with .zstd).
///
/// A process that is killed leaves all messages that were written more than a second before,
/// provided that `flush_by_time` is set and `write` or `flush_if_due` is called at least every 100
/// ms. The bag then lacks metadata and the index of the last file; readers do without,
/// `recover_bag` makes it whole.
///
/// Throws BagError; its fault is kNoSpace when the disk is full. After an error of `write`, `flush`
/// or `split` the writer only takes `close`, which completes what is on the disk to a readable bag
/// as far as there is space.
///
/// Not thread-safe: one thread at a time. Memory: one chunk or the cache, plus the size of the
/// message where it is compressed; for the index of the current MCAP file some 100 bytes for each
/// chunk. Writes do not wait for the disk: a power loss can cost what the operating system had not
/// written yet.
class BagWriter {
 public:
  /// Makes the folder, whose last part is the bag's name. Throws BagError(kExists) when there is
  /// something of that name already, std::invalid_argument for options out of range.
  explicit BagWriter(std::filesystem::path folder, const BagWriterOptions& options = {});
  /// As `close`, but errors are lost.
  ~BagWriter();
  BagWriter(const BagWriter&) = delete;
  BagWriter& operator=(const BagWriter&) = delete;

  /// The index of the topic in this writer. A name that was added before keeps its index and what
  /// was said of it first; throws BagError(kUsage) when the type differs, or name or type are
  /// empty.
  TopicIndex add_topic(const BagTopic& topic);

  /// Appends a message. Messages should come by rising log time; those that do not are kept, and
  /// are read in the order of their log time. `message.data` is not needed after the call. Throws
  /// BagError(kUsage) for an unknown topic, for negative times, which bags cannot hold, and for
  /// data of more than 1 GB.
  void write(const BagMessage& message);

  /// Gives everything to the operating system: a kill after it loses nothing written before.
  void flush();
  /// The same, if the last flush was at least 800 ms ago: for times without messages.
  void flush_if_due();

  /// Begins a new file.
  void split();

  /// Completes the files and writes `metadata.yaml`. Later calls do nothing. With file compression
  /// it takes as long as zstd needs for the last file.
  void close();

  /// What was written so far.
  [[nodiscard]] const BagMetadata& metadata() const noexcept;
  [[nodiscard]] const std::filesystem::path& folder() const noexcept;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace pipescout::bags
