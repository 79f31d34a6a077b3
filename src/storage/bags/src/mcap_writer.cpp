// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <map>
#include <optional>
#include <tuple>
#include <utility>

#include "compression.hpp"
#include "file_access.hpp"
#include "mcap_records.hpp"
#include "storage_file.hpp"

namespace pipescout::bags {
namespace {

using namespace mcap;

/// A message from this size on goes from the caller's memory to the file, without a copy into the
/// chunk, which ends with it.
constexpr std::size_t kLargeMessage = std::size_t{128} * 1024;

class McapWriter : public FileWriter {
 public:
  McapWriter(const std::filesystem::path& path, const BagWriterOptions& options)
      : options_(options), file_(path) {
    if (options.chunk_compression == ChunkCompression::kZstd) {
      zstd_.emplace(options.compression_level);
    }
    chunk_.reserve(static_cast<std::size_t>(options.chunk_size + kLargeMessage));
    Bytes start;
    append(start, std::as_bytes(std::span(kMagic)));
    append_record(start, Opcode::kHeader, [](Bytes& content) {
      append_text(content, "ros2");
      append_text(content, "pipescout");
    });
    file_.write({start});
  }

  void add_topic(const BagTopic& topic) override {
    if (channels_.size() == std::numeric_limits<std::uint16_t>::max()) {
      throw BagError(BagFault::kUsage, file_.path(), "more than 65535 topics do not fit into MCAP");
    }
    // Schemas and channels stand outside of the chunks: a chunk that is damaged does not take the
    // meaning of the later ones with it.
    Bytes records;
    const auto [schema, is_new] =
        schema_ids_.try_emplace(std::tuple(topic.type, topic.schema_encoding, topic.schema_text),
                                static_cast<std::uint16_t>(schema_ids_.size() + 1));
    if (is_new) {
      append_schema(records, {.id = schema->second,
                              .name = topic.type,
                              .encoding = topic.schema_encoding,
                              .data = topic.schema_text});
      append(schemas_, records);
    }
    Channel channel{.id = static_cast<std::uint16_t>(channels_.size() + 1),
                    .schema = schema->second,
                    .topic = topic.name,
                    .message_encoding = topic.serialization_format,
                    .metadata = {{"offered_qos_profiles", topic.offered_qos_profiles}}};
    if (!topic.type_description_hash.empty()) {
      channel.metadata["topic_type_hash"] = topic.type_description_hash;
    }
    const std::size_t start = records.size();
    append_channel(records, channel);
    append(channel_records_, std::span(records).subspan(start));
    channels_.emplace_back();
    file_.write({records});
  }

  void write(const BagMessage& message) override {
    ChannelState& channel = channels_[message.topic];
    const auto log_time = static_cast<std::uint64_t>(message.log_time);
    const Message record{.channel = static_cast<std::uint16_t>(message.topic + 1),
                         .sequence = channel.sequence++,
                         .log_time = log_time,
                         .publish_time = static_cast<std::uint64_t>(message.publish_time),
                         .data = message.data};
    if (channel.index.empty()) {
      used_.push_back(message.topic);
    }
    channel.index.emplace_back(log_time, chunk_.size());
    start_time_ = std::min(start_time_, log_time);
    end_time_ = std::max(end_time_, log_time);
    append_message_head(chunk_, record, message.data.size());
    if (message.data.size() >= kLargeMessage &&
        options_.chunk_compression == ChunkCompression::kNone) {
      end_chunk(message.data);
      return;
    }
    append(chunk_, message.data);
    if (chunk_.size() >= options_.chunk_size) {
      end_chunk({});
    }
  }

  [[nodiscard]] std::uint64_t size() const override {
    constexpr std::uint64_t kRest = 256;
    return file_.size() + chunk_.size() + chunk_indexes_.size() + schemas_.size() +
           channel_records_.size() + kRest + channels_.size() * 10;
  }

  void flush() override {
    if (!used_.empty()) {
      end_chunk({});
    }
  }

  void close(const std::string&) override {
    const std::uint64_t data_end = file_.size();
    try {
      flush();
    } catch (const BagError&) {
      write_summary_or_cut(data_end);
      throw;
    }
    write_summary_or_cut(file_.size());
  }

 private:
  struct ChannelState {
    std::uint32_t sequence = 0;
    std::uint64_t written = 0;  ///< messages in the file
    /// Log time and place of its messages in the current chunk.
    std::vector<std::pair<std::uint64_t, std::uint64_t>> index;
  };

  /// Writes the chunk, whose last record lacks `tail`, and begins a new one. On an error the chunk
  /// is lost.
  void end_chunk(ByteView tail) {
    const std::uint64_t offset = file_.size();
    const std::uint64_t size = chunk_.size() + tail.size();
    const std::uint32_t crc = options_.checksums ? crc32(tail, crc32(chunk_)) : 0;
    ByteView records = chunk_;
    std::string_view compression;
    if (options_.chunk_compression == ChunkCompression::kLz4) {
      compress_lz4(chunk_, packed_);
      compression = "lz4";
      records = packed_;
    } else if (options_.chunk_compression == ChunkCompression::kZstd) {
      zstd_->compress(chunk_, packed_);
      compression = "zstd";
      records = packed_;
    }
    const std::uint64_t record_size = records.size() + tail.size();

    head_.clear();
    append_number(head_, static_cast<std::uint8_t>(Opcode::kChunk));
    // Four numbers, the name of the compression and the size of the records.
    append_number(head_, std::uint64_t{8 + 8 + 8 + 4 + 4 + 8} + compression.size() + record_size);
    append_number(head_, start_time_);
    append_number(head_, end_time_);
    append_number(head_, size);
    append_number(head_, crc);
    append_text(head_, compression);
    append_number(head_, record_size);

    ChunkIndex index{.start_time = start_time_,
                     .end_time = end_time_,
                     .chunk_offset = offset,
                     .chunk_length = head_.size() + record_size,
                     .compression = std::string(compression),
                     .compressed_size = record_size,
                     .uncompressed_size = size};
    append_message_indexes(index);
    std::vector<std::pair<TopicIndex, std::uint64_t>> counts;
    for (const TopicIndex topic : used_) {
      counts.emplace_back(topic, channels_[topic].index.size());
      channels_[topic].index.clear();
    }
    used_.clear();
    const auto [start, end] =
        std::pair(std::exchange(start_time_, kNever), std::exchange(end_time_, 0));
    try {
      file_.write({head_, records, tail, indexes_});
    } catch (...) {
      chunk_.clear();
      throw;
    }
    chunk_.clear();
    append_chunk_index(chunk_indexes_, index);
    ++chunks_;
    for (const auto& [topic, count] : counts) {
      channels_[topic].written += count;
    }
    file_start_time_ = std::min(file_start_time_, start);
    file_end_time_ = std::max(file_end_time_, end);
  }

  void append_message_indexes(ChunkIndex& chunk) {
    indexes_.clear();
    const std::uint64_t start = chunk.chunk_offset + chunk.chunk_length;
    for (const TopicIndex topic : used_) {
      const auto& entries = channels_[topic].index;
      chunk.message_index_offsets.emplace_back(topic + 1, start + indexes_.size());
      append_record(indexes_, Opcode::kMessageIndex, [&](Bytes& content) {
        append_number(content, static_cast<std::uint16_t>(topic + 1));
        append_number(content, static_cast<std::uint32_t>(entries.size() * sizeof(entries[0])));
        append(content, std::as_bytes(std::span(entries)));
      });
    }
    chunk.message_index_length = indexes_.size();
  }

  /// Readers scan a file without a summary, but stumble over half of one.
  void write_summary_or_cut(std::uint64_t data_end) {
    try {
      file_.write({end_of_file(data_end)});
    } catch (const BagError&) {
      file_.shorten(data_end);
      throw;
    }
  }

  [[nodiscard]] Bytes end_of_file(std::uint64_t data_end) const {
    Bytes end;
    append_record(end, Opcode::kDataEnd,
                  [](Bytes& content) { append_number(content, std::uint32_t{0}); });
    const std::size_t summary = end.size();
    const auto place = [&] { return data_end + end.size(); };
    Bytes offsets;
    const auto add_group = [&](Opcode opcode, ByteView records) {
      if (!records.empty()) {
        append_record(offsets, Opcode::kSummaryOffset, [&](Bytes& content) {
          append_number(content, static_cast<std::uint8_t>(opcode));
          append_number(content, place());
          append_number(content, std::uint64_t{records.size()});
        });
        append(end, records);
      }
    };
    Bytes statistics;
    append_statistics(statistics, this->statistics());
    add_group(Opcode::kSchema, schemas_);
    add_group(Opcode::kChannel, channel_records_);
    add_group(Opcode::kStatistics, statistics);
    add_group(Opcode::kChunkIndex, chunk_indexes_);
    const std::uint64_t offsets_start = place();
    append(end, offsets);
    append_number(end, static_cast<std::uint8_t>(Opcode::kFooter));
    append_number(end, std::uint64_t{kFooterSize});
    append_number(end, data_end + summary);
    append_number(end, offsets_start);
    append_number(end, options_.checksums ? crc32(std::span(end).subspan(summary)) : 0U);
    append(end, std::as_bytes(std::span(kMagic)));
    return end;
  }

  [[nodiscard]] Statistics statistics() const {
    Statistics result{.schema_count = static_cast<std::uint16_t>(schema_ids_.size()),
                      .channel_count = static_cast<std::uint32_t>(channels_.size()),
                      .chunk_count = chunks_};
    for (std::size_t topic = 0; topic < channels_.size(); ++topic) {
      result.message_count += channels_[topic].written;
      result.channel_message_counts.emplace_back(topic + 1, channels_[topic].written);
    }
    if (result.message_count > 0) {
      result.start_time = file_start_time_;
      result.end_time = file_end_time_;
    }
    return result;
  }

  static constexpr std::uint64_t kNever = std::numeric_limits<std::uint64_t>::max();

  BagWriterOptions options_;
  OutputFile file_;
  std::optional<ZstdCompressor> zstd_;
  std::map<std::tuple<std::string, std::string, std::string>, std::uint16_t> schema_ids_;
  std::vector<ChannelState> channels_;
  Bytes schemas_;          ///< all records, for the summary
  Bytes channel_records_;  ///< all records, for the summary
  Bytes chunk_indexes_;    ///< all records, for the summary
  std::uint32_t chunks_ = 0;
  std::uint64_t file_start_time_ = kNever;
  std::uint64_t file_end_time_ = 0;

  Bytes chunk_;                   ///< records of the current chunk
  std::vector<TopicIndex> used_;  ///< topics with messages in it
  std::uint64_t start_time_ = kNever;
  std::uint64_t end_time_ = 0;
  Bytes head_, packed_, indexes_;  ///< kept for their memory
};

}  // namespace

std::unique_ptr<FileWriter> make_mcap_writer(const std::filesystem::path& path,
                                             const BagWriterOptions& options) {
  return std::make_unique<McapWriter>(path, options);
}

}  // namespace pipescout::bags
