// SPDX-License-Identifier: Apache-2.0
#include "weld_signal.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <memory>
#include <optional>
#include <pipescout_msgs/msg/eddy_current_samples.hpp>
#include <pipescout_msgs/msg/fused_odometer.hpp>
#include <vector>

#include "pipescout/bags/bag_reader.hpp"
#include "pipescout/bags/topic_choice.hpp"
#include "pipescout/command_line/command.hpp"
#include "pipescout/command_line/suggestion.hpp"
#include "pipescout/csv/csv_file.hpp"
#include "pipescout/csv/csv_reader.hpp"
#include "pipescout/csv/csv_words.hpp"
#include "pipescout/idl/message_type.hpp"

namespace pipescout::inspect {
namespace {

using command_line::CommandError;
using odometry::Impedance;
using odometry::kMaxEddyCurrentChannels;
using Samples = pipescout_msgs::msg::EddyCurrentSamples;
using Fused = pipescout_msgs::msg::FusedOdometer;

constexpr const char* kSamplesType = "pipescout_msgs/msg/EddyCurrentSamples";
constexpr const char* kFusedType = "pipescout_msgs/msg/FusedOdometer";

struct ChannelColumns {
  std::size_t x = 0;
  std::size_t y = 0;
};

std::size_t signal_column(const CsvReader& table, const std::string& name,
                          const SignalColumns& columns) {
  const auto found = table.find_column(name);
  if (!found) {
    throw CsvError(table.path(), table.header_line(),
                   "no column '" + name + "'" + command_line::suggestion(name, table.columns()) +
                       "; the file has " + quoted_list(table.columns()) +
                       (columns.path.empty() ? " (other names need --columns)"
                                             : "; named in " + columns.path));
  }
  return *found;
}

std::vector<ChannelColumns> channel_columns(const CsvReader& table, const SignalColumns& columns) {
  std::vector<ChannelColumns> result;
  for (std::size_t c = 0; c < columns.x.size(); ++c) {
    result.push_back(
        {signal_column(table, columns.x[c], columns), signal_column(table, columns.y[c], columns)});
  }
  if (!result.empty()) {
    return result;
  }
  for (std::size_t c = 1; c <= kMaxEddyCurrentChannels; ++c) {
    const std::string number = std::to_string(c);
    if (!table.find_column("x" + number)) {
      break;
    }
    result.push_back(
        {signal_column(table, "x" + number, columns), signal_column(table, "y" + number, columns)});
  }
  if (result.empty()) {
    result.push_back({signal_column(table, "x", columns), signal_column(table, "y", columns)});
  }
  return result;
}

/// NaN where there is none.
double signal_value(const CsvReader& table, std::size_t column) {
  if (table.cells()[column].empty()) {
    return std::numeric_limits<double>::quiet_NaN();
  }
  const auto value = table.number(column);
  if (!value) {
    table.refuse(column, "a number");
  }
  return *value;
}

double distance_value(const CsvReader& table, std::size_t column) {
  const double value = signal_value(table, column);
  if (!std::isfinite(value)) {
    table.refuse(column, "a distance, which every sample needs");
  }
  return value;
}

/// What the file says of the unit of the distance, the mapping must say too.
void check_unit(const CsvReader& table, std::size_t column, const SignalColumns& columns) {
  const std::string said = table.numbers()->unit(column);
  const auto metres = metres_per_list_unit(said);
  if (metres && *metres != columns.metres_per_unit) {
    throw CsvError(
        table.path(), table.header_line(),
        "column '" + columns.distance + "' is in " + said + ", and the unit is " +
            (columns.path.empty() ? "m without --columns" : "another one in " + columns.path));
  }
}

struct FusedPoint {
  double time = 0.0;      // s
  double distance = 0.0;  // m
};

template <typename Stamp>
double seconds(const Stamp& stamp) {
  return static_cast<double>(stamp.sec) + 1e-9 * static_cast<double>(stamp.nanosec);
}

/// Calls `take` with each message of a topic that stands before the first damage; returns what the
/// damage is, empty for a bag that is whole.
template <typename Message, typename Take>
std::string for_each_message(const std::string& bag, const std::string& topic, const char* type,
                             const Take& take) {
  bags::BagReader reader(bag);
  reader.set_filter({.topics = std::vector<std::string>{topic}});
  const MessageType& message_type = *find_message_type(type);
  const std::shared_ptr<void> message = message_type.create();
  std::string damage;
  for (std::size_t number = 1; const auto next = reader.next_before_damage(damage); ++number) {
    if (!message_type.deserialize(next->data, message.get())) {
      throw CommandError(bag + ": message " + std::to_string(number) + " of " + topic +
                         " cannot be decoded");
    }
    take(number, *static_cast<const Message*>(message.get()));
  }
  return damage;
}

/// The fused distances, times rising.
std::vector<FusedPoint> read_distances(const std::string& bag, const std::string& topic,
                                       std::string& damage) {
  std::vector<FusedPoint> points;
  damage = for_each_message<Fused>(bag, topic, kFusedType, [&](std::size_t, const Fused& message) {
    const FusedPoint point{seconds(message.header.stamp), message.distance};
    // Without consensus there is no distance; what lies between is a straight line.
    if (std::isfinite(point.distance) && (points.empty() || point.time > points.back().time)) {
      points.push_back(point);
    }
  });
  if (points.size() < 2) {
    throw CommandError(bag + ": " + topic + " has fewer than 2 distances");
  }
  return points;
}

std::optional<double> distance_at(const std::vector<FusedPoint>& points, double time) {
  const auto next =
      std::lower_bound(points.begin(), points.end(), time,
                       [](const FusedPoint& point, double at) { return point.time < at; });
  if (next == points.end() || (next == points.begin() && time < next->time)) {
    return std::nullopt;
  }
  if (next == points.begin()) {
    return next->distance;
  }
  const FusedPoint& before = *std::prev(next);
  return std::lerp(before.distance, next->distance,
                   (time - before.time) / (next->time - before.time));
}

}  // namespace

std::vector<std::string> read_signal_table(const std::string& path, const SignalColumns& columns,
                                           const SignalSink& sink) {
  const std::string bytes = read_csv_text(path);
  CsvFormat format = columns.format;
  if (columns.path.empty()) {
    format.settings = "the file of --columns";
  }
  CsvReader table(bytes, path, format);
  const std::size_t distance = signal_column(table, columns.distance, columns);
  check_unit(table, distance, columns);
  const std::vector<ChannelColumns> channels = channel_columns(table, columns);
  sink.begin(channels.size());
  std::array<Impedance, kMaxEddyCurrentChannels> values{};
  while (table.next()) {
    for (std::size_t c = 0; c < channels.size(); ++c) {
      values[c] = {signal_value(table, channels[c].x), signal_value(table, channels[c].y)};
    }
    sink.sample(distance_value(table, distance) * columns.metres_per_unit,
                {values.data(), channels.size()});
  }
  return table.notes();
}

BagRemainder read_signal_bag(const std::string& bag, const std::string& samples_topic,
                             const std::string& odometer_topic, const SignalSink& sink) {
  const bags::BagReader reader(bag);
  const std::string samples =
      bags::choose_topic(reader, bag, {kSamplesType}, samples_topic).topic.name;
  const std::string odometer =
      bags::choose_topic(reader, bag, {kFusedType}, odometer_topic, "--odometer-topic").topic.name;
  BagRemainder remainder;
  const std::vector<FusedPoint> points = read_distances(bag, odometer, remainder.damage);
  std::size_t channels = 0;
  std::array<Impedance, kMaxEddyCurrentChannels> values{};
  const auto take = [&](std::size_t number, const Samples& message) {
    const auto refuse = [&](const std::string& problem) {
      throw CommandError(bag + ": message " + std::to_string(number) + " of " + samples + ": " +
                         problem);
    };
    if (message.channels < 1 || message.channels > kMaxEddyCurrentChannels) {
      refuse("channels: " + std::to_string(message.channels) + " is outside [1, " +
             std::to_string(kMaxEddyCurrentChannels) + "]");
    }
    if (channels != 0 && message.channels != channels) {
      refuse("channels: " + std::to_string(message.channels) + " and before " +
             std::to_string(channels));
    }
    if (message.x.size() != message.y.size() || message.x.size() % message.channels != 0) {
      refuse(std::to_string(message.x.size()) + " values of x and " +
             std::to_string(message.y.size()) + " of y");
    }
    if (!(message.sample_interval > 0.0) || !std::isfinite(message.sample_interval)) {
      refuse("sample_interval: " + format_csv_number(message.sample_interval) +
             " is not a finite number above 0");
    }
    if (channels == 0) {
      channels = message.channels;
      sink.begin(channels);
    }
    for (std::size_t k = 0; k * channels < message.x.size(); ++k) {
      const auto distance = distance_at(
          points, seconds(message.header.stamp) + static_cast<double>(k) * message.sample_interval);
      if (!distance) {
        ++remainder.passed_over;
        continue;
      }
      for (std::size_t c = 0; c < channels; ++c) {
        values[c] = {message.x[k * channels + c], message.y[k * channels + c]};
      }
      sink.sample(*distance, {values.data(), channels});
    }
  };
  if (const std::string damage = for_each_message<Samples>(bag, samples, kSamplesType, take);
      !damage.empty()) {
    remainder.damage = damage;
  }
  if (channels == 0) {
    throw CommandError(bag + ": " + samples + " has no messages");
  }
  return remainder;
}

}  // namespace pipescout::inspect
