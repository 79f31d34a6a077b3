// SPDX-License-Identifier: Apache-2.0
#include "pipescout/bags/bag_metadata.hpp"

#include <yaml-cpp/yaml.h>

#include <array>
#include <string_view>
#include <utility>

#include "pipescout/bags/bag_error.hpp"
#include "pipescout/bags/topic_choice.hpp"
#include "pipescout/files/yaml_location.hpp"

namespace pipescout::bags {
namespace {

constexpr int kNewestVersion = 9;
constexpr int kWrittenVersion = 5;

/// A value of a mapping. Throws YamlError where it is missing or of another kind.
class Reading {
 public:
  explicit Reading(std::string path) : path_(std::move(path)) {}

  [[nodiscard]] YAML::Node child(const YAML::Node& node, const char* key) const {
    if (!node.IsMap()) {
      throw YamlError(path_, node.Mark(), "a mapping is expected");
    }
    const YAML::Node found = node[key];
    if (!found) {
      throw YamlError(path_, node.Mark(), std::string(key) + " is missing");
    }
    return found;
  }

  template <class T>
  [[nodiscard]] T value(const YAML::Node& node, const char* key) const {
    const YAML::Node found = child(node, key);
    try {
      return found.as<T>();
    } catch (const YAML::Exception&) {
      throw YamlError(path_, found.Mark(), std::string(key) + " has a value of another kind");
    }
  }

  template <class T>
  [[nodiscard]] T value_or(const YAML::Node& node, const char* key, T otherwise) const {
    return node.IsMap() && node[key] ? value<T>(node, key) : otherwise;
  }

  [[nodiscard]] YAML::Node sequence(const YAML::Node& node, const char* key) const {
    const YAML::Node found = child(node, key);
    if (!found.IsSequence() && !found.IsNull()) {
      throw YamlError(path_, found.Mark(), std::string(key) + " is no sequence");
    }
    return found;
  }

  [[noreturn]] void unsupported(const YAML::Node& node, const std::string& what) const {
    throw BagError(BagFault::kUnsupported, line_location(path_, node.Mark()), what);
  }

 private:
  std::string path_;
};

Compression compression_of(const Reading& reading, const YAML::Node& node) {
  const auto mode = reading.value_or<std::string>(node, "compression_mode", "");
  const auto format = reading.value_or<std::string>(node, "compression_format", "");
  if (mode.empty() || mode == "NONE" || mode == "none") {
    return Compression::kNone;
  }
  if (format != "zstd") {
    reading.unsupported(node["compression_format"],
                        "compression_format: '" + format + "' is not known");
  }
  if (mode == "FILE" || mode == "file") {
    return Compression::kFile;
  }
  if (mode == "MESSAGE" || mode == "message") {
    return Compression::kMessage;
  }
  reading.unsupported(node["compression_mode"], "compression_mode: '" + mode + "' is not known");
}

BagTopic topic_of(const Reading& reading, const YAML::Node& node) {
  BagTopic topic;
  topic.name = reading.value<std::string>(node, "name");
  topic.type = reading.value<std::string>(node, "type");
  topic.serialization_format = reading.value_or<std::string>(node, "serialization_format", "cdr");
  topic.type_description_hash = reading.value_or<std::string>(node, "type_description_hash", "");
  if (const YAML::Node qos = node["offered_qos_profiles"]; qos && qos.IsScalar()) {
    topic.offered_qos_profiles = humble_qos_profiles(qos.Scalar());
  } else if (qos && qos.IsSequence()) {
    // Since version 9 the profiles are no longer a text.
    topic.offered_qos_profiles = humble_qos_profiles(YAML::Dump(qos));
  }
  return topic;
}

BagMetadata metadata_of(const Reading& reading, const YAML::Node& document) {
  const YAML::Node node = reading.child(document, "rosbag2_bagfile_information");
  BagMetadata metadata;
  metadata.version = reading.value<int>(node, "version");
  if (metadata.version < 1 || metadata.version > kNewestVersion) {
    reading.unsupported(node["version"], "version " + std::to_string(metadata.version) +
                                             " is not known, only 1 to " +
                                             std::to_string(kNewestVersion));
  }
  const auto identifier = reading.value<std::string>(node, "storage_identifier");
  if (const auto storage = storage_of(identifier)) {
    metadata.storage = *storage;
  } else if (!identifier.empty()) {
    reading.unsupported(node["storage_identifier"],
                        "storage_identifier: '" + identifier + "' is not known");
  }
  metadata.duration = reading.value<std::int64_t>(reading.child(node, "duration"), "nanoseconds");
  metadata.starting_time =
      reading.value<std::int64_t>(reading.child(node, "starting_time"), "nanoseconds_since_epoch");
  metadata.messages = reading.value<std::uint64_t>(node, "message_count");
  for (const YAML::Node& each : reading.sequence(node, "topics_with_message_count")) {
    metadata.topics.push_back({topic_of(reading, reading.child(each, "topic_metadata")),
                               reading.value<std::uint64_t>(each, "message_count")});
  }
  metadata.compression = compression_of(reading, node);
  for (const YAML::Node& each : reading.sequence(node, "relative_file_paths")) {
    metadata.files.push_back({.path = each.as<std::string>("")});
  }
  if (identifier.empty()) {
    // As `ros2 bag reindex` of Humble leaves it: the files tell (rosbag2, issue 2175).
    const auto storage =
        metadata.files.empty() ? std::nullopt : storage_by_name(metadata.files.front().path);
    if (!storage) {
      reading.unsupported(node["storage_identifier"],
                          "storage_identifier: is empty, and no file is named from which it "
                          "could be known");
    }
    metadata.storage = *storage;
  }
  if (node["files"] && node["files"].IsSequence()) {
    std::size_t k = 0;
    for (const YAML::Node& each : node["files"]) {
      if (k == metadata.files.size()) {
        break;
      }
      BagFile& file = metadata.files[k++];
      file.starting_time = reading.value<std::int64_t>(reading.child(each, "starting_time"),
                                                       "nanoseconds_since_epoch");
      file.duration = reading.value<std::int64_t>(reading.child(each, "duration"), "nanoseconds");
      file.messages = reading.value<std::uint64_t>(each, "message_count");
    }
  }
  if (const YAML::Node data = node["custom_data"]; data && data.IsMap()) {
    for (const auto& entry : data) {
      metadata.custom_data[entry.first.as<std::string>("")] = entry.second.as<std::string>("");
    }
  }
  metadata.ros_distro = reading.value_or<std::string>(node, "ros_distro", "");
  return metadata;
}

/// Policies as numbers of rmw in Humble.
int policy_number(std::string_view policy, std::string_view name) {
  using Entry = std::pair<std::string_view, int>;
  static constexpr std::array<Entry, 3> kHistory{
      {{"keep_last", 1}, {"keep_all", 2}, {"unknown", 3}}};
  static constexpr std::array<Entry, 3> kReliability{
      {{"reliable", 1}, {"best_effort", 2}, {"unknown", 3}}};
  static constexpr std::array<Entry, 3> kDurability{
      {{"transient_local", 1}, {"volatile", 2}, {"unknown", 3}}};
  static constexpr std::array<Entry, 4> kLiveliness{
      {{"automatic", 1}, {"manual_by_node", 2}, {"manual_by_topic", 3}, {"unknown", 4}}};
  const auto find = [&](const auto& entries) {
    for (const auto& [text, number] : entries) {
      if (text == name) {
        return number;
      }
    }
    return 0;  // system_default
  };
  if (policy == "history") {
    return find(kHistory);
  }
  if (policy == "reliability") {
    return find(kReliability);
  }
  return policy == "durability" ? find(kDurability) : find(kLiveliness);
}

/// As text: yaml-cpp would group its digits by the global locale.
template <class Integer>
void emit_integer(YAML::Emitter& out, const char* key, Integer value) {
  out << YAML::Key << key << YAML::Value << std::to_string(value);
}

void emit_nanoseconds(YAML::Emitter& out, const char* key, const char* unit, std::int64_t value) {
  out << YAML::Key << key << YAML::Value << YAML::BeginMap;
  emit_integer(out, unit, value);
  out << YAML::EndMap;
}

void emit_topic(YAML::Emitter& out, const TopicCount& count) {
  const BagTopic& topic = count.topic;
  out << YAML::BeginMap << YAML::Key << "topic_metadata" << YAML::Value << YAML::BeginMap;
  out << YAML::Key << "name" << YAML::Value << topic.name;
  out << YAML::Key << "type" << YAML::Value << topic.type;
  out << YAML::Key << "serialization_format" << YAML::Value << topic.serialization_format;
  out << YAML::Key << "offered_qos_profiles" << YAML::Value << YAML::DoubleQuoted
      << topic.offered_qos_profiles;
  out << YAML::EndMap;
  emit_integer(out, "message_count", count.messages);
  out << YAML::EndMap;
}

}  // namespace

std::string metadata_to_yaml(const BagMetadata& metadata) {
  YAML::Emitter out;
  out << YAML::BeginMap << YAML::Key << "rosbag2_bagfile_information" << YAML::Value
      << YAML::BeginMap;
  emit_integer(out, "version", kWrittenVersion);
  out << YAML::Key << "storage_identifier" << YAML::Value
      << std::string(storage_identifier(metadata.storage));
  emit_nanoseconds(out, "duration", "nanoseconds", metadata.duration);
  emit_nanoseconds(out, "starting_time", "nanoseconds_since_epoch", metadata.starting_time);
  emit_integer(out, "message_count", metadata.messages);
  out << YAML::Key << "topics_with_message_count" << YAML::Value << YAML::BeginSeq;
  for (const TopicCount& each : metadata.topics) {
    emit_topic(out, each);
  }
  out << YAML::EndSeq;
  const bool compressed = metadata.compression != Compression::kNone;
  out << YAML::Key << "compression_format" << YAML::Value << YAML::DoubleQuoted
      << (compressed ? "zstd" : "");
  out << YAML::Key << "compression_mode" << YAML::Value << YAML::DoubleQuoted
      << (!compressed                                     ? ""
          : metadata.compression == Compression::kMessage ? "MESSAGE"
                                                          : "FILE");
  out << YAML::Key << "relative_file_paths" << YAML::Value << YAML::BeginSeq;
  for (const BagFile& file : metadata.files) {
    out << file.path;
  }
  out << YAML::EndSeq << YAML::Key << "files" << YAML::Value << YAML::BeginSeq;
  for (const BagFile& file : metadata.files) {
    out << YAML::BeginMap << YAML::Key << "path" << YAML::Value << file.path;
    emit_nanoseconds(out, "starting_time", "nanoseconds_since_epoch", file.starting_time);
    emit_nanoseconds(out, "duration", "nanoseconds", file.duration);
    emit_integer(out, "message_count", file.messages);
    out << YAML::EndMap;
  }
  out << YAML::EndSeq << YAML::EndMap << YAML::EndMap;
  return std::string(out.c_str()) + "\n";
}

BagMetadata metadata_from_yaml(const std::string& text, const std::filesystem::path& path) {
  try {
    return metadata_of(Reading(path.string()), parse_yaml(text, path.string()));
  } catch (const YamlError& error) {
    const std::string where = path.string() + ":";
    std::string what = error.what();
    // The place in the file stays in front, the file itself is named once.
    if (what.starts_with(where)) {
      what.erase(0, where.size());
    }
    throw BagError(BagFault::kMalformed, path, what);
  } catch (const YAML::Exception& error) {
    throw BagError(BagFault::kMalformed, path, error.what());
  }
}

std::string humble_qos_profiles(const std::string& text) {
  YAML::Node profiles;
  try {
    profiles = parse_yaml(text, "offered_qos_profiles");
  } catch (const YamlError&) {
    return text;
  }
  if (!profiles.IsSequence()) {
    return text;
  }
  bool changed = false;
  for (YAML::Node profile : profiles) {
    if (!profile.IsMap()) {
      return text;
    }
    for (const char* policy : {"history", "reliability", "durability", "liveliness"}) {
      const YAML::Node value = profile[policy];
      int number = 0;
      if (value && value.IsScalar() && !YAML::convert<int>::decode(value, number)) {
        profile[policy] = policy_number(policy, value.Scalar());
        changed = true;
      }
    }
  }
  return changed ? YAML::Dump(profiles) : text;
}

}  // namespace pipescout::bags
