// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// What bags hold. A bag is a folder as rosbag2 has it: `metadata.yaml` and one or more files, each
/// an SQLite database (.db3) or an MCAP file (.mcap), perhaps compressed (.zstd).
namespace pipescout::bags {

/// How the files of a bag are laid out.
enum class Storage : std::uint8_t {
  kSqlite,  ///< "sqlite3", what ROS 2 Humble writes
  kMcap,    ///< "mcap"
  kRos1     ///< "rosbag_v2", the .bag files of ROS 1, version 2.0; only read
};

/// rosbag2's name: "sqlite3", "mcap", "rosbag_v2".
[[nodiscard]] std::string_view storage_identifier(Storage storage) noexcept;
/// The storage of that name; none for other names.
[[nodiscard]] std::optional<Storage> storage_of(std::string_view identifier) noexcept;

/// What zstd is applied to besides the chunks of MCAP.
enum class Compression : std::uint8_t {
  kNone,
  kMessage,  ///< each message by itself
  kFile      ///< each file once it is complete; the messages of the last file are safe as without
};

/// How the chunks of an MCAP file are compressed.
enum class ChunkCompression : std::uint8_t { kNone, kLz4, kZstd };

/// A topic as it is kept in a bag.
struct BagTopic {
  /// With the leading slash: "/imu/data".
  std::string name;
  /// "sensor_msgs/msg/Imu".
  std::string type;
  std::string serialization_format = "cdr";
  /// QoS of each publisher as rosbag2 of Humble writes them: a YAML sequence in a text, policies as
  /// numbers. A reader translates what newer versions write into it. May be empty.
  std::string offered_qos_profiles;
  /// "RIHS01_...", of ROS 2 newer than Humble; else empty.
  std::string type_description_hash;
  /// "ros2msg", "ros2idl", or empty when the definition is not known.
  std::string schema_encoding;
  /// The definition of the type and of all types in it, as MCAP asks of that encoding. SQLite bags
  /// of Humble have no place for it.
  std::string schema_text;

  bool operator==(const BagTopic&) const = default;
};

/// Index into the topics of one writer or of one reader.
using TopicIndex = std::uint32_t;

/// One message. `data` belongs to whoever hands the message out.
struct BagMessage {
  TopicIndex topic = 0;
  /// When it was received, in nanoseconds since 1970 (or of the simulation). The order of a bag.
  std::int64_t log_time = 0;
  /// When it was published, in nanoseconds. SQLite bags do not keep it: it is then `log_time`.
  std::int64_t publish_time = 0;
  /// CDR with its encapsulation header.
  std::span<const std::byte> data;
};

struct TopicCount {
  BagTopic topic;
  std::uint64_t messages = 0;
};

/// One file of a bag.
struct BagFile {
  /// Relative to the bag.
  std::string path;
  std::int64_t starting_time = 0;  ///< ns
  std::int64_t duration = 0;       ///< ns
  std::uint64_t messages = 0;
};

/// What `metadata.yaml` says.
struct BagMetadata {
  /// The version of the format; what is written has 5, that of Humble.
  int version = 5;
  Storage storage = Storage::kSqlite;
  std::int64_t starting_time = 0;  ///< of the first message, ns; 0 without messages
  std::int64_t duration = 0;       ///< from the first to the last message, ns
  std::uint64_t messages = 0;
  /// In the order in which they were added. The schemas are in the files only.
  std::vector<TopicCount> topics;
  Compression compression = Compression::kNone;
  std::vector<BagFile> files;
  /// Of newer versions; what is written has none.
  std::map<std::string, std::string> custom_data;
  std::string ros_distro;
};

/// Which messages are read.
struct BagFilter {
  /// Names; none: all topics.
  std::optional<std::vector<std::string>> topics;
  /// Log times in ns: from `start`, up to and with `end`.
  std::int64_t start = std::numeric_limits<std::int64_t>::min();
  std::int64_t end = std::numeric_limits<std::int64_t>::max();
};

}  // namespace pipescout::bags
