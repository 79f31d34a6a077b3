// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <limits>
#include <memory>
#include <optional>
#include <unordered_map>
#include <utility>

#include "file_access.hpp"
#include "pipescout/bags/bag_metadata.hpp"
#include "sqlite_database.hpp"
#include "sqlite_pages.hpp"
#include "storage_file.hpp"

namespace pipescout::bags {
namespace {

class SqliteReader : public FileReader {
 public:
  explicit SqliteReader(const std::filesystem::path& path) : file_(path) {
    try {
      check_header();
      database_ = std::make_unique<SqliteDatabase>(path, SqliteDatabase::Mode::kRead);
      read_topics();
    } catch (const BagError& error) {
      if (error.fault() == BagFault::kUnsupported) {
        throw;
      }
      // Throws when even that is of no use.
      read_pages(error);
    }
    select(std::vector<bool>(content_.topics.size(), true),
           std::numeric_limits<std::int64_t>::min(), std::numeric_limits<std::int64_t>::max());
  }

  [[nodiscard]] const std::vector<BagTopic>& topics() const override { return content_.topics; }
  [[nodiscard]] bool has_checksums() const noexcept override { return false; }

  [[nodiscard]] const FileContent& content() override {
    if (!counted_) {
      content_.counts.assign(content_.topics.size(), 0);
      if (!pages_) {
        try {
          count_rows();
        } catch (const BagError& error) {
          read_pages(error);
        }
      }
      if (pages_) {
        count_pages();
      }
      counted_ = true;
    }
    return content_;
  }

  void select(const std::vector<bool>& wanted, std::int64_t start, std::int64_t end) override {
    wanted_ = wanted;
    start_ = start;
    end_ = end;
    last_.reset();
    next_row_ = 0;
    query_.reset();
    if (!pages_) {
      try {
        prepare();
      } catch (const BagError& error) {
        read_pages(error);
      }
    }
  }

  bool next(BagMessage& message) override {
    if (!pages_) {
      try {
        return next_from_query(message);
      } catch (const BagError& error) {
        read_pages(error);
      }
    }
    return next_from_pages(message);
  }

 private:
  /// SQLite itself takes the missing end of the last page for zeros.
  void check_header() const {
    Bytes header;
    constexpr std::uint64_t kDatabaseHeaderSize = 100;
    file_.read(0, kDatabaseHeaderSize, header);
    if (header.size() < kDatabaseHeaderSize) {
      throw BagError(BagFault::kIncomplete, file_.path(), header.size(), "header", "is cut");
    }
    // With a journal the file is completed first.
    const std::uint64_t size = SqlitePages::size_by_header(header);
    if (size > file_.size() && !has_journal(file_.path())) {
      throw BagError(BagFault::kIncomplete, file_.path(), file_.size(), "database",
                     "is cut: it had " + std::to_string(size) + " bytes");
    }
  }

  void read_topics() {
    for (const char* table : {"topics", "messages"}) {
      if (!database_->has_table(table)) {
        throw BagError(BagFault::kMalformed, file_.path(),
                       std::string("has no table '") + table + "': it is no bag");
      }
    }
    const auto text_or = [&](const char* column, const char* otherwise) {
      return database_->has_column("topics", column) ? std::string(column) : otherwise;
    };
    SqliteStatement query(
        *database_, "SELECT id, name, type, " + text_or("serialization_format", "'cdr'") + ", " +
                        text_or("offered_qos_profiles", "''") + ", " +
                        text_or("type_description_hash", "''") + " FROM topics ORDER BY id");
    while (query.step()) {
      add_topic(query.number(0), {.name = query.text(1),
                                  .type = query.text(2),
                                  .serialization_format = query.text(3),
                                  .offered_qos_profiles = humble_qos_profiles(query.text(4)),
                                  .type_description_hash = query.text(5)});
    }
    if (database_->has_table("message_definitions")) {
      SqliteStatement definitions(
          *database_,
          "SELECT topic_type, encoding, encoded_message_definition FROM message_definitions");
      while (definitions.step()) {
        const std::string type = definitions.text(0);
        for (BagTopic& topic : content_.topics) {
          if (topic.type == type) {
            topic.schema_encoding = definitions.text(1);
            topic.schema_text = definitions.text(2);
          }
        }
      }
    }
  }

  void add_topic(std::int64_t id, BagTopic topic) {
    if (indexes_.try_emplace(id, static_cast<TopicIndex>(content_.topics.size())).second) {
      ids_.push_back(id);
      content_.topics.push_back(std::move(topic));
    }
  }

  void count_rows() {
    SqliteStatement query(*database_,
                          "SELECT topic_id, COUNT(*), MIN(timestamp), MAX(timestamp) FROM messages "
                          "GROUP BY topic_id");
    while (query.step()) {
      const auto topic = indexes_.find(query.number(0));
      if (topic == indexes_.end()) {
        add_fault(unknown_topic(query.number(0)));
        continue;
      }
      const auto count = static_cast<std::uint64_t>(query.number(1));
      add_count(topic->second, count, query.number(2), query.number(3));
    }
  }

  void count_pages() {
    content_.messages = 0;
    content_.counts.assign(content_.topics.size(), 0);
    for (const auto& row : pages_->rows()) {
      if (const auto topic = indexes_.find(row.topic); topic != indexes_.end()) {
        add_count(topic->second, 1, row.time, row.time);
      }
    }
  }

  void add_count(TopicIndex topic, std::uint64_t count, std::int64_t start, std::int64_t end) {
    content_.start = content_.messages == 0 ? start : std::min(content_.start, start);
    content_.end = content_.messages == 0 ? end : std::max(content_.end, end);
    content_.counts[topic] += count;
    content_.messages += count;
  }

  [[nodiscard]] BagError unknown_topic(std::int64_t id) const {
    return {BagFault::kMalformed, file_.path(),
            "messages of topic_id " + std::to_string(id) + ", which no row of 'topics' has"};
  }

  void prepare() {
    std::string topics;
    for (std::size_t k = 0; k < wanted_.size(); ++k) {
      if (wanted_[k]) {
        topics += (topics.empty() ? "" : ",") + std::to_string(ids_[k]);
      }
    }
    // A scan along the index of times: rows of equal times come by their id.
    const bool all = std::find(wanted_.begin(), wanted_.end(), false) == wanted_.end();
    query_.emplace(*database_,
                   "SELECT id, topic_id, timestamp, data FROM messages WHERE "
                   "timestamp BETWEEN ? AND ?" +
                       (all ? "" : " AND topic_id IN (" + topics + ")") +
                       " ORDER BY timestamp, id");
    query_->bind(1, start_);
    query_->bind(2, end_);
  }

  bool next_from_query(BagMessage& message) {
    while (query_ && query_->step()) {
      const auto topic = indexes_.find(query_->number(1));
      if (topic == indexes_.end()) {
        continue;
      }
      last_ = std::pair(query_->number(2), query_->number(0));
      message = {.topic = topic->second,
                 .log_time = last_->first,
                 .publish_time = last_->first,
                 .data = query_->blob(3)};
      return true;
    }
    query_.reset();
    return false;
  }

  /// SQLite gave up: the rows are taken from the pages.
  void read_pages(const BagError& error) {
    query_.reset();
    pages_ = std::make_unique<SqlitePages>(file_);
    if (content_.topics.empty()) {
      for (const auto& [id, topic] : pages_->topics()) {
        add_topic(id, topic);
      }
      wanted_.resize(content_.topics.size(), true);
    }
    if (content_.topics.empty()) {
      throw error;
    }
    add_fault(error);
    counted_ = false;
  }

  bool next_from_pages(BagMessage& message) {
    const auto& rows = pages_->rows();
    if (next_row_ == 0) {
      next_row_ = static_cast<std::size_t>(
          std::lower_bound(rows.begin(), rows.end(), start_,
                           [](const auto& row, std::int64_t start) { return row.time < start; }) -
          rows.begin());
    }
    while (next_row_ < rows.size()) {
      const auto& row = rows[next_row_++];
      if (row.time > end_) {
        next_row_ = rows.size();
        break;
      }
      const auto topic = indexes_.find(row.topic);
      if (topic == indexes_.end() || !wanted_[topic->second] ||
          (last_ && std::pair(row.time, row.id) <= *last_) || !pages_->read(row, blob_)) {
        continue;
      }
      message = {
          .topic = topic->second, .log_time = row.time, .publish_time = row.time, .data = blob_};
      return true;
    }
    return false;
  }

  InputFile file_;
  std::unique_ptr<SqliteDatabase> database_;
  std::unique_ptr<SqlitePages> pages_;  ///< where SQLite cannot read the file
  FileContent content_;
  bool counted_ = false;
  std::unordered_map<std::int64_t, TopicIndex> indexes_;
  std::vector<std::int64_t> ids_;  ///< by topic

  std::vector<bool> wanted_;
  std::int64_t start_ = 0;
  std::int64_t end_ = 0;
  std::optional<SqliteStatement> query_;
  std::optional<std::pair<std::int64_t, std::int64_t>> last_;  ///< time and id of the last message
  std::size_t next_row_ = 0;
  Bytes blob_;
};

}  // namespace

std::unique_ptr<FileReader> open_sqlite(const std::filesystem::path& path) {
  return std::make_unique<SqliteReader>(path);
}

}  // namespace pipescout::bags
