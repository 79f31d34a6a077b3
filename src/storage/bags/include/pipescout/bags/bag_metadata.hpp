// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "pipescout/bags/bag_types.hpp"

namespace pipescout::bags {

/// The name of the file in a bag's folder.
inline constexpr const char* kMetadataFile = "metadata.yaml";

/// The content of `metadata.yaml`, version 5. The version in `metadata` does not matter.
[[nodiscard]] std::string metadata_to_yaml(const BagMetadata& metadata);

/// Reads version 1 to 9. `path` is for errors. Throws BagError: kMalformed, or kUnsupported for
/// another version, storage or compression.
[[nodiscard]] BagMetadata metadata_from_yaml(const std::string& text,
                                             const std::filesystem::path& path);

/// Offered QoS profiles as Humble writes them, from any version's text: newer ones write the names
/// of policies where Humble has numbers. A text that is no such YAML is returned as it is.
[[nodiscard]] std::string humble_qos_profiles(const std::string& text);

}  // namespace pipescout::bags
