// SPDX-License-Identifier: Apache-2.0
#include "mcap_index.hpp"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include "compression.hpp"

namespace pipescout::bags::mcap {
namespace {

/// Bytes that are read for the fields of a record in front of its data.
constexpr std::uint64_t kFieldsRead = 64;
/// No chunk unpacks to more.
constexpr std::uint64_t kMaxChunkSize = std::uint64_t{4} * 1024 * 1024 * 1024;

bool is_magic(ByteView bytes) {
  return bytes.size() == kMagic.size() &&
         std::equal(bytes.begin(), bytes.end(), std::as_bytes(std::span(kMagic)).begin());
}

/// What is found while the index grows.
class Indexer {
 public:
  explicit Indexer(const InputFile& file) : file_(file) {}

  FileIndex index() {
    check_start();
    if (!read_summary()) {
      scan();
    }
    return std::move(index_);
  }

 private:
  void check_start() {
    Bytes start;
    file_.read(0, kMagic.size(), start);
    const auto magic = std::as_bytes(std::span(kMagic)).first(start.size());
    if (!std::equal(start.begin(), start.end(), magic.begin())) {
      throw BagError(BagFault::kMalformed, file_.path(), 0, "magic", "is not that of MCAP");
    }
    if (start.size() < kMagic.size()) {
      throw BagError(BagFault::kIncomplete, file_.path(), start.size(), "magic", "is cut");
    }
  }

  void fault(BagFault fault, std::uint64_t offset, const std::string& field,
             const std::string& message) {
    index_.faults.emplace_back(fault, file_.path(), offset, field, message);
  }

  /// False when there is no usable summary; why it is none that is damaged is a fault.
  bool read_summary() {
    constexpr std::uint64_t kEnd = kPrefixSize + kFooterSize + kMagic.size();
    if (file_.size() < kMagic.size() + kEnd) {
      return false;
    }
    const std::uint64_t footer_start = file_.size() - kEnd;
    Bytes end;
    file_.read(footer_start, kEnd, end);
    if (end.size() < kEnd || !is_magic(std::span(end).last(kMagic.size()))) {
      return false;
    }
    has_end_ = true;
    ByteCursor cursor(end);
    const auto record = take_record(cursor);
    const auto footer =
        record && record->opcode == Opcode::kFooter ? read_footer(record->content) : std::nullopt;
    if (!footer) {
      fault(BagFault::kMalformed, footer_start, "footer", "is no footer record");
      return false;
    }
    if (footer->summary_start == 0) {
      return false;
    }
    if (footer->summary_start < kMagic.size() || footer->summary_start > footer_start) {
      fault(BagFault::kMalformed, footer_start, "footer.summary_start",
            std::to_string(footer->summary_start) + " lies outside of the file");
      return false;
    }
    Bytes summary;
    constexpr std::uint64_t kUncovered = sizeof(std::uint32_t) + kMagic.size();
    file_.read(footer->summary_start, file_.size() - kUncovered - footer->summary_start, summary);
    if (footer->summary_crc != 0 && crc32(summary) != footer->summary_crc) {
      fault(BagFault::kChecksum, footer->summary_start, "footer.summary_crc",
            "the summary has changed since it was written");
      return false;
    }
    summary.resize(static_cast<std::size_t>(footer_start - footer->summary_start));
    return read_summary_records(summary, footer->summary_start);
  }

  bool read_summary_records(ByteView summary, std::uint64_t start) {
    FileIndex found;
    std::optional<Statistics> statistics;
    ByteCursor cursor(summary);
    while (cursor.left() > 0) {
      const std::uint64_t place = start + cursor.position();
      const auto record = take_record(cursor);
      bool good = record.has_value();
      if (good && record->opcode == Opcode::kSchema) {
        auto schema = read_schema(record->content);
        good = schema.has_value();
        if (good) {
          found.schemas.emplace(schema->id, std::move(*schema));
        }
      } else if (good && record->opcode == Opcode::kChannel) {
        auto channel = read_channel(record->content);
        good = channel.has_value();
        if (good) {
          found.channels.emplace(channel->id, std::move(*channel));
        }
      } else if (good && record->opcode == Opcode::kStatistics) {
        statistics = read_statistics(record->content);
        good = statistics.has_value();
      } else if (good && record->opcode == Opcode::kChunkIndex) {
        const auto chunk = read_chunk_index(record->content);
        good = chunk && chunk->chunk_offset <= start && chunk->chunk_length <= start &&
               chunk->chunk_offset + chunk->chunk_length <= start;
        if (good) {
          add_chunk(found, *chunk);
        }
      }
      if (!good) {
        fault(BagFault::kMalformed, place, "summary", "has a record that makes no sense");
        return false;
      }
    }
    // Messages outside of chunks are in no index, and counts are wanted.
    if (!statistics || statistics->chunk_count != found.chunks.size() ||
        (statistics->message_count > 0 &&
         (found.chunks.empty() || statistics->channel_message_counts.empty()))) {
      return false;
    }
    std::uint64_t total = 0;
    for (const auto& [channel, count] : statistics->channel_message_counts) {
      found.counts[channel] += count;
      total += count;
      if (count > 0 && !found.channels.contains(channel)) {
        fault(BagFault::kMalformed, start, "statistics.channel_message_counts",
              "channel " + std::to_string(channel) + " is not in the summary");
        return false;
      }
    }
    if (total != statistics->message_count) {
      fault(BagFault::kMalformed, start, "statistics.message_count",
            "differs from the sum over the channels");
      return false;
    }
    found.start_time = statistics->start_time;
    found.end_time = statistics->end_time;
    found.faults = std::move(index_.faults);
    index_ = std::move(found);
    note_checksums();
    return true;
  }

  static void add_chunk(FileIndex& index, const ChunkIndex& chunk) {
    ChunkPlace& place = index.chunks.emplace_back(
        ChunkPlace{.offset = chunk.chunk_offset,
                   .length = chunk.chunk_length,
                   .start_time = chunk.start_time,
                   .end_time = chunk.end_time,
                   .channels_known = !chunk.message_index_offsets.empty()});
    for (const auto& [channel, offset] : chunk.message_index_offsets) {
      place.channels.push_back(channel);
    }
    std::sort(place.channels.begin(), place.channels.end());
  }

  /// Whether there are any is known from the first chunk.
  void note_checksums() {
    if (index_.chunks.empty()) {
      index_.has_checksums = true;
      return;
    }
    Bytes fields;
    file_.read(index_.chunks.front().offset + kPrefixSize, kFieldsRead, fields);
    const auto chunk = read_chunk(fields);
    index_.has_checksums = chunk && chunk->uncompressed_crc != 0;
  }

  void scan() {
    bool ended = false;
    std::uint64_t offset = kMagic.size();
    Bytes fields;
    while (!ended && offset < file_.size()) {
      file_.read(offset, kPrefixSize + kFieldsRead, fields);
      ByteCursor cursor(fields);
      const auto opcode = cursor.number<std::uint8_t>();
      const auto length = cursor.number<std::uint64_t>();
      const std::uint64_t left = file_.size() - offset;
      if (!length) {
        fault(BagFault::kIncomplete, offset, "record", "is cut");
        break;
      }
      if (*opcode == 0) {
        fault(BagFault::kMalformed, offset, "opcode", "is 0");
        break;
      }
      const bool whole = *length <= left - kPrefixSize;
      if (!whole) {
        fault(BagFault::kIncomplete, offset, "record",
              "needs " + std::to_string(*length) + " bytes, the file has " +
                  std::to_string(left - kPrefixSize) + " more");
      }
      const std::uint64_t content = std::min(*length, left - kPrefixSize);
      ended = add_record(static_cast<Opcode>(*opcode), offset, content, whole) || !whole;
      offset += kPrefixSize + content;
    }
    if (index_.faults.empty() && (!ended || !has_end_)) {
      fault(BagFault::kIncomplete, offset, "footer", "is missing");
    }
    finish_scan();
  }

  /// True when the data ends with this record.
  bool add_record(Opcode opcode, std::uint64_t offset, std::uint64_t size, bool whole) {
    Bytes content;
    const std::uint64_t start = offset + kPrefixSize;
    switch (opcode) {
      case Opcode::kDataEnd:
      case Opcode::kFooter:
        return true;
      case Opcode::kSchema:
      case Opcode::kChannel:
        if (whole) {
          file_.read(start, size, content);
          add_definition({opcode, content}, offset);
        }
        return false;
      case Opcode::kChunk:
        file_.read(start, size, content);
        scan_chunk(content, offset);
        return false;
      case Opcode::kMessage: {
        file_.read(start, std::min<std::uint64_t>(size, kMessageFieldsSize), content);
        const auto message = read_message(content);
        if (whole && message) {
          index_.loose.push_back({.log_time = message->log_time,
                                  .offset = start,
                                  .size = size,
                                  .channel = message->channel});
          count(*message, offset);
        } else if (whole) {
          fault(BagFault::kMalformed, offset, "message", "is too short");
        }
        return false;
      }
      default:
        return false;
    }
  }

  void add_definition(const Record& record, std::uint64_t offset) {
    if (record.opcode == Opcode::kSchema) {
      if (auto schema = read_schema(record.content)) {
        index_.schemas.emplace(schema->id, std::move(*schema));
      } else {
        fault(BagFault::kMalformed, offset, "schema", "is malformed");
      }
    } else if (auto channel = read_channel(record.content)) {
      index_.channels.emplace(channel->id, std::move(*channel));
    } else {
      fault(BagFault::kMalformed, offset, "channel", "is malformed");
    }
  }

  void scan_chunk(ByteView content, std::uint64_t offset) {
    const auto chunk = read_chunk(content);
    if (!chunk) {
      if (index_.faults.empty()) {
        fault(BagFault::kMalformed, offset, "chunk", "is malformed");
      }
      return;
    }
    unpack_chunk(file_, offset, *chunk, unpacked_, index_.faults);
    index_.has_checksums = index_.has_checksums || chunk->uncompressed_crc != 0;
    ChunkPlace place{.offset = offset,
                     .length = kPrefixSize + content.size(),
                     .start_time = std::numeric_limits<std::uint64_t>::max(),
                     .channels_known = true};
    ByteCursor cursor(unpacked_);
    while (const auto record = take_record(cursor)) {
      if (record->opcode == Opcode::kMessage) {
        if (const auto message = read_message(record->content)) {
          place.start_time = std::min(place.start_time, message->log_time);
          place.end_time = std::max(place.end_time, message->log_time);
          place.channels.push_back(message->channel);
          count(*message, offset);
        }
      } else if (record->opcode == Opcode::kSchema || record->opcode == Opcode::kChannel) {
        add_definition(*record, offset);
      }
    }
    std::sort(place.channels.begin(), place.channels.end());
    place.channels.erase(std::unique(place.channels.begin(), place.channels.end()),
                         place.channels.end());
    if (!place.channels.empty()) {
      index_.chunks.push_back(std::move(place));
    }
  }

  void count(const Message& message, std::uint64_t offset) {
    if (!index_.channels.contains(message.channel)) {
      if (!unknown_channel_told_) {
        fault(BagFault::kMalformed, offset, "message.channel_id",
              "channel " + std::to_string(message.channel) + " is defined nowhere before");
        unknown_channel_told_ = true;
      }
      return;
    }
    ++index_.counts[message.channel];
    ++scanned_;
    index_.start_time =
        scanned_ == 1 ? message.log_time : std::min(index_.start_time, message.log_time);
    index_.end_time = std::max(index_.end_time, message.log_time);
  }

  void finish_scan() {
    std::stable_sort(
        index_.loose.begin(), index_.loose.end(),
        [](const LooseMessage& a, const LooseMessage& b) { return a.log_time < b.log_time; });
  }

  const InputFile& file_;
  FileIndex index_;
  Bytes unpacked_;
  std::uint64_t scanned_ = 0;
  bool unknown_channel_told_ = false;
  bool has_end_ = false;  ///< the file ends with footer and magic
};

}  // namespace

FileIndex index_file(const InputFile& file) {
  return Indexer(file).index();
}

void unpack_chunk(const InputFile& file, std::uint64_t offset, const Chunk& chunk, Bytes& records,
                  std::vector<BagError>& faults) {
  records.clear();
  const auto fault = [&](BagFault kind, const char* field, const std::string& message) {
    faults.emplace_back(kind, file.path(), offset, field, message);
  };
  bool whole = chunk.whole;
  if (chunk.compression.empty()) {
    records.assign(chunk.records.begin(), chunk.records.end());
  } else if (chunk.compression == "zstd" || chunk.compression == "lz4") {
    const Codec codec = chunk.compression == "zstd" ? Codec::kZstd : Codec::kLz4;
    const Unpacked result = unpack(codec, chunk.records, kMaxChunkSize, records);
    if (result == Unpacked::kDamaged || (result == Unpacked::kCut && whole)) {
      fault(BagFault::kMalformed, "chunk.records", "is no " + chunk.compression + " frame");
      whole = false;
    } else if (result == Unpacked::kTooLarge) {
      fault(BagFault::kUnsupported, "chunk.records", "unpacks to more than 4 GiB");
      whole = false;
    }
  } else {
    fault(BagFault::kUnsupported, "chunk.compression", "'" + chunk.compression + "' is not known");
    return;
  }
  if (!whole) {
    return;
  }
  if (records.size() != chunk.uncompressed_size) {
    fault(BagFault::kMalformed, "chunk.uncompressed_size",
          std::to_string(chunk.uncompressed_size) + ", but there are " +
              std::to_string(records.size()) + " bytes");
  }
  if (chunk.uncompressed_crc != 0 && crc32(records) != chunk.uncompressed_crc) {
    fault(BagFault::kChecksum, "chunk.uncompressed_crc",
          "the chunk has changed since it was written; its messages are left out");
    records.clear();
  }
}

}  // namespace pipescout::bags::mcap
