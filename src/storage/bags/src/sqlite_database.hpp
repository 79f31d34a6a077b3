// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sqlite3.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "bytes.hpp"
#include "pipescout/files/temporary_folder.hpp"

namespace pipescout::bags {

/// Whether a journal lies beside the file: its last writer was killed or still writes, and the
/// content is that of the file rolled back or forward.
[[nodiscard]] bool has_journal(const std::filesystem::path& path);

/// An open SQLite database. Throws BagError naming its file.
class SqliteDatabase {
 public:
  /// kRead: nothing changes, neither the file nor what lies beside it, and no file appears there. A
  /// database whose writer was killed is completed in a copy among the temporary files.
  enum class Mode : std::uint8_t { kNew, kRead };
  SqliteDatabase(std::filesystem::path path, Mode mode);
  ~SqliteDatabase() = default;
  SqliteDatabase(const SqliteDatabase&) = delete;
  SqliteDatabase& operator=(const SqliteDatabase&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const noexcept { return path_; }
  [[nodiscard]] sqlite3* handle() const noexcept { return handle_.get(); }
  void execute(const std::string& sql);
  /// The first number that a query gives; 0 without any.
  [[nodiscard]] std::int64_t number(const std::string& sql);
  [[nodiscard]] bool has_table(const std::string& name);
  [[nodiscard]] bool has_column(const std::string& table, const std::string& column);
  /// Throws what SQLite's last error means.
  [[noreturn]] void fail(const std::string& what) const;
  /// Closes it; the destructor does so too, but loses the error.
  void close();

 private:
  struct Close {
    void operator()(sqlite3* handle) const noexcept { sqlite3_close_v2(handle); }
  };

  void open(const std::string& name, int flags);
  void open_to_read();
  /// False where SQLite would have to write first.
  [[nodiscard]] bool can_be_read() const;
  void open_copy();

  std::filesystem::path path_;
  std::optional<TemporaryFolder> copy_folder_;
  std::unique_ptr<sqlite3, Close> handle_;
};

/// A prepared statement; its database must live longer.
class SqliteStatement {
 public:
  SqliteStatement(SqliteDatabase& database, const std::string& sql);

  /// Parameters count from 1. Texts and blobs must live until `reset`.
  void bind(int parameter, std::int64_t value);
  void bind(int parameter, std::string_view text);
  void bind(int parameter, ByteView blob);
  /// Goes to the next row; false behind the last one.
  bool step();
  void reset() noexcept;

  /// Columns count from 0; valid until the next step.
  [[nodiscard]] std::int64_t number(int column) const noexcept;
  [[nodiscard]] std::string text(int column) const;
  [[nodiscard]] ByteView blob(int column) const noexcept;

 private:
  struct Finalize {
    void operator()(sqlite3_stmt* statement) const noexcept { sqlite3_finalize(statement); }
  };
  SqliteDatabase& database_;
  std::unique_ptr<sqlite3_stmt, Finalize> statement_;
};

}  // namespace pipescout::bags
