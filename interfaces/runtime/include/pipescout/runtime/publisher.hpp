// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "pipescout/runtime/transport.hpp"

namespace pipescout {

/// Running totals of an event, as DDS statuses count them.
struct EventCount {
  std::uint64_t total = 0;
  std::uint64_t change = 0;  ///< since the previous callback
};

struct IncompatibleQos {
  EventCount count;
  QosPolicy policy{};  ///< of the most recent mismatch
};

/// Events of a publisher. Callbacks run in the publisher's callback group.
struct PublisherEvents {
  std::function<void(EventCount)> deadline_missed = {};
  std::function<void(EventCount)> liveliness_lost = {};
  std::function<void(const IncompatibleQos&)> incompatible_qos = {};
  /// Number of matched subscriptions, here and in other processes.
  std::function<void(std::size_t)> matched = {};
};

struct PublisherStatistics {
  std::uint64_t published = 0;
  std::uint64_t sent_to_other_processes = 0;  ///< each was serialised once
  /// Could not be sent, or was replaced by `depth` later ones during a slow send.
  std::uint64_t send_failures = 0;
  std::uint64_t suppressed = 0;  ///< published while the component was not active, and dropped
  std::uint64_t deadlines_missed = 0;
  std::uint64_t liveliness_lost = 0;
  std::uint64_t incompatible_qos = 0;
};

/// Sequence numbers of one published message. Services need both to relate a reply.
struct PublishedSample {
  std::int64_t local_sequence_number = 0;  ///< 0: suppressed
  /// 0: not sent to other processes, or sent by another thread that is sending at the moment.
  std::int64_t remote_sequence_number = 0;
};

/// A publisher of a type known at run time. `Publisher<T>` is the typed front. Thread-safe.
/// Messages of one publisher arrive at each subscription in the order of publishing.
class UntypedPublisher {
 public:
  virtual ~UntypedPublisher() = default;

  /// Passes the pointer to every matched subscription of this process; the message must not be
  /// changed afterwards. Serialises it once for other processes if a reader is matched there, or if
  /// it is retained for late joiners. Sending may block (a slow reader, a full socket), but only
  /// this thread: it also sends the messages that other threads publish in the meantime.
  virtual PublishedSample publish(std::shared_ptr<const void> message,
                                  const SampleIdentity& related) = 0;

  /// The publisher of an inactive component is disabled: it drops and counts messages.
  virtual void set_enabled(bool enabled) = 0;
  /// Asserts liveliness for `Liveliness::kManualByTopic`; publishing asserts it too. When neither
  /// happens within the lease, subscriptions are notified at once, even while a callback of the
  /// publisher hangs.
  virtual void assert_liveliness() = 0;

  [[nodiscard]] virtual std::size_t subscription_count() const = 0;
  /// True when the remote reader of that identity is matched.
  [[nodiscard]] virtual bool is_matched_remotely(const Gid& reader) const = 0;
  [[nodiscard]] virtual int local_subscription_count() const = 0;
  [[nodiscard]] virtual int remote_subscription_count() const = 0;
  [[nodiscard]] virtual PublisherStatistics statistics() const = 0;
  [[nodiscard]] virtual const Gid& gid() const = 0;
  [[nodiscard]] virtual const WireTopic& topic() const = 0;
  [[nodiscard]] virtual const QoS& qos() const = 0;
};

/// Publishes messages of type T. A handle: copies share the publisher, which is destroyed with the
/// last one.
template <class T>
class Publisher {
 public:
  Publisher() = default;
  explicit Publisher(std::shared_ptr<UntypedPublisher> untyped) : untyped_(std::move(untyped)) {}

  /// Publishes without a copy. The message must not be changed afterwards.
  void publish(std::shared_ptr<const T> message) { untyped_->publish(std::move(message), {}); }
  void publish(std::unique_ptr<T> message) {
    publish(std::shared_ptr<const T>(std::move(message)));
  }
  /// Moves (or copies, when given an lvalue) the message into shared ownership first.
  void publish(T message) { publish(std::make_shared<const T>(std::move(message))); }

  [[nodiscard]] std::size_t subscription_count() const { return untyped_->subscription_count(); }
  [[nodiscard]] PublisherStatistics statistics() const { return untyped_->statistics(); }
  void assert_liveliness() { untyped_->assert_liveliness(); }
  [[nodiscard]] const std::shared_ptr<UntypedPublisher>& untyped() const { return untyped_; }
  [[nodiscard]] explicit operator bool() const noexcept { return untyped_ != nullptr; }

 private:
  std::shared_ptr<UntypedPublisher> untyped_;
};

}  // namespace pipescout
