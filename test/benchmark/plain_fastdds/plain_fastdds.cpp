// SPDX-License-Identifier: Apache-2.0
#include "plain_fastdds.hpp"

#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastdds/rtps/transport/shared_mem/SharedMemTransportDescriptor.h>
#include <atomic>
#include <fastdds/dds/core/condition/GuardCondition.hpp>
#include <fastdds/dds/core/condition/StatusCondition.hpp>
#include <fastdds/dds/core/condition/WaitSet.hpp>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/DataWriterListener.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <functional>
#include <span>
#include <stdexcept>
#include <thread>

namespace pipescout::benchmarks {

namespace dds = eprosima::fastdds::dds;
namespace rtps = eprosima::fastdds::rtps;

namespace {

/// The type as a program that knows nothing but Fast DDS gives it: only the bytes come from us.
class ImageType final : public dds::TopicDataType {
 public:
  ImageType() {
    setName(std::string(type_.dds_name).c_str());
    // Of an image without content; buffers grow with the first message.
    m_typeSize = static_cast<std::uint32_t>(type_.serialized_size(type_.create().get()));
  }

  bool serialize(void* data, eprosima::fastrtps::rtps::SerializedPayload_t* payload) override {
    payload->encapsulation = CDR_LE;
    payload->length = static_cast<std::uint32_t>(
        type_.serialize(data, {reinterpret_cast<std::byte*>(payload->data), payload->max_size}));
    return payload->length != 0;
  }
  bool deserialize(eprosima::fastrtps::rtps::SerializedPayload_t* payload, void* data) override {
    return type_.deserialize({reinterpret_cast<const std::byte*>(payload->data), payload->length},
                             data);
  }
  std::function<std::uint32_t()> getSerializedSizeProvider(void* data) override {
    return [this, data] { return static_cast<std::uint32_t>(type_.serialized_size(data)); };
  }
  void* createData() override { return new sensor_msgs::msg::Image(); }
  void deleteData(void* data) override { delete static_cast<sensor_msgs::msg::Image*>(data); }
  bool getKey(void*, eprosima::fastrtps::rtps::InstanceHandle_t*, bool) override { return false; }

 private:
  const MessageType& type_ = message_type<sensor_msgs::msg::Image>();
};

}  // namespace

class PlainParticipant {
 public:
  explicit PlainParticipant(std::uint32_t domain) : type(new ImageType()) {
    dds::DomainParticipantQos qos = dds::PARTICIPANT_QOS_DEFAULT;
    qos.transport().use_builtin_transports = false;
    qos.transport().user_transports.push_back(
        std::make_shared<rtps::SharedMemTransportDescriptor>());
    auto udp = std::make_shared<rtps::UDPv4TransportDescriptor>();
    udp->interfaceWhiteList.emplace_back("127.0.0.1");
    qos.transport().user_transports.push_back(udp);
    participant = dds::DomainParticipantFactory::get_instance()->create_participant(domain, qos);
    if (participant == nullptr) {
      throw std::runtime_error("no participant for the plain Fast DDS peer");
    }
    type.register_type(participant);
    publisher = participant->create_publisher(dds::PUBLISHER_QOS_DEFAULT);
    subscriber = participant->create_subscriber(dds::SUBSCRIBER_QOS_DEFAULT);
  }
  ~PlainParticipant() {
    participant->delete_contained_entities();
    dds::DomainParticipantFactory::get_instance()->delete_participant(participant);
  }
  PlainParticipant(const PlainParticipant&) = delete;
  PlainParticipant& operator=(const PlainParticipant&) = delete;

  dds::Topic* topic(const std::string& name) {
    if (auto* description = participant->lookup_topicdescription(name)) {
      return dynamic_cast<dds::Topic*>(description);
    }
    return participant->create_topic(name, type.get_type_name(), dds::TOPIC_QOS_DEFAULT);
  }

  dds::TypeSupport type;
  dds::DomainParticipant* participant = nullptr;
  dds::Publisher* publisher = nullptr;
  dds::Subscriber* subscriber = nullptr;
};

class PlainWriter::Impl final : public dds::DataWriterListener {
 public:
  Impl(std::shared_ptr<PlainParticipant> owner, const std::string& topic)
      : owner_(std::move(owner)) {
    writer = owner_->publisher->create_datawriter(owner_->topic(topic), dds::DATAWRITER_QOS_DEFAULT,
                                                  this);
  }
  ~Impl() override { owner_->publisher->delete_datawriter(writer); }
  void on_publication_matched(dds::DataWriter*,
                              const dds::PublicationMatchedStatus& info) override {
    matched = info.current_count;
  }

  std::atomic<int> matched{0};
  dds::DataWriter* writer = nullptr;

 private:
  std::shared_ptr<PlainParticipant> owner_;
};

PlainWriter::PlainWriter(const std::shared_ptr<PlainParticipant>& participant,
                         const std::string& topic)
    : impl_(std::make_unique<Impl>(participant, topic)) {}
PlainWriter::~PlainWriter() = default;
void PlainWriter::write(sensor_msgs::msg::Image& image) {
  impl_->writer->write(&image);
}
int PlainWriter::matched() const {
  return impl_->matched;
}

class PlainReader::Impl final : public dds::DataReaderListener {
 public:
  Impl(std::shared_ptr<PlainParticipant> owner, const std::string& topic,
       std::function<void(sensor_msgs::msg::Image&)> callback, PlainCallback where)
      : owner_(std::move(owner)), callback_(std::move(callback)) {
    dds::DataReaderQos qos = dds::DATAREADER_QOS_DEFAULT;
    qos.reliability().kind = dds::RELIABLE_RELIABILITY_QOS;
    dds::StatusMask heard = dds::StatusMask::subscription_matched();
    if (where == PlainCallback::kInListener) {
      heard << dds::StatusMask::data_available();
    }
    reader = owner_->subscriber->create_datareader(owner_->topic(topic), qos, this, heard);
    if (where == PlainCallback::kInThread) {
      reader->get_statuscondition().set_enabled_statuses(dds::StatusMask::data_available());
      wait_set_.attach_condition(reader->get_statuscondition());
      wait_set_.attach_condition(stop_);
      thread_ = std::thread([this] { wait(); });
    }
  }
  ~Impl() override {
    if (thread_.joinable()) {
      stop_.set_trigger_value(true);
      thread_.join();
      wait_set_.detach_condition(reader->get_statuscondition());
    }
    owner_->subscriber->delete_datareader(reader);
  }
  void on_subscription_matched(dds::DataReader*,
                               const dds::SubscriptionMatchedStatus& info) override {
    matched = info.current_count;
  }
  void on_data_available(dds::DataReader*) override { take_all(); }

  std::atomic<int> matched{0};
  dds::DataReader* reader = nullptr;

 private:
  void take_all() {
    dds::SampleInfo info;
    while (reader->take_next_sample(&image_, &info) == ReturnCode_t::RETCODE_OK) {
      if (info.valid_data) {
        callback_(image_);
      }
    }
  }
  void wait() {
    dds::ConditionSeq active;
    while (!stop_.get_trigger_value()) {
      wait_set_.wait(active, eprosima::fastrtps::c_TimeInfinite);
      take_all();
    }
  }

  std::shared_ptr<PlainParticipant> owner_;
  std::function<void(sensor_msgs::msg::Image&)> callback_;
  sensor_msgs::msg::Image image_;
  dds::GuardCondition stop_;
  dds::WaitSet wait_set_;
  std::thread thread_;
};

PlainReader::PlainReader(const std::shared_ptr<PlainParticipant>& participant,
                         const std::string& topic,
                         std::function<void(sensor_msgs::msg::Image&)> callback,
                         PlainCallback where)
    : impl_(std::make_unique<Impl>(participant, topic, std::move(callback), where)) {}
PlainReader::~PlainReader() = default;
int PlainReader::matched() const {
  return impl_->matched;
}

std::shared_ptr<PlainParticipant> create_plain_participant(std::uint32_t domain) {
  return std::make_shared<PlainParticipant>(domain);
}

}  // namespace pipescout::benchmarks
