// SPDX-License-Identifier: Apache-2.0
#include "broker.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace pipescout {

namespace {

/// The handle: ends the subscription when it goes, while queue and callback may still be in use.
class LocalSubscription final : public UntypedSubscription {
 public:
  LocalSubscription(std::shared_ptr<Broker> broker, std::shared_ptr<SubscriptionQueue> queue,
                    std::shared_ptr<SharedReader> reader, Gid gid)
      : broker_(std::move(broker)),
        queue_(std::move(queue)),
        reader_(std::move(reader)),
        gid_(gid) {}

  ~LocalSubscription() override {
    if (reader_) {
      reader_->leave(*queue_);
      reader_.reset();
    }
    broker_->remove(queue_);
    queue_->close();
    broker_->tell_destroyed(*this);
  }
  LocalSubscription(const LocalSubscription&) = delete;
  LocalSubscription& operator=(const LocalSubscription&) = delete;

  void set_enabled(bool enabled) override { queue_->set_enabled(enabled); }
  std::size_t publisher_count() const override { return queue_->publisher_count(); }
  int local_publisher_count() const override { return queue_->local_publisher_count(); }
  int remote_publisher_count() const override { return queue_->remote_publisher_count(); }
  bool is_matched(const Gid& publisher) const override {
    return broker_->is_matched(*queue_, publisher) || (reader_ && reader_->is_matched(publisher));
  }
  LivelinessChange liveliness() const override { return queue_->liveliness(); }
  SubscriptionStatistics statistics() const override { return queue_->statistics(); }
  const InputExpectation& expected() const override { return queue_->options().expected; }
  const Gid& gid() const override { return gid_; }
  const WireTopic& topic() const override { return queue_->options().topic; }
  const QoS& qos() const override { return queue_->options().qos; }

 private:
  const std::shared_ptr<Broker> broker_;
  const std::shared_ptr<SubscriptionQueue> queue_;
  std::shared_ptr<SharedReader> reader_;  // null without a transport
  const Gid gid_;
};

}  // namespace

void Broker::check_type(const WireTopic& topic) {
  const auto found = topics_.find(topic.name);
  if (found != topics_.end() && found->second.type->dds_name != topic.type->dds_name) {
    throw TopicTypeMismatch("topic '" + topic.name + "' carries " +
                            std::string(found->second.type->name) + " in this process, not " +
                            std::string(topic.type->name));
  }
}

Broker::Topic& Broker::topic_of_type(const WireTopic& topic) {
  check_type(topic);
  Topic& entry = topics_[topic.name];
  entry.type = topic.type;
  return entry;
}

void Broker::forget_if_unused(const std::string& name) {
  const auto found = topics_.find(name);
  if (found != topics_.end() && found->second.publishers.empty() &&
      found->second.subscriptions.empty()) {
    topics_.erase(found);
  }
}

Gid Broker::next_gid(bool writer) {
  // As in a DDS GUID: the participant's prefix, an entity number, and the kind of entity.
  Gid gid;
  if (transport_) {
    gid = transport_->participant();
  }
  const std::uint32_t entity = ++last_entity_;
  gid.bytes[12] = static_cast<std::uint8_t>(entity >> 16U);
  gid.bytes[13] = static_cast<std::uint8_t>(entity >> 8U);
  gid.bytes[14] = static_cast<std::uint8_t>(entity);
  gid.bytes[15] = writer ? 0x03 : 0x04;
  return gid;
}

std::shared_ptr<UntypedPublisher> Broker::create_publisher(PublisherOptions options) {
  options.qos.validate();
  {
    const std::lock_guard lock(mutex_);
    check_type(options.topic);
  }
  auto publisher = std::make_shared<LocalPublisher>(shared_from_this(), options, next_gid(true));
  publisher->start();
  const std::lock_guard lock(mutex_);
  Topic& topic = topic_of_type(options.topic);
  topic.publishers.push_back(publisher.get());
  for (const auto& queue : topic.subscriptions) {
    connect(*publisher, queue);
  }
  return publisher;
}

std::shared_ptr<UntypedSubscription> Broker::create_subscription(SubscriptionOptions options) {
  options.qos.validate();
  if (!options.callback) {
    throw std::invalid_argument("subscription of " + options.topic.name + " has no callback");
  }
  {
    const std::lock_guard lock(mutex_);
    check_type(options.topic);
  }
  auto queue = std::make_shared<SubscriptionQueue>(std::move(options));
  queue->start();
  const WireTopic& wire_topic = queue->options().topic;
  std::shared_ptr<SharedReader> reader;
  if (transport_) {
    reader = reader_for(queue);
  }
  const Gid gid = reader ? reader->gid() : next_gid(false);
  // From here on the handle cleans up, also when the type changed meanwhile.
  auto subscription =
      std::make_shared<LocalSubscription>(shared_from_this(), queue, std::move(reader), gid);
  const std::lock_guard lock(mutex_);
  Topic& topic = topic_of_type(wire_topic);
  topic.subscriptions.push_back(queue);
  for (LocalPublisher* publisher : topic.publishers) {
    connect(*publisher, queue);
  }
  return subscription;
}

std::shared_ptr<SharedReader> Broker::reader_for(const std::shared_ptr<SubscriptionQueue>& queue) {
  const SubscriptionOptions& options = queue->options();
  if (options.own_reader) {
    return std::make_shared<SharedReader>(*transport_, options.topic, options.qos, step_traffic_,
                                          queue);
  }
  const std::lock_guard lock(readers_mutex_);
  auto& readers = readers_[options.topic.name];
  std::erase_if(readers, [](const auto& weak) { return weak.expired(); });
  for (const auto& weak : readers) {
    const auto reader = weak.lock();
    if (reader && reader->serves(options.topic, options.qos) && reader->join(queue)) {
      return reader;
    }
  }
  auto reader =
      std::make_shared<SharedReader>(*transport_, options.topic, options.qos, step_traffic_, queue);
  readers.push_back(reader);
  return reader;
}

void Broker::forget_ended_readers(const std::string& topic) {
  const std::lock_guard lock(readers_mutex_);
  const auto found = readers_.find(topic);
  if (found == readers_.end()) {
    return;
  }
  std::erase_if(found->second, [](const auto& weak) { return weak.expired(); });
  if (found->second.empty()) {
    readers_.erase(found);
  }
}

void Broker::connect(LocalPublisher& publisher, const std::shared_ptr<SubscriptionQueue>& queue) {
  if (const auto policy = incompatibility(publisher.qos(), queue->options().qos)) {
    publisher.incompatible(*policy);
    queue->incompatible(*policy);
  } else {
    publisher.match(queue);
  }
}

bool Broker::is_matched(const SubscriptionQueue& queue, const Gid& publisher) {
  const std::lock_guard lock(mutex_);
  const auto found = topics_.find(queue.options().topic.name);
  return found != topics_.end() &&
         std::any_of(found->second.publishers.begin(), found->second.publishers.end(),
                     [&](const LocalPublisher* candidate) {
                       return candidate->gid() == publisher &&
                              !incompatibility(candidate->qos(), queue.options().qos);
                     });
}

void Broker::remove(LocalPublisher& publisher) {
  const std::lock_guard lock(mutex_);
  publisher.unmatch_all();
  const auto found = topics_.find(publisher.topic().name);
  if (found != topics_.end()) {
    std::erase(found->second.publishers, &publisher);
    forget_if_unused(publisher.topic().name);
  }
}

void Broker::remove(const std::shared_ptr<SubscriptionQueue>& queue) {
  const std::string& name = queue->options().topic.name;
  forget_ended_readers(name);
  const std::lock_guard lock(mutex_);
  const auto found = topics_.find(name);
  if (found == topics_.end()) {
    return;
  }
  for (LocalPublisher* publisher : found->second.publishers) {
    publisher->unmatch(*queue);
  }
  std::erase(found->second.subscriptions, queue);
  forget_if_unused(name);
}

LocalPublisher::LocalPublisher(std::shared_ptr<Broker> broker, PublisherOptions options,
                               Gid local_gid)
    : broker_(std::move(broker)),
      options_(std::move(options)),
      is_step_traffic_(pipescout::is_step_traffic(options_.topic.name)),
      gid_(local_gid) {}

LocalPublisher::~LocalPublisher() {
  if (!matched_) {
    return;  // start() failed
  }
  writer_.reset();
  broker_->step_traffic()->readers_changed(gid_, {});
  if (deadline_) {
    deadline_->stop();
  }
  if (watch_) {
    watch_->close();
  }
  deadline_missed_->close();
  liveliness_lost_->close();
  incompatible_qos_->close();
  matched_->close();
  broker_->remove(*this);
  broker_->tell_destroyed(*this);
}

void LocalPublisher::start() {
  const auto& events = options_.events;
  const auto& group = options_.group;
  const bool monitored = options_.qos.liveliness == Liveliness::kManualByTopic &&
                         options_.qos.liveliness_lease.has_value();
  if (!group && (events.deadline_missed || events.liveliness_lost || events.incompatible_qos ||
                 events.matched)) {
    throw std::invalid_argument("publisher of " + options_.topic.name +
                                ": events need a callback group");
  }
  deadline_missed_ = std::make_shared<CountedEvent>(group, events.deadline_missed);
  liveliness_lost_ = std::make_shared<CountedEvent>(group, events.liveliness_lost);
  incompatible_qos_.emplace(group, events.incompatible_qos);
  matched_ = std::make_shared<LatestEvent<std::size_t>>(group, events.matched);
  if (options_.qos.deadline && group) {
    deadline_ = std::make_shared<Watchdog>(
        group, *options_.qos.deadline, Watchdog::Lapse::kEachPeriod,
        [missed = deadline_missed_](std::uint64_t periods) { missed->add(periods); });
  }
  if (monitored) {
    // Not in the publisher's own group: a callback that hangs there is what the lease is to reveal.
    watch_ = broker_->watch_thread().create_group();
    // A plain pointer: the watch thread must not become the last owner. The destructor closes the
    // group.
    lease_ =
        std::make_shared<Watchdog>(watch_, *options_.qos.liveliness_lease, Watchdog::Lapse::kOnce,
                                   [this](std::uint64_t) { liveliness_lapsed(); });
    lease_->touch();
  }
  if (Transport* transport = broker_->transport()) {
    writer_ = transport->create_writer(options_.topic, options_.qos, *this);
    gid_ = writer_->gid();
  }
}

PublishedSample LocalPublisher::publish(std::shared_ptr<const void> message,
                                        const SampleIdentity& related) {
  if (!message) {
    throw std::invalid_argument("publish on " + options_.topic.name + ": the message is null");
  }
  PublishedSample sample;
  std::unique_lock lock(mutex_);
  if (!enabled_) {
    ++statistics_.suppressed;
    return sample;
  }
  ++statistics_.published;
  sample.local_sequence_number = ++sequence_number_;
  const Time now = SystemClock().now();
  const MessageInfo info{.source_time = now,
                         .reception_time = now,
                         .identity = {gid_, sequence_number_},
                         .related = related,
                         .from_this_process = true};
  std::optional<SteadyTime> expiry;
  if (options_.qos.lifespan) {
    expiry = add_saturated(steady_now(), *options_.qos.lifespan);
  }
  MessageForms forms(message, *options_.topic.type);
  for (const auto& queue : matches_) {
    deliver(*queue, forms, info, expiry);
  }
  const bool retain = options_.qos.durability == Durability::kTransientLocal;
  if (retain) {
    if (retained_.size() >= options_.qos.depth) {
      retained_.pop_front();
    }
    retained_.push_back({std::move(forms), info, expiry});
  }
  if (deadline_) {
    deadline_->touch();
  }
  renew_lease();
  // What is retained must be with the transport before a reader appears: sent later it would
  // also reach volatile readers, which asked for nothing old. Otherwise the transport is asked
  // for readers: `remote_readers_` is told later, when somebody may have seen the match already
  // (is_matched_remotely) and publishes because of it.
  if (writer_ && (retain || writer_->matched_remote_readers() > 0)) {
    sample.remote_sequence_number = send({std::move(message), related}, lock);
  }
  return sample;
}

void LocalPublisher::deliver(SubscriptionQueue& queue, MessageForms& forms, const MessageInfo& info,
                             std::optional<SteadyTime> expiry) {
  if (auto message = forms.as(*queue.options().topic.type)) {
    queue.receive(std::move(message), info, expiry);
  } else {
    queue.on_malformed_sample(info.identity);
  }
}

std::int64_t LocalPublisher::send(Outgoing own, std::unique_lock<std::mutex>& lock) {
  if (is_sending_) {
    if (outgoing_.size() >= options_.qos.depth) {
      outgoing_.pop_front();
      ++statistics_.send_failures;
    }
    outgoing_.push_back(std::move(own));
    return 0;
  }
  is_sending_ = true;
  std::int64_t own_sequence_number = 0;
  bool is_own = true;
  for (Outgoing next = std::move(own);;
       next = std::move(outgoing_.front()), outgoing_.pop_front()) {
    lock.unlock();
    // Asked before the message is sent: who is matched later may not get it.
    std::vector<Gid> receivers;
    StepTraffic& traffic = *broker_->step_traffic();
    if (is_step_traffic_ && traffic.is_enabled()) {
      receivers = writer_->matched_participants();
    }
    SampleIdentity identity;
    try {
      identity = writer_->write(next.message.get(), next.related);
    } catch (...) {
      lock.lock();
      is_sending_ = false;
      ++statistics_.send_failures;
      throw;
    }
    if (identity.sequence_number != 0 && !receivers.empty()) {
      traffic.sent(gid_, receivers, identity.sequence_number);
      if (auto now = writer_->matched_participants(); now != receivers) {
        traffic.readers_changed(gid_, now);
      }
    }
    next = {};  // what may be destroyed with it is destroyed without the lock
    lock.lock();
    ++(identity.sequence_number != 0 ? statistics_.sent_to_other_processes
                                     : statistics_.send_failures);
    if (std::exchange(is_own, false)) {
      own_sequence_number = identity.sequence_number;
    }
    if (outgoing_.empty()) {
      break;
    }
  }
  is_sending_ = false;
  return own_sequence_number;
}

void LocalPublisher::renew_lease() {
  if (!lease_) {
    return;
  }
  lease_->touch();
  if (!std::exchange(alive_, true)) {
    for (const auto& queue : matches_) {
      queue->local_publisher_liveliness(true);
    }
  }
}

void LocalPublisher::liveliness_lapsed() {
  const std::lock_guard lock(mutex_);
  // Somebody may have renewed the lease after it ran out and before this call.
  if (lease_->is_armed()) {
    return;
  }
  // Counted before anybody can see it.
  liveliness_lost_->add();
  alive_ = false;
  for (const auto& queue : matches_) {
    queue->local_publisher_liveliness(false);
  }
}

void LocalPublisher::set_enabled(bool enabled) {
  const std::lock_guard lock(mutex_);
  enabled_ = enabled;
  if (!enabled && deadline_) {
    deadline_->stop();
  }
}

void LocalPublisher::assert_liveliness() {
  if (writer_) {
    writer_->assert_liveliness();  // may wait for a send
  }
  const std::lock_guard lock(mutex_);
  renew_lease();
}

std::size_t LocalPublisher::subscription_count() const {
  const std::lock_guard lock(mutex_);
  return matches_.size() + static_cast<std::size_t>(remote_readers_.load());
}

bool LocalPublisher::is_matched_remotely(const Gid& reader) const {
  return writer_ && writer_->is_matched(reader);
}

int LocalPublisher::local_subscription_count() const {
  const std::lock_guard lock(mutex_);
  return static_cast<int>(matches_.size());
}

int LocalPublisher::remote_subscription_count() const {
  return remote_readers_;
}

PublisherStatistics LocalPublisher::statistics() const {
  const std::lock_guard lock(mutex_);
  PublisherStatistics statistics = statistics_;
  statistics.deadlines_missed = deadline_missed_->total();
  statistics.liveliness_lost = liveliness_lost_->total();
  statistics.incompatible_qos = incompatible_qos_->total();
  return statistics;
}

void LocalPublisher::tell_matched() {
  matched_->set(matches_.size() + static_cast<std::size_t>(remote_readers_.load()));
}

void LocalPublisher::match(const std::shared_ptr<SubscriptionQueue>& queue) {
  const std::lock_guard lock(mutex_);
  matches_.push_back(queue);
  queue->local_publisher_matched(alive_);
  if (queue->options().qos.durability == Durability::kTransientLocal) {
    const std::size_t depth = queue->options().qos.depth;
    const std::size_t skip = retained_.size() > depth ? retained_.size() - depth : 0;
    const SteadyTime now = steady_now();
    for (std::size_t i = skip; i < retained_.size(); ++i) {
      Retained& retained = retained_[i];
      if (!retained.expiry || now <= *retained.expiry) {
        deliver(*queue, retained.forms, retained.info, retained.expiry);
      }
    }
  }
  tell_matched();
}

void LocalPublisher::unmatch(const SubscriptionQueue& queue) {
  const std::lock_guard lock(mutex_);
  const auto removed = std::erase_if(
      matches_,
      [&](const std::shared_ptr<SubscriptionQueue>& match) { return match.get() == &queue; });
  if (removed > 0) {
    tell_matched();
  }
}

void LocalPublisher::unmatch_all() {
  const std::lock_guard lock(mutex_);
  for (const auto& queue : matches_) {
    queue->local_publisher_unmatched(alive_);
  }
  matches_.clear();
}

void LocalPublisher::incompatible(QosPolicy policy) {
  incompatible_qos_->add(policy);
}

void LocalPublisher::on_remote_readers_changed(int matched, const std::vector<Gid>& participants) {
  remote_readers_ = matched;
  if (StepTraffic& traffic = *broker_->step_traffic(); is_step_traffic_ && traffic.is_enabled()) {
    traffic.readers_changed(gid_, participants);
  }
  if (!options_.group) {
    return;
  }
  // The transport holds locks of its own while it reports.
  options_.group->post([weak = weak_from_this()] {
    if (const auto self = weak.lock()) {
      const std::lock_guard lock(self->mutex_);
      self->tell_matched();
    }
  });
}

void LocalPublisher::on_incompatible_remote_reader(QosPolicy policy) {
  incompatible(policy);
}

}  // namespace pipescout
