// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "pipescout/idl/field_access.hpp"
#include "pipescout/idl/message_type.hpp"

namespace pipescout::bag_command {

/// A file that is written line by line. Throws CommandError naming it.
class TextFile {
 public:
  explicit TextFile(std::filesystem::path path);
  void write(const std::string& line);
  /// Throws also for what could not be written before.
  void close();

 private:
  std::filesystem::path path_;
  std::ofstream file_;
};

/// The columns of a type's fields: "header.stamp.sec", "position.x", "data[0]". Sequences have as
/// many columns as their longest one in the bag; of one that is longer than the limit, only its
/// length is written ("data.size").
class FlatFields {
 public:
  FlatFields(const MessageType& type, std::size_t limit);

  /// Each message, before the columns are asked for.
  void observe(MessageView message);
  [[nodiscard]] std::vector<std::string> columns() const;
  /// A cell for each column; empty where a sequence is shorter.
  void cells(MessageView message, std::vector<std::string>& cells) const;

 private:
  struct Node {
    const MessageField* field = nullptr;
    std::size_t longest = 0;
    std::vector<Node> fields;  ///< of a message
  };
  static std::vector<Node> nodes_of(const MessageType& type);
  static void observe(std::vector<Node>& nodes, MessageView message);
  void add_columns(const std::vector<Node>& nodes, const std::string& prefix,
                   std::vector<std::string>& columns) const;
  /// `message` without an object: all cells are empty.
  void add_cells(const std::vector<Node>& nodes, MessageView message,
                 std::vector<std::string>& cells) const;

  std::vector<Node> nodes_;
  std::size_t limit_;
};

/// Writes each image to a file of its own, FOLDER/NUMBER_SECONDS.png. Encodings: mono8, mono16,
/// 16UC1, 32FC1, rgb8, bgr8, rgba8, bgra8 and Bayer patterns of 8 and 16 bits, which become
/// colours. 32FC1 goes to TIFF always. Images of sensor_msgs/msg/CompressedImage are written as
/// they are.
class ImageExport {
 public:
  /// `ending`: "png" or "tiff".
  ImageExport(std::filesystem::path folder, std::string ending);
  [[nodiscard]] static bool takes(std::string_view type);
  /// Throws CommandError for an encoding or a size that makes no sense.
  void write(MessageView message);
  [[nodiscard]] std::uint64_t count() const noexcept { return count_; }

 private:
  std::filesystem::path folder_;
  std::string ending_;
  std::uint64_t count_ = 0;
};

/// Writes poses as TUM has them: "seconds x y z qx qy qz qw", by the stamp of the message.
/// Transforms go to a file for each child frame.
class TrajectoryExport {
 public:
  /// `path`: of the file, without its ending.
  explicit TrajectoryExport(std::filesystem::path path);
  /// nav_msgs Odometry, geometry_msgs PoseStamped, PoseWithCovarianceStamped and TransformStamped,
  /// tf2_msgs TFMessage.
  [[nodiscard]] static bool takes(std::string_view type);
  void write(MessageView message);
  /// The number of files.
  std::size_t close();

 private:
  void write_transform(const void* transform);
  TextFile& file(const std::string& child_frame);

  std::filesystem::path path_;
  std::map<std::string, std::unique_ptr<TextFile>> files_;
};

/// "/imu/data" as a part of a file's name: "imu_data".
[[nodiscard]] std::string file_name_of(std::string_view topic);

}  // namespace pipescout::bag_command
