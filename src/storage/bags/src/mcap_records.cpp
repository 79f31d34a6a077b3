// SPDX-License-Identifier: Apache-2.0
#include "mcap_records.hpp"

namespace pipescout::bags::mcap {
namespace {

/// Appends what `fill` appends behind its length in 32 bits.
template <class Fill>
void append_sized(Bytes& to, Fill fill) {
  const std::size_t start = to.size();
  append_number(to, std::uint32_t{0});
  fill();
  const auto length = static_cast<std::uint32_t>(to.size() - start - sizeof(std::uint32_t));
  std::memcpy(to.data() + start, &length, sizeof(length));
}

using Numbers = std::vector<std::pair<std::uint16_t, std::uint64_t>>;

void append_numbers(Bytes& to, const Numbers& numbers) {
  append_sized(to, [&] {
    for (const auto& [key, value] : numbers) {
      append_number(to, key);
      append_number(to, value);
    }
  });
}

/// Reads fields one after another; remembers whether all of them were there.
class Fields {
 public:
  explicit Fields(ByteView content) : cursor_(content) {}

  template <class T>
  void number(T& value) {
    take(cursor_.number<T>(), value);
  }
  void text(std::string& value) { take(cursor_.text(), value); }
  void numbers(Numbers& values) {
    Fields inner(sized());
    while (inner.whole_ && inner.cursor_.left() > 0) {
      auto& [key, value] = values.emplace_back();
      inner.number(key);
      inner.number(value);
    }
    whole_ = whole_ && inner.whole_;
  }
  void texts(std::map<std::string, std::string>& values) {
    Fields inner(sized());
    while (inner.whole_ && inner.cursor_.left() > 0) {
      std::string key;
      inner.text(key);
      inner.text(values[key]);
    }
    whole_ = whole_ && inner.whole_;
  }
  ByteView sized() {
    ByteView result;
    take(cursor_.sized_bytes(), result);
    return result;
  }
  [[nodiscard]] bool whole() const { return whole_; }
  ByteCursor& cursor() { return cursor_; }

 private:
  template <class From, class To>
  void take(const std::optional<From>& from, To& to) {
    if (from && whole_) {
      to = *from;
    } else {
      whole_ = false;
    }
  }

  ByteCursor cursor_;
  bool whole_ = true;
};

template <class T>
std::optional<T> if_whole(const Fields& fields, T&& value) {
  return fields.whole() ? std::optional(std::forward<T>(value)) : std::nullopt;
}

}  // namespace

void append_schema(Bytes& to, const Schema& schema) {
  append_record(to, Opcode::kSchema, [&](Bytes& content) {
    append_number(content, schema.id);
    append_text(content, schema.name);
    append_text(content, schema.encoding);
    append_text(content, schema.data);
  });
}

void append_channel(Bytes& to, const Channel& channel) {
  append_record(to, Opcode::kChannel, [&](Bytes& content) {
    append_number(content, channel.id);
    append_number(content, channel.schema);
    append_text(content, channel.topic);
    append_text(content, channel.message_encoding);
    append_sized(content, [&] {
      for (const auto& [key, value] : channel.metadata) {
        append_text(content, key);
        append_text(content, value);
      }
    });
  });
}

void append_chunk_index(Bytes& to, const ChunkIndex& index) {
  append_record(to, Opcode::kChunkIndex, [&](Bytes& content) {
    append_number(content, index.start_time);
    append_number(content, index.end_time);
    append_number(content, index.chunk_offset);
    append_number(content, index.chunk_length);
    append_numbers(content, index.message_index_offsets);
    append_number(content, index.message_index_length);
    append_text(content, index.compression);
    append_number(content, index.compressed_size);
    append_number(content, index.uncompressed_size);
  });
}

void append_statistics(Bytes& to, const Statistics& statistics) {
  append_record(to, Opcode::kStatistics, [&](Bytes& content) {
    append_number(content, statistics.message_count);
    append_number(content, statistics.schema_count);
    append_number(content, statistics.channel_count);
    append_number(content, statistics.attachment_count);
    append_number(content, statistics.metadata_count);
    append_number(content, statistics.chunk_count);
    append_number(content, statistics.start_time);
    append_number(content, statistics.end_time);
    append_numbers(content, statistics.channel_message_counts);
  });
}

void append_message_head(Bytes& to, const Message& message, std::uint64_t size) {
  // Hundreds of thousands a second: one growth for all fields.
  const std::size_t start = to.size();
  to.resize(start + kPrefixSize + kMessageFieldsSize);
  std::byte* place = to.data() + start;
  const auto put = [&place](auto value) {
    std::memcpy(place, &value, sizeof(value));
    place += sizeof(value);
  };
  put(static_cast<std::uint8_t>(Opcode::kMessage));
  put(kMessageFieldsSize + size);
  put(message.channel);
  put(message.sequence);
  put(message.log_time);
  put(message.publish_time);
}

std::optional<Schema> read_schema(ByteView content) {
  Fields fields(content);
  Schema schema;
  fields.number(schema.id);
  fields.text(schema.name);
  fields.text(schema.encoding);
  fields.text(schema.data);
  return if_whole(fields, std::move(schema));
}

std::optional<Channel> read_channel(ByteView content) {
  Fields fields(content);
  Channel channel;
  fields.number(channel.id);
  fields.number(channel.schema);
  fields.text(channel.topic);
  fields.text(channel.message_encoding);
  fields.texts(channel.metadata);
  return if_whole(fields, std::move(channel));
}

std::optional<Message> read_message(ByteView content) {
  Fields fields(content);
  Message message;
  fields.number(message.channel);
  fields.number(message.sequence);
  fields.number(message.log_time);
  fields.number(message.publish_time);
  message.data = content.subspan(fields.cursor().position());
  return if_whole(fields, std::move(message));
}

std::optional<Chunk> read_chunk(ByteView content) {
  Fields fields(content);
  Chunk chunk;
  std::uint64_t size = 0;
  fields.number(chunk.start_time);
  fields.number(chunk.end_time);
  fields.number(chunk.uncompressed_size);
  fields.number(chunk.uncompressed_crc);
  fields.text(chunk.compression);
  fields.number(size);
  chunk.whole = fields.cursor().left() >= size;
  chunk.records = content.subspan(fields.cursor().position());
  if (chunk.whole) {
    chunk.records = chunk.records.first(static_cast<std::size_t>(size));
  }
  return if_whole(fields, std::move(chunk));
}

std::optional<ChunkIndex> read_chunk_index(ByteView content) {
  Fields fields(content);
  ChunkIndex index;
  fields.number(index.start_time);
  fields.number(index.end_time);
  fields.number(index.chunk_offset);
  fields.number(index.chunk_length);
  fields.numbers(index.message_index_offsets);
  fields.number(index.message_index_length);
  fields.text(index.compression);
  fields.number(index.compressed_size);
  fields.number(index.uncompressed_size);
  return if_whole(fields, std::move(index));
}

std::optional<Statistics> read_statistics(ByteView content) {
  Fields fields(content);
  Statistics statistics;
  fields.number(statistics.message_count);
  fields.number(statistics.schema_count);
  fields.number(statistics.channel_count);
  fields.number(statistics.attachment_count);
  fields.number(statistics.metadata_count);
  fields.number(statistics.chunk_count);
  fields.number(statistics.start_time);
  fields.number(statistics.end_time);
  fields.numbers(statistics.channel_message_counts);
  return if_whole(fields, std::move(statistics));
}

std::optional<Footer> read_footer(ByteView content) {
  Fields fields(content);
  Footer footer;
  fields.number(footer.summary_start);
  fields.number(footer.summary_offset_start);
  fields.number(footer.summary_crc);
  return if_whole(fields, std::move(footer));
}

std::optional<Record> take_record(ByteCursor& from) {
  const ByteCursor before = from;
  const auto opcode = from.number<std::uint8_t>();
  const auto length = from.number<std::uint64_t>();
  const auto content = length ? from.bytes(*length) : std::nullopt;
  if (!content) {
    from = before;
    return std::nullopt;
  }
  return Record{static_cast<Opcode>(*opcode), *content};
}

}  // namespace pipescout::bags::mcap
