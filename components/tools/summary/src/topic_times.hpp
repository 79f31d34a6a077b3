// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "pipescout/bags/bag_types.hpp"
#include "pipescout/idl/message_type.hpp"
#include "pipescout/mission_folder/mission_section.hpp"

namespace pipescout::summary {

/// When the messages of one topic came.
class TopicTimes {
 public:
  /// `type` may be null: unknown here.
  TopicTimes(bags::BagTopic topic, const MessageType* type);

  void add(const bags::BagMessage& message);

  [[nodiscard]] const bags::BagTopic& topic() const noexcept { return topic_; }
  [[nodiscard]] std::uint64_t messages() const noexcept { return messages_; }
  [[nodiscard]] std::uint64_t bytes() const noexcept { return bytes_; }
  /// topic, type, messages, rate [Hz], longest gap [s], delay [s], MB
  [[nodiscard]] std::vector<MissionCell> row() const;
  /// What is wrong with the stamps, one sentence each.
  [[nodiscard]] std::vector<std::string> remarks() const;

 private:
  bags::BagTopic topic_;
  bool has_header_;
  std::uint64_t messages_ = 0;
  std::uint64_t bytes_ = 0;
  std::int64_t first_ = 0;  // log times, ns
  std::int64_t last_ = 0;
  std::int64_t longest_gap_ = 0;
  std::uint64_t stamped_ = 0;
  std::uint64_t without_stamp_ = 0;
  std::uint64_t backwards_ = 0;  // stamps before the one of the message before
  std::int64_t last_stamp_ = 0;
  double sum_of_delays_ = 0.0;  // s, log time minus stamp
};

}  // namespace pipescout::summary
