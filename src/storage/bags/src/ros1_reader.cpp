// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <limits>
#include <map>
#include <optional>
#include <stdexcept>
#include <utility>

#include "compression.hpp"
#include "file_access.hpp"
#include "ros1_message.hpp"
#include "storage_file.hpp"

namespace pipescout::bags {
namespace {

constexpr std::string_view kMagic = "#ROSBAG V2.0\n";
constexpr std::uint64_t kMaxChunkSize = std::uint64_t{4} * 1024 * 1024 * 1024;
/// Unpacked chunks that are kept: those of a bag overlap in time a little.
constexpr std::size_t kChunksKept = 4;

enum class Op : std::uint8_t { kMessage = 2, kIndex = 4, kChunk = 5, kConnection = 7 };

/// The fields of a record's header.
using Header = std::map<std::string, std::string_view, std::less<>>;

struct Record {
  Header header;
  ByteView data;
};

std::optional<Header> header_of(ByteView bytes) {
  Header header;
  ByteCursor cursor(bytes);
  while (cursor.left() > 0) {
    const auto field = cursor.text();
    const std::size_t equals = field ? field->find('=') : std::string_view::npos;
    if (equals == std::string_view::npos) {
      return std::nullopt;
    }
    header.emplace(field->substr(0, equals), field->substr(equals + 1));
  }
  return header;
}

template <class T>
std::optional<T> number(const Header& header, std::string_view name) {
  const auto found = header.find(name);
  return found == header.end() ? std::nullopt : ByteCursor(bytes_of(found->second)).number<T>();
}

std::string text(const Header& header, std::string_view name) {
  const auto found = header.find(name);
  return found == header.end() ? std::string() : std::string(found->second);
}

std::optional<Record> take_record(ByteCursor& from) {
  const auto header_bytes = from.sized_bytes();
  const auto data = header_bytes ? from.sized_bytes() : std::nullopt;
  auto header = data ? header_of(*header_bytes) : std::nullopt;
  return header ? std::optional(Record{std::move(*header), *data}) : std::nullopt;
}

class Ros1Reader : public FileReader {
 public:
  explicit Ros1Reader(const std::filesystem::path& path) : file_(path) {
    Bytes start;
    file_.read(0, kMagic.size(), start);
    if (text_of(start) != kMagic) {
      throw BagError(
          text_of(start).starts_with("#ROSBAG V") ? BagFault::kUnsupported : BagFault::kMalformed,
          path, 0, "version", "is not that of a ROS 1 bag, 2.0");
    }
    scan();
    std::stable_sort(entries_.begin(), entries_.end(),
                     [](const Entry& a, const Entry& b) { return a.time < b.time; });
    content_.messages = entries_.size();
    if (!entries_.empty()) {
      content_.start = entries_.front().time;
      content_.end = entries_.back().time;
    }
    select(std::vector<bool>(content_.topics.size(), true),
           std::numeric_limits<std::int64_t>::min(), std::numeric_limits<std::int64_t>::max());
  }

  [[nodiscard]] const std::vector<BagTopic>& topics() const override { return content_.topics; }
  [[nodiscard]] const FileContent& content() override { return content_; }
  [[nodiscard]] bool has_checksums() const noexcept override { return false; }

  void select(const std::vector<bool>& wanted, std::int64_t start, std::int64_t end) override {
    wanted_ = wanted;
    end_ = end;
    next_ = static_cast<std::size_t>(
        std::lower_bound(entries_.begin(), entries_.end(), start,
                         [](const Entry& entry, std::int64_t time) { return entry.time < time; }) -
        entries_.begin());
  }

  bool next(BagMessage& message) override {
    while (next_ < entries_.size() && entries_[next_].time <= end_) {
      const Entry& entry = entries_[next_++];
      if (!wanted_[entry.topic]) {
        continue;
      }
      const Bytes& chunk = unpacked(entry.chunk);
      if (entry.offset + entry.size > chunk.size() ||
          !converters_[entry.topic]->to_cdr(
              std::span(chunk).subspan(static_cast<std::size_t>(entry.offset), entry.size), cdr_)) {
        add_fault(BagError(BagFault::kMalformed, file_.path(), entry.chunk,
                           content_.topics[entry.topic].name,
                           "a message does not fit its definition"));
        continue;
      }
      message = {
          .topic = entry.topic, .log_time = entry.time, .publish_time = entry.time, .data = cdr_};
      return true;
    }
    return false;
  }

 private:
  struct Entry {
    std::int64_t time = 0;
    std::uint64_t chunk = 0;   ///< place of the record in the file
    std::uint64_t offset = 0;  ///< of the message in the chunk's data
    std::uint32_t size = 0;
    TopicIndex topic = 0;
  };

  void fault(BagFault kind, std::uint64_t offset, const char* field, const std::string& message) {
    add_fault(BagError(kind, file_.path(), offset, field, message));
  }

  /// Header and data of the record at a place; moves the place behind it.
  std::optional<Record> read_record(std::uint64_t& offset, Bytes& bytes) {
    constexpr std::uint64_t kLength = sizeof(std::uint32_t);
    file_.read(offset, kLength, bytes);
    const auto header_size = ByteCursor(bytes).number<std::uint32_t>();
    if (header_size) {
      file_.read(offset + kLength + *header_size, kLength, bytes);
      const auto data_size = ByteCursor(bytes).number<std::uint32_t>();
      if (data_size) {
        const std::uint64_t size = 2 * kLength + *header_size + *data_size;
        file_.read(offset, size, bytes);
        ByteCursor cursor(bytes);
        auto record = take_record(cursor);
        if (record) {
          offset += size;
          return record;
        }
      }
    }
    return std::nullopt;
  }

  void scan() {
    std::uint64_t offset = kMagic.size();
    Bytes bytes;
    while (offset < file_.size()) {
      const std::uint64_t place = offset;
      const auto record = read_record(offset, bytes);
      if (!record) {
        fault(BagFault::kIncomplete, place, "record", "is cut or malformed");
        return;
      }
      const auto op = number<std::uint8_t>(record->header, "op");
      if (op == static_cast<std::uint8_t>(Op::kChunk)) {
        scan_chunk(place);
      } else if (op == static_cast<std::uint8_t>(Op::kConnection)) {
        add_connection(*record, place);
      }
    }
  }

  void scan_chunk(std::uint64_t place) {
    const Bytes& chunk = unpacked(place);
    ByteCursor cursor(chunk);
    while (cursor.left() > 0) {
      const auto record = take_record(cursor);
      if (!record) {
        fault(BagFault::kMalformed, place, "chunk", "holds a record that is cut or malformed");
        return;
      }
      const auto op = number<std::uint8_t>(record->header, "op");
      if (op == static_cast<std::uint8_t>(Op::kConnection)) {
        add_connection(*record, place);
      } else if (op == static_cast<std::uint8_t>(Op::kMessage)) {
        add_message(*record, place, cursor.position() - record->data.size());
      }
    }
  }

  void add_message(const Record& record, std::uint64_t place, std::size_t offset) {
    const auto connection = number<std::uint32_t>(record.header, "conn");
    const auto time = number<std::uint64_t>(record.header, "time");
    const auto topic = connection ? connections_.find(*connection) : connections_.end();
    if (!time || topic == connections_.end()) {
      fault(BagFault::kMalformed, place, "message", "has no time or no known connection");
      return;
    }
    if (!topic->second) {
      return;  // its definition was refused
    }
    constexpr std::int64_t kSecond = 1'000'000'000;
    // Seconds in the lower half, nanoseconds in the upper one.
    const std::int64_t nanoseconds = static_cast<std::int64_t>(*time & 0xFFFFFFFFU) * kSecond +
                                     static_cast<std::int64_t>(*time >> 32U);
    entries_.push_back({.time = nanoseconds,
                        .chunk = place,
                        .offset = offset,
                        .size = static_cast<std::uint32_t>(record.data.size()),
                        .topic = *topic->second});
    ++content_.counts[*topic->second];
  }

  void add_connection(const Record& record, std::uint64_t place) {
    const auto connection = number<std::uint32_t>(record.header, "conn");
    const auto details = header_of(record.data);
    if (!connection || !details) {
      fault(BagFault::kMalformed, place, "connection", "is malformed");
      return;
    }
    if (connections_.contains(*connection)) {
      return;
    }
    const std::string type = text(*details, "type");
    const std::string name = text(record.header, "topic");
    try {
      auto converter = std::make_unique<Ros1Message>(type, text(*details, "message_definition"));
      content_.topics.push_back(
          ros2_topic(name, type, *converter, text(*details, "latching") == "1"));
      connections_[*connection] = static_cast<TopicIndex>(converters_.size());
      converters_.push_back(std::move(converter));
      content_.counts.push_back(0);
    } catch (const std::invalid_argument& error) {
      connections_[*connection] = std::nullopt;
      fault(BagFault::kUnsupported, place, name.c_str(), error.what());
    }
  }

  /// The data of a chunk; empty with a fault when it cannot be unpacked.
  const Bytes& unpacked(std::uint64_t place) {
    const auto known = std::find_if(chunks_.begin(), chunks_.end(),
                                    [place](const auto& each) { return each.first == place; });
    if (known != chunks_.end()) {
      std::rotate(chunks_.begin(), known, known + 1);
      return chunks_.front().second;
    }
    if (chunks_.size() >= kChunksKept) {
      chunks_.pop_back();
    }
    chunks_.insert(chunks_.begin(), {place, Bytes()});
    Bytes& result = chunks_.front().second;
    Bytes bytes;
    std::uint64_t offset = place;
    const auto record = read_record(offset, bytes);
    const std::string compression = record ? text(record->header, "compression") : "";
    if (compression == "none") {
      append(result, record->data);
    } else if (compression == "bz2" || compression == "lz4") {
      const Codec codec = compression == "bz2" ? Codec::kBzip2 : Codec::kLz4;
      if (unpack(codec, record->data, kMaxChunkSize, result) != Unpacked::kWhole) {
        fault(BagFault::kMalformed, place, "chunk", "is no " + compression);
      }
    } else {
      fault(BagFault::kUnsupported, place, "chunk.compression",
            "'" + compression + "' is not known");
    }
    return result;
  }

  InputFile file_;
  FileContent content_;
  std::map<std::uint32_t, std::optional<TopicIndex>> connections_;
  std::vector<std::unique_ptr<Ros1Message>> converters_;  ///< by topic
  std::vector<Entry> entries_;                            ///< by time
  std::vector<std::pair<std::uint64_t, Bytes>> chunks_;   ///< unpacked, the last used first
  std::vector<bool> wanted_;
  std::int64_t end_ = 0;
  std::size_t next_ = 0;
  Bytes cdr_;
};

}  // namespace

std::unique_ptr<FileReader> open_ros1_bag(const std::filesystem::path& path) {
  return std::make_unique<Ros1Reader>(path);
}

}  // namespace pipescout::bags
