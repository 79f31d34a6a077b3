// SPDX-License-Identifier: Apache-2.0
#include "sqlite_database.hpp"

#include <sys/resource.h>

#include <cctype>
#include <cerrno>
#include <string_view>
#include <system_error>
#include <utility>

#include "file_access.hpp"
#include "pipescout/bags/bag_error.hpp"

namespace pipescout::bags {
namespace {

/// Endings of the files that SQLite keeps beside a database
/// (https://www.sqlite.org/tempfiles.html).
constexpr const char* kJournal = "-journal";
constexpr const char* kWal = "-wal";
constexpr const char* kSharedMemory = "-shm";

/// Bytes; none where there is no such file.
std::optional<std::uintmax_t> size_beside(const std::filesystem::path& path, const char* ending) {
  std::error_code error;
  const auto size = std::filesystem::file_size(path.string() + ending, error);
  return error ? std::nullopt : std::optional(size);
}

/// Whether the header says that changes go to a -wal
/// (https://www.sqlite.org/fileformat2.html#file_format_version_numbers).
bool asks_for_wal(const std::filesystem::path& path) {
  constexpr std::uint64_t kReadVersion = 19;
  constexpr std::byte kWalVersion{2};
  Bytes version;
  InputFile(path).read(kReadVersion, 1, version);
  return !version.empty() && version.front() == kWalVersion;
}

/// https://www.sqlite.org/uri.html
std::string uri(const std::filesystem::path& path, const std::string& parameter) {
  constexpr std::string_view kHex = "0123456789ABCDEF";
  std::string result = "file://";
  for (const char c : std::filesystem::absolute(path).string()) {
    const auto byte = static_cast<unsigned char>(c);
    if (std::isalnum(byte) != 0 || c == '/' || c == '.' || c == '_' || c == '-') {
      result += c;
    } else {
      result += {'%', kHex[byte >> 4U], kHex[byte & 0xFU]};
    }
  }
  return result + "?" + parameter;
}

/// Whether the file has reached the largest size that this process may write.
bool is_at_size_limit(const std::filesystem::path& path) {
  rlimit limit{};
  std::error_code error;
  const auto size = std::filesystem::file_size(path, error);
  constexpr std::uintmax_t kLargestPage = 65536;
  return !error && ::getrlimit(RLIMIT_FSIZE, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY &&
         size + kLargestPage > limit.rlim_cur;
}

}  // namespace

bool has_journal(const std::filesystem::path& path) {
  // TRUNCATE leaves an empty one.
  return size_beside(path, kJournal).value_or(0) > 0 || size_beside(path, kWal).value_or(0) > 0;
}

SqliteDatabase::SqliteDatabase(std::filesystem::path path, Mode mode) : path_(std::move(path)) {
  if (mode == Mode::kNew) {
    open(path_.string(), SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE);
  } else {
    open_to_read();
  }
}

void SqliteDatabase::open_to_read() {
  const auto wal = size_beside(path_, kWal);
  if (wal && size_beside(path_, kSharedMemory)) {
    // The index of a writer that lives, or one in memory.
    open(uri(path_, "readonly_shm=1"), SQLITE_OPEN_READONLY | SQLITE_OPEN_URI);
    if (can_be_read()) {
      return;
    }
  } else if (wal.value_or(0) == 0 && asks_for_wal(path_)) {
    // Complete, and nobody writes it. SQLite would make a -wal and a -shm to read it.
    open(uri(path_, "immutable=1"), SQLITE_OPEN_READONLY | SQLITE_OPEN_URI);
    return;
  } else if (wal.value_or(0) == 0) {
    open(path_.string(), SQLITE_OPEN_READONLY);
    if (can_be_read()) {
      return;
    }
  }
  open_copy();
}

bool SqliteDatabase::can_be_read() const {
  const int result =
      sqlite3_exec(handle_.get(), "SELECT COUNT(*) FROM sqlite_master", nullptr, nullptr, nullptr);
  if (result == SQLITE_OK) {
    return true;
  }
  if ((result & 0xff) == SQLITE_READONLY || (result & 0xff) == SQLITE_CANTOPEN) {
    return false;
  }
  fail("cannot be read");
}

void SqliteDatabase::open_copy() {
  std::filesystem::path copy;
  try {
    copy_folder_.emplace();
    copy = copy_folder_->path() / path_.filename();
    std::filesystem::copy_file(path_, copy);
    for (const char* ending : {kJournal, kWal}) {
      if (size_beside(path_, ending)) {
        std::filesystem::copy_file(path_.string() + ending, copy.string() + ending);
      }
    }
  } catch (const std::system_error& error) {
    throw_system_error(error.code().value(), path_,
                       "its writer was interrupted, and it cannot be copied to " +
                           std::filesystem::temp_directory_path().string() + " to be completed");
  }
  // The copy of a file that is write-protected.
  std::error_code ignored;
  for (const char* ending : {"", kJournal, kWal}) {
    std::filesystem::permissions(copy.string() + ending, std::filesystem::perms::owner_write,
                                 std::filesystem::perm_options::add, ignored);
  }
  open(copy.string(), SQLITE_OPEN_READWRITE);
}

void SqliteDatabase::open(const std::string& name, int flags) {
  sqlite3* handle = nullptr;
  const int result = sqlite3_open_v2(name.c_str(), &handle, flags | SQLITE_OPEN_NOMUTEX, nullptr);
  handle_.reset(handle);
  if (result != SQLITE_OK) {
    if (handle == nullptr) {
      throw std::bad_alloc();
    }
    fail("cannot be opened");
  }
  // A file from elsewhere runs no code of its own.
  sqlite3_db_config(handle, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
  sqlite3_db_config(handle, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
  // What lies in a -wal stays there.
  sqlite3_db_config(handle, SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, 1, nullptr);
  constexpr int kWait = 2000;  // ms, for a recorder that commits just now
  sqlite3_busy_timeout(handle, kWait);
}

void SqliteDatabase::fail(const std::string& what) const {
  const int code = sqlite3_errcode(handle_.get());
  const int error = sqlite3_system_errno(handle_.get());
  BagFault fault = BagFault::kSystem;
  std::string reason = sqlite3_errmsg(handle_.get());
  switch (code & 0xff) {
    case SQLITE_FULL:
      fault = BagFault::kNoSpace;
      break;
    case SQLITE_IOERR:
      // SQLite does not keep what its own calls said of writing beyond the largest size allowed.
      if (error == ENOSPC || error == EFBIG || error == EDQUOT || is_at_size_limit(path_)) {
        fault = BagFault::kNoSpace;
      }
      if (error != 0) {
        reason += ", " + std::generic_category().message(error);
      }
      break;
    case SQLITE_CORRUPT:
    case SQLITE_NOTADB:
    case SQLITE_ERROR:
      fault = BagFault::kMalformed;
      break;
    default:
      break;
  }
  throw BagError(fault, path_, what + ": " + reason);
}

void SqliteDatabase::execute(const std::string& sql) {
  if (sqlite3_exec(handle_.get(), sql.c_str(), nullptr, nullptr, nullptr) != SQLITE_OK) {
    fail(sql.substr(0, sql.find('(')));
  }
}

std::int64_t SqliteDatabase::number(const std::string& sql) {
  SqliteStatement statement(*this, sql);
  return statement.step() ? statement.number(0) : 0;
}

bool SqliteDatabase::has_table(const std::string& name) {
  return number("SELECT COUNT(*) FROM sqlite_master WHERE type = 'table' AND name = '" + name +
                "'") > 0;
}

bool SqliteDatabase::has_column(const std::string& table, const std::string& column) {
  return number("SELECT COUNT(*) FROM pragma_table_info('" + table + "') WHERE name = '" + column +
                "'") > 0;
}

void SqliteDatabase::close() {
  if (sqlite3_close(handle_.get()) != SQLITE_OK) {
    fail("cannot be closed");
  }
  (void)handle_.release();
}

SqliteStatement::SqliteStatement(SqliteDatabase& database, const std::string& sql)
    : database_(database) {
  sqlite3_stmt* statement = nullptr;
  if (sqlite3_prepare_v2(database.handle(), sql.c_str(), -1, &statement, nullptr) != SQLITE_OK) {
    database.fail("cannot be asked");
  }
  statement_.reset(statement);
}

void SqliteStatement::bind(int parameter, std::int64_t value) {
  if (sqlite3_bind_int64(statement_.get(), parameter, value) != SQLITE_OK) {
    database_.fail("a number does not fit");
  }
}

void SqliteStatement::bind(int parameter, std::string_view text) {
  if (sqlite3_bind_text64(statement_.get(), parameter, text.data(), text.size(), SQLITE_STATIC,
                          SQLITE_UTF8) != SQLITE_OK) {
    database_.fail("a text does not fit");
  }
}

void SqliteStatement::bind(int parameter, ByteView blob) {
  // A null pointer would be bound as NULL, which the table refuses.
  const void* data = blob.empty() ? "" : static_cast<const void*>(blob.data());
  if (sqlite3_bind_blob64(statement_.get(), parameter, data, blob.size(), SQLITE_STATIC) !=
      SQLITE_OK) {
    database_.fail("a message does not fit");
  }
}

bool SqliteStatement::step() {
  const int result = sqlite3_step(statement_.get());
  if (result == SQLITE_ROW) {
    return true;
  }
  if (result != SQLITE_DONE) {
    database_.fail("cannot go on");
  }
  return false;
}

void SqliteStatement::reset() noexcept {
  sqlite3_reset(statement_.get());
}

std::int64_t SqliteStatement::number(int column) const noexcept {
  return sqlite3_column_int64(statement_.get(), column);
}

std::string SqliteStatement::text(int column) const {
  const auto* text = sqlite3_column_text(statement_.get(), column);
  const auto size = static_cast<std::size_t>(sqlite3_column_bytes(statement_.get(), column));
  return text == nullptr ? std::string() : std::string(reinterpret_cast<const char*>(text), size);
}

ByteView SqliteStatement::blob(int column) const noexcept {
  const auto* data = static_cast<const std::byte*>(sqlite3_column_blob(statement_.get(), column));
  const auto size = static_cast<std::size_t>(sqlite3_column_bytes(statement_.get(), column));
  return data == nullptr ? ByteView() : ByteView(data, size);
}

}  // namespace pipescout::bags
