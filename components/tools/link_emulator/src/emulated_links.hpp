// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <random>
#include <vector>

namespace pipescout_test {

/// What a link does to the frames of each direction.
struct LinkOptions {
  double loss = 0.0;                  ///< probability that a frame is lost, 0..1
  std::chrono::nanoseconds delay{0};  ///< from the end of sending to arrival
  double rate = 0.0;                  ///< bit/s; 0: not limited
  bool shared = false;                ///< the rate is that of one radio channel for all directions
  std::minstd_rand::result_type seed = 1;
};

/// Frames on their way over lossy links, one direction of a link per index. Frames of a direction
/// keep their order. Where the rate is shared, the directions that have something to send take
/// turns, frame by frame, as the stations of a radio cell do; a frame that is lost takes its time
/// on the channel all the same. A direction whose queue holds 50 ms of its rate (at least ten full
/// frames) drops what comes. Time is an argument and must not run backwards.
class EmulatedLinks {
 public:
  using Time = std::chrono::nanoseconds;
  using Frame = std::vector<std::uint8_t>;
  using Deliver = std::function<void(std::size_t direction, const Frame& frame)>;

  EmulatedLinks(const LinkOptions& options, std::size_t directions);

  /// A frame is there to be sent. The first `header` bytes do not count on the channel.
  void send(std::size_t direction, Frame frame, std::size_t header, Time now);

  /// Delivers, in order of arrival, all that has arrived by now.
  void advance(Time now, const Deliver& deliver);

  /// When `advance` has something to do next; nothing: not before the next frame is sent.
  [[nodiscard]] std::optional<Time> next() const;

 private:
  struct Waiting {
    Frame frame;
    std::size_t bytes = 0;  // on the channel
    Time since{0};
  };
  struct Queue {
    std::deque<Waiting> frames;
    std::size_t bytes = 0;
  };
  struct Channel {
    std::vector<std::size_t> directions;
    std::size_t turn = 0;  // place in `directions` of the one that sends next
    Time free_at{0};
  };
  struct Arriving {
    std::size_t direction = 0;
    Frame frame;
  };

  void transmit(Channel& channel, Time now);
  [[nodiscard]] std::optional<std::size_t> next_direction(const Channel& channel) const;
  [[nodiscard]] Time duration(std::size_t bytes) const;

  LinkOptions options_;
  std::size_t most_bytes_;
  std::vector<Queue> queues_;
  std::vector<Channel> channels_;
  std::multimap<Time, Arriving> arriving_;
  std::minstd_rand random_;
};

}  // namespace pipescout_test
