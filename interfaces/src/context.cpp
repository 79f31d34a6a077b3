// SPDX-License-Identifier: Apache-2.0
#include "pipescout/interfaces/context.hpp"

#include <mutex>
#include <rosgraph_msgs/msg/clock.hpp>
#include <utility>

#include "broker.hpp"
#include "graph.hpp"
#include "pipescout/interfaces/graph.hpp"

namespace pipescout {

namespace {

class ProcessContext final : public Context {
 public:
  explicit ProcessContext(std::unique_ptr<Transport> transport)
      : broker_(std::make_shared<Broker>(std::move(transport))),
        graph_(create_graph(broker_)),
        system_clock_(std::make_shared<SystemClock>()) {}

  std::shared_ptr<UntypedPublisher> create_publisher(PublisherOptions options) override {
    return broker_->create_publisher(std::move(options));
  }
  std::shared_ptr<UntypedSubscription> create_subscription(SubscriptionOptions options) override {
    return broker_->create_subscription(std::move(options));
  }
  Graph& graph() override { return *graph_; }
  std::shared_ptr<SystemClock> system_clock() const override { return system_clock_; }

  std::shared_ptr<SimulatedClock> simulated_clock() override {
    const std::lock_guard lock(mutex_);
    if (!simulated_clock_) {
      simulated_clock_ = std::make_shared<SimulatedClock>();
      clock_subscription_ = broker_->create_subscription(
          {.topic = {"rt/clock", &message_type<rosgraph_msgs::msg::Clock>()},
           .qos = QoS::sensor_data(1),
           .callback = [clock = simulated_clock_](const std::shared_ptr<const void>& message,
                                                  const MessageInfo&) {
             const auto& stamp =
                 static_cast<const rosgraph_msgs::msg::Clock*>(message.get())->clock();
             clock->set(Time(std::chrono::seconds(stamp.sec()) +
                             std::chrono::nanoseconds(stamp.nanosec())));
           }});
    }
    return simulated_clock_;
  }

  Transport* transport() override { return broker_->transport(); }

 private:
  const std::shared_ptr<Broker> broker_;
  const std::unique_ptr<Graph> graph_;
  const std::shared_ptr<SystemClock> system_clock_;
  std::mutex mutex_;
  std::shared_ptr<SimulatedClock> simulated_clock_;
  std::shared_ptr<UntypedSubscription> clock_subscription_;
};

}  // namespace

std::shared_ptr<Context> Context::create(std::unique_ptr<Transport> transport) {
  return std::make_shared<ProcessContext>(std::move(transport));
}

}  // namespace pipescout
