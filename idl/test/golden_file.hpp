// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

/// Reader of the files in golden/, whose README describes them.
namespace pipescout::testing {

struct GoldenMessage {
  std::string type;
  std::string kind;  ///< "default" or "filled"
  std::vector<std::byte> cdr;
  std::string yaml;  ///< as `topic echo` prints it
  std::string csv;   ///< as `topic echo --csv` does
};

inline std::vector<GoldenMessage> read_golden_file(const std::filesystem::path& file) {
  std::vector<GoldenMessage> messages;
  std::ifstream stream(file);
  for (std::string line; std::getline(stream, line);) {
    const auto space = std::min(line.find(' '), line.size());
    const auto word = line.substr(0, space);
    const auto rest = space < line.size() ? line.substr(space + 1) : std::string();
    if (word == "message") {
      const auto end = rest.find(' ');
      messages.push_back({rest.substr(0, end), rest.substr(end + 1), {}, {}, {}});
    } else if (messages.empty()) {
      throw std::runtime_error(file.string() + ": does not begin with a message");
    } else if (word == "cdr") {
      for (std::size_t i = 0; i + 1 < rest.size(); i += 2) {
        messages.back().cdr.push_back(
            static_cast<std::byte>(std::stoul(rest.substr(i, 2), nullptr, 16)));
      }
    } else if (word == "yaml") {
      messages.back().yaml += rest + "\n";
    } else if (word == "csv") {
      messages.back().csv = rest;
    } else {
      throw std::runtime_error(file.string() + ": unknown line " + line);
    }
  }
  return messages;
}

/// Of all files in the folder.
inline std::vector<GoldenMessage> read_golden_files(const std::filesystem::path& folder) {
  std::vector<GoldenMessage> messages;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() == ".txt") {
      const auto own = read_golden_file(entry.path());
      messages.insert(messages.end(), own.begin(), own.end());
    }
  }
  return messages;
}

}  // namespace pipescout::testing
