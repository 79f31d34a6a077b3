// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "pipescout/runtime/transport.hpp"

namespace pipescout::testing {

/// A network inside one test: contexts with transports of the same `FakeNetwork` discover each
/// other like separate processes. Messages are serialised and deserialised through their
/// `MessageType`; matching follows the QoS rules of DDS; late joiners of transient local topics get
/// the last messages. No socket is opened and no thread is started.
///
/// Nothing is delivered automatically: written samples and matches are queued as events, in order,
/// until the test calls `deliver` or `deliver_one`, which run on the calling thread. So a test
/// controls the order of events. Endpoints are matched in one event and notified in later ones, as
/// on a real network.
///
/// A `DelayedCall` is queued too, regardless of its delay.
///
/// Not simulated: deadlines, lifespan and leases on the wire; loss only through `set_tamper`.
/// Thread-safe. Transports may outlive the `FakeNetwork` object; they share its state.
class FakeNetwork {
 public:
  FakeNetwork();
  ~FakeNetwork();
  FakeNetwork(const FakeNetwork&) = delete;
  FakeNetwork& operator=(const FakeNetwork&) = delete;

  /// A new process on this network.
  [[nodiscard]] std::unique_ptr<Transport> create_transport(const std::string& name = "fake");

  /// Delivers all queued events, and those that result from them. Returns the number of events.
  /// Must not be called from a listener.
  std::size_t deliver();
  /// Delivers the oldest event; false when the queue is empty.
  bool deliver_one();
  /// Called after an event was queued, on the thread that queued it and with no lock held by the
  /// network (but possibly by the writer); lets a test wake a thread that delivers. Empty: no call.
  void on_pending(std::function<void()> pending);

  /// Endpoints of a topic (its DDS name) are not matched until `allow_matching`.
  void hold_matching(const std::string& topic);
  void allow_matching(const std::string& topic);

  /// `tamper` may change the bytes of each sample; false drops the sample: it is sent again to a
  /// reliable reader, and a best-effort one is notified of the loss. Empty: nothing is changed.
  using Tamper = std::function<bool(const std::string& topic, std::vector<std::byte>& bytes)>;
  void set_tamper(Tamper tamper);

  /// Disconnects the process of this identity, as after SIGKILL and the end of its lease: the
  /// others lose its endpoints and then the participant.
  void crash(const Gid& participant);

  /// Adds a warning to `Transport::warnings` of every process.
  void warn(const std::string& sentence);

  /// Number of serialised messages in all transports: one per write, regardless of the number of
  /// readers.
  [[nodiscard]] std::uint64_t serialisations() const;

  class State;

 private:
  const std::shared_ptr<State> state_;
};

}  // namespace pipescout::testing
