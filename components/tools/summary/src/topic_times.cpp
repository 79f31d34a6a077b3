// SPDX-License-Identifier: Apache-2.0
#include "topic_times.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "pipescout/bag_topics/header_stamp.hpp"
#include "tables/values.hpp"

namespace pipescout::summary {
namespace {

constexpr double kNanoseconds = 1e9;
/// No driver is that late: stamps further off are of another clock.
constexpr double kOtherClock = 60.0;  // s

/// Many nodes publish what they say of themselves on one topic, each by its own clock: that of the
/// system beside a simulated one, which may not have begun. Such stamps are no measurements.
bool is_of_many_clocks(const std::string& type) {
  return type == "diagnostic_msgs/msg/DiagnosticArray" ||
         type == "pipescout_msgs/msg/MissionStatus";
}

double seconds(std::int64_t nanoseconds) {
  return static_cast<double>(nanoseconds) / kNanoseconds;
}

}  // namespace

TopicTimes::TopicTimes(bags::BagTopic topic, const MessageType* type)
    : topic_(std::move(topic)),
      has_header_(begins_with_header(type) && !is_of_many_clocks(topic_.type)) {}

void TopicTimes::add(const bags::BagMessage& message) {
  if (messages_ == 0) {
    first_ = message.log_time;
  } else {
    longest_gap_ = std::max(longest_gap_, message.log_time - last_);
  }
  last_ = message.log_time;
  ++messages_;
  bytes_ += message.data.size();
  const auto stamp = has_header_ ? header_stamp(message.data) : std::nullopt;
  if (!stamp) {
    return;
  }
  if (*stamp == 0) {
    ++without_stamp_;
    return;
  }
  if (stamped_ > 0 && *stamp < last_stamp_) {
    ++backwards_;
  }
  last_stamp_ = *stamp;
  ++stamped_;
  sum_of_delays_ += seconds(message.log_time - *stamp);
}

std::vector<MissionCell> TopicTimes::row() const {
  const double duration = seconds(last_ - first_);
  std::vector<MissionCell> cells{topic_.name, topic_.type, static_cast<std::int64_t>(messages_)};
  const auto number_or_none = [&](bool known, double value, double parts) {
    if (known) {
      cells.emplace_back(rounded(value, parts));
    } else {
      cells.emplace_back();
    }
  };
  const bool has_rate = messages_ > 1 && duration > 0;
  number_or_none(has_rate, static_cast<double>(messages_ - 1) / duration, 100);
  number_or_none(messages_ > 1, seconds(longest_gap_), 1000);
  const double delay = sum_of_delays_ / static_cast<double>(stamped_);
  number_or_none(stamped_ > 0 && std::abs(delay) <= kOtherClock, delay, 1000);
  number_or_none(true, static_cast<double>(bytes_) / 1e6, 1000);
  return cells;
}

std::vector<std::string> TopicTimes::remarks() const {
  std::vector<std::string> result;
  if (without_stamp_ > 0) {
    result.push_back(topic_.name + ": " + std::to_string(without_stamp_) + " of " +
                     std::to_string(messages_) + " messages have no stamp.");
  }
  if (backwards_ > 0) {
    result.push_back(topic_.name + ": stamps go back " + std::to_string(backwards_) + " times.");
  }
  if (stamped_ > 0) {
    const double delay = sum_of_delays_ / static_cast<double>(stamped_);
    if (std::abs(delay) > kOtherClock) {
      char text[64];
      std::snprintf(text, sizeof text, "%.3f", std::abs(delay));
      result.push_back(topic_.name + ": stamps are of another clock than the recording's, " + text +
                       (delay > 0 ? " s before it." : " s after it."));
    }
  }
  return result;
}

}  // namespace pipescout::summary
