// SPDX-License-Identifier: Apache-2.0
#include <fastrtps/config.h>

#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "dds_reader.hpp"
#include "dds_writer.hpp"
#include "participant.hpp"
#include "pipescout/dds/dds_transport.hpp"

namespace pipescout {
namespace dds {
namespace {

class DdsDelayedCall final : public DelayedCall {
 public:
  DdsDelayedCall(std::shared_ptr<Participant> participant, std::function<void()> call)
      : participant_(std::move(participant)), call_(std::move(call)) {
    participant_->events().admit(this);
  }
  DdsDelayedCall(const DdsDelayedCall&) = delete;
  DdsDelayedCall& operator=(const DdsDelayedCall&) = delete;
  ~DdsDelayedCall() override { participant_->events().dismiss(this); }

  void start(Duration delay) override {
    if (!pending_.exchange(true)) {
      participant_->events().post_after(this, delay, [this] {
        pending_ = false;
        call_();
      });
    }
  }

 private:
  const std::shared_ptr<Participant> participant_;
  const std::function<void()> call_;
  std::atomic<bool> pending_{false};
};

class DdsTransport : public Transport {
 public:
  explicit DdsTransport(const DdsOptions& options)
      : participant_(std::make_shared<Participant>(options)) {}
  DdsTransport(const DdsTransport&) = delete;
  DdsTransport& operator=(const DdsTransport&) = delete;
  // Endpoints may outlive the transport and with them the participant, but not its callback.
  ~DdsTransport() override { participant_->discovery().on_graph_changed(nullptr); }

  std::unique_ptr<TransportWriter> create_writer(const WireTopic& topic, const QoS& qos,
                                                 TransportWriterListener& listener) override {
    return std::make_unique<DdsWriter>(participant_, topic, qos, listener);
  }
  std::unique_ptr<TransportReader> create_reader(const WireTopic& topic, const QoS& qos,
                                                 TransportReaderListener& listener) override {
    return std::make_unique<DdsReader>(participant_, topic, qos, listener);
  }
  Gid participant() const override { return participant_->gid(); }
  std::vector<DiscoveredParticipant> remote_participants() const override {
    return participant_->discovery().participants();
  }
  std::vector<DiscoveredEndpoint> remote_endpoints() const override {
    return participant_->discovery().endpoints();
  }
  std::vector<UnheardParticipant> take_census() override { return participant_->take_census(); }
  void on_graph_changed(GraphChanged callback) override {
    participant_->discovery().on_graph_changed(std::move(callback));
  }
  std::unique_ptr<DelayedCall> create_delayed_call(std::function<void()> call) override {
    return std::make_unique<DdsDelayedCall>(participant_, std::move(call));
  }
  std::vector<std::string> warnings() const override { return participant_->warnings(); }

 private:
  const std::shared_ptr<Participant> participant_;
};

}  // namespace
}  // namespace dds

std::unique_ptr<Transport> create_dds_transport(const DdsOptions& options) {
  return std::make_unique<dds::DdsTransport>(options);
}

std::string fast_dds_version() {
  return FASTRTPS_VERSION_STR;
}

}  // namespace pipescout
