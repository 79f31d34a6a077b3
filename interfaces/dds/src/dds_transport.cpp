// SPDX-License-Identifier: Apache-2.0
#include <memory>
#include <utility>

#include "dds_reader.hpp"
#include "dds_writer.hpp"
#include "participant.hpp"
#include "pipescout/dds/dds_transport.hpp"

namespace pipescout {
namespace dds {
namespace {

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
  void on_graph_changed(GraphChanged callback) override {
    participant_->discovery().on_graph_changed(std::move(callback));
  }

 private:
  const std::shared_ptr<Participant> participant_;
};

}  // namespace
}  // namespace dds

std::unique_ptr<Transport> create_dds_transport(const DdsOptions& options) {
  return std::make_unique<dds::DdsTransport>(options);
}

}  // namespace pipescout
