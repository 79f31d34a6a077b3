// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "pipescout/runtime/names.hpp"
#include "pipescout/runtime/time.hpp"
#include "pipescout/runtime/transport.hpp"

namespace pipescout::host {

/// The claim of one process to the names of its nodes, against those of others: of several
/// processes that claim a name one keeps it, whatever the network loses, delays, or joins later.
///
/// Each process announces a text (`Announcements`): its state, the age of its claim, its names (24
/// bits of a hash each), and an answer to each other process that seems to have one of its names.
/// An answer tells the name, so that equal hashes of different names do no harm, and shows that the
/// other one is alive: a claim that a discovery server still tells of, of a process that was
/// killed, never answers.
///
/// The rule: who holds its names keeps them against one who still asks for them; of two in the same
/// state the earlier one keeps them. Ages are durations on steady clocks; they are compared by one
/// of the two, the one with the lower participant id, which tells its verdict: so both follow the
/// same comparison, although a message takes its time. Ages that differ by less than that time may
/// be judged either way; equal ones are decided by the id.
///
/// A new claim is asked for in several rounds. A round is lost with probability 1 - (1 - p)^2 where
/// a datagram is lost with probability p: of eight rounds all with 8e-9 at p = 5 %, 3e-4 at 20 %.
/// Later, too, two that meet answer each other, in as many rounds.
///
/// Pure: knows no clock and no network. Not thread-safe.
class NameClaim {
 public:
  enum class State {
    kAsking,   ///< not confirmed yet
    kHolding,  ///< no other process has objected
    kGivenUp   ///< another process has the names
  };
  struct Pace {
    /// Between two announcements of changes. Should exceed the time in which an answer comes: else
    /// the last rounds are judged too early.
    Duration period = std::chrono::milliseconds(200);
    int rounds = 8;
  };
  /// Another process with a name of this one.
  struct Rival {
    Gid participant;
    std::string name;   ///< that both have, fully qualified
    bool wins = false;  ///< this process has to give way
    Duration age{};     ///< of its claim, as far as it has told
    bool operator==(const Rival&) const = default;
  };

  NameClaim(Gid self, const std::vector<NodeName>& names, Pace pace, SteadyTime now);

  /// What other processes say now; those that have gone are missing.
  void hear(const std::map<Gid, std::string>& others, SteadyTime now);
  /// The text that is to be announced now; nothing: none, until `due` or until something is heard.
  [[nodiscard]] std::optional<std::string> on_time(SteadyTime now);
  /// When `on_time` is to be called at the latest; nothing: only after `hear`.
  [[nodiscard]] std::optional<SteadyTime> due() const;

  [[nodiscard]] State state() const noexcept { return state_; }
  /// Who has shown that it has a name of this process and is alive; one that wins before others. A
  /// holder gives up when a rival wins, and then this is that one. One that asks does not give up:
  /// the rival may be a mission that is just ending.
  [[nodiscard]] std::optional<Rival> rival() const;

 private:
  enum class Verdict { kNone, kOlder, kYounger };
  struct Other {
    std::string text;
    State state = State::kAsking;
    Duration age{};
    SteadyTime since{};     ///< of its claim, on our clock: not earlier than that
    SteadyTime heard_at{};  ///< the last change of its text
    int silent_rounds = 0;  ///< announcements of ours since then
    std::string shared;     ///< a name of ours that it seems to have; empty: none
    bool is_met = false;    ///< it has answered with a name of ours
    bool says_older = false;
    Verdict verdict = Verdict::kNone;  ///< ours on ourselves, where it is ours to judge
  };

  void take(const Gid& gid, const std::string& text, SteadyTime now);
  void judge(const Gid& gid, Other& other) const;
  [[nodiscard]] bool loses_to(const Gid& gid, const Other& other) const;
  [[nodiscard]] bool is_live_rival(const Other& other) const;
  [[nodiscard]] bool has_open_question() const;
  [[nodiscard]] std::string text(SteadyTime now) const;

  const Gid self_;
  /// By their hashes. Of two with the same one, which is as good as impossible (3e-6 for ten
  /// names), the second is not claimed.
  std::map<std::uint32_t, std::string> names_;
  const Pace pace_;
  const SteadyTime since_;
  State state_ = State::kAsking;
  std::optional<Rival> winner_;  ///< once this process has given up
  std::map<Gid, Other> others_;
  int rounds_left_;  ///< of this process's own asking
  bool has_news_ = true;
  std::optional<SteadyTime> announced_at_;
};

}  // namespace pipescout::host
