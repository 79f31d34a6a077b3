// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/synchronizer.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <geometry_msgs/msg/point_stamped.hpp>
#include <geometry_msgs/msg/twist_stamped.hpp>
#include <memory>
#include <stdexcept>
#include <utility>
#include <vector>

#include "pipescout/runtime/synchronized_subscriptions.hpp"
#include "pipescout/testing/component_harness.hpp"

namespace pipescout {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using Set = std::vector<int>;

Time at(int milliseconds) {
  return Time(std::chrono::milliseconds(milliseconds));
}

/// Messages are their stamps in ms.
class Sets {
 public:
  explicit Sets(std::size_t streams, SynchronizerOptions options = {})
      : synchronizer_(streams, std::move(options),
                      [this](const std::vector<Synchronizer::Message>& messages) {
                        Set set;
                        for (const auto& message : messages) {
                          set.push_back(*std::static_pointer_cast<const int>(message));
                        }
                        told.push_back(std::move(set));
                      }) {}

  void add(std::size_t stream, int milliseconds) {
    synchronizer_.add(stream, at(milliseconds), std::make_shared<const int>(milliseconds));
  }
  [[nodiscard]] const SynchronizerStatistics& statistics() const {
    return synchronizer_.statistics();
  }

  std::vector<Set> told;

 private:
  Synchronizer synchronizer_;
};

TEST(ExactSynchronizer, MakesSetsOfEqualStampsAndDropsWhatIsEarlier) {
  Sets sets(3, {.policy = SynchronizerPolicy::kExact});
  sets.add(0, 1);
  sets.add(0, 2);
  sets.add(1, 2);
  sets.add(2, 1);
  EXPECT_THAT(sets.told, IsEmpty());
  sets.add(2, 2);
  EXPECT_THAT(sets.told, ElementsAre(Set{2, 2, 2}));
  sets.add(1, 3);
  EXPECT_EQ(sets.statistics().sets, 1U);
  EXPECT_EQ(sets.statistics().streams[0].unmatched, 1U);
  EXPECT_EQ(sets.statistics().streams[2].unmatched, 1U);
}

TEST(ExactSynchronizer, ItsQueueIsBounded) {
  Sets sets(2, {.policy = SynchronizerPolicy::kExact, .queue_size = 3});
  for (int stamp = 0; stamp < 10; ++stamp) {
    sets.add(0, stamp);
  }
  EXPECT_EQ(sets.statistics().streams[0].queue_full, 7U);
  sets.add(1, 6);
  sets.add(1, 7);
  EXPECT_THAT(sets.told, ElementsAre(Set{7, 7}));
}

TEST(ApproximateSynchronizer, EqualStampsAreToldAtOnce) {
  Sets sets(2);
  for (int stamp = 10; stamp < 40; stamp += 10) {
    sets.add(0, stamp);
    sets.add(1, stamp);
  }
  EXPECT_THAT(sets.told, ElementsAre(Set{10, 10}, Set{20, 20}, Set{30, 30}));
}

TEST(ApproximateSynchronizer, TakesTheTightestSetWithThePivot) {
  Sets sets(2);
  sets.add(0, 0);
  sets.add(0, 9);
  sets.add(1, 10);  // the pivot: 9 is nearer than 0, and 12 is not
  sets.add(0, 12);
  EXPECT_THAT(sets.told, ElementsAre(Set{9, 10}));
  EXPECT_EQ(sets.statistics().streams[0].unmatched, 1U);
}

TEST(ApproximateSynchronizer, ACameraAndASlowerOneOfTheSameTimesArePaired) {
  Sets sets(2);
  for (int i = 0; i <= 30; ++i) {
    sets.add(0, 10 * i);
    if (i % 3 == 0) {
      sets.add(1, 10 * i + 2);
    }
  }
  ASSERT_GE(sets.told.size(), 9U);
  for (const Set& set : sets.told) {
    EXPECT_EQ(set[1] - set[0], 2);
  }
}

TEST(ApproximateSynchronizer, KnownSpacingTellsASetEarlier) {
  Sets unknowing(2);
  Sets knowing(2, {.shortest_spacing = {std::chrono::milliseconds(10), Duration::zero()}});
  for (Sets* sets : {&unknowing, &knowing}) {
    sets->add(0, 0);
    sets->add(1, 4);
  }
  EXPECT_THAT(unknowing.told, IsEmpty());
  EXPECT_THAT(knowing.told, ElementsAre(Set{0, 4}));
}

TEST(ApproximateSynchronizer, SetsThatAreTooWideAreNone) {
  Sets sets(2, {.longest_interval = std::chrono::milliseconds(3)});
  sets.add(0, 0);
  sets.add(1, 10);
  sets.add(0, 12);
  sets.add(1, 20);
  sets.add(0, 30);
  EXPECT_THAT(sets.told, ElementsAre(Set{12, 10}));
}

TEST(ApproximateSynchronizer, AFullQueueDropsItsOldestAndCounts) {
  Sets sets(2, {.queue_size = 3});
  for (int i = 0; i < 10; ++i) {
    sets.add(0, 10 * i);
  }
  EXPECT_EQ(sets.statistics().streams[0].queue_full, 7U);
  sets.add(1, 81);
  sets.add(1, 91);
  EXPECT_THAT(sets.told, ElementsAre(Set{80, 81}));
}

TEST(ApproximateSynchronizer, ALateMessageIsDroppedAndAClockThatWasSetBackBeginsAnew) {
  Sets sets(2);
  sets.add(0, 5000);
  sets.add(0, 4990);
  sets.add(0, 5000);
  EXPECT_EQ(sets.statistics().streams[0].late, 2U);
  sets.add(0, 10);
  EXPECT_EQ(sets.statistics().set_back, 1U);
  EXPECT_EQ(sets.statistics().streams[0].unmatched, 1U);
  sets.add(1, 10);
  EXPECT_THAT(sets.told, ElementsAre(Set{10, 10}));
}

TEST(SynchronizerOptions, AreChecked) {
  EXPECT_THROW(Sets(1), std::invalid_argument);
  EXPECT_THROW(Sets(10), std::invalid_argument);
  EXPECT_THROW(Sets(2, {.queue_size = 0}), std::invalid_argument);
  EXPECT_THROW(Sets(2, {.age_penalty = -1}), std::invalid_argument);
  EXPECT_THROW(Sets(2, {.longest_interval = Duration(-1)}), std::invalid_argument);
  EXPECT_THROW(Sets(2, {.shortest_spacing = {Duration::zero()}}), std::invalid_argument);
  EXPECT_THROW(Sets(2, {.set_back = Duration(-1)}), std::invalid_argument);
}

/// Streams with random distances, and the order in which their messages come.
struct Traffic {
  std::vector<std::vector<int>> stamps;
  std::vector<std::size_t> order;
};

Traffic draw_traffic() {
  Traffic traffic;
  const auto streams = *rc::gen::inRange<std::size_t>(2, 5);
  for (std::size_t i = 0; i < streams; ++i) {
    const auto steps = *rc::gen::container<std::vector<int>>(30, rc::gen::inRange(1, 60));
    std::vector<int> stamps;
    int stamp = 0;
    for (const int step : steps) {
      stamps.push_back(stamp += step);
      traffic.order.push_back(i);
    }
    traffic.stamps.push_back(std::move(stamps));
  }
  const auto keys =
      *rc::gen::container<std::vector<int>>(traffic.order.size(), rc::gen::inRange(0, 1000));
  std::vector<std::pair<int, std::size_t>> keyed;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    keyed.emplace_back(keys[i], traffic.order[i]);
  }
  std::ranges::sort(keyed);
  for (std::size_t i = 0; i < keyed.size(); ++i) {
    traffic.order[i] = keyed[i].second;
  }
  return traffic;
}

std::vector<Set> run(const Traffic& traffic, const std::vector<std::size_t>& order) {
  Sets sets(traffic.stamps.size(), {.queue_size = 1000});
  std::vector<std::size_t> sent(traffic.stamps.size(), 0);
  for (const std::size_t stream : order) {
    sets.add(stream, traffic.stamps[stream][sent[stream]++]);
  }
  return sets.told;
}

RC_GTEST_PROP(ApproximateSynchronizerProperty, SetsDoNotCrossAndDoNotDependOnTheOrderOfArrival,
              ()) {
  const Traffic traffic = draw_traffic();
  const std::vector<Set> sets = run(traffic, traffic.order);
  for (std::size_t i = 1; i < sets.size(); ++i) {
    for (std::size_t stream = 0; stream < traffic.stamps.size(); ++stream) {
      RC_ASSERT(sets[i][stream] > sets[i - 1][stream]);
    }
  }
  std::vector<std::size_t> sorted = traffic.order;
  std::ranges::sort(sorted);
  RC_ASSERT(run(traffic, sorted) == sets);
}

RC_GTEST_PROP(ApproximateSynchronizerProperty, BetweenTwoSetsNoneIsPassedOver, ()) {
  const Traffic traffic = draw_traffic();
  const std::vector<Set> sets = run(traffic, traffic.order);
  for (std::size_t i = 1; i < sets.size(); ++i) {
    bool each_has_one_between = true;
    for (std::size_t stream = 0; stream < traffic.stamps.size(); ++stream) {
      each_has_one_between =
          each_has_one_between && std::ranges::any_of(traffic.stamps[stream], [&](int stamp) {
            return stamp > sets[i - 1][stream] && stamp < sets[i][stream];
          });
    }
    RC_ASSERT(!each_has_one_between);
  }
}

using geometry_msgs::msg::PointStamped;
using geometry_msgs::msg::TwistStamped;
constexpr Topic<PointStamped> kPoints{"points", QoS::reliable(10)};
constexpr Topic<TwistStamped> kTwists{"twists", QoS::reliable(10)};

class Pairing final : public Component {
 public:
  explicit Pairing(ComponentOptions options) : Component(std::move(options)) {}

  std::vector<std::pair<double, double>> pairs;

 private:
  CallbackReturn on_configure() override {
    inputs_.emplace(
        *this, SynchronizerOptions{.policy = SynchronizerPolicy::kExact, .queue_size = 2},
        [this](const std::shared_ptr<const PointStamped>& point,
               const std::shared_ptr<const TwistStamped>& twist) {
          pairs.emplace_back(point->point.x, twist->twist.linear.x);
        },
        kPoints, kTwists);
    return CallbackReturn::kSuccess;
  }
  CallbackReturn on_cleanup() override {
    inputs_.reset();
    return CallbackReturn::kSuccess;
  }

  std::optional<SynchronizedSubscriptions<PointStamped, TwistStamped>> inputs_;
};

TEST(SynchronizedSubscriptionsTest, DeliverPairsAndTellWhatWasLost) {
  testing::ComponentHarness harness;
  auto& pairing = harness.make<Pairing>();
  ASSERT_TRUE(harness.bring_up(pairing).success);
  for (int i = 1; i <= 4; ++i) {
    PointStamped point;
    point.header.stamp = to_message(at(i));
    point.point.x = i;
    harness.publish(kPoints, point);
  }
  TwistStamped twist;
  twist.header.stamp = to_message(at(4));
  twist.twist.linear.x = 40;
  harness.publish(kTwists, twist);
  harness.publish(kTwists, twist);
  harness.spin();
  EXPECT_THAT(pairing.pairs, ElementsAre(std::pair(4.0, 40.0)));
  const auto status = harness.next_diagnostics(pairing);
  EXPECT_EQ(harness.value(status, "points.sync.queue_full"), "2");
  EXPECT_EQ(harness.value(status, "points.sync.unmatched"), "1");
  EXPECT_EQ(harness.value(status, "twists.sync.late"), "1");
  EXPECT_EQ(harness.value(status, "sync.sets"), "1");
}

}  // namespace
}  // namespace pipescout
