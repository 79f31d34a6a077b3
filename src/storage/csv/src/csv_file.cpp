// SPDX-License-Identifier: Apache-2.0
#include "pipescout/csv/csv_file.hpp"

#include <cstddef>
#include <filesystem>
#include <fstream>
#include <ios>
#include <system_error>

#include "pipescout/csv/csv_reader.hpp"

namespace pipescout {
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
  return text;
}

}  // namespace pipescout
