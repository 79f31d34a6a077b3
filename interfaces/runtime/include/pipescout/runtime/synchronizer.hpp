// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "pipescout/runtime/time.hpp"

namespace pipescout {

enum class SynchronizerPolicy {
  kExact,       ///< messages of one set have the same stamp
  kApproximate  ///< their stamps lie as close together as the streams allow
};

/// The semantics, and the defaults, are those of ROS's message_filters.
struct SynchronizerOptions {
  SynchronizerPolicy policy = SynchronizerPolicy::kApproximate;
  /// Messages of each stream that wait, or for kExact sets that are not complete. At least 1.
  std::size_t queue_size = 10;
  /// kApproximate: a later set must be better by this share to be preferred. Not negative.
  double age_penalty = 0.1;
  /// kApproximate: sets whose stamps lie further apart are none. Not negative.
  Duration longest_interval = Duration::max();
  /// kApproximate: for each stream, what its stamps lie apart at least; lets a set be told before
  /// the next message shows that there is no better one. Empty: unknown. Not negative.
  std::vector<Duration> shortest_spacing = {};
  /// A stamp that is earlier than the one before of its stream by more than this is of a clock that
  /// was set back: all that waits is dropped. By less: the message is late, and dropped. Not
  /// negative.
  Duration set_back = std::chrono::seconds(1);
};

struct SynchronizerStatistics {
  struct Stream {
    std::uint64_t received = 0;
    std::uint64_t matched = 0;
    std::uint64_t unmatched = 0;   ///< no set wanted them: usual where rates differ
    std::uint64_t queue_full = 0;  ///< dropped before it was known whether a set wants them
    std::uint64_t late = 0;        ///< stamp not after that of the one before
  };
  std::vector<Stream> streams;
  std::uint64_t sets = 0;
  std::uint64_t set_back = 0;  ///< how often all that waited was dropped
};

/// Makes sets, of one message of each stream, whose stamps belong together. Types are known to the
/// typed front only, `SynchronizedSubscriptions`. Not thread-safe.
///
/// kApproximate is the algorithm that ROS publishes at
/// wiki.ros.org/message_filters/ApproximateTime. It needs no parameter that says how close is close
/// enough, and of the sets that it makes holds: a message is in one set at most; sets do not cross
/// (each message of a later one is later than that of the earlier one); between two of them no set
/// was passed over; and each is the tightest that its pivot can be in, the pivot being the message
/// that came last of those that were needed for a first set. A set whose stamps are all equal is
/// told at once.
class Synchronizer {
 public:
  using Message = std::shared_ptr<const void>;
  /// The messages of a set, in the order of the streams.
  using Callback = std::function<void(const std::vector<Message>&)>;

  /// 2 to 9 streams. Throws std::invalid_argument naming the option that is out of range.
  Synchronizer(std::size_t streams, SynchronizerOptions options, Callback callback);

  /// Takes a message; `callback` is called for each set that is now known. The stream must be below
  /// their number.
  void add(std::size_t stream, Time stamp, Message message);

  [[nodiscard]] const SynchronizerStatistics& statistics() const noexcept { return statistics_; }

 private:
  struct Entry {
    Time stamp;
    Message message;
  };
  struct Stream {
    std::deque<Entry> ahead;   // not looked at yet, in the order of stamps
    std::deque<Entry> passed;  // looked at since there is a candidate
    std::optional<Time> last;  // stamp of the latest that came
    bool lost = false;         // its queue was full, and since then no message of it was a pivot
  };
  /// Streams with the earliest and the latest of the next messages, and their stamps.
  struct Span {
    std::size_t first = 0;
    std::size_t last = 0;
    Time begin;
    Time end;
  };

  void add_exact(std::size_t stream, Time stamp, Message message);
  void add_approximate(std::size_t stream, Time stamp, Message message);
  void forget_all();
  void search();
  /// What can be said with messages that are missing, from when they come at the earliest.
  void search_ahead();
  [[nodiscard]] bool all_have_messages() const;
  [[nodiscard]] Time next_stamp(std::size_t stream) const;
  [[nodiscard]] Span span() const;
  /// True when the growth at the end, with the penalty, is at least that gain at the begin.
  [[nodiscard]] bool outweighs(Duration later_end, Duration later_begin) const;
  void pass(std::size_t stream);
  void take_back(std::size_t stream, std::size_t count);
  void make_candidate(const Span& span);
  void tell_candidate();

  const SynchronizerOptions options_;
  const Callback callback_;
  std::vector<Stream> streams_;
  SynchronizerStatistics statistics_;

  // kApproximate: the best set so far that the pivot can be in.
  bool has_candidate_ = false;
  std::vector<Entry> candidate_;
  Time candidate_begin_;
  Time candidate_end_;
  std::size_t pivot_ = 0;
  Time pivot_stamp_;

  std::map<Time, std::vector<Message>> incomplete_;  // kExact
};

}  // namespace pipescout
