// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "pipescout/bags/bag_reader.hpp"
#include "pipescout/bags/bag_writer.hpp"

namespace pipescout::bags::testing {

using Data = std::vector<std::byte>;

/// A message with its content, to be compared.
struct Stored {
  std::string topic;
  std::int64_t log_time = 0;
  std::int64_t publish_time = 0;
  Data data;

  bool operator==(const Stored&) const = default;
};

inline Data bytes(const std::string& text) {
  Data result(text.size());
  std::memcpy(result.data(), text.data(), text.size());
  return result;
}

/// Bytes that begin like CDR and do not compress well.
inline Data cdr(std::mt19937& random, std::size_t size) {
  Data result(size + 4);
  result[1] = std::byte{1};
  for (std::size_t k = 4; k < result.size(); ++k) {
    result[k] = static_cast<std::byte>(random());
  }
  return result;
}

inline BagTopic topic(const std::string& name, const std::string& type = "std_msgs/msg/String") {
  return {.name = name,
          .type = type,
          .offered_qos_profiles = "- history: 1\n  depth: 10\n",
          .schema_encoding = "ros2msg",
          .schema_text = "string data\n"};
}

inline void write(BagWriter& writer, const Stored& message) {
  writer.write({.topic = writer.add_topic(topic(message.topic)),
                .log_time = message.log_time,
                .publish_time = message.publish_time,
                .data = message.data});
}

/// Messages on two topics, 10 ms apart, of 16 bytes to about `largest`, no two alike.
inline std::vector<Stored> messages(std::size_t count, std::size_t largest, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::vector<Stored> result;
  for (std::size_t k = 0; k < count; ++k) {
    const std::int64_t time = 1'700'000'000'000'000'000 + static_cast<std::int64_t>(k) * 10'000'000;
    result.push_back(
        {k % 3 == 0 ? "/image" : "/pose", time, time, cdr(random, 12 + random() % (largest + 1))});
  }
  return result;
}

/// Everything up to the end or the first thing that cannot be read, which goes to `error`.
inline std::vector<Stored> read(BagReader& reader, std::string* error = nullptr) {
  std::vector<Stored> result;
  try {
    while (const auto message = reader.next()) {
      result.push_back({reader.topics().at(message->topic).name,
                        message->log_time,
                        message->publish_time,
                        {message->data.begin(), message->data.end()}});
    }
  } catch (const BagError& fault) {
    if (error == nullptr) {
      throw;
    }
    *error = fault.what();
  }
  return result;
}

inline std::vector<Stored> read(const std::filesystem::path& bag) {
  BagReader reader(bag);
  return read(reader);
}

/// The content with one to four places changed, left out or added, and now and then the end cut
/// off.
inline std::string mutated(std::string content, std::mt19937& random) {
  for (std::size_t changes = 1 + random() % 4; changes-- > 0 && !content.empty();) {
    const std::size_t place = random() % content.size();
    switch (random() % 9) {
      case 0:
        content.resize(place);
        break;
      case 1:
      case 2:
        content.erase(place, 1 + random() % 40);
        break;
      case 3:
      case 4:
        content.insert(place, 1 + random() % 40, static_cast<char>(random()));
        break;
      default:
        content[place] = static_cast<char>(random());
    }
  }
  return content;
}

inline void write_file(const std::filesystem::path& path, const std::string& content) {
  std::ofstream(path, std::ios::binary) << content;
}

}  // namespace pipescout::bags::testing
