// SPDX-License-Identifier: Apache-2.0
#include <cstdint>
#include <ctime>
#include <filesystem>
#include <iomanip>
#include <iostream>
#include <memory>
#include <sstream>
#include <string>
#include <system_error>

#include "offline_commands.hpp"
#include "pipescout/bags/bag_reader.hpp"

namespace pipescout::bag_command {
namespace {

namespace fs = std::filesystem;
using command_line::Action;
constexpr std::int64_t kSecond = 1'000'000'000;

/// "123.456789012".
std::string seconds(std::int64_t nanoseconds) {
  std::ostringstream out;
  out << nanoseconds / kSecond << '.' << std::setw(9) << std::setfill('0') << nanoseconds % kSecond;
  return out.str();
}

/// As rosbag2 writes it, "Nov 25 2026 17:35:14.123456789 (1700000000.123456789)", in local time.
std::string date(std::int64_t nanoseconds) {
  const auto time = static_cast<std::time_t>(nanoseconds / kSecond);
  std::tm parts{};
  ::localtime_r(&time, &parts);
  std::ostringstream out;
  out << std::put_time(&parts, "%b %e %Y %H:%M:%S") << '.' << std::setw(9) << std::setfill('0')
      << nanoseconds % kSecond << " (" << seconds(nanoseconds) << ")";
  return out.str();
}

std::string size_text(std::uintmax_t bytes) {
  constexpr double kUnit = 1024.0;
  auto value = static_cast<double>(bytes);
  const char* unit = "B";
  for (const char* larger : {"KiB", "MiB", "GiB", "TiB"}) {
    if (value < kUnit) {
      break;
    }
    value /= kUnit;
    unit = larger;
  }
  std::ostringstream out;
  out << std::fixed << std::setprecision(value == static_cast<double>(bytes) ? 0 : 1) << value
      << ' ' << unit;
  return out.str();
}

int show(const std::string& bag) {
  const bags::BagReader reader(bag);
  const bags::BagMetadata& metadata = reader.metadata();
  const fs::path folder = fs::is_directory(bag) ? fs::path(bag) : fs::path(bag).parent_path();
  std::uintmax_t size = 0;
  std::string files;
  for (const auto& file : metadata.files) {
    std::error_code error;
    const auto bytes = fs::file_size(folder / file.path, error);
    size += error ? 0 : bytes;
    files += (files.empty() ? "" : "\n                   ") + file.path;
  }
  std::cout << "Files:             " << files << "\nBag size:          " << size_text(size)
            << "\nStorage id:        " << bags::storage_identifier(metadata.storage) << '\n';
  if (metadata.compression != bags::Compression::kNone) {
    std::cout << "Compression:       zstd, each "
              << (metadata.compression == bags::Compression::kFile ? "file" : "message") << '\n';
  }
  std::cout << "Duration:          " << seconds(metadata.duration)
            << "s\nStart:             " << date(metadata.starting_time)
            << "\nEnd:               " << date(metadata.starting_time + metadata.duration)
            << "\nMessages:          " << metadata.messages << "\nTopic information: ";
  const char* indent = "";
  for (const auto& [topic, messages] : metadata.topics) {
    std::cout << indent << "Topic: " << topic.name << " | Type: " << topic.type
              << " | Count: " << messages
              << " | Serialization Format: " << topic.serialization_format << '\n';
    indent = "                   ";
  }
  if (metadata.topics.empty()) {
    std::cout << '\n';
  }
  return command_line::kExitOk;
}

}  // namespace

void add_info_command(CLI::App& app, Action& action) {
  auto bag = std::make_shared<std::string>();
  auto* command = app.add_subcommand("info", "Show what a bag holds");
  command->add_option("bag", *bag, "Folder of the bag, or one .db3, .mcap or .bag file")
      ->required();
  command->callback([=, &action] { action = [=] { return show(*bag); }; });
}

}  // namespace pipescout::bag_command
