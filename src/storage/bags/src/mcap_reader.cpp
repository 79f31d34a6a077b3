// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <limits>
#include <memory>
#include <queue>
#include <stdexcept>
#include <unordered_map>
#include <utility>

#include "file_access.hpp"
#include "mcap_index.hpp"
#include "ros1_message.hpp"
#include "storage_file.hpp"

namespace pipescout::bags {
namespace {

using namespace mcap;

/// MCAP's times have one bit more than those of ROS.
std::int64_t signed_time(std::uint64_t time) {
  return static_cast<std::int64_t>(std::min<std::uint64_t>(
      time, static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max())));
}

/// A chunk in memory, or the messages outside of chunks.
struct Source {
  struct Entry {
    std::uint64_t log_time = 0;
    std::uint64_t offset = 0;  ///< of the record's content, in the chunk's records or in the file
    std::uint64_t size = 0;
  };
  std::uint64_t place = 0;  ///< in the file: decides between equal times
  Bytes records;
  std::vector<Entry> entries;
  std::size_t next = 0;
};

class McapReader : public FileReader {
 public:
  explicit McapReader(const std::filesystem::path& path) : file_(path), index_(index_file(file_)) {
    for (const BagError& fault : index_.faults) {
      add_fault(fault);
    }
    for (const auto& [id, channel] : index_.channels) {
      BagTopic topic{.name = channel.topic, .serialization_format = channel.message_encoding};
      if (const auto schema = index_.schemas.find(channel.schema); schema != index_.schemas.end()) {
        topic.type = schema->second.name;
        topic.schema_encoding = schema->second.encoding;
        topic.schema_text = schema->second.data;
      } else if (channel.schema != 0) {
        add_fault(BagError(BagFault::kMalformed, file_.path(),
                           "channel of " + channel.topic + ": its schema " +
                               std::to_string(channel.schema) + " is missing"));
      }
      if (const auto qos = channel.metadata.find("offered_qos_profiles");
          qos != channel.metadata.end()) {
        topic.offered_qos_profiles = qos->second;
      }
      if (const auto hash = channel.metadata.find("topic_type_hash");
          hash != channel.metadata.end()) {
        topic.type_description_hash = hash->second;
      }
      topics_.emplace(id, static_cast<TopicIndex>(content_.topics.size()));
      converters_.push_back(channel.message_encoding == "ros1" ? take_ros1(topic, channel)
                                                               : nullptr);
      content_.topics.push_back(std::move(topic));
      const auto count = index_.counts.find(id);
      content_.counts.push_back(count == index_.counts.end() ? 0 : count->second);
      content_.messages += content_.counts.back();
    }
    content_.start = signed_time(index_.start_time);
    content_.end = signed_time(index_.end_time);
    select(std::vector<bool>(content_.topics.size(), true),
           std::numeric_limits<std::int64_t>::min(), std::numeric_limits<std::int64_t>::max());
  }

  [[nodiscard]] const std::vector<BagTopic>& topics() const override { return content_.topics; }
  [[nodiscard]] const FileContent& content() override { return content_; }
  [[nodiscard]] bool has_checksums() const noexcept override { return index_.has_checksums; }

  void select(const std::vector<bool>& wanted, std::int64_t start, std::int64_t end) override {
    wanted_ = wanted;
    // Times before 1970 are in no MCAP file.
    start_ = static_cast<std::uint64_t>(std::max<std::int64_t>(start, 0));
    end_ = static_cast<std::uint64_t>(std::max<std::int64_t>(end, 0));
    is_empty_ = end < 0 || start > end;
    if (end == std::numeric_limits<std::int64_t>::max()) {
      end_ = std::numeric_limits<std::uint64_t>::max();
    }
    active_ = {};
    last_ = nullptr;
    sources_.clear();
    pending_.clear();
    next_pending_ = 0;
    if (is_empty_) {
      return;
    }
    for (std::size_t k = 0; k < index_.chunks.size(); ++k) {
      if (is_wanted(index_.chunks[k])) {
        pending_.push_back(k);
      }
    }
    std::stable_sort(pending_.begin(), pending_.end(), [this](std::size_t a, std::size_t b) {
      return index_.chunks[a].start_time < index_.chunks[b].start_time;
    });
    auto loose = std::make_unique<Source>();
    for (const LooseMessage& message : index_.loose) {
      if (is_wanted(message.channel) && message.log_time >= start_ && message.log_time <= end_) {
        loose->entries.push_back({message.log_time, message.offset, message.size});
      }
    }
    add_source(std::move(loose));
  }

  bool next(BagMessage& message) override {
    for (;;) {
      if (last_ != nullptr) {
        go_on_with(*std::exchange(last_, nullptr));
      }
      while (next_pending_ < pending_.size() &&
             (active_.empty() ||
              index_.chunks[pending_[next_pending_]].start_time <= active_.top().log_time)) {
        load(index_.chunks[pending_[next_pending_++]]);
      }
      if (active_.empty()) {
        return false;
      }
      last_ = active_.top().source;
      active_.pop();
      const Source::Entry& entry = last_->entries[last_->next];
      const auto record = read_message(content_of(*last_, entry));
      if (!record) {
        add_fault(BagError(BagFault::kIncomplete, file_.path(), entry.offset, "message",
                           "has become shorter while it was read"));
        continue;
      }
      message = {.topic = topics_.at(record->channel),
                 .log_time = signed_time(record->log_time),
                 .publish_time = signed_time(record->publish_time),
                 .data = record->data};
      if (const Ros1Message* converter = converters_[message.topic].get(); converter != nullptr) {
        if (!converter->to_cdr(record->data, cdr_)) {
          add_fault(BagError(BagFault::kMalformed, file_.path(), last_->place,
                             content_.topics[message.topic].name,
                             "a message does not fit its definition"));
          continue;
        }
        message.data = cdr_;
      }
      return true;
    }
  }

 private:
  struct Head {
    std::uint64_t log_time;
    std::uint64_t place;
    Source* source;
    /// For a queue that gives its largest element first.
    bool operator<(const Head& other) const {
      return std::pair(log_time, place) > std::pair(other.log_time, other.place);
    }
  };

  /// Turns a topic of ROS 1 into one of ROS 2; none, with a fault, where that cannot be: the topic
  /// keeps its encoding then.
  std::unique_ptr<Ros1Message> take_ros1(BagTopic& topic, const Channel& channel) {
    const std::string where = "channel of " + channel.topic + ": its messages are of ROS 1, and ";
    if (topic.schema_encoding != "ros1msg") {
      add_fault(
          BagError(BagFault::kUnsupported, file_.path(),
                   where + "their definition is '" + topic.schema_encoding + "', not ros1msg"));
      return nullptr;
    }
    try {
      auto converter = std::make_unique<Ros1Message>(topic.type, topic.schema_text);
      const auto latching = channel.metadata.find("latching");
      topic = ros2_topic(topic.name, topic.type, *converter,
                         latching != channel.metadata.end() && latching->second == "1");
      return converter;
    } catch (const std::invalid_argument& error) {
      add_fault(BagError(BagFault::kUnsupported, file_.path(),
                         where + "their definition cannot be used: " + error.what()));
      return nullptr;
    }
  }

  [[nodiscard]] bool is_wanted(std::uint16_t channel) const {
    const auto topic = topics_.find(channel);
    return topic != topics_.end() && wanted_[topic->second];
  }
  [[nodiscard]] bool is_wanted(const ChunkPlace& chunk) const {
    return chunk.start_time <= end_ && chunk.end_time >= start_ &&
           (!chunk.channels_known ||
            std::any_of(chunk.channels.begin(), chunk.channels.end(),
                        [this](std::uint16_t channel) { return is_wanted(channel); }));
  }

  ByteView content_of(const Source& source, const Source::Entry& entry) {
    if (source.records.empty()) {
      file_.read(entry.offset, entry.size, loose_);
      return loose_;
    }
    return std::span(source.records)
        .subspan(static_cast<std::size_t>(entry.offset), static_cast<std::size_t>(entry.size));
  }

  void add_source(std::unique_ptr<Source> source) {
    if (source->entries.empty()) {
      spare_ = std::move(source);
      return;
    }
    push(*source);
    sources_.emplace(source.get(), std::move(source));
  }

  void push(Source& source) {
    const auto& entry = source.entries[source.next];
    // Loose messages have places of their own.
    active_.push({entry.log_time, source.records.empty() ? entry.offset : source.place, &source});
  }

  void go_on_with(Source& source) {
    if (++source.next < source.entries.size()) {
      push(source);
    } else {
      const auto found = sources_.find(&source);
      spare_ = std::move(found->second);
      sources_.erase(found);
    }
  }

  void load(const ChunkPlace& place) {
    std::unique_ptr<Source> source = spare_ ? std::move(spare_) : std::make_unique<Source>();
    source->place = place.offset;
    source->entries.clear();
    source->next = 0;
    source->records.clear();
    std::vector<BagError> faults;
    file_.read(place.offset, place.length, raw_);
    ByteCursor cursor(raw_);
    const auto opcode = cursor.number<std::uint8_t>();
    const auto length = cursor.number<std::uint64_t>();
    const auto chunk = length && *opcode == static_cast<std::uint8_t>(Opcode::kChunk)
                           ? read_chunk(std::span(raw_).subspan(kPrefixSize))
                           : std::nullopt;
    if (!chunk) {
      faults.emplace_back(BagFault::kMalformed, file_.path(), place.offset, "chunk",
                          "is no chunk, though the summary says so");
    } else {
      if (!chunk->whole && faults_at(place.offset) == 0) {
        faults.emplace_back(BagFault::kIncomplete, file_.path(), place.offset, "chunk.records",
                            "is longer than the chunk");
      }
      unpack_chunk(file_, place.offset, *chunk, source->records, faults);
      list_messages(*source, place.offset, faults);
    }
    for (BagError& fault : faults) {
      tell(std::move(fault));
    }
    add_source(std::move(source));
  }

  void list_messages(Source& source, std::uint64_t offset, std::vector<BagError>& faults) {
    ByteCursor cursor(source.records);
    std::uint64_t last = 0;
    bool sorted = true;
    while (const auto record = take_record(cursor)) {
      if (record->opcode != Opcode::kMessage) {
        continue;
      }
      const auto message = read_message(record->content);
      if (!message || !topics_.contains(message->channel)) {
        faults.emplace_back(
            BagFault::kMalformed, file_.path(), offset, "message",
            message ? "its channel " + std::to_string(message->channel) + " is defined nowhere"
                    : "is too short");
        continue;
      }
      if (!is_wanted(message->channel) || message->log_time < start_ || message->log_time > end_) {
        continue;
      }
      sorted = sorted && message->log_time >= last;
      last = message->log_time;
      source.entries.push_back(
          {message->log_time, cursor.position() - record->content.size(), record->content.size()});
    }
    if (cursor.left() > 0) {
      faults.emplace_back(BagFault::kIncomplete, file_.path(), offset, "chunk.records",
                          "ends within a record");
    }
    if (!sorted) {
      std::stable_sort(source.entries.begin(), source.entries.end(),
                       [](const auto& a, const auto& b) { return a.log_time < b.log_time; });
    }
  }

  [[nodiscard]] std::ptrdiff_t faults_at(std::uint64_t offset) const {
    return std::count_if(faults().begin(), faults().end(),
                         [offset](const BagError& fault) { return fault.offset() == offset; });
  }

  /// A chunk that is read again has the same faults again.
  void tell(BagError fault) {
    const bool known = std::any_of(faults().begin(), faults().end(), [&](const BagError& other) {
      return other.offset() == fault.offset() && std::string(other.what()) == fault.what();
    });
    if (!known) {
      add_fault(std::move(fault));
    }
  }

  InputFile file_;
  FileIndex index_;
  FileContent content_;
  std::unordered_map<std::uint16_t, TopicIndex> topics_;
  std::vector<std::unique_ptr<Ros1Message>> converters_;  ///< by topic; none: taken as it is

  std::vector<bool> wanted_;
  std::uint64_t start_ = 0;
  std::uint64_t end_ = 0;
  bool is_empty_ = false;
  std::vector<std::size_t> pending_;  ///< chunks by their start
  std::size_t next_pending_ = 0;
  std::priority_queue<Head> active_;
  std::unordered_map<Source*, std::unique_ptr<Source>> sources_;
  Source* last_ = nullptr;         ///< whose message was handed out last
  std::unique_ptr<Source> spare_;  ///< kept for its memory
  Bytes raw_;
  Bytes loose_;
  Bytes cdr_;
};

}  // namespace

std::unique_ptr<FileReader> open_mcap(const std::filesystem::path& path) {
  return std::make_unique<McapReader>(path);
}

}  // namespace pipescout::bags
