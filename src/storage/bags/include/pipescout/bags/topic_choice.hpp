// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <initializer_list>
#include <optional>
#include <string>

#include "pipescout/bags/bag_reader.hpp"

namespace pipescout::bags {

/// The storage that the name of a file says: ".db3", ".mcap" or ".bag", also with ".zstd" behind
/// it.
[[nodiscard]] std::optional<Storage> storage_by_name(const std::filesystem::path& path);

/// Whether a program that reads bags or folders of files should read this as a bag: a file, or a
/// folder that holds `metadata.yaml` or a file of a bag.
[[nodiscard]] bool is_bag(const std::filesystem::path& path);

/// The topic that a program of one input reads: the one named `wanted`, with or without the '/' in
/// front, or with an empty name the only one there is, of those in CDR that have one of `types`.
/// Throws BagError (kUsage) that says which topics there are to choose from, by which `option` of
/// the command line.
[[nodiscard]] const TopicCount& choose_topic(const BagReader& reader,
                                             const std::filesystem::path& bag,
                                             std::initializer_list<const char*> types,
                                             const std::string& wanted,
                                             const std::string& option = "--topic");

}  // namespace pipescout::bags
