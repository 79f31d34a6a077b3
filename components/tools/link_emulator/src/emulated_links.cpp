// SPDX-License-Identifier: Apache-2.0
#include "emulated_links.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace pipescout_test {
namespace {

constexpr double kQueueSeconds = 0.05;
constexpr double kLeastQueueBytes = 10 * 1514.0;  // full Ethernet frames
constexpr double kBitsPerByte = 8.0;
constexpr double kNanosecondsPerSecond = 1e9;

}  // namespace

EmulatedLinks::EmulatedLinks(const LinkOptions& options, std::size_t directions)
    : options_(options),
      most_bytes_(options.rate > 0.0
                      ? static_cast<std::size_t>(
                            std::max(kLeastQueueBytes, options.rate / kBitsPerByte * kQueueSeconds))
                      : std::numeric_limits<std::size_t>::max()),
      queues_(directions),
      channels_(options.shared ? 1 : directions),
      random_(options.seed) {
  for (std::size_t direction = 0; direction < directions; ++direction) {
    channels_[options.shared ? 0 : direction].directions.push_back(direction);
  }
}

void EmulatedLinks::send(std::size_t direction, Frame frame, std::size_t header, Time now) {
  Queue& queue = queues_[direction];
  const std::size_t bytes = frame.size() - std::min(header, frame.size());
  Channel& channel = channels_[options_.shared ? 0 : direction];
  transmit(channel, now);
  if (bytes > most_bytes_ || queue.bytes > most_bytes_ - bytes) {
    return;
  }
  queue.bytes += bytes;
  queue.frames.push_back({std::move(frame), bytes, now});
  transmit(channel, now);
}

void EmulatedLinks::advance(Time now, const Deliver& deliver) {
  for (Channel& channel : channels_) {
    transmit(channel, now);
  }
  while (!arriving_.empty() && arriving_.begin()->first <= now) {
    const auto first = arriving_.extract(arriving_.begin());
    deliver(first.mapped().direction, first.mapped().frame);
  }
}

std::optional<EmulatedLinks::Time> EmulatedLinks::next() const {
  std::optional<Time> earliest;
  const auto consider = [&](Time time) { earliest = std::min(earliest.value_or(time), time); };
  if (!arriving_.empty()) {
    consider(arriving_.begin()->first);
  }
  for (const Channel& channel : channels_) {
    if (next_direction(channel)) {
      consider(channel.free_at);
    }
  }
  return earliest;
}

// All frames whose transmission begins by now.
void EmulatedLinks::transmit(Channel& channel, Time now) {
  while (channel.free_at <= now) {
    const auto place = next_direction(channel);
    if (!place) {
      return;
    }
    const std::size_t direction = channel.directions[*place];
    channel.turn = (*place + 1) % channel.directions.size();
    Queue& queue = queues_[direction];
    Waiting sent = std::move(queue.frames.front());
    queue.frames.pop_front();
    queue.bytes -= sent.bytes;
    channel.free_at = std::max(channel.free_at, sent.since) + duration(sent.bytes);
    if (!std::bernoulli_distribution(options_.loss)(random_)) {
      arriving_.emplace(channel.free_at + options_.delay,
                        Arriving{direction, std::move(sent.frame)});
    }
  }
}

std::optional<std::size_t> EmulatedLinks::next_direction(const Channel& channel) const {
  for (std::size_t step = 0; step < channel.directions.size(); ++step) {
    const std::size_t place = (channel.turn + step) % channel.directions.size();
    if (!queues_[channel.directions[place]].frames.empty()) {
      return place;
    }
  }
  return std::nullopt;
}

EmulatedLinks::Time EmulatedLinks::duration(std::size_t bytes) const {
  if (options_.rate <= 0.0) {
    return Time{0};
  }
  return Time{std::llround(static_cast<double>(bytes) * kBitsPerByte / options_.rate *
                           kNanosecondsPerSecond)};
}

}  // namespace pipescout_test
