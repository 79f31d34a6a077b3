// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/context.hpp"

#include <map>
#include <mutex>
#include <utility>

#include "broker.hpp"
#include "graph.hpp"
#include "pipescout/runtime/activity.hpp"
#include "pipescout/runtime/graph.hpp"
#include "step_reporter.hpp"
#include "transform_listener.hpp"

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

  std::shared_ptr<SimulatedClock> simulated_clock(const std::string& topic) override {
    const std::lock_guard lock(mutex_);
    auto& clock = simulated_clocks_[topic];
    if (!clock) {
      clock = std::make_shared<SimulatedClock>();
    }
    return clock;
  }

  const std::shared_ptr<Activity>& activity() const override { return activity_; }

  const std::shared_ptr<StepTraffic>& step_traffic() const override {
    return broker_->step_traffic();
  }
  std::shared_ptr<StepParticipation> take_part_in_steps(const std::string& clock_topic,
                                                        const std::string& node) override {
    if (broker_->transport() == nullptr) {
      return nullptr;
    }
    auto reporter = step_reporter(clock_topic);
    graph_->add_shared_endpoint(NodeName::parse(node), reporter->publisher());
    return std::make_shared<StepParticipation>(std::move(reporter), node);
  }
  std::shared_ptr<CallbackGroup> create_watch_group() override {
    return broker_->watch_thread().create_group();
  }

  std::shared_ptr<TransformListener> transform_listener(
      const std::string& tf_topic, const std::string& tf_static_topic) override {
    const std::lock_guard lock(mutex_);
    auto& known = transform_listeners_[{tf_topic, tf_static_topic}];
    auto listener = known.lock();
    if (!listener) {
      listener = TransformListener::create(*this, tf_topic, tf_static_topic);
      known = listener;
    }
    return listener;
  }

  Transport* transport() override { return broker_->transport(); }

 private:
  std::shared_ptr<StepReporter> step_reporter(const std::string& clock_topic) {
    const std::lock_guard lock(mutex_);
    auto& known = step_reporters_[clock_topic];
    auto reporter = known.lock();
    if (!reporter) {
      reporter = std::make_shared<StepReporter>(broker_, activity_, clock_topic);
      known = reporter;
    }
    return reporter;
  }

  const std::shared_ptr<Broker> broker_;
  const std::unique_ptr<OwnGraph> graph_;
  const std::shared_ptr<SystemClock> system_clock_;
  const std::shared_ptr<Activity> activity_ = std::make_shared<Activity>();
  std::mutex mutex_;
  std::map<std::string, std::shared_ptr<SimulatedClock>> simulated_clocks_;  // by topic
  std::map<std::string, std::weak_ptr<StepReporter>> step_reporters_;        // by clock's topic
  std::map<std::pair<std::string, std::string>, std::weak_ptr<TransformListener>>
      transform_listeners_;  // by topics
};

}  // namespace

std::shared_ptr<Context> Context::create(std::unique_ptr<Transport> transport) {
  return std::make_shared<ProcessContext>(std::move(transport));
}

}  // namespace pipescout
