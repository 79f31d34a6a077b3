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

/// A network inside one test: contexts whose transports come from the same `FakeNetwork` see each
/// other as if they were processes. Messages are really serialised and deserialised through their
/// `MessageType`; matching follows the QoS rules of DDS; late joiners of transient local topics get
/// the last messages. No socket is opened and no thread is started.
///
/// Nothing travels by itself: what is written, matched or unmatched waits on the wire, in order,
/// until the test lets it through with `deliver` or `deliver_one`, on the thread that calls these.
/// So a test decides what overtakes what. Endpoints are matched in one event and told of it in
/// later ones, as on a real network.
///
/// A `DelayedCall` waits on the wire too, whatever its delay.
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

  /// Lets everything through that is on the wire, and what that brings about. Returns the number
  /// of events. Not to be called from a listener.
  std::size_t deliver();
  /// Lets the oldest event through; false when the wire is empty.
  bool deliver_one();
  /// Called after something was put on the wire, on the thread that did so and with no lock held
  /// by the network (but maybe by the writer); lets a test wake a thread that delivers. Empty:
  /// nobody.
  void on_pending(std::function<void()> pending);

  /// Endpoints of a topic (its DDS name) do not find each other until `allow_matching`.
  void hold_matching(const std::string& topic);
  void allow_matching(const std::string& topic);

  /// Bytes of each sample pass through `tamper` on their way; false drops the sample, and its
  /// reader is told that it is lost. Empty: nothing is changed.
  using Tamper = std::function<bool(const std::string& topic, std::vector<std::byte>& bytes)>;
  void set_tamper(Tamper tamper);

  /// The process of this identity falls silent for the others, as after SIGKILL and the end of its
  /// lease: the others lose its endpoints and then the participant.
  void crash(const Gid& participant);

  /// From now on one of the `Transport::warnings` of every process.
  void warn(const std::string& sentence);

  /// Messages that were serialised, in all transports: one per write, whatever the number of
  /// readers.
  [[nodiscard]] std::uint64_t serialisations() const;

  class State;

 private:
  const std::shared_ptr<State> state_;
};

}  // namespace pipescout::testing
