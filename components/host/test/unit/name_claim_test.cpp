// SPDX-License-Identifier: Apache-2.0
#include "core/name_claim.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace pipescout::host {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using State = NameClaim::State;

Gid gid(std::uint8_t number) {
  Gid result;
  result.bytes[3] = number;
  result.bytes[15] = 0xc1;
  return result;
}

std::vector<NodeName> robot(const std::string& ns = "/robot_1") {
  return {{ns, "odometry_fusion"}, {ns, "state_estimator"}};
}

/// Processes on a network that loses and delays announcements, each of which repeats what it says
/// once a second.
class Network {
 public:
  Network(double loss, Duration delay, unsigned seed) : loss_(loss), delay_(delay), random_(seed) {}

  /// Lower numbers have lower ids.
  NameClaim& start(std::uint8_t number, const std::vector<NodeName>& names = robot()) {
    processes_[gid(number)].claim = std::make_unique<NameClaim>(gid(number), names, Pace{}, now_);
    return *processes_.at(gid(number)).claim;
  }
  /// What `about` said last reaches `to`, as from a discovery server.
  void tell_of(std::uint8_t about, std::uint8_t to) {
    auto& told = processes_.at(gid(to));
    told.heard[gid(about)] = processes_.at(gid(about)).says;
    told.claim->hear(told.heard, now_);
  }
  /// A process that no longer does anything, which nobody knows.
  void kill(std::uint8_t number) { processes_.at(gid(number)).is_alive = false; }
  void end(std::uint8_t number) {
    processes_.erase(gid(number));
    for (auto& [other, process] : processes_) {
      process.heard.erase(gid(number));
    }
  }
  /// Whether the two hear each other.
  void separate(std::uint8_t one, std::uint8_t other, bool separated) {
    if (separated) {
      cuts_.push_back({gid(one), gid(other)});
    } else {
      std::erase(cuts_, std::pair(gid(one), gid(other)));
    }
  }
  void run(Duration time) {
    for (const auto end = now_ + time; now_ < end; now_ += milliseconds(10)) {
      step();
    }
  }
  [[nodiscard]] State state(std::uint8_t number) const {
    return processes_.at(gid(number)).claim->state();
  }
  [[nodiscard]] NameClaim& claim(std::uint8_t number) { return *processes_.at(gid(number)).claim; }
  [[nodiscard]] int announcements() const { return announcements_; }

 private:
  using Pace = NameClaim::Pace;
  struct Process {
    std::unique_ptr<NameClaim> claim;
    std::map<Gid, std::string> heard;
    std::string says;
    SteadyTime repeats_at{};
    bool is_alive = true;
  };
  struct Flight {
    SteadyTime arrives;
    Gid from;
    Gid to;
    std::string text;
  };

  [[nodiscard]] bool are_separated(const Gid& a, const Gid& b) const {
    return std::any_of(cuts_.begin(), cuts_.end(), [&](const auto& cut) {
      return cut == std::pair(a, b) || cut == std::pair(b, a);
    });
  }
  void send(const Gid& from, Process& process) {
    process.repeats_at = now_ + seconds(1);
    for (const auto& [to, other] : processes_) {
      const bool is_lost = std::uniform_real_distribution<>()(random_) < loss_;
      if (to != from && !is_lost && !are_separated(from, to)) {
        in_flight_.push_back({now_ + delay_, from, to, process.says});
      }
    }
  }
  void step() {
    while (!in_flight_.empty() && in_flight_.front().arrives <= now_) {
      const auto flight = std::move(in_flight_.front());
      in_flight_.pop_front();
      const auto to = processes_.find(flight.to);
      if (to != processes_.end() && to->second.is_alive && processes_.contains(flight.from)) {
        to->second.heard[flight.from] = flight.text;
        to->second.claim->hear(to->second.heard, now_);
      }
    }
    for (auto& [id, process] : processes_) {
      if (!process.is_alive) {
        continue;
      }
      if (auto text = process.claim->on_time(now_)) {
        ++announcements_;
        process.says = std::move(*text);
        send(id, process);
      } else if (now_ >= process.repeats_at) {
        send(id, process);
      }
    }
  }

  const double loss_;
  const Duration delay_;
  std::mt19937 random_;
  SteadyTime now_{seconds(1000)};
  std::map<Gid, Process> processes_;
  std::deque<Flight> in_flight_;
  std::vector<std::pair<Gid, Gid>> cuts_;
  int announcements_ = 0;
};

TEST(NameClaimTest, OneThatIsAloneHoldsItsNamesAfterItsRounds) {
  Network network(0.0, {}, 1);
  network.start(1);
  network.run(milliseconds(1500));
  EXPECT_EQ(network.state(1), State::kAsking);
  network.run(milliseconds(300));
  EXPECT_EQ(network.state(1), State::kHolding);
  const int announcements = network.announcements();
  network.run(seconds(60));
  EXPECT_EQ(network.announcements(), announcements) << "it never falls silent";
}

TEST(NameClaimTest, OtherNamesDoNotMatter) {
  Network network(0.0, milliseconds(20), 1);
  network.start(1, robot("/robot_1"));
  network.start(2, robot("/robot_2"));
  network.run(seconds(2));
  EXPECT_EQ(network.state(1), State::kHolding);
  EXPECT_EQ(network.state(2), State::kHolding);
  EXPECT_EQ(network.claim(1).rival(), std::nullopt);
}

TEST(NameClaimTest, WhoeverComesLaterLosesWhateverItsId) {
  for (const auto& [first, second] : {std::pair<std::uint8_t, std::uint8_t>{1, 2}, {2, 1}}) {
    for (unsigned seed = 1; seed <= 200; ++seed) {
      Network network(0.05, milliseconds(20), seed);
      network.start(first);
      network.run(seconds(3));
      network.start(second);
      network.run(milliseconds(1700));
      ASSERT_EQ(network.state(first), State::kHolding) << seed;
      ASSERT_EQ(network.state(second), State::kAsking) << seed;
      const auto rival = network.claim(second).rival();
      ASSERT_TRUE(rival && rival->wins) << seed;
      EXPECT_EQ(rival->participant, gid(first));
      EXPECT_THAT(rival->name, ::testing::StartsWith("/robot_1/"));
      EXPECT_FALSE(network.claim(first).rival()->wins);
      network.run(seconds(30));  // as long as it likes
      ASSERT_EQ(network.state(second), State::kAsking) << seed;
    }
  }
}

TEST(NameClaimTest, OfThoseThatStartTogetherOneIsLeft) {
  for (unsigned seed = 1; seed <= 200; ++seed) {
    Network network(0.05, milliseconds(20), seed);
    std::mt19937 random(seed);
    std::vector<std::uint8_t> numbers{1, 2, 3};
    std::shuffle(numbers.begin(), numbers.end(), random);
    for (const auto number : numbers) {
      network.start(number);
      network.run(milliseconds(10 * (random() % 8)));
    }
    // As a host does: who loses ends, after a while.
    for (int turn = 0; turn < 4; ++turn) {
      network.run(seconds(2));
      for (const auto number : std::vector(numbers)) {
        if (const auto rival = network.claim(number).rival(); rival && rival->wins) {
          ASSERT_EQ(network.state(number), State::kAsking) << seed;
          network.end(number);
          std::erase(numbers, number);
        }
      }
    }
    // All three can lose at once where their ages differ by less than the delay of the network.
    ASSERT_LE(numbers.size(), 1U) << seed;
    for (const auto number : numbers) {
      EXPECT_EQ(network.state(number), State::kHolding) << seed;
    }
  }
}

TEST(NameClaimTest, OfTwoThatMeetLaterTheYoungerOneGivesUp) {
  for (const auto& [older, younger] : {std::pair<std::uint8_t, std::uint8_t>{1, 2}, {2, 1}}) {
    for (unsigned seed = 1; seed <= 200; ++seed) {
      Network network(0.2, milliseconds(50), seed);
      network.separate(1, 2, true);
      network.start(older);
      network.run(seconds(5));
      network.start(younger);
      network.run(seconds(100));
      ASSERT_EQ(network.state(older), State::kHolding);
      ASSERT_EQ(network.state(younger), State::kHolding);
      network.separate(1, 2, false);
      network.run(seconds(30));
      ASSERT_EQ(network.state(older), State::kHolding) << seed;
      ASSERT_EQ(network.state(younger), State::kGivenUp) << seed;
      const auto rival = network.claim(younger).rival();
      ASSERT_TRUE(rival && rival->wins) << seed;
      EXPECT_EQ(rival->participant, gid(older)) << seed;
      const int announcements = network.announcements();
      network.run(seconds(60));
      EXPECT_EQ(network.announcements(), announcements) << "they never fall silent";
    }
  }
}

TEST(NameClaimTest, OneThatIsStillToldOfButDeadDoesNotKeepItsNames) {
  Network network(0.0, milliseconds(20), 1);
  network.start(1);
  network.run(seconds(5));
  network.kill(1);
  network.start(3);
  network.tell_of(1, 3);
  network.run(milliseconds(1500));
  EXPECT_EQ(network.state(3), State::kAsking);
  EXPECT_EQ(network.claim(3).rival(), std::nullopt);
  network.run(milliseconds(300));
  EXPECT_EQ(network.state(3), State::kHolding);
}

TEST(NameClaimTest, NamesAreFreeOnceTheirHolderHasGone) {
  Network network(0.0, milliseconds(20), 1);
  network.start(1);
  network.run(seconds(3));
  network.start(2);
  network.run(seconds(1));
  EXPECT_EQ(network.state(2), State::kAsking);
  network.end(1);
  network.run(seconds(2));
  EXPECT_EQ(network.state(2), State::kHolding);
}

TEST(NameClaimTest, TextsThatAreNotUnderstoodClaimNothing) {
  for (const char* text : {"", "1", "2,h,100,AAAA", "1,x,100,AAAA", "1,h,x,AAAA", "1,h,-5,AAAA",
                           "1,h,5,AAA", "1,h,5,;;;;,x:y:z", ",,,,,,"}) {
    NameClaim claim(gid(1), robot(), {}, SteadyTime(seconds(1)));
    claim.hear({{gid(2), text}}, SteadyTime(seconds(2)));
    EXPECT_EQ(claim.rival(), std::nullopt) << text;
  }
}

TEST(NameClaimTest, AnAnswerWithANameOfAnotherHashIsNone) {
  const std::vector<NodeName> names{{"/", "a"}};
  NameClaim one(gid(1), names, {}, SteadyTime(seconds(1)));
  NameClaim other(gid(2), names, {}, SteadyTime(seconds(1)));
  const auto hello = one.on_time(SteadyTime(seconds(1)));
  ASSERT_TRUE(hello);
  other.hear({{gid(1), *hello}}, SteadyTime(seconds(1)));
  auto answer = other.on_time(SteadyTime(seconds(1)));
  ASSERT_TRUE(answer);
  ASSERT_TRUE(answer->ends_with(":/a")) << *answer;
  answer->back() = 'b';
  one.hear({{gid(2), *answer}}, SteadyTime(seconds(1)));
  EXPECT_EQ(one.rival(), std::nullopt);
}

}  // namespace
}  // namespace pipescout::host
