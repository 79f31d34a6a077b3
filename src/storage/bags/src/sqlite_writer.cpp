// SPDX-License-Identifier: Apache-2.0
#include <optional>
#include <vector>

#include "file_access.hpp"
#include "sqlite_database.hpp"
#include "storage_file.hpp"

namespace pipescout::bags {
namespace {

/// Of Humble.
constexpr int kSchemaVersion = 3;
constexpr int kMetadataVersion = 5;

class SqliteWriter : public FileWriter {
 public:
  SqliteWriter(const std::filesystem::path& path, const BagWriterOptions& options)
      : database_(make_new(path), SqliteDatabase::Mode::kNew) {
    // Pages that are new to the file are in no journal, so a rollback journal costs next to nothing
    // where rows are only added; a write-ahead log writes everything twice. What a process has
    // written outlives it without waiting for the disk.
    database_.execute("PRAGMA journal_mode = TRUNCATE");
    database_.execute("PRAGMA synchronous = OFF");
    database_.execute("PRAGMA cache_size = -" + std::to_string(options.cache_size / 1024));
    database_.execute(
        "BEGIN;"
        "CREATE TABLE schema(schema_version INTEGER PRIMARY KEY,ros_distro TEXT NOT NULL);"
        "CREATE TABLE metadata(id INTEGER PRIMARY KEY,metadata_version INTEGER NOT NULL,"
        "metadata TEXT NOT NULL);"
        "CREATE TABLE topics(id INTEGER PRIMARY KEY,name TEXT NOT NULL,type TEXT NOT NULL,"
        "serialization_format TEXT NOT NULL,offered_qos_profiles TEXT NOT NULL);"
        "CREATE TABLE messages(id INTEGER PRIMARY KEY,topic_id INTEGER NOT NULL,"
        "timestamp INTEGER NOT NULL, data BLOB NOT NULL);"
        "CREATE INDEX timestamp_idx ON messages (timestamp ASC);"
        "INSERT INTO schema VALUES (" +
        std::to_string(kSchemaVersion) + ", 'humble'); COMMIT");
    insert_.emplace(database_, "INSERT INTO messages (timestamp, topic_id, data) VALUES (?, ?, ?)");
    page_size_ = static_cast<std::uint64_t>(database_.number("PRAGMA page_size"));
    measure();
  }

  void add_topic(const BagTopic& topic) override {
    begin();
    SqliteStatement insert(database_,
                           "INSERT INTO topics (name, type, serialization_format, "
                           "offered_qos_profiles) VALUES (?, ?, ?, ?)");
    insert.bind(1, topic.name);
    insert.bind(2, topic.type);
    insert.bind(3, topic.serialization_format);
    insert.bind(4, topic.offered_qos_profiles);
    insert.step();
    rows_.push_back(sqlite3_last_insert_rowid(database_.handle()));
    commit();
  }

  void write(const BagMessage& message) override {
    begin();
    insert_->bind(1, message.log_time);
    insert_->bind(2, rows_[message.topic]);
    insert_->bind(3, message.data);
    try {
      insert_->step();
    } catch (...) {
      insert_->reset();
      throw;
    }
    insert_->reset();
    // A row, its entry in the index, the pages that hold it.
    constexpr std::uint64_t kRow = 48;
    size_ += message.data.size() + message.data.size() / 512 + kRow;
  }

  [[nodiscard]] std::uint64_t size() const override { return size_; }

  void flush() override { commit(); }

  void close(const std::string& metadata) override {
    try {
      if (failed_transaction()) {
        // What was in it is lost; with what was committed before the file is whole.
        sqlite3_exec(database_.handle(), "ROLLBACK", nullptr, nullptr, nullptr);
        active_ = false;
      }
      commit();
      begin();
      {
        SqliteStatement insert(database_,
                               "INSERT INTO metadata (metadata_version, metadata) VALUES (?, ?)");
        insert.bind(1, std::int64_t{kMetadataVersion});
        insert.bind(2, metadata);
        insert.step();
      }
      commit();
    } catch (const BagError&) {
      sqlite3_exec(database_.handle(), "ROLLBACK", nullptr, nullptr, nullptr);
      insert_.reset();
      database_.close();
      throw;
    }
    insert_.reset();
    database_.close();
  }

 private:
  /// SQLite would take any file for a database that is to be continued.
  static const std::filesystem::path& make_new(const std::filesystem::path& path) {
    const OutputFile file(path);
    return path;
  }

  void begin() {
    if (!active_) {
      database_.execute("BEGIN");
      active_ = true;
    }
  }
  void commit() {
    if (active_) {
      database_.execute("COMMIT");
      active_ = false;
      measure();
    }
  }
  /// SQLite takes a transaction back by itself after some errors.
  [[nodiscard]] bool failed_transaction() const {
    return active_ && sqlite3_get_autocommit(database_.handle()) != 0;
  }
  void measure() {
    size_ = page_size_ * static_cast<std::uint64_t>(database_.number("PRAGMA page_count"));
  }

  SqliteDatabase database_;
  std::optional<SqliteStatement> insert_;
  std::vector<std::int64_t> rows_;  ///< of the topics
  std::uint64_t page_size_ = 0;
  std::uint64_t size_ = 0;
  bool active_ = false;
};

}  // namespace

std::unique_ptr<FileWriter> make_sqlite_writer(const std::filesystem::path& path,
                                               const BagWriterOptions& options) {
  return std::make_unique<SqliteWriter>(path, options);
}

}  // namespace pipescout::bags
