// SPDX-License-Identifier: Apache-2.0
#include "storage_options.hpp"

#include <algorithm>
#include <chrono>
#include <regex>

#include "pipescout/command_line/command.hpp"

namespace pipescout::bag_command {

void add_storage_options(CLI::App& command, StorageOptions& options) {
  command.add_option("-o,--output", options.output, "Folder of the new bag")->required();
  command
      .add_option("-s,--storage", options.storage,
                  "sqlite3 or mcap; without it that of the bag that is read")
      ->check(CLI::IsMember({"sqlite3", "mcap"}));
  command
      .add_option("-b,--max-bag-size", options.max_bag_size,
                  "Begin a new file before one is larger, bytes; 0: never")
      ->check(CLI::Range(std::uint64_t{0}, std::uint64_t{1} << 62U));
  command
      .add_option("-d,--max-bag-duration", options.max_bag_duration,
                  "Begin a new file after so many seconds; 0: never")
      ->check(CLI::Range(0.0, 1e9));
  command
      .add_option("--compression-mode", options.compression_mode,
                  "none, file (each file once it is complete) or message")
      ->check(CLI::IsMember({"none", "file", "message"}));
  command.add_option("--compression-format", options.compression_format, "zstd")
      ->check(CLI::IsMember({"zstd"}));
  command
      .add_option("--chunk-compression", options.chunk_compression,
                  "none, lz4 or zstd: of the chunks of MCAP")
      ->check(CLI::IsMember({"none", "lz4", "zstd"}));
}

bags::BagWriterOptions writer_options(const StorageOptions& options, bags::Storage source) {
  bags::BagWriterOptions result;
  result.storage = source == bags::Storage::kRos1 ? bags::Storage::kSqlite : source;
  if (const auto chosen = bags::storage_of(options.storage)) {
    result.storage = *chosen;
  }
  result.max_file_size = options.max_bag_size;
  result.max_file_duration = std::chrono::duration_cast<std::chrono::nanoseconds>(
      std::chrono::duration<double>(options.max_bag_duration));
  if (options.compression_mode == "file") {
    result.compression = bags::Compression::kFile;
  } else if (options.compression_mode == "message") {
    result.compression = bags::Compression::kMessage;
  }
  if (options.chunk_compression == "lz4") {
    result.chunk_compression = bags::ChunkCompression::kLz4;
  } else if (options.chunk_compression == "zstd") {
    result.chunk_compression = bags::ChunkCompression::kZstd;
  }
  return result;
}

namespace {

CLI::Validator is_regex() {
  return {[](const std::string& text) -> std::string {
            try {
              const std::regex expression(text);
              return {};
            } catch (const std::regex_error&) {
              return "'" + text + "' is no regular expression";
            }
          },
          ""};
}

}  // namespace

void add_topic_options(CLI::App& command, TopicOptions& options) {
  command.add_option("--topics", options.topics, "Only these topics");
  command.add_option("-e,--regex", options.regex, "Only topics that match, and those of --topics")
      ->check(is_regex());
  command.add_option("-x,--exclude", options.exclude, "No topic that matches")->check(is_regex());
}

std::optional<std::vector<std::string>> chosen_topics(const TopicOptions& options,
                                                      const std::vector<bags::BagTopic>& topics) {
  if (options.topics.empty() && options.regex.empty() && options.exclude.empty()) {
    return std::nullopt;
  }
  for (const std::string& name : options.topics) {
    if (std::none_of(topics.begin(), topics.end(),
                     [&](const bags::BagTopic& topic) { return topic.name == name; })) {
      throw command_line::CommandError("the bag has no topic " + name);
    }
  }
  const bool all = options.topics.empty() && options.regex.empty();
  const std::regex wanted(options.regex);
  const std::regex unwanted(options.exclude);
  std::vector<std::string> result;
  for (const bags::BagTopic& topic : topics) {
    const bool named =
        std::find(options.topics.begin(), options.topics.end(), topic.name) != options.topics.end();
    const bool matches = !options.regex.empty() && std::regex_search(topic.name, wanted);
    const bool excluded = !options.exclude.empty() && std::regex_search(topic.name, unwanted);
    if ((all || named || matches) && !excluded) {
      result.push_back(topic.name);
    }
  }
  if (result.empty()) {
    throw command_line::CommandError("no topic of the bag is chosen by --topics, -e and -x");
  }
  return result;
}

}  // namespace pipescout::bag_command
