// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "pipescout/idl/message_type.hpp"
#include "pipescout/runtime/qos.hpp"
#include "pipescout/runtime/time.hpp"

/// Delivery to other processes. The in-process path does not use it: the runtime delivers a
/// `shared_ptr<const T>` itself, and passes a message to a `Transport` only for readers in other
/// processes. A context without a transport is the backend of unit tests without sockets.
namespace pipescout {

/// Identity of a participant or endpoint: the 16 bytes of a DDS GUID (12 prefix, 4 entity).
struct Gid {
  std::array<std::uint8_t, 16> bytes{};
  auto operator<=>(const Gid&) const = default;
};

/// "01.0f.45....|00.00.12.03", as DDS tools print a GUID.
[[nodiscard]] std::string to_string(const Gid& gid);

/// True when both belong to the same participant.
[[nodiscard]] bool same_participant(const Gid& a, const Gid& b) noexcept;

/// The participant that an endpoint belongs to: the same bytes without the entity.
[[nodiscard]] Gid participant_of(const Gid& endpoint) noexcept;

/// Identifies one sample of one writer; services relate a reply to its request with it.
struct SampleIdentity {
  Gid writer;
  std::int64_t sequence_number = 0;
  auto operator<=>(const SampleIdentity&) const = default;
};

/// Metadata of a received message.
struct MessageInfo {
  Time source_time{};       ///< system time at which the publisher published
  Time reception_time{};    ///< system time at which the message reached this process
  SampleIdentity identity;  ///< of this sample
  SampleIdentity related;   ///< services: the request of a reply, or the reply reader of a request
  bool from_this_process = false;
};

/// A topic by its name on the wire and its type. `name` is the DDS name ("rt/odometer/fused",
/// "rq/talker/get_parametersRequest", "ros_discovery_info").
struct WireTopic {
  std::string name;
  const MessageType* type = nullptr;
};

/// Counts of a liveliness change, seen by a subscription: publishers that are alive or not.
struct LivelinessChange {
  int alive = 0;
  int not_alive = 0;
};

/// Events of a writer. Called from threads of the transport; must return soon, must not throw, and
/// must not call back into the endpoint's destruction.
class TransportWriterListener {
 public:
  virtual ~TransportWriterListener() = default;
  /// `matched`: remote readers now matched; `participants`: those that have any, each once.
  virtual void on_remote_readers_changed(int matched, const std::vector<Gid>& participants) = 0;
  virtual void on_incompatible_remote_reader(QosPolicy policy) = 0;
};

/// Events of a reader. Same rules as for `TransportWriterListener`. Samples (`on_remote_message`,
/// `on_malformed_sample`, `on_overwritten_sample`, `on_samples_lost`) come from threads that hold
/// locks of the transport: a lock that they take must not be held by a caller of `write` or while
/// an endpoint is created or destroyed. The other events, of writers too, come one after the other
/// from a thread that holds none.
class TransportReaderListener {
 public:
  virtual ~TransportReaderListener() = default;
  /// A message from another process, deserialised into an object of the topic's type.
  virtual void on_remote_message(std::shared_ptr<const void> message, const MessageInfo& info) = 0;
  /// A sample whose data does not match the topic's type; it was dropped.
  virtual void on_malformed_sample(const SampleIdentity& sample) = 0;
  /// A sample whose data its writer has overwritten before it was read here.
  virtual void on_overwritten_sample(const SampleIdentity& sample) = 0;
  /// Samples that the network lost for good (best effort).
  virtual void on_samples_lost(int count) = 0;
  virtual void on_remote_writers_changed(int matched) = 0;
  virtual void on_incompatible_remote_writer(QosPolicy policy) = 0;
  /// Absolute numbers for the remote writers of this topic.
  virtual void on_remote_liveliness_changed(LivelinessChange now) = 0;
};

/// The sending end towards other processes. Destroying it unregisters the listener first: no call
/// is in progress or follows once the destructor returned.
class TransportWriter {
 public:
  virtual ~TransportWriter() = default;
  /// Serialises the message once and sends it to every matched remote reader; with transient local
  /// durability also keeps it for later ones. `related` is sent along when its writer is not zero.
  /// Returns the identity of the sample; sequence number 0 when the sample could not be sent.
  /// Thread-safe.
  virtual SampleIdentity write(const void* message, const SampleIdentity& related) = 0;
  /// The current state, like `is_matched`; the listener is notified later.
  [[nodiscard]] virtual int matched_remote_readers() const = 0;
  /// True when the remote reader of that identity is matched (service replies wait for it).
  [[nodiscard]] virtual bool is_matched(const Gid& reader) const = 0;
  /// Participants of the matched remote readers, without their entity, each once.
  [[nodiscard]] virtual std::vector<Gid> matched_participants() const = 0;
  /// For `Liveliness::kManualByTopic`.
  virtual void assert_liveliness() = 0;
  [[nodiscard]] virtual Gid gid() const = 0;
};

/// The receiving end from other processes; same rule for destruction.
class TransportReader {
 public:
  virtual ~TransportReader() = default;
  [[nodiscard]] virtual int matched_remote_writers() const = 0;
  [[nodiscard]] virtual bool is_matched(const Gid& writer) const = 0;
  [[nodiscard]] virtual Gid gid() const = 0;
};

/// An endpoint somewhere on the network, as discovery reports it.
struct DiscoveredEndpoint {
  Gid gid;
  Gid participant;
  bool is_writer = false;
  std::string topic;  ///< DDS name
  std::string type;   ///< DDS type name
  QoS qos;            ///< depth is not announced by discovery and is 0 here
};

struct DiscoveredParticipant {
  Gid gid;
  std::string name;
  std::string enclave;  ///< from the user data "enclave=...;", as ROS 2 sends it; empty for non-ROS
  /// It can be reached by processes of its machine alone, as with `ROS_LOCALHOST_ONLY`.
  bool is_on_loopback_alone = false;
};

/// A participant of this machine that holds sockets of the domain but has not been discovered: it
/// has just come, does not answer, or cannot be heard.
struct UnheardParticipant {
  int process = 0;         ///< its id; 0: that of another user, who alone may see it
  std::string program;     ///< of the process; empty when it is not known
  std::uint16_t port = 0;  ///< for discovery; 0: one that the standard does not name
  /// It takes messages from shared memory alone, or is in another network namespace: it cannot be
  /// discovered, while others may still answer.
  bool has_no_udp = false;
  bool operator==(const UnheardParticipant&) const = default;
};

/// Called on a thread of the transport when the remote graph has changed. It may call
/// `remote_participants` and `remote_endpoints`, which already contain the change. A message of
/// another process may arrive shortly before `remote_participants` shows that process.
using GraphChanged = std::function<void()>;

/// A delayed call, see `Transport::create_delayed_call`. Once destroyed, no call is in progress or
/// follows. Thread-safe; must not be destroyed by its own call.
class DelayedCall {
 public:
  virtual ~DelayedCall() = default;
  /// Calls once after the delay; does nothing while a call is pending. The call itself may start
  /// the next one.
  virtual void start(Duration delay) = 0;
};

class Transport {
 public:
  virtual ~Transport() = default;

  /// Throws TransportError with the topic's name when the endpoint cannot be made. The listener
  /// must outlive the returned endpoint.
  [[nodiscard]] virtual std::unique_ptr<TransportWriter> create_writer(
      const WireTopic& topic, const QoS& qos, TransportWriterListener& listener) = 0;
  [[nodiscard]] virtual std::unique_ptr<TransportReader> create_reader(
      const WireTopic& topic, const QoS& qos, TransportReaderListener& listener) = 0;

  /// Identity of this process's participant.
  [[nodiscard]] virtual Gid participant() const = 0;

  /// Snapshot of the discovered OTHER processes.
  [[nodiscard]] virtual std::vector<DiscoveredParticipant> remote_participants() const = 0;
  [[nodiscard]] virtual std::vector<DiscoveredEndpoint> remote_endpoints() const = 0;
  /// Replaces the callback; an empty one removes it and returns once no call is in progress.
  virtual void on_graph_changed(GraphChanged callback) = 0;

  /// `call` runs on a thread of the transport that holds none of its locks; it must return soon and
  /// must not throw. The transport must outlive the returned object.
  [[nodiscard]] virtual std::unique_ptr<DelayedCall> create_delayed_call(
      std::function<void()> call) = 0;

  /// Limitations of the transport, one sentence each, in the order of detection: "no room in
  /// /dev/shm ...". Reported on /diagnostics; they are already in the log.
  [[nodiscard]] virtual std::vector<std::string> warnings() const = 0;

  /// Who is on this machine and missing from `remote_participants`; removes from it those of this
  /// machine that were killed, which are otherwise kept until their lease ends. Asks the kernel for
  /// the sockets of all processes: some milliseconds. A transport that cannot know returns none.
  virtual std::vector<UnheardParticipant> take_census() { return {}; }
};

/// A participant, topic or endpoint could not be created.
class TransportError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace pipescout
