// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "pipescout/bags/bag_reader.hpp"
#include "pipescout/bags/bag_writer.hpp"

namespace pipescout::bag_command {

/// How a new bag is stored, as the command line says it.
struct StorageOptions {
  std::string output;
  std::string storage;
  std::uint64_t max_bag_size = 0;
  double max_bag_duration = 0.0;  ///< s
  std::string compression_mode = "none";
  std::string compression_format = "zstd";
  std::string chunk_compression = "none";
};

void add_storage_options(CLI::App& command, StorageOptions& options);

/// Without `-s` the new bag is stored as `source` is; a bag of ROS 1 becomes SQLite.
[[nodiscard]] bags::BagWriterOptions writer_options(const StorageOptions& options,
                                                    bags::Storage source);

/// Which topics are meant: all of `topics` (or all there are), those that match `regex`, and none
/// that matches `exclude`.
struct TopicOptions {
  std::vector<std::string> topics;
  std::string regex;
  std::string exclude;
};

void add_topic_options(CLI::App& command, TopicOptions& options);

/// The topics of the bag that are meant; none where no option was given. Throws CommandError for
/// names that the bag does not have, or where no topic is left.
[[nodiscard]] std::optional<std::vector<std::string>> chosen_topics(
    const TopicOptions& options, const std::vector<bags::BagTopic>& topics);

}  // namespace pipescout::bag_command
