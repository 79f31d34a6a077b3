// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/synchronizer.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>

#include "text_for_people.hpp"

namespace pipescout {
namespace {

constexpr std::size_t kFewestStreams = 2;
constexpr std::size_t kMostStreams = 9;

void check(const SynchronizerOptions& options, std::size_t streams) {
  const auto refuse = [](const std::string& text) {
    throw std::invalid_argument("synchronizer: " + text);
  };
  if (streams < kFewestStreams || streams > kMostStreams) {
    refuse(std::to_string(streams) + " streams, not 2 to 9");
  }
  if (options.queue_size == 0) {
    refuse("queue_size is 0");
  }
  if (!(options.age_penalty >= 0)) {
    refuse("age_penalty is " + text_for_people(options.age_penalty) + ", negative or none");
  }
  if (options.longest_interval < Duration::zero()) {
    refuse("longest_interval is negative");
  }
  if (options.set_back < Duration::zero()) {
    refuse("set_back is negative");
  }
  if (!options.shortest_spacing.empty() && options.shortest_spacing.size() != streams) {
    refuse("shortest_spacing has " + std::to_string(options.shortest_spacing.size()) +
           " values for " + std::to_string(streams) + " streams");
  }
  if (std::ranges::any_of(options.shortest_spacing,
                          [](Duration spacing) { return spacing < Duration::zero(); })) {
    refuse("shortest_spacing has a negative value");
  }
}

}  // namespace

Synchronizer::Synchronizer(std::size_t streams, SynchronizerOptions options, Callback callback)
    : options_(std::move(options)), callback_(std::move(callback)) {
  check(options_, streams);
  streams_.resize(streams);
  statistics_.streams.resize(streams);
}

void Synchronizer::add(std::size_t stream, Time stamp, Message message) {
  auto& counts = statistics_.streams.at(stream);
  std::optional<Time>& last = streams_[stream].last;
  ++counts.received;
  if (last && stamp <= *last) {
    if (*last - stamp <= options_.set_back) {
      ++counts.late;
      return;
    }
    ++statistics_.set_back;
    forget_all();
  }
  last = stamp;
  if (options_.policy == SynchronizerPolicy::kExact) {
    add_exact(stream, stamp, std::move(message));
  } else {
    add_approximate(stream, stamp, std::move(message));
  }
}

void Synchronizer::forget_all() {
  for (auto& [stamp, messages] : incomplete_) {
    for (std::size_t i = 0; i < messages.size(); ++i) {
      statistics_.streams[i].unmatched += messages[i] ? 1 : 0;
    }
  }
  incomplete_.clear();
  for (std::size_t i = 0; i < streams_.size(); ++i) {
    statistics_.streams[i].unmatched += streams_[i].ahead.size() + streams_[i].passed.size();
    streams_[i] = {};
  }
  has_candidate_ = false;
  candidate_.clear();
}

void Synchronizer::add_exact(std::size_t stream, Time stamp, Message message) {
  auto& messages = incomplete_[stamp];
  messages.resize(streams_.size());
  messages[stream] = std::move(message);
  if (std::ranges::all_of(messages, [](const Message& each) { return each != nullptr; })) {
    const std::vector<Message> set = std::move(messages);
    const auto end = incomplete_.find(stamp);
    // Streams are in order, so what is earlier and not complete will not be.
    for (auto entry = incomplete_.begin(); entry != end; ++entry) {
      for (std::size_t i = 0; i < streams_.size(); ++i) {
        statistics_.streams[i].unmatched += entry->second[i] ? 1 : 0;
      }
    }
    incomplete_.erase(incomplete_.begin(), std::next(end));
    ++statistics_.sets;
    for (auto& counts : statistics_.streams) {
      ++counts.matched;
    }
    callback_(set);
  } else if (incomplete_.size() > options_.queue_size) {
    for (std::size_t i = 0; i < streams_.size(); ++i) {
      statistics_.streams[i].queue_full += incomplete_.begin()->second[i] ? 1 : 0;
    }
    incomplete_.erase(incomplete_.begin());
  }
}

void Synchronizer::add_approximate(std::size_t stream, Time stamp, Message message) {
  Stream& own = streams_[stream];
  own.ahead.push_back({stamp, std::move(message)});
  if (own.ahead.size() + own.passed.size() > options_.queue_size) {
    // Without the oldest message the search must begin again.
    has_candidate_ = false;
    candidate_.clear();
    for (std::size_t i = 0; i < streams_.size(); ++i) {
      take_back(i, streams_[i].passed.size());
    }
    own.ahead.pop_front();
    own.lost = true;
    ++statistics_.streams[stream].queue_full;
  }
  search();
}

bool Synchronizer::all_have_messages() const {
  return std::ranges::none_of(streams_, [](const Stream& stream) { return stream.ahead.empty(); });
}

Time Synchronizer::next_stamp(std::size_t stream) const {
  const Stream& own = streams_[stream];
  if (!own.ahead.empty()) {
    return own.ahead.front().stamp;
  }
  // Only asked for with a candidate, which has a message of each stream; and a set that is to be
  // better must not lack the pivot, so what comes before it does not matter.
  const Duration spacing =
      options_.shortest_spacing.empty() ? Duration::zero() : options_.shortest_spacing[stream];
  return std::max(add_saturated(*own.last, spacing), pivot_stamp_);
}

Synchronizer::Span Synchronizer::span() const {
  Span result{0, 0, next_stamp(0), next_stamp(0)};
  for (std::size_t i = 1; i < streams_.size(); ++i) {
    const Time stamp = next_stamp(i);
    if (stamp < result.begin) {
      result.first = i;
      result.begin = stamp;
    }
    if (stamp > result.end) {
      result.last = i;
      result.end = stamp;
    }
  }
  return result;
}

bool Synchronizer::outweighs(Duration later_end, Duration later_begin) const {
  return static_cast<double>(later_end.count()) * (1 + options_.age_penalty) >=
         static_cast<double>(later_begin.count());
}

void Synchronizer::pass(std::size_t stream) {
  Stream& own = streams_[stream];
  own.passed.push_back(std::move(own.ahead.front()));
  own.ahead.pop_front();
}

void Synchronizer::take_back(std::size_t stream, std::size_t count) {
  Stream& own = streams_[stream];
  for (; count > 0; --count) {
    own.ahead.push_front(std::move(own.passed.back()));
    own.passed.pop_back();
  }
}

void Synchronizer::make_candidate(const Span& span) {
  candidate_.clear();
  for (const Stream& stream : streams_) {
    candidate_.push_back(stream.ahead.front());
  }
  candidate_begin_ = span.begin;
  candidate_end_ = span.end;
  has_candidate_ = true;
}

void Synchronizer::search() {
  while (all_have_messages()) {
    const Span next = span();
    if (!has_candidate_) {
      // Whatever set the latest one is in, the earliest is in none; and a set must not pass over
      // one that a lost message would have made.
      for (std::size_t i = 0; i < streams_.size(); ++i) {
        streams_[i].lost = streams_[i].lost && i == next.last;
      }
      if (next.end - next.begin > options_.longest_interval || streams_[next.last].lost) {
        streams_[next.first].ahead.pop_front();
        ++statistics_.streams[next.first].unmatched;
        continue;
      }
      make_candidate(next);
      pivot_ = next.last;
      pivot_stamp_ = next.end;
    } else if (!outweighs(next.end - candidate_end_, next.begin - candidate_begin_)) {
      make_candidate(next);
    }
    // All sets with the pivot are tried once it is the earliest. And none that ends as late as this
    // one can be better when even one that begins with the pivot were not.
    if (next.first == pivot_ ||
        outweighs(next.end - candidate_end_, pivot_stamp_ - candidate_begin_)) {
      tell_candidate();
      continue;
    }
    pass(next.first);
    if (!all_have_messages()) {
      search_ahead();
    }
  }
}

void Synchronizer::search_ahead() {
  std::vector<std::size_t> tried(streams_.size(), 0);
  while (true) {
    const Span next = span();
    if (outweighs(next.end - candidate_end_, pivot_stamp_ - candidate_begin_)) {
      tell_candidate();  // takes back what was tried
      return;
    }
    if (!outweighs(next.end - candidate_end_, next.begin - candidate_begin_)) {
      break;  // what comes may make a better set
    }
    // A message that is not there is not before the pivot, so the test above has ended the search.
    pass(next.first);
    ++tried[next.first];
  }
  for (std::size_t i = 0; i < streams_.size(); ++i) {
    take_back(i, tried[i]);
  }
}

void Synchronizer::tell_candidate() {
  std::vector<Message> set;
  for (std::size_t i = 0; i < streams_.size(); ++i) {
    Stream& own = streams_[i];
    take_back(i, own.passed.size());
    while (own.ahead.front().stamp < candidate_[i].stamp) {
      own.ahead.pop_front();
      ++statistics_.streams[i].unmatched;
    }
    own.ahead.pop_front();
    ++statistics_.streams[i].matched;
    set.push_back(std::move(candidate_[i].message));
  }
  has_candidate_ = false;
  candidate_.clear();
  ++statistics_.sets;
  callback_(set);
}

}  // namespace pipescout
