// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <utility>

#include "pipescout/runtime/publisher.hpp"
#include "pipescout/runtime/time.hpp"
#include "pipescout/runtime/transport.hpp"

namespace pipescout {

/// Events of a subscription. Callbacks run in the subscription's callback group.
struct SubscriptionEvents {
  std::function<void(EventCount)> deadline_missed = {};
  /// Numbers of publishers that are alive and not alive, here and in other processes.
  std::function<void(LivelinessChange)> liveliness_changed = {};
  std::function<void(const IncompatibleQos&)> incompatible_qos = {};
  /// Messages lost: dropped by the full queue, or by the network.
  std::function<void(EventCount)> message_lost = {};
  /// Data that does not match the type: the publisher has another definition of it.
  std::function<void(EventCount)> message_malformed = {};
  /// Number of matched publishers, here and in other processes.
  std::function<void(std::size_t)> matched = {};
};

/// What a component expects of an input, for its watch: see NodeSubscriptionOptions::expected.
struct InputExpectation {
  double minimum_rate = 0;  ///< Hz; 0: any
  double maximum_age = 0;   ///< s, of the newest message; 0: any
  bool operator==(const InputExpectation&) const = default;
};

struct SubscriptionStatistics {
  std::uint64_t received = 0;
  std::uint64_t delivered = 0;           ///< callbacks begun
  std::uint64_t dropped_queue_full = 0;  ///< the oldest message was replaced by a new one
  std::uint64_t dropped_inactive = 0;    ///< while the component was not active
  std::uint64_t expired = 0;             ///< older than the publisher's lifespan
  std::uint64_t lost_by_network = 0;
  std::uint64_t malformed = 0;  ///< data that does not match the type
  std::uint64_t deadlines_missed = 0;
  std::uint64_t incompatible_qos = 0;
  /// Stamp of the message received last; nothing before, and for types without `header.stamp` or
  /// `stamp`.
  std::optional<Time> last_stamp = std::nullopt;
};

/// A subscription to a type known at run time. `Subscription<T>` is the typed front.
class UntypedSubscription {
 public:
  using Callback = std::function<void(const std::shared_ptr<const void>&, const MessageInfo&)>;

  virtual ~UntypedSubscription() = default;

  /// A subscription of an inactive component is disabled: the last `depth` messages wait in its
  /// queue and are delivered when it is enabled, or all are dropped, see WhileInactive. Without a
  /// callback group they are dropped.
  virtual void set_enabled(bool enabled) = 0;

  [[nodiscard]] virtual std::size_t publisher_count() const = 0;
  [[nodiscard]] virtual int local_publisher_count() const = 0;
  [[nodiscard]] virtual int remote_publisher_count() const = 0;
  /// True when the publisher of that identity, here or in another process, is matched.
  [[nodiscard]] virtual bool is_matched(const Gid& publisher) const = 0;
  [[nodiscard]] virtual LivelinessChange liveliness() const = 0;
  [[nodiscard]] virtual SubscriptionStatistics statistics() const = 0;
  /// Identity of the reader, which subscriptions of the same topic and QoS may share.
  [[nodiscard]] virtual const Gid& gid() const = 0;
  [[nodiscard]] virtual const WireTopic& topic() const = 0;
  [[nodiscard]] virtual const QoS& qos() const = 0;
  /// As declared with the subscription.
  [[nodiscard]] virtual const InputExpectation& expected() const = 0;
};

/// A handle: copies share the subscription, which is destroyed with the last one. If the publisher
/// is in the same process, the callback gets the published object itself.
template <class T>
class Subscription {
 public:
  Subscription() = default;
  explicit Subscription(std::shared_ptr<UntypedSubscription> untyped)
      : untyped_(std::move(untyped)) {}

  [[nodiscard]] std::size_t publisher_count() const { return untyped_->publisher_count(); }
  [[nodiscard]] SubscriptionStatistics statistics() const { return untyped_->statistics(); }
  [[nodiscard]] const std::shared_ptr<UntypedSubscription>& untyped() const { return untyped_; }
  [[nodiscard]] explicit operator bool() const noexcept { return untyped_ != nullptr; }

 private:
  std::shared_ptr<UntypedSubscription> untyped_;
};

}  // namespace pipescout
