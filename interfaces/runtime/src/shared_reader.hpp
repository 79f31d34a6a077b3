// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "pipescout/runtime/transport.hpp"
#include "step_traffic.hpp"

namespace pipescout {

/// The reader of one topic with one QoS, for all subscriptions of the process that ask for this
/// QoS, and all for objects or all for bytes: each message is received and deserialised once and
/// handed to all of them as the same object. A subscription that joins later is told of the
/// matches, the liveliness and the incompatible writers that there have been. Thread-safe.
class SharedReader final : private TransportReaderListener {
 public:
  /// The first subscription joins before anything can arrive. Throws TransportError.
  SharedReader(Transport& transport, const WireTopic& topic, const QoS& qos,
               std::shared_ptr<StepTraffic> traffic,
               std::shared_ptr<TransportReaderListener> first);
  SharedReader(const SharedReader&) = delete;
  SharedReader& operator=(const SharedReader&) = delete;
  ~SharedReader() override = default;

  [[nodiscard]] bool serves(const WireTopic& topic, const QoS& qos) const;
  /// False when the subscription needs another reader: writers keep transient local messages for
  /// each reader that comes, and send them once. This reader has received some that the
  /// subscription has not seen.
  [[nodiscard]] bool join(const std::shared_ptr<TransportReaderListener>& subscription);
  /// No call of the subscription is in progress or follows once this returned.
  void leave(const TransportReaderListener& subscription);

  [[nodiscard]] bool is_matched(const Gid& writer) const { return reader_->is_matched(writer); }
  [[nodiscard]] const Gid& gid() const noexcept { return gid_; }

 private:
  void on_remote_message(std::shared_ptr<const void> message, const MessageInfo& info) override;
  void on_malformed_sample(const SampleIdentity& sample) override;
  void on_overwritten_sample(const SampleIdentity& sample) override;
  void on_samples_lost(int count) override;
  void on_remote_writers_changed(int matched) override;
  void on_incompatible_remote_writer(QosPolicy policy) override;
  void on_remote_liveliness_changed(LivelinessChange now) override;

  /// For a simulation in lock step: the sample is not under way any more.
  void count(const SampleIdentity& sample);
  /// Calls for each subscription; the first exception comes out once all were called.
  template <class Call>
  void tell_all(Call call);  // under mutex_

  const std::string topic_;
  const MessageType* const type_;
  const QoS qos_;
  const std::shared_ptr<StepTraffic> traffic_;
  Gid gid_;

  // Held while the subscriptions are told, so that none is told after it left. Never held while
  // the transport makes or destroys an endpoint, which waits for the calls above.
  std::mutex mutex_;
  std::vector<std::shared_ptr<TransportReaderListener>> subscriptions_;
  bool has_received_ = false;
  int matched_writers_ = 0;
  LivelinessChange liveliness_;
  std::map<QosPolicy, std::uint64_t> incompatible_writers_;

  std::unique_ptr<TransportReader> reader_;  // last: destroyed before what its listener uses
};

}  // namespace pipescout
