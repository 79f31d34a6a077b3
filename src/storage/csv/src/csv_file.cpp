// SPDX-License-Identifier: Apache-2.0
#include "pipescout/csv/csv_file.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <ios>
#include <system_error>

#include "pipescout/csv/csv_table.hpp"
#include "pipescout/csv/utf8.hpp"

namespace pipescout {
namespace {

void check_encoding(const std::string& text, const std::string& path) {
  if (text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF")) {
    throw CsvError(path, 0, "is UTF-16; save it as UTF-8");
  }
  const std::size_t at = first_byte_not_utf8(text);
  if (at == std::string_view::npos) {
    return;
  }
  const auto byte = static_cast<unsigned char>(text[at]);
  std::array<char, 2> digits{'0', '0'};
  std::to_chars(digits.data(), digits.data() + digits.size(), byte, 16);
  const auto lines = std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), '\n');
  throw CsvError(path, 1 + static_cast<std::size_t>(lines),
                 "is not UTF-8: byte 0x" + std::string(digits.begin(), digits.end()) +
                     "; save it as UTF-8, for example with iconv -f WINDOWS-1252 -t UTF-8");
}

}  // namespace

std::string read_csv_text(const std::string& path) {
  // Asked first: opening a pipe would wait for its writer.
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) {
    throw CsvError(path, 0, std::make_error_code(std::errc::no_such_file_or_directory).message());
  }
  if (!std::filesystem::is_regular_file(status)) {
    throw CsvError(path, 0, "is not a regular file");
  }
  const auto size = std::filesystem::file_size(path, error);
  if (error) {
    throw CsvError(path, 0, error.message());
  }
  if (size > kMaxCsvFileSize) {
    throw CsvError(path, 0, "is larger than " + std::to_string(kMaxCsvFileSize) + " bytes");
  }
  std::ifstream file(path, std::ios::binary);
  std::string text(static_cast<std::size_t>(size), '\0');
  if (!file || !file.read(text.data(), static_cast<std::streamsize>(text.size()))) {
    throw CsvError(path, 0, "cannot be read");
  }
  check_encoding(text, path);
  return text;
}

}  // namespace pipescout
