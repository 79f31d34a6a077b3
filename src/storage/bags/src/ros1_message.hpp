// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "bytes.hpp"
#include "pipescout/bags/bag_types.hpp"

namespace pipescout::bags {

/// Turns messages as ROS 1 serialises them into the CDR of ROS 2, by the definition that the bag
/// carries. `time` and `duration` become those of builtin_interfaces, std_msgs/Header loses `seq`.
class Ros1Message {
 public:
  /// `type`: "sensor_msgs/Imu"; `definition`: with all types in it, as in the bag. Throws
  /// std::invalid_argument naming what makes no sense in it.
  Ros1Message(const std::string& type, std::string_view definition);

  /// False when the bytes are fewer or more than the definition says.
  [[nodiscard]] bool to_cdr(ByteView message, Bytes& cdr) const;
  /// The definition as "ros2msg" has it.
  [[nodiscard]] const std::string& ros2_definition() const noexcept { return text_; }

 private:
  struct Field {
    std::size_t size = 0;  ///< of a number, 0 otherwise
    std::size_t type = 0;  ///< of a message, in types_
    bool is_string = false;
    bool is_time = false;
    bool is_array = false;
    bool is_dropped = false;        ///< is not in the message of ROS 2
    std::uint32_t fixed_count = 0;  ///< of an array; 0: as many as the message says
  };
  struct Type {
    std::vector<Field> fields;
    bool is_defined = false;
  };

  enum class Visit : std::uint8_t { kNot, kAbove, kDone };

  std::size_t type_index(const std::string& name);
  void read_line(const std::string& type, std::string_view line);
  void check_no_loop(std::size_t type, std::vector<Visit>& visits) const;
  [[nodiscard]] bool convert(const Type& type, ByteCursor& from, Bytes& to) const;
  [[nodiscard]] bool convert(const Field& field, ByteCursor& from, Bytes& to) const;

  std::unordered_map<std::string, std::size_t> indexes_;
  std::vector<Type> types_;
  std::vector<std::string> names_;
  std::string text_;
  bool uses_time_ = false;
  bool uses_duration_ = false;
};

/// The topic of ROS 2 that a topic of ROS 1 becomes. `type`: "sensor_msgs/Imu".
[[nodiscard]] BagTopic ros2_topic(const std::string& name, const std::string& type,
                                  const Ros1Message& converter, bool latched);

}  // namespace pipescout::bags
