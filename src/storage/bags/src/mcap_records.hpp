// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "bytes.hpp"

/// The records of MCAP, https://mcap.dev/spec.
namespace pipescout::bags::mcap {

inline constexpr std::array<unsigned char, 8> kMagic{0x89, 'M', 'C', 'A', 'P', '0', '\r', '\n'};

enum class Opcode : std::uint8_t {
  kHeader = 1,
  kFooter,
  kSchema,
  kChannel,
  kMessage,
  kChunk,
  kMessageIndex,
  kChunkIndex,
  kAttachment,
  kAttachmentIndex,
  kStatistics,
  kMetadata,
  kMetadataIndex,
  kSummaryOffset,
  kDataEnd
};

/// Opcode and length in front of each record.
inline constexpr std::size_t kPrefixSize = 9;
inline constexpr std::size_t kFooterSize = 20;
/// Fields of a message record in front of its data.
inline constexpr std::size_t kMessageFieldsSize = 22;

struct Schema {
  std::uint16_t id = 0;
  std::string name;
  std::string encoding;
  std::string data;
};

struct Channel {
  std::uint16_t id = 0;
  std::uint16_t schema = 0;
  std::string topic;
  std::string message_encoding;
  std::map<std::string, std::string> metadata;
};

struct Message {
  std::uint16_t channel = 0;
  std::uint32_t sequence = 0;
  std::uint64_t log_time = 0;
  std::uint64_t publish_time = 0;
  ByteView data;
};

struct Chunk {
  std::uint64_t start_time = 0;
  std::uint64_t end_time = 0;
  std::uint64_t uncompressed_size = 0;
  std::uint32_t uncompressed_crc = 0;
  std::string compression;
  /// As far as the bytes go.
  ByteView records;
  /// Whether `records` are all that the record says.
  bool whole = false;
};

struct ChunkIndex {
  std::uint64_t start_time = 0;
  std::uint64_t end_time = 0;
  std::uint64_t chunk_offset = 0;
  std::uint64_t chunk_length = 0;
  /// Channels with messages, and where in the file their index is.
  std::vector<std::pair<std::uint16_t, std::uint64_t>> message_index_offsets;
  std::uint64_t message_index_length = 0;
  std::string compression;
  std::uint64_t compressed_size = 0;
  std::uint64_t uncompressed_size = 0;
};

struct Statistics {
  std::uint64_t message_count = 0;
  std::uint16_t schema_count = 0;
  std::uint32_t channel_count = 0;
  std::uint32_t attachment_count = 0;
  std::uint32_t metadata_count = 0;
  std::uint32_t chunk_count = 0;
  std::uint64_t start_time = 0;
  std::uint64_t end_time = 0;
  std::vector<std::pair<std::uint16_t, std::uint64_t>> channel_message_counts;
};

struct Footer {
  std::uint64_t summary_start = 0;
  std::uint64_t summary_offset_start = 0;
  std::uint32_t summary_crc = 0;
};

/// Appends a record whose content `fill` appends.
template <class Fill>
void append_record(Bytes& to, Opcode opcode, Fill fill) {
  const std::size_t start = to.size();
  append_number(to, static_cast<std::uint8_t>(opcode));
  append_number(to, std::uint64_t{0});
  fill(to);
  const std::uint64_t length = to.size() - start - kPrefixSize;
  std::memcpy(to.data() + start + 1, &length, sizeof(length));
}

void append_schema(Bytes& to, const Schema& schema);
void append_channel(Bytes& to, const Channel& channel);
void append_chunk_index(Bytes& to, const ChunkIndex& index);
void append_statistics(Bytes& to, const Statistics& statistics);
/// All of a message record but its data, `size` bytes.
void append_message_head(Bytes& to, const Message& message, std::uint64_t size);

/// The content of records; none when it is malformed.
[[nodiscard]] std::optional<Schema> read_schema(ByteView content);
[[nodiscard]] std::optional<Channel> read_channel(ByteView content);
[[nodiscard]] std::optional<Message> read_message(ByteView content);
/// Of a chunk whose end may be missing.
[[nodiscard]] std::optional<Chunk> read_chunk(ByteView content);
[[nodiscard]] std::optional<ChunkIndex> read_chunk_index(ByteView content);
[[nodiscard]] std::optional<Statistics> read_statistics(ByteView content);
[[nodiscard]] std::optional<Footer> read_footer(ByteView content);

/// A record that begins at some place among bytes.
struct Record {
  Opcode opcode{};
  ByteView content;
};
/// Takes a record off the front; none when less than a whole one is left.
[[nodiscard]] std::optional<Record> take_record(ByteCursor& from);

}  // namespace pipescout::bags::mcap
