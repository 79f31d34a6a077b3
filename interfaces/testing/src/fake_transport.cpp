// SPDX-License-Identifier: Apache-2.0
#include "pipescout/testing/fake_transport.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <deque>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <utility>

namespace pipescout::testing {

namespace {

/// A listener that can be taken away, after which no call is in progress.
template <class Listener>
class Guarded {
 public:
  explicit Guarded(Listener& listener) : listener_(&listener) {}
  template <class Call>
  void tell(Call call) {
    const std::lock_guard lock(mutex_);
    if (listener_ != nullptr) {
      call(*listener_);
    }
  }
  void detach() {
    const std::lock_guard lock(mutex_);
    listener_ = nullptr;
  }

 private:
  std::mutex mutex_;
  Listener* listener_;
};

struct Sample {
  std::vector<std::byte> bytes;
  MessageInfo info;
};

Time now() {
  return std::chrono::time_point_cast<std::chrono::nanoseconds>(std::chrono::system_clock::now());
}

}  // namespace

class FakeNetwork::State : public std::enable_shared_from_this<FakeNetwork::State> {
 public:
  struct Endpoint {
    Gid gid;
    Gid participant;
    WireTopic topic;
    QoS qos;
    std::set<Gid> matched;
    std::shared_ptr<Guarded<TransportWriterListener>> writer_listener;  // one of the two
    std::shared_ptr<Guarded<TransportReaderListener>> reader_listener;
    std::deque<Sample> history;  // writer, transient local
    std::int64_t sequence_number = 0;

    [[nodiscard]] bool is_writer() const { return writer_listener != nullptr; }
  };
  struct Process {
    std::string name;
    std::shared_ptr<Guarded<GraphChanged>> graph_changed;
    bool crashed = false;
  };
  // Runs with no lock held.
  using Event = std::function<void()>;

  Gid add_process(const std::string& name);
  void remove_process(const Gid& participant);
  void crash(const Gid& participant);
  Gid add_endpoint(Endpoint endpoint);
  void remove_endpoint(const Gid& gid);
  SampleIdentity write(const Gid& writer, const void* message, const SampleIdentity& related);
  [[nodiscard]] int matched_count(const Gid& gid) const;
  [[nodiscard]] bool is_matched(const Gid& gid, const Gid& other) const;
  [[nodiscard]] std::vector<Gid> matched_participants(const Gid& gid) const;
  [[nodiscard]] std::vector<DiscoveredParticipant> participants_seen_by(const Gid& self) const;
  [[nodiscard]] std::vector<DiscoveredEndpoint> endpoints_seen_by(const Gid& self) const;
  void set_graph_changed(const Gid& participant, GraphChanged callback);
  void call_on_delivery(std::shared_ptr<Guarded<std::function<void()>>> call);

  bool deliver_one();
  void set_pending(std::function<void()> pending);
  void hold(const std::string& topic, bool held);
  void set_tamper(Tamper tamper);
  [[nodiscard]] std::uint64_t serialisations() const;
  void warn(const std::string& sentence);
  [[nodiscard]] std::vector<std::string> warnings() const;

 private:
  // All under mutex_ unless they say otherwise.
  void put_on_wire(Event event);
  void announce_graph_change(const Gid& about);
  void discover(const Gid& gid);
  void match(const Gid& writer_gid, const Gid& reader_gid);  // takes mutex_
  void unmatch(const Gid& gid, const Gid& gone);             // takes mutex_
  void send(const Gid& reader, const Sample& sample);
  void receive(const Gid& reader_gid, Sample sample);  // takes mutex_
  void tell_matches(const Gid& gid);                   // takes mutex_
  void tell_pending();                                 // takes mutex_
  [[nodiscard]] bool sees(const Gid& self, const Gid& other) const;

  // One event at a time, so that counts are told in order.
  std::mutex delivery_mutex_;
  mutable std::mutex mutex_;
  std::map<Gid, Process> processes_;
  std::map<Gid, Endpoint> endpoints_;
  std::set<std::string> held_;
  std::deque<Event> wire_;
  std::function<void()> pending_;
  Tamper tamper_;
  std::uint8_t last_process_ = 0;
  std::uint32_t last_entity_ = 0;
  std::uint64_t serialisations_ = 0;
  std::vector<std::string> warnings_;
};

Gid FakeNetwork::State::add_process(const std::string& name) {
  Gid gid;
  {
    const std::lock_guard lock(mutex_);
    // As in a DDS GUID: 12 bytes of prefix, and the entity of a participant.
    gid.bytes = {0xfa, 0x4e};
    gid.bytes[11] = ++last_process_;
    gid.bytes[14] = 0x01;
    gid.bytes[15] = 0xc1;
    processes_[gid] = {name, nullptr, false};
    announce_graph_change(gid);
  }
  tell_pending();
  return gid;
}

void FakeNetwork::State::remove_process(const Gid& participant) {
  {
    const std::lock_guard lock(mutex_);
    processes_.erase(participant);
    announce_graph_change(participant);
  }
  tell_pending();
}

void FakeNetwork::State::crash(const Gid& participant) {
  {
    const std::lock_guard lock(mutex_);
    const auto process = processes_.find(participant);
    if (process == processes_.end() || process->second.crashed) {
      return;
    }
    process->second.crashed = true;
    for (const auto& [gid, endpoint] : endpoints_) {
      if (endpoint.participant == participant) {
        for (const Gid& other : endpoint.matched) {
          put_on_wire([this, other, gone = gid] { unmatch(other, gone); });
        }
      }
    }
    announce_graph_change(participant);
  }
  tell_pending();
}

Gid FakeNetwork::State::add_endpoint(Endpoint endpoint) {
  const Gid participant = endpoint.participant;
  Gid gid = participant;
  {
    const std::lock_guard lock(mutex_);
    const std::uint32_t entity = ++last_entity_;
    gid.bytes[12] = static_cast<std::uint8_t>(entity >> 16U);
    gid.bytes[13] = static_cast<std::uint8_t>(entity >> 8U);
    gid.bytes[14] = static_cast<std::uint8_t>(entity);
    gid.bytes[15] = endpoint.is_writer() ? 0x03 : 0x04;
    endpoint.gid = gid;
    endpoints_.emplace(gid, std::move(endpoint));
    discover(gid);
    announce_graph_change(participant);
  }
  tell_pending();
  return gid;
}

void FakeNetwork::State::remove_endpoint(const Gid& gid) {
  {
    const std::lock_guard lock(mutex_);
    const auto found = endpoints_.find(gid);
    if (found == endpoints_.end()) {
      return;
    }
    const Endpoint removed = std::move(found->second);
    endpoints_.erase(found);
    for (const Gid& other : removed.matched) {
      put_on_wire([this, other, gid] { unmatch(other, gid); });
    }
    announce_graph_change(removed.participant);
  }
  tell_pending();
}

SampleIdentity FakeNetwork::State::write(const Gid& writer, const void* message,
                                         const SampleIdentity& related) {
  SampleIdentity identity;
  {
    const std::lock_guard lock(mutex_);
    Endpoint& endpoint = endpoints_.at(writer);
    const MessageType& type = *endpoint.topic.type;
    Sample sample;
    sample.bytes.resize(type.serialized_size(message));
    const std::size_t written = type.serialize(message, sample.bytes);
    if (written == 0) {
      return {};
    }
    sample.bytes.resize(written);
    ++serialisations_;
    identity = {writer, ++endpoint.sequence_number};
    sample.info = {.source_time = now(),
                   .reception_time = {},
                   .identity = identity,
                   .related = related,
                   .from_this_process = false};
    if (endpoint.qos.durability == Durability::kTransientLocal) {
      if (endpoint.history.size() >= endpoint.qos.depth) {
        endpoint.history.pop_front();
      }
      endpoint.history.push_back(sample);
    }
    for (const Gid& reader : endpoint.matched) {
      send(reader, sample);
    }
  }
  tell_pending();
  return identity;
}

void FakeNetwork::State::send(const Gid& reader, const Sample& sample) {
  put_on_wire([this, reader, sample] { receive(reader, sample); });
}

void FakeNetwork::State::receive(const Gid& reader_gid, Sample sample) {
  WireTopic topic;
  std::shared_ptr<Guarded<TransportReaderListener>> listener;
  Reliability reliability = Reliability::kReliable;
  Tamper tamper;
  {
    const std::lock_guard lock(mutex_);
    const auto reader = endpoints_.find(reader_gid);
    if (reader == endpoints_.end() ||
        !sees(reader->second.participant, sample.info.identity.writer)) {
      return;
    }
    topic = reader->second.topic;
    listener = reader->second.reader_listener;
    reliability = reader->second.qos.reliability;
    tamper = tamper_;
  }
  const Sample sent = sample;
  if (tamper && !tamper(topic.name, sample.bytes)) {
    if (reliability == Reliability::kReliable) {
      const std::lock_guard lock(mutex_);
      wire_.push_front([this, reader_gid, sent] { receive(reader_gid, sent); });
    } else {
      listener->tell([](TransportReaderListener& told) { told.on_samples_lost(1); });
    }
    return;
  }
  sample.info.reception_time = now();
  std::shared_ptr<void> message = topic.type->create();
  if (!topic.type->deserialize(sample.bytes, message.get())) {
    listener->tell(
        [&](TransportReaderListener& told) { told.on_malformed_sample(sample.info.identity); });
    return;
  }
  listener->tell([&](TransportReaderListener& told) {
    told.on_remote_message(std::move(message), sample.info);
  });
}

void FakeNetwork::State::discover(const Gid& gid) {
  const Endpoint& self = endpoints_.at(gid);
  for (const auto& [other_gid, other] : endpoints_) {
    const bool pairs = other.is_writer() != self.is_writer() &&
                       other.participant != self.participant &&
                       other.topic.name == self.topic.name &&
                       other.topic.type->dds_name == self.topic.type->dds_name;
    if (pairs) {
      const Gid writer = self.is_writer() ? gid : other_gid;
      const Gid reader = self.is_writer() ? other_gid : gid;
      put_on_wire([this, writer, reader] { match(writer, reader); });
    }
  }
}

void FakeNetwork::State::match(const Gid& writer_gid, const Gid& reader_gid) {
  std::optional<QosPolicy> policy;
  std::shared_ptr<Guarded<TransportWriterListener>> writer_listener;
  std::shared_ptr<Guarded<TransportReaderListener>> reader_listener;
  {
    const std::lock_guard lock(mutex_);
    const auto writer = endpoints_.find(writer_gid);
    const auto reader = endpoints_.find(reader_gid);
    if (writer == endpoints_.end() || reader == endpoints_.end() ||
        held_.contains(writer->second.topic.name) ||
        !sees(writer->second.participant, reader_gid) ||
        !sees(reader->second.participant, writer_gid) ||
        writer->second.matched.contains(reader_gid)) {
      return;
    }
    policy = incompatibility(writer->second.qos, reader->second.qos);
    if (!policy) {
      writer->second.matched.insert(reader_gid);
      reader->second.matched.insert(writer_gid);
      if (reader->second.qos.durability == Durability::kTransientLocal) {
        for (const Sample& sample : writer->second.history) {
          send(reader_gid, sample);
        }
      }
      for (const Gid& told : {reader_gid, writer_gid}) {
        put_on_wire([this, told] { tell_matches(told); });
      }
    }
    writer_listener = writer->second.writer_listener;
    reader_listener = reader->second.reader_listener;
  }
  if (policy) {
    writer_listener->tell(
        [&](TransportWriterListener& told) { told.on_incompatible_remote_reader(*policy); });
    reader_listener->tell(
        [&](TransportReaderListener& told) { told.on_incompatible_remote_writer(*policy); });
  }
  tell_pending();
}

void FakeNetwork::State::unmatch(const Gid& gid, const Gid& gone) {
  {
    const std::lock_guard lock(mutex_);
    const auto found = endpoints_.find(gid);
    if (found == endpoints_.end() || found->second.matched.erase(gone) == 0) {
      return;
    }
    put_on_wire([this, gid] { tell_matches(gid); });
  }
  tell_pending();
}

void FakeNetwork::State::tell_matches(const Gid& gid) {
  int matched = 0;
  std::shared_ptr<Guarded<TransportWriterListener>> writer_listener;
  std::shared_ptr<Guarded<TransportReaderListener>> reader_listener;
  {
    const std::lock_guard lock(mutex_);
    const auto found = endpoints_.find(gid);
    if (found == endpoints_.end()) {
      return;
    }
    matched = static_cast<int>(found->second.matched.size());
    writer_listener = found->second.writer_listener;
    reader_listener = found->second.reader_listener;
  }
  if (writer_listener) {
    const std::vector<Gid> participants = matched_participants(gid);
    writer_listener->tell([&](TransportWriterListener& told) {
      told.on_remote_readers_changed(matched, participants);
    });
  } else {
    reader_listener->tell([&](TransportReaderListener& told) {
      told.on_remote_writers_changed(matched);
      told.on_remote_liveliness_changed({.alive = matched, .not_alive = 0});
    });
  }
}

void FakeNetwork::State::announce_graph_change(const Gid& about) {
  for (const auto& [participant, process] : processes_) {
    if (participant != about && process.graph_changed) {
      put_on_wire([listener = process.graph_changed] {
        listener->tell([](GraphChanged& changed) { changed(); });
      });
    }
  }
}

void FakeNetwork::State::set_graph_changed(const Gid& participant, GraphChanged callback) {
  std::shared_ptr<Guarded<GraphChanged>> before;
  {
    const std::lock_guard lock(mutex_);
    auto& process = processes_.at(participant);
    before = std::move(process.graph_changed);
    process.graph_changed = nullptr;
    if (callback) {
      // The guard and the function that it guards live and die together.
      struct Owned {
        explicit Owned(GraphChanged owned) : function(std::move(owned)), guard(function) {}
        GraphChanged function;
        Guarded<GraphChanged> guard;
      };
      const auto owned = std::make_shared<Owned>(std::move(callback));
      process.graph_changed = {owned, &owned->guard};
    }
  }
  if (before) {
    before->detach();
  }
}

void FakeNetwork::State::call_on_delivery(std::shared_ptr<Guarded<std::function<void()>>> call) {
  {
    const std::lock_guard lock(mutex_);
    put_on_wire([call = std::move(call)] {
      call->tell([](const std::function<void()>& function) { function(); });
    });
  }
  tell_pending();
}

bool FakeNetwork::State::sees(const Gid& self, const Gid& other) const {
  const auto process_of = [&](const Gid& gid) {
    return std::find_if(processes_.begin(), processes_.end(), [&](const auto& entry) {
      return std::equal(gid.bytes.begin(), gid.bytes.begin() + 12, entry.first.bytes.begin());
    });
  };
  const auto process = process_of(other);
  const auto own = process_of(self);
  return process != processes_.end() && own != processes_.end() && !process->second.crashed &&
         !own->second.crashed;
}

int FakeNetwork::State::matched_count(const Gid& gid) const {
  const std::lock_guard lock(mutex_);
  return static_cast<int>(endpoints_.at(gid).matched.size());
}

bool FakeNetwork::State::is_matched(const Gid& gid, const Gid& other) const {
  const std::lock_guard lock(mutex_);
  return endpoints_.at(gid).matched.contains(other);
}

std::vector<Gid> FakeNetwork::State::matched_participants(const Gid& gid) const {
  const std::lock_guard lock(mutex_);
  std::set<Gid> participants;
  for (const Gid& other : endpoints_.at(gid).matched) {
    participants.insert(participant_of(other));
  }
  return {participants.begin(), participants.end()};
}

std::vector<DiscoveredParticipant> FakeNetwork::State::participants_seen_by(const Gid& self) const {
  const std::lock_guard lock(mutex_);
  std::vector<DiscoveredParticipant> seen;
  for (const auto& [participant, process] : processes_) {
    if (participant != self && sees(self, participant)) {
      seen.push_back({participant, process.name, "/"});
    }
  }
  return seen;
}

std::vector<DiscoveredEndpoint> FakeNetwork::State::endpoints_seen_by(const Gid& self) const {
  const std::lock_guard lock(mutex_);
  std::vector<DiscoveredEndpoint> seen;
  for (const auto& [gid, endpoint] : endpoints_) {
    if (endpoint.participant != self && sees(self, endpoint.participant)) {
      QoS qos = endpoint.qos;
      qos.depth = 0;
      seen.push_back({gid, endpoint.participant, endpoint.is_writer(), endpoint.topic.name,
                      std::string(endpoint.topic.type->dds_name), qos});
    }
  }
  return seen;
}

void FakeNetwork::State::put_on_wire(Event event) {
  wire_.push_back(std::move(event));
}

void FakeNetwork::State::tell_pending() {
  std::function<void()> pending;
  {
    const std::lock_guard lock(mutex_);
    if (!wire_.empty()) {
      pending = pending_;
    }
  }
  if (pending) {
    pending();
  }
}

bool FakeNetwork::State::deliver_one() {
  const std::lock_guard delivery(delivery_mutex_);
  Event event;
  {
    const std::lock_guard lock(mutex_);
    if (wire_.empty()) {
      return false;
    }
    event = std::move(wire_.front());
    wire_.pop_front();
  }
  event();
  return true;
}

void FakeNetwork::State::set_pending(std::function<void()> pending) {
  const std::lock_guard lock(mutex_);
  pending_ = std::move(pending);
}

void FakeNetwork::State::hold(const std::string& topic, bool held) {
  {
    const std::lock_guard lock(mutex_);
    if (held) {
      held_.insert(topic);
      return;
    }
    held_.erase(topic);
    for (const auto& [gid, endpoint] : endpoints_) {
      if (endpoint.topic.name == topic && endpoint.is_writer()) {
        discover(gid);
      }
    }
  }
  tell_pending();
}

void FakeNetwork::State::set_tamper(Tamper tamper) {
  const std::lock_guard lock(mutex_);
  tamper_ = std::move(tamper);
}

std::uint64_t FakeNetwork::State::serialisations() const {
  const std::lock_guard lock(mutex_);
  return serialisations_;
}

void FakeNetwork::State::warn(const std::string& sentence) {
  const std::lock_guard lock(mutex_);
  warnings_.push_back(sentence);
}

std::vector<std::string> FakeNetwork::State::warnings() const {
  const std::lock_guard lock(mutex_);
  return warnings_;
}

namespace {

using State = FakeNetwork::State;

class FakeWriter final : public TransportWriter {
 public:
  FakeWriter(std::shared_ptr<State> network, Gid gid,
             std::shared_ptr<Guarded<TransportWriterListener>> listener)
      : network_(std::move(network)), gid_(gid), listener_(std::move(listener)) {}
  FakeWriter(const FakeWriter&) = delete;
  FakeWriter& operator=(const FakeWriter&) = delete;
  ~FakeWriter() override {
    listener_->detach();
    network_->remove_endpoint(gid_);
  }
  SampleIdentity write(const void* message, const SampleIdentity& related) override {
    return network_->write(gid_, message, related);
  }
  int matched_remote_readers() const override { return network_->matched_count(gid_); }
  bool is_matched(const Gid& reader) const override { return network_->is_matched(gid_, reader); }
  std::vector<Gid> matched_participants() const override {
    return network_->matched_participants(gid_);
  }
  void assert_liveliness() override {}
  Gid gid() const override { return gid_; }

 private:
  const std::shared_ptr<State> network_;
  const Gid gid_;
  const std::shared_ptr<Guarded<TransportWriterListener>> listener_;
};

class FakeReader final : public TransportReader {
 public:
  FakeReader(std::shared_ptr<State> network, Gid gid,
             std::shared_ptr<Guarded<TransportReaderListener>> listener)
      : network_(std::move(network)), gid_(gid), listener_(std::move(listener)) {}
  FakeReader(const FakeReader&) = delete;
  FakeReader& operator=(const FakeReader&) = delete;
  ~FakeReader() override {
    listener_->detach();
    network_->remove_endpoint(gid_);
  }
  int matched_remote_writers() const override { return network_->matched_count(gid_); }
  bool is_matched(const Gid& writer) const override { return network_->is_matched(gid_, writer); }
  Gid gid() const override { return gid_; }

 private:
  const std::shared_ptr<State> network_;
  const Gid gid_;
  const std::shared_ptr<Guarded<TransportReaderListener>> listener_;
};

/// Waits on the wire for the test, whatever the delay.
class FakeDelayedCall final : public DelayedCall {
 public:
  FakeDelayedCall(std::shared_ptr<State> network, std::function<void()> call)
      : network_(std::move(network)),
        call_([this, inner = std::move(call)] {
          pending_ = false;
          inner();
        }),
        guarded_(std::make_shared<Guarded<std::function<void()>>>(call_)) {}
  FakeDelayedCall(const FakeDelayedCall&) = delete;
  FakeDelayedCall& operator=(const FakeDelayedCall&) = delete;
  ~FakeDelayedCall() override { guarded_->detach(); }

  void start(Duration) override {
    if (!pending_.exchange(true)) {
      network_->call_on_delivery(guarded_);
    }
  }

 private:
  const std::shared_ptr<State> network_;
  std::atomic<bool> pending_{false};
  std::function<void()> call_;
  const std::shared_ptr<Guarded<std::function<void()>>> guarded_;
};

class FakeTransport final : public Transport {
 public:
  FakeTransport(std::shared_ptr<State> network, const std::string& name)
      : network_(std::move(network)), gid_(network_->add_process(name)) {}
  FakeTransport(const FakeTransport&) = delete;
  FakeTransport& operator=(const FakeTransport&) = delete;
  ~FakeTransport() override {
    network_->set_graph_changed(gid_, nullptr);
    network_->remove_process(gid_);
  }

  std::unique_ptr<TransportWriter> create_writer(const WireTopic& topic, const QoS& qos,
                                                 TransportWriterListener& listener) override {
    const auto guarded = std::make_shared<Guarded<TransportWriterListener>>(listener);
    State::Endpoint endpoint;
    endpoint.participant = gid_;
    endpoint.topic = topic;
    endpoint.qos = qos;
    endpoint.writer_listener = guarded;
    return std::make_unique<FakeWriter>(network_, network_->add_endpoint(std::move(endpoint)),
                                        guarded);
  }
  std::unique_ptr<TransportReader> create_reader(const WireTopic& topic, const QoS& qos,
                                                 TransportReaderListener& listener) override {
    const auto guarded = std::make_shared<Guarded<TransportReaderListener>>(listener);
    State::Endpoint endpoint;
    endpoint.participant = gid_;
    endpoint.topic = topic;
    endpoint.qos = qos;
    endpoint.reader_listener = guarded;
    return std::make_unique<FakeReader>(network_, network_->add_endpoint(std::move(endpoint)),
                                        guarded);
  }

  Gid participant() const override { return gid_; }
  std::vector<DiscoveredParticipant> remote_participants() const override {
    return network_->participants_seen_by(gid_);
  }
  std::vector<DiscoveredEndpoint> remote_endpoints() const override {
    return network_->endpoints_seen_by(gid_);
  }
  void on_graph_changed(GraphChanged callback) override {
    network_->set_graph_changed(gid_, std::move(callback));
  }
  std::unique_ptr<DelayedCall> create_delayed_call(std::function<void()> call) override {
    return std::make_unique<FakeDelayedCall>(network_, std::move(call));
  }
  std::vector<std::string> warnings() const override { return network_->warnings(); }

 private:
  const std::shared_ptr<State> network_;
  const Gid gid_;
};

}  // namespace

FakeNetwork::FakeNetwork() : state_(std::make_shared<State>()) {}
FakeNetwork::~FakeNetwork() = default;

std::unique_ptr<Transport> FakeNetwork::create_transport(const std::string& name) {
  return std::make_unique<FakeTransport>(state_, name);
}

std::size_t FakeNetwork::deliver() {
  std::size_t delivered = 0;
  while (state_->deliver_one()) {
    ++delivered;
  }
  return delivered;
}

bool FakeNetwork::deliver_one() {
  return state_->deliver_one();
}
void FakeNetwork::on_pending(std::function<void()> pending) {
  state_->set_pending(std::move(pending));
}
void FakeNetwork::hold_matching(const std::string& topic) {
  state_->hold(topic, true);
}
void FakeNetwork::allow_matching(const std::string& topic) {
  state_->hold(topic, false);
}
void FakeNetwork::set_tamper(Tamper tamper) {
  state_->set_tamper(std::move(tamper));
}
void FakeNetwork::crash(const Gid& participant) {
  state_->crash(participant);
}
void FakeNetwork::warn(const std::string& sentence) {
  state_->warn(sentence);
}
std::uint64_t FakeNetwork::serialisations() const {
  return state_->serialisations();
}

}  // namespace pipescout::testing
