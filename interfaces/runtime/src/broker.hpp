// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "message_forms.hpp"
#include "pipescout/runtime/context.hpp"
#include "shared_reader.hpp"
#include "step_traffic.hpp"
#include "subscription_queue.hpp"
#include "watch_thread.hpp"

namespace pipescout {

class LocalPublisher;

/// Matches the publishers and subscriptions of one process, and owns the way out of it.
/// Lock order: broker, publisher, shared reader, subscription queue, executor. None of them is held
/// while the transport writes, and while the transport reports only those from the shared reader on
/// are taken.
class Broker : public std::enable_shared_from_this<Broker> {
 public:
  explicit Broker(std::unique_ptr<Transport> transport) : transport_(std::move(transport)) {}

  [[nodiscard]] std::shared_ptr<UntypedPublisher> create_publisher(PublisherOptions options);
  [[nodiscard]] std::shared_ptr<UntypedSubscription> create_subscription(
      SubscriptionOptions options);

  [[nodiscard]] Transport* transport() const noexcept { return transport_.get(); }
  [[nodiscard]] WatchThread& watch_thread() noexcept { return watch_thread_; }
  [[nodiscard]] const std::shared_ptr<StepTraffic>& step_traffic() const noexcept {
    return step_traffic_;
  }

  /// Told of every endpoint that is destroyed, on the destroying thread. Its address tells which:
  /// subscriptions that share a reader have the same identity. Set once, before endpoints are made.
  void on_endpoint_destroyed(std::function<void(const void*)> callback) {
    endpoint_destroyed_ = std::move(callback);
  }
  void tell_destroyed(const UntypedPublisher& publisher) const { tell_destroyed(&publisher); }
  void tell_destroyed(const UntypedSubscription& subscription) const {
    tell_destroyed(&subscription);
  }

  /// True when the publisher of that identity is in this process and matches the subscription.
  [[nodiscard]] bool is_matched(const SubscriptionQueue& queue, const Gid& publisher);

  void remove(LocalPublisher& publisher);
  void remove(const std::shared_ptr<SubscriptionQueue>& queue);

 private:
  struct Topic {
    const MessageType* type = nullptr;
    std::vector<LocalPublisher*> publishers;
    std::vector<std::shared_ptr<SubscriptionQueue>> subscriptions;
  };

  /// Under mutex_; throws TopicTypeMismatch.
  Topic& topic_of_type(const WireTopic& topic);
  void check_type(const WireTopic& topic);
  // Under mutex_.
  void connect(LocalPublisher& publisher, const std::shared_ptr<SubscriptionQueue>& queue);
  void forget_if_unused(const std::string& name);
  Gid next_gid(bool writer);

  void tell_destroyed(const void* endpoint) const {
    if (endpoint_destroyed_) {
      endpoint_destroyed_(endpoint);
    }
  }
  /// One that serves others already, or a new one. Throws TransportError.
  std::shared_ptr<SharedReader> reader_for(const std::shared_ptr<SubscriptionQueue>& queue);
  void forget_ended_readers(const std::string& topic);

  const std::shared_ptr<Transport> transport_;
  const std::shared_ptr<StepTraffic> step_traffic_ = std::make_shared<StepTraffic>();
  std::function<void(const void*)> endpoint_destroyed_;
  std::mutex mutex_;
  std::map<std::string, Topic> topics_;
  std::atomic<std::uint32_t> last_entity_{0};
  std::mutex readers_mutex_;  // by itself: held while the transport makes a reader
  std::map<std::string, std::vector<std::weak_ptr<SharedReader>>> readers_;  // by topic

  WatchThread watch_thread_;
};

/// The sending half: delivers to matched queues of this process, keeps the last messages for late
/// joiners, and hands messages to the transport when a remote reader is matched, or might come
/// late.
class LocalPublisher final : public UntypedPublisher,
                             public TransportWriterListener,
                             public std::enable_shared_from_this<LocalPublisher> {
 public:
  LocalPublisher(std::shared_ptr<Broker> broker, PublisherOptions options, Gid local_gid);
  ~LocalPublisher() override;
  LocalPublisher(const LocalPublisher&) = delete;
  LocalPublisher& operator=(const LocalPublisher&) = delete;

  /// Second part of construction: needs shared_from_this; makes the transport's writer.
  void start();

  PublishedSample publish(std::shared_ptr<const void> message,
                          const SampleIdentity& related) override;
  void set_enabled(bool enabled) override;
  void assert_liveliness() override;
  std::size_t subscription_count() const override;
  bool is_matched_remotely(const Gid& reader) const override;
  int local_subscription_count() const override;
  int remote_subscription_count() const override;
  PublisherStatistics statistics() const override;
  const Gid& gid() const override { return gid_; }
  const WireTopic& topic() const override { return options_.topic; }
  const QoS& qos() const override { return options_.qos; }

  /// Called by the broker, under its lock.
  void match(const std::shared_ptr<SubscriptionQueue>& queue);
  void unmatch(const SubscriptionQueue& queue);
  void unmatch_all();
  void incompatible(QosPolicy policy);

  void on_remote_readers_changed(int matched, const std::vector<Gid>& participants) override;
  void on_incompatible_remote_reader(QosPolicy policy) override;

 private:
  struct Retained {
    MessageForms forms;
    MessageInfo info;
    std::optional<SteadyTime> expiry;
  };

  struct Outgoing {
    std::shared_ptr<const void> message;
    SampleIdentity related;
  };

  static void deliver(SubscriptionQueue& queue, MessageForms& forms, const MessageInfo& info,
                      std::optional<SteadyTime> expiry);
  /// Sends the message, and what other threads publish meanwhile; or leaves it to the thread that
  /// is sending. Returns its sequence number, 0 when it has none (yet). The lock is on mutex_.
  std::int64_t send(Outgoing own, std::unique_lock<std::mutex>& lock);
  void renew_lease();  // under mutex_
  void liveliness_lapsed();
  void tell_matched();  // under mutex_

  const std::shared_ptr<Broker> broker_;
  const PublisherOptions options_;
  const bool is_step_traffic_;
  Gid gid_;
  std::shared_ptr<CountedEvent> deadline_missed_;
  std::shared_ptr<CountedEvent> liveliness_lost_;
  std::optional<IncompatibleQosEvent> incompatible_qos_;
  std::shared_ptr<LatestEvent<std::size_t>> matched_;
  std::shared_ptr<Watchdog> deadline_;
  std::shared_ptr<CallbackGroup> watch_;  // of the watch thread; null without a manual lease
  std::shared_ptr<Watchdog> lease_;

  mutable std::mutex mutex_;
  std::vector<std::shared_ptr<SubscriptionQueue>> matches_;
  std::deque<Retained> retained_;
  std::deque<Outgoing> outgoing_;  // for the thread that is sending; at most `depth`
  bool is_sending_ = false;
  bool enabled_ = true;
  bool alive_ = true;
  std::int64_t sequence_number_ = 0;
  PublisherStatistics statistics_;

  // The transport holds locks of its own while it calls the listener, so what such a call touches
  // is outside of mutex_.
  std::atomic<int> remote_readers_{0};

  std::unique_ptr<TransportWriter> writer_;  // last: destroyed before what its listener uses
};

}  // namespace pipescout
