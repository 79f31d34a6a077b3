// SPDX-License-Identifier: Apache-2.0
// The same cases for every way that a message can take.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <std_msgs/msg/int64.hpp>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "peer_end.hpp"
#include "pipescout/dds/dds_transport.hpp"

namespace pipescout::conformance {
namespace {

using std::chrono::milliseconds;
using std_msgs::msg::Int64;

constexpr Duration kPatience = std::chrono::seconds(30);

enum class Path { kSocketless, kInProcess, kAcrossProcesses };

/// Where the other end is does not matter to a test.
class Peer {
 public:
  virtual ~Peer() = default;
  virtual std::string tell(const std::string& line) = 0;
  /// Ends as by a crash: nothing says goodbye. In one process the endpoint just goes.
  virtual void crash() = 0;
};

class SameProcessPeer final : public Peer {
 public:
  explicit SameProcessPeer(std::shared_ptr<Context> context) : end_(std::move(context)) {}
  std::string tell(const std::string& line) override { return end_.execute(line); }
  void crash() override { end_.execute("drop"); }

 private:
  PeerEnd end_;
};

class OtherProcessPeer final : public Peer {
 public:
  explicit OtherProcessPeer(std::uint32_t domain) {
    std::array<int, 2> to{};
    std::array<int, 2> from{};
    if (pipe(to.data()) != 0 || pipe(from.data()) != 0) {
      throw std::runtime_error("no pipes");
    }
    const std::string domain_text = std::to_string(domain);
    child_ = fork();
    if (child_ == 0) {
      prctl(PR_SET_PDEATHSIG, SIGKILL);
      dup2(to[0], STDIN_FILENO);
      dup2(from[1], STDOUT_FILENO);
      close(to[1]);
      close(from[0]);
      execl(CONFORMANCE_PEER, "conformance_peer", domain_text.c_str(), nullptr);
      _exit(127);
    }
    close(to[0]);
    close(from[1]);
    to_ = fdopen(to[1], "w");
    from_ = fdopen(from[0], "r");
    if (read_line() != "ready") {
      throw std::runtime_error("conformance_peer did not start");
    }
  }

  ~OtherProcessPeer() override {
    fclose(to_);
    fclose(from_);
    waitpid(child_, nullptr, 0);
  }
  OtherProcessPeer(const OtherProcessPeer&) = delete;
  OtherProcessPeer& operator=(const OtherProcessPeer&) = delete;

  std::string tell(const std::string& line) override {
    fputs((line + "\n").c_str(), to_);
    fflush(to_);
    return read_line();
  }
  void crash() override { kill(child_, SIGKILL); }

 private:
  std::string read_line() {
    std::string line;
    for (int character = fgetc(from_); character != '\n'; character = fgetc(from_)) {
      if (character == EOF) {
        return "gone";
      }
      line.push_back(static_cast<char>(character));
    }
    return line;
  }

  pid_t child_ = -1;
  FILE* to_ = nullptr;
  FILE* from_ = nullptr;
};

class QosConformanceTest : public testing::TestWithParam<Path> {
 protected:
  void SetUp() override {
    // The low range, so that the ports stay below those that the system hands out.
    const auto domain = static_cast<std::uint32_t>(1 + getpid() % 100);
    if (GetParam() == Path::kSocketless) {
      context_ = Context::create_in_process();
    } else {
      context_ =
          Context::create(create_dds_transport({.domain_id = domain, .localhost_only = true}));
    }
    if (GetParam() == Path::kAcrossProcesses) {
      peer_ = std::make_unique<OtherProcessPeer>(domain);
    } else {
      peer_ = std::make_unique<SameProcessPeer>(context_);
    }
    node_ = std::make_unique<Node>(NodeOptions{.context = context_,
                                               .executor = &executor_,
                                               .name = {"/conformance", "tested"},
                                               .standard_interfaces = false});
  }

  void expect_ok(const std::string& line) { ASSERT_EQ(peer_->tell(line), "ok") << line; }

  void peer_publisher(const QoS& qos) { expect_ok("publisher topic " + to_text(qos)); }
  void peer_subscription(const QoS& qos) { expect_ok("subscription topic " + to_text(qos)); }

  // A callback on a match wakes the executor, and with it whoever waits for the match.
  void subscribe(const QoS& qos, SubscriptionEvents events = {}) {
    events.matched = [](std::size_t) {};
    subscription_ = node_->create_subscription<Int64>(
        "topic", qos, [this](const Int64& message) { received_.push_back(message.data); },
        {.events = std::move(events)});
  }
  void advertise(const QoS& qos, PublisherEvents events = {}) {
    events.matched = [](std::size_t) {};
    publisher_ = node_->create_publisher<Int64>("topic", qos, {.events = std::move(events)});
  }
  void publish(std::int64_t value) {
    Int64 message;
    message.data = value;
    publisher_.publish(std::move(message));
  }
  void publish_from_peer(std::int64_t first, std::int64_t last) {
    for (std::int64_t value = first; value <= last; ++value) {
      expect_ok("publish " + std::to_string(value));
    }
  }

  [[nodiscard]] bool spin_until(const std::function<bool()>& done) {
    return executor_.spin_until(done, kPatience);
  }
  /// For what comes about while no callback may run.
  [[nodiscard]] static bool wait_without_spinning(const std::function<bool()>& done) {
    const auto end = std::chrono::steady_clock::now() + kPatience;
    while (!done() && std::chrono::steady_clock::now() < end) {
      // No event: the executor, which would tell of it, stands still.
      std::this_thread::sleep_for(milliseconds(1));
    }
    return done();
  }
  /// Both ends know of each other.
  void await_match() {
    ASSERT_TRUE(spin_until([&] {
      return subscription_ ? subscription_.publisher_count() > 0
                           : publisher_.subscription_count() > 0;
    }));
    expect_ok("wait matched 1");
  }

  Executor executor_;
  std::shared_ptr<Context> context_;
  std::unique_ptr<Peer> peer_;
  std::unique_ptr<Node> node_;
  Subscription<Int64> subscription_;
  Publisher<Int64> publisher_;
  std::vector<std::int64_t> received_;
};

TEST_P(QosConformanceTest, DepthKeepsTheLatestAndCountsTheOthers) {
  std::uint64_t lost = 0;
  subscribe(QoS::reliable(3), {.message_lost = [&](EventCount count) { lost = count.total; }});
  peer_publisher(QoS::reliable(20));
  await_match();
  publish_from_peer(1, 10);
  ASSERT_TRUE(wait_without_spinning([&] { return subscription_.statistics().received == 10; }));
  ASSERT_TRUE(spin_until([&] { return received_.size() >= 3 && lost > 0; }));
  EXPECT_THAT(received_, testing::ElementsAre(8, 9, 10));
  EXPECT_EQ(subscription_.statistics().dropped_queue_full, 7U);
  EXPECT_EQ(lost, 7U);
}

TEST_P(QosConformanceTest, ReliableDeliversAllInOrder) {
  constexpr std::int64_t kCount = 500;
  subscribe(QoS::reliable(kCount));
  peer_publisher(QoS::reliable(kCount));
  await_match();
  publish_from_peer(1, kCount);
  ASSERT_TRUE(spin_until([&] { return received_.size() == kCount; }));
  for (std::int64_t i = 0; i < kCount; ++i) {
    EXPECT_EQ(received_[static_cast<std::size_t>(i)], i + 1);
  }
}

TEST_P(QosConformanceTest, PublisherDeliversToThePeerInOrder) {
  advertise(QoS::reliable(100));
  peer_subscription(QoS::reliable(100));
  await_match();
  for (std::int64_t value = 1; value <= 5; ++value) {
    publish(value);
  }
  EXPECT_EQ(peer_->tell("wait received 5"), "1 2 3 4 5");
}

TEST_P(QosConformanceTest, BestEffortReadersHearReliableWriters) {
  subscribe(QoS::sensor_data());
  peer_publisher(QoS::reliable());
  await_match();
  publish_from_peer(1, 1);
  ASSERT_TRUE(spin_until([&] { return !received_.empty(); }));
  EXPECT_THAT(received_, testing::ElementsAre(1));
}

TEST_P(QosConformanceTest, ReliableReaderRefusesBestEffortWriterAndBothAreTold) {
  std::optional<QosPolicy> policy;
  subscribe(QoS::reliable(),
            {.incompatible_qos = [&](const IncompatibleQos& event) { policy = event.policy; }});
  peer_publisher(QoS::sensor_data());
  ASSERT_TRUE(spin_until([&] { return policy.has_value(); }));
  EXPECT_EQ(*policy, QosPolicy::kReliability);
  EXPECT_EQ(peer_->tell("wait incompatible 1"), "ok");
  EXPECT_EQ(subscription_.publisher_count(), 0U);
}

TEST_P(QosConformanceTest, TransientLocalReaderRefusesVolatileWriter) {
  std::optional<QosPolicy> policy;
  advertise(QoS::reliable(),
            {.incompatible_qos = [&](const IncompatibleQos& event) { policy = event.policy; }});
  peer_subscription(QoS::latched());
  ASSERT_TRUE(spin_until([&] { return policy.has_value(); }));
  EXPECT_EQ(*policy, QosPolicy::kDurability);
  EXPECT_EQ(publisher_.subscription_count(), 0U);
}

TEST_P(QosConformanceTest, LateJoinerGetsTheRetainedMessages) {
  peer_publisher(QoS::latched(3));
  publish_from_peer(1, 5);
  subscribe(QoS::latched(10));
  ASSERT_TRUE(spin_until([&] { return received_.size() == 3; }));
  EXPECT_THAT(received_, testing::ElementsAre(3, 4, 5));
  publish_from_peer(6, 6);
  ASSERT_TRUE(spin_until([&] { return received_.size() == 4; }));
  EXPECT_EQ(received_.back(), 6);
}

TEST_P(QosConformanceTest, OwnRetainedMessagesReachALatePeer) {
  advertise(QoS::latched(2));
  for (std::int64_t value = 1; value <= 4; ++value) {
    publish(value);
  }
  peer_subscription(QoS::latched(10));
  EXPECT_EQ(peer_->tell("wait received 2"), "3 4");
}

TEST_P(QosConformanceTest, VolatileLateJoinerGetsNothingOld) {
  peer_publisher(QoS::latched(3));
  publish_from_peer(1, 2);
  subscribe(QoS::reliable());
  await_match();
  publish_from_peer(3, 3);
  ASSERT_TRUE(spin_until([&] { return !received_.empty(); }));
  EXPECT_THAT(received_, testing::ElementsAre(3));
}

TEST_P(QosConformanceTest, MissedDeadlinesAreToldOnBothSides) {
  QoS qos = QoS::reliable();
  qos.deadline = milliseconds(100);
  std::uint64_t missed = 0;
  subscribe(qos, {.deadline_missed = [&](EventCount count) { missed = count.total; }});
  peer_publisher(qos);
  await_match();
  publish_from_peer(1, 1);
  ASSERT_TRUE(spin_until([&] { return missed >= 2; })) << "one each period of silence";
  EXPECT_EQ(peer_->tell("wait deadline_missed 2"), "ok");
}

TEST_P(QosConformanceTest, SlowerOfferIsIncompatibleWithTheRequestedDeadline) {
  QoS requested = QoS::reliable();
  requested.deadline = milliseconds(100);
  QoS offered = QoS::reliable();
  offered.deadline = milliseconds(200);
  std::optional<QosPolicy> policy;
  subscribe(requested,
            {.incompatible_qos = [&](const IncompatibleQos& event) { policy = event.policy; }});
  peer_publisher(offered);
  ASSERT_TRUE(spin_until([&] { return policy.has_value(); }));
  EXPECT_EQ(*policy, QosPolicy::kDeadline);
}

TEST_P(QosConformanceTest, SilentManualPublisherLosesItsLivelinessAndRegainsIt) {
  QoS qos = QoS::reliable();
  qos.liveliness = Liveliness::kManualByTopic;
  qos.liveliness_lease = milliseconds(300);
  std::vector<LivelinessChange> changes;
  subscribe(qos, {.liveliness_changed = [&](LivelinessChange now) { changes.push_back(now); }});
  peer_publisher(qos);
  await_match();
  publish_from_peer(1, 1);
  const auto seen = [&](int alive, int not_alive) {
    return !changes.empty() && changes.back().alive == alive &&
           changes.back().not_alive == not_alive;
  };
  ASSERT_TRUE(spin_until([&] { return seen(0, 1); })) << "it fell silent";
  EXPECT_EQ(peer_->tell("wait liveliness_lost 1"), "ok");
  // On a slow machine it may have lapsed again before anybody looks.
  bool regained = false;
  for (int attempt = 0; attempt < 50 && !regained; ++attempt) {
    expect_ok("assert");
    regained = executor_.spin_until([&] { return seen(1, 0); }, milliseconds(200));
  }
  EXPECT_TRUE(regained) << "it spoke again";
}

TEST_P(QosConformanceTest, CrashedPublisherIsNoticed) {
  QoS qos = QoS::reliable();
  qos.liveliness_lease = milliseconds(500);
  std::optional<LivelinessChange> last;
  subscribe(qos, {.liveliness_changed = [&](LivelinessChange now) { last = now; }});
  peer_publisher(qos);
  await_match();
  ASSERT_TRUE(spin_until([&] { return last && last->alive == 1; }));
  peer_->crash();
  EXPECT_TRUE(spin_until([&] { return last->alive == 0; }));
}

INSTANTIATE_TEST_SUITE_P(Paths, QosConformanceTest,
                         testing::Values(Path::kSocketless, Path::kInProcess,
                                         Path::kAcrossProcesses),
                         [](const testing::TestParamInfo<Path>& path) {
                           switch (path.param) {
                             case Path::kSocketless:
                               return "Socketless";
                             case Path::kInProcess:
                               return "InProcess";
                             case Path::kAcrossProcesses:
                               break;
                           }
                           return "AcrossProcesses";
                         });

}  // namespace
}  // namespace pipescout::conformance
