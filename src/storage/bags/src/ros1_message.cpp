// SPDX-License-Identifier: Apache-2.0
#include "ros1_message.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <stdexcept>
#include <utility>

namespace pipescout::bags {
namespace {

/// In front of each message's CDR: little endian.
constexpr std::size_t kEncapsulation = 4;

std::size_t number_size(std::string_view type) {
  static const std::unordered_map<std::string_view, std::size_t> kSizes{
      {"bool", 1},  {"int8", 1},   {"uint8", 1},  {"byte", 1},   {"char", 1},
      {"int16", 2}, {"uint16", 2}, {"int32", 4},  {"uint32", 4}, {"float32", 4},
      {"int64", 8}, {"uint64", 8}, {"float64", 8}};
  const auto found = kSizes.find(type);
  return found == kSizes.end() ? 0 : found->second;
}

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kSpace = " \t\r\n";
  const std::size_t start = text.find_first_not_of(kSpace);
  return start == std::string_view::npos
             ? std::string_view()
             : text.substr(start, text.find_last_not_of(kSpace) - start + 1);
}

std::string_view without_comment(std::string_view line) {
  return line.substr(0, line.find('#'));
}

/// Names of fields in ROS 2 have no capitals: K becomes k, frameId becomes frame_id.
std::string field_name(std::string_view name) {
  std::string result;
  for (std::size_t k = 0; k < name.size(); ++k) {
    const auto c = static_cast<unsigned char>(name[k]);
    if (std::isupper(c) != 0 && k > 0 &&
        std::islower(static_cast<unsigned char>(name[k - 1])) != 0) {
      result += '_';
    }
    result += static_cast<char>(std::tolower(c));
  }
  return result;
}

/// "sensor_msgs/Imu" as "sensor_msgs/msg/Imu".
std::string ros2_type_name(const std::string& ros1_name) {
  const std::size_t slash = ros1_name.find('/');
  return slash == std::string::npos ? ros1_name
                                    : ros1_name.substr(0, slash) + "/msg" + ros1_name.substr(slash);
}

void align(Bytes& cdr, std::size_t size) {
  const std::size_t beyond = (cdr.size() - kEncapsulation) % size;
  if (beyond != 0) {
    cdr.resize(cdr.size() + size - beyond, std::byte{0});
  }
}

}  // namespace

BagTopic ros2_topic(const std::string& name, const std::string& type, const Ros1Message& converter,
                    bool latched) {
  BagTopic topic{.name = name,
                 .type = ros2_type_name(type),
                 .schema_encoding = "ros2msg",
                 .schema_text = converter.ros2_definition()};
  if (latched) {
    topic.offered_qos_profiles =
        "- history: 1\n  depth: 1\n  reliability: 1\n  durability: 1\n  deadline:\n    sec: 0\n"
        "    nsec: 0\n  lifespan:\n    sec: 0\n    nsec: 0\n  liveliness: 1\n"
        "  liveliness_lease_duration:\n    sec: 0\n    nsec: 0\n"
        "  avoid_ros_namespace_conventions: false\n";
  }
  return topic;
}

Ros1Message::Ros1Message(const std::string& type, std::string_view definition) {
  (void)type_index(type);
  std::string current = type;
  types_.front().is_defined = true;
  while (!definition.empty()) {
    const std::size_t end = std::min(definition.find('\n'), definition.size());
    const std::string_view line = definition.substr(0, end);
    definition.remove_prefix(std::min(end + 1, definition.size()));
    if (line.starts_with("=====")) {
      continue;
    }
    if (line.starts_with("MSG: ")) {
      current = std::string(trimmed(line.substr(5)));
      types_[type_index(current)].is_defined = true;
      text_ += std::string(80, '=') + "\nMSG: " + current + "\n";
      continue;
    }
    read_line(current, line);
  }
  for (std::size_t k = 0; k < types_.size(); ++k) {
    if (!types_[k].is_defined) {
      throw std::invalid_argument(type + ": the definition of " + names_[k] + " is missing");
    }
  }
  std::vector<Visit> visits(types_.size(), Visit::kNot);
  check_no_loop(0, visits);
  for (const auto& [used, name] :
       {std::pair(uses_time_, "Time"), std::pair(uses_duration_, "Duration")}) {
    if (used) {
      text_ += std::string(80, '=') + "\nMSG: builtin_interfaces/" + name +
               "\nint32 sec\nuint32 nanosec\n";
    }
  }
}

std::size_t Ros1Message::type_index(const std::string& name) {
  const auto [entry, is_new] = indexes_.try_emplace(name, types_.size());
  if (is_new) {
    types_.emplace_back();
    names_.push_back(name);
  }
  return entry->second;
}

void Ros1Message::read_line(const std::string& type, std::string_view line) {
  const std::string_view content = trimmed(without_comment(line));
  const std::size_t space = content.find_first_of(" \t");
  if (space == std::string_view::npos) {
    if (!content.empty()) {
      throw std::invalid_argument(type + ": '" + std::string(content) + "' is no field");
    }
    return;
  }
  std::string_view field_type = content.substr(0, space);
  const std::string_view rest = trimmed(content.substr(space));
  if (rest.find('=') != std::string_view::npos) {
    // A constant: it is in no message. That of a string may hold '#'.
    text_ += std::string(trimmed(field_type == "string" ? line : content)) + "\n";
    return;
  }
  Field field;
  std::string array;
  if (const std::size_t bracket = field_type.find('['); bracket != std::string_view::npos) {
    array = std::string(field_type.substr(bracket));
    field.is_array = true;
    const char* number = array.data() + 1;
    if (array != "[]" &&
        (std::from_chars(number, array.data() + array.size(), field.fixed_count).ptr !=
             array.data() + array.size() - 1 ||
         field.fixed_count == 0)) {
      throw std::invalid_argument(type + ": '" + array + "' is no size of an array");
    }
    field_type = field_type.substr(0, bracket);
  }
  if (type == "std_msgs/Header" && rest == "seq") {
    types_[type_index(type)].fields.push_back(
        {.size = number_size(field_type), .is_dropped = true});
    return;
  }
  std::string name(field_type);
  field.size = number_size(field_type);
  field.is_string = field_type == "string";
  field.is_time = field_type == "time" || field_type == "duration";
  if (field.is_time) {
    uses_time_ = uses_time_ || field_type == "time";
    uses_duration_ = uses_duration_ || field_type == "duration";
    name = field_type == "time" ? "builtin_interfaces/Time" : "builtin_interfaces/Duration";
  } else if (field.size == 0 && !field.is_string) {
    if (field_type == "Header") {
      name = "std_msgs/Header";
    } else if (field_type.find('/') == std::string_view::npos) {
      name = type.substr(0, type.find('/') + 1) + name;
    }
    field.type = type_index(name);
  }
  types_[type_index(type)].fields.push_back(field);
  text_ += name + array + " " + field_name(rest) + "\n";
}

void Ros1Message::check_no_loop(std::size_t type, std::vector<Visit>& visits) const {
  if (visits[type] == Visit::kAbove) {
    throw std::invalid_argument(names_[type] + " contains itself");
  }
  if (visits[type] == Visit::kDone) {
    return;
  }
  visits[type] = Visit::kAbove;
  for (const Field& field : types_[type].fields) {
    if (field.size == 0 && !field.is_string && !field.is_time) {
      check_no_loop(field.type, visits);
    }
  }
  visits[type] = Visit::kDone;
}

bool Ros1Message::to_cdr(ByteView message, Bytes& cdr) const {
  cdr.clear();
  append_number(cdr, std::uint32_t{0x0100});  // CDR, little endian
  ByteCursor cursor(message);
  return convert(types_.front(), cursor, cdr) && cursor.left() == 0;
}

bool Ros1Message::convert(const Type& type, ByteCursor& from, Bytes& to) const {
  // Messages without fields take no bytes: a definition of such could fill any memory.
  constexpr std::size_t kLargestGrowth = 16;
  if (to.size() > kLargestGrowth * (from.position() + from.left() + 256)) {
    return false;
  }
  if (type.fields.empty()) {
    to.push_back(std::byte{0});  // ROS 2 gives a message without fields one
    return true;
  }
  return std::all_of(type.fields.begin(), type.fields.end(),
                     [&](const Field& field) { return convert(field, from, to); });
}

bool Ros1Message::convert(const Field& field, ByteCursor& from, Bytes& to) const {
  if (field.is_dropped) {
    return from.bytes(field.size).has_value();
  }
  std::uint32_t count = 1;
  if (field.is_array) {
    count = field.fixed_count;
    if (count == 0) {
      const auto given = from.number<std::uint32_t>();
      if (!given) {
        return false;
      }
      count = *given;
      align(to, sizeof(count));
      append_number(to, count);
    }
  }
  if (field.size > 0 || field.is_time) {
    const std::size_t size = field.is_time ? 4 : field.size;
    const auto numbers = from.bytes(std::uint64_t{count} * (field.is_time ? 2 * size : size));
    if (!numbers) {
      return false;
    }
    if (count > 0) {
      align(to, size);
      append(to, *numbers);
    }
    return true;
  }
  for (std::uint32_t k = 0; k < count; ++k) {
    if (field.is_string) {
      const auto text = from.text();
      if (!text) {
        return false;
      }
      align(to, sizeof(std::uint32_t));
      append_number(to, static_cast<std::uint32_t>(text->size() + 1));
      append(to, bytes_of(*text));
      to.push_back(std::byte{0});
    } else {
      if (!convert(types_[field.type], from, to)) {
        return false;
      }
    }
  }
  return true;
}

}  // namespace pipescout::bags
