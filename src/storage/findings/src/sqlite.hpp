// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

struct sqlite3;
struct sqlite3_stmt;

/// SQLite's handles as values. Errors are LeakStoreError, naming the file.
namespace pipescout {

class Database {
 public:
  explicit Database(const std::filesystem::path& file);
  ~Database();
  Database(const Database&) = delete;
  Database& operator=(const Database&) = delete;

  void execute(const char* sql) const;
  [[noreturn]] void fail(const std::string& what) const;
  [[nodiscard]] sqlite3* get() const noexcept { return handle_; }

 private:
  std::string name_;
  sqlite3* handle_ = nullptr;
};

class Statement {
 public:
  Statement(const Database& database, std::string_view sql);
  ~Statement();
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;

  /// The next parameter; NaN and infinity become NULL.
  Statement& bind(double value);
  Statement& bind(std::int64_t value);
  Statement& bind(std::string_view value);
  Statement& bind(std::span<const std::uint8_t> value);

  /// Whether there is a row.
  [[nodiscard]] bool step();
  /// For what gives no rows.
  void run();

  /// The next column of the row; NaN for NULL.
  [[nodiscard]] double number();
  [[nodiscard]] std::int64_t integer();
  [[nodiscard]] std::string text();
  [[nodiscard]] std::vector<std::uint8_t> blob();

 private:
  void check(int code) const;

  const Database& database_;
  sqlite3_stmt* handle_ = nullptr;
  int parameter_ = 0;
  int column_ = 0;
};

/// Rolled back unless it is committed.
class Transaction {
 public:
  explicit Transaction(const Database& database);
  ~Transaction();
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;
  void commit();

 private:
  const Database& database_;
  bool open_ = true;
};

}  // namespace pipescout
