// SPDX-License-Identifier: Apache-2.0
#include "sqlite.hpp"

#include <sqlite3.h>

#include <cmath>
#include <limits>

#include "pipescout/leak_store/leak_store.hpp"

namespace pipescout {

Database::Database(const std::filesystem::path& file) : name_(file.string()) {
  const int code = ::sqlite3_open_v2(file.c_str(), &handle_,
                                     SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, nullptr);
  if (code != SQLITE_OK) {
    const std::string why = handle_ == nullptr ? "no memory" : ::sqlite3_errmsg(handle_);
    ::sqlite3_close(handle_);
    throw LeakStoreError(name_ + ": " + why);
  }
  ::sqlite3_busy_timeout(handle_, 5000);
}

Database::~Database() {
  ::sqlite3_close(handle_);
}

void Database::execute(const char* sql) const {
  if (::sqlite3_exec(handle_, sql, nullptr, nullptr, nullptr) != SQLITE_OK) {
    fail(::sqlite3_errmsg(handle_));
  }
}

void Database::fail(const std::string& what) const {
  throw LeakStoreError(name_ + ": " + what);
}

Statement::Statement(const Database& database, std::string_view sql) : database_(database) {
  check(::sqlite3_prepare_v2(database.get(), sql.data(), static_cast<int>(sql.size()), &handle_,
                             nullptr));
}

Statement::~Statement() {
  ::sqlite3_finalize(handle_);
}

void Statement::check(int code) const {
  if (code != SQLITE_OK) {
    database_.fail(::sqlite3_errmsg(database_.get()));
  }
}

Statement& Statement::bind(double value) {
  ++parameter_;
  check(std::isfinite(value) ? ::sqlite3_bind_double(handle_, parameter_, value)
                             : ::sqlite3_bind_null(handle_, parameter_));
  return *this;
}

Statement& Statement::bind(std::int64_t value) {
  check(::sqlite3_bind_int64(handle_, ++parameter_, value));
  return *this;
}

Statement& Statement::bind(std::string_view value) {
  check(::sqlite3_bind_text(handle_, ++parameter_, value.data(), static_cast<int>(value.size()),
                            SQLITE_TRANSIENT));
  return *this;
}

Statement& Statement::bind(std::span<const std::uint8_t> value) {
  check(::sqlite3_bind_blob64(handle_, ++parameter_, value.data(), value.size(), SQLITE_TRANSIENT));
  return *this;
}

bool Statement::step() {
  column_ = 0;
  const int code = ::sqlite3_step(handle_);
  if (code != SQLITE_ROW && code != SQLITE_DONE) {
    check(code);
  }
  return code == SQLITE_ROW;
}

void Statement::run() {
  while (step()) {
  }
}

double Statement::number() {
  const int column = column_++;
  return ::sqlite3_column_type(handle_, column) == SQLITE_NULL
             ? std::numeric_limits<double>::quiet_NaN()
             : ::sqlite3_column_double(handle_, column);
}

std::int64_t Statement::integer() {
  return ::sqlite3_column_int64(handle_, column_++);
}

std::string Statement::text() {
  const int column = column_++;
  const auto* data = reinterpret_cast<const char*>(::sqlite3_column_text(handle_, column));
  const auto size = static_cast<std::size_t>(::sqlite3_column_bytes(handle_, column));
  return data == nullptr ? std::string() : std::string(data, size);
}

std::vector<std::uint8_t> Statement::blob() {
  const int column = column_++;
  const auto* data = static_cast<const std::uint8_t*>(::sqlite3_column_blob(handle_, column));
  const auto size = static_cast<std::size_t>(::sqlite3_column_bytes(handle_, column));
  return data == nullptr ? std::vector<std::uint8_t>()
                         : std::vector<std::uint8_t>(data, data + size);
}

Transaction::Transaction(const Database& database) : database_(database) {
  database_.execute("BEGIN IMMEDIATE");
}

Transaction::~Transaction() {
  if (open_) {
    ::sqlite3_exec(database_.get(), "ROLLBACK", nullptr, nullptr, nullptr);
  }
}

void Transaction::commit() {
  database_.execute("COMMIT");
  open_ = false;
}

}  // namespace pipescout
