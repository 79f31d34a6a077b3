// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>

#include "pipescout/runtime/transport.hpp"

namespace pipescout {

/// For a subscription that asks for best effort in a process that takes part in the steps of a
/// simulation: from writers that offer reliability its messages come reliably. A simulation waits
/// for each message, so none may be lost; and a subscription that asked for reliability would not
/// match writers that do not offer it. Each message is told once.
class LosslessReader final : public TransportReader, private TransportReaderListener {
 public:
  /// `qos` asks for best effort and is volatile. Throws TransportError. `transport` and `listener`
  /// must exist as long as this.
  LosslessReader(Transport& transport, const WireTopic& topic, const QoS& qos,
                 TransportReaderListener& listener);
  LosslessReader(const LosslessReader&) = delete;
  LosslessReader& operator=(const LosslessReader&) = delete;
  ~LosslessReader() override;

  [[nodiscard]] int matched_remote_writers() const override;
  [[nodiscard]] bool is_matched(const Gid& writer) const override;
  [[nodiscard]] Gid gid() const override;

 private:
  /// What comes reliably.
  class Reliable;

  // Of the best-effort reader.
  void on_remote_message(std::shared_ptr<const void> message, const MessageInfo& info) override;
  void on_malformed_sample(const SampleIdentity& sample) override;
  void on_overwritten_sample(const SampleIdentity& sample) override;
  void on_samples_lost(int count) override;
  void on_remote_writers_changed(int matched) override;
  void on_incompatible_remote_writer(QosPolicy policy) override;
  void on_remote_liveliness_changed(LivelinessChange now) override;

  [[nodiscard]] bool comes_reliably(const Gid& writer) const;
  /// Whether the sample was not told before.
  [[nodiscard]] bool is_new(const SampleIdentity& sample);

  Transport& transport_;
  const WireTopic topic_;
  const QoS qos_;
  TransportReaderListener& listener_;
  std::mutex mutex_;
  std::map<Gid, std::int64_t> last_;  // sequence numbers by writer
  std::unique_ptr<Reliable> owned_reliable_;
  std::atomic<Reliable*> reliable_{nullptr};      // null until there is a writer for it
  std::unique_ptr<TransportReader> best_effort_;  // last: destroyed before what its listener uses
};

}  // namespace pipescout
