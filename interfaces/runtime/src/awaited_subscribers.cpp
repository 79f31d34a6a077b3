// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/awaited_subscribers.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <stdexcept>
#include <utility>

#include "pipescout/runtime/graph.hpp"
#include "pipescout/runtime/names.hpp"
#include "pipescout/runtime/parameters.hpp"
#include "pipescout/runtime/timer.hpp"

namespace pipescout {

/// Shared with what is posted to the executor, which may outlive the handle.
class AwaitedSubscribers::Impl : public std::enable_shared_from_this<Impl> {
 public:
  Impl(Node& node, std::string_view what, const std::vector<std::string>& topics)
      : node_(node), what_(what) {
    const std::string description = "nodes that must have subscribed before " + std::string(what) +
                                    "; takes effect when configured";
    const auto declare = [&](const std::string& name, const std::string& of) {
      names_.push_back(name);
      parameters_.push_back(node.parameters().declare<std::vector<std::string>>(
          name, {}, {.description = of + description}));
    };
    if (topics.empty()) {
      declare(kParameter, "");
    }
    for (const std::string& topic : topics) {
      declare(std::string(kParameter) + "." + topic, topic + ": ");
    }
  }

  void watch(const std::vector<std::shared_ptr<UntypedPublisher>>& publishers,
             std::function<void()> arrived) {
    if (publishers.size() != parameters_.size()) {
      throw std::invalid_argument("AwaitedSubscribers: " + std::to_string(publishers.size()) +
                                  " publishers for " + std::to_string(parameters_.size()) +
                                  " parameters");
    }
    std::vector<Awaited> awaited;
    for (std::size_t i = 0; i < publishers.size(); ++i) {
      if (publishers[i] == nullptr) {
        continue;
      }
      const auto names = parameters_[i].share();
      for (const std::string& name : *names) {
        awaited.push_back({resolve(name, names_[i]), publishers[i]});
      }
    }
    stop();
    awaited_ = std::move(awaited);
    arrived_ = std::move(arrived);
    // Before the first look, so that no change is missed.
    changes_ = node_.context().graph().on_changed([weak = weak_from_this()] {
      if (const auto alive = weak.lock()) {
        alive->look_later();
      }
    });
    look();
    if (!all_there_) {
      // By real time: simulated time may not run before.
      complaint_ = std::make_unique<Timer>(node_.default_group(), kUsualWait, [this] {
        complaint_->set_enabled(false);
        node_.logger().info("before " + what_ + " it waits for the subscriptions of " + missing());
      });
    }
  }

  std::function<void(std::size_t)> on_matched() {
    return [weak = weak_from_this()](std::size_t) {
      if (const auto alive = weak.lock()) {
        alive->look();
      }
    };
  }

  void stop() {
    changes_.reset();
    complaint_.reset();
    awaited_.clear();
    arrived_ = nullptr;
    all_there_ = false;
  }

  [[nodiscard]] bool all_there() const { return all_there_; }

  [[nodiscard]] std::string missing() const {
    std::string text;
    const auto endpoints = node_.context().graph().endpoints();
    for (const Awaited& awaited : awaited_) {
      if (!is_there(awaited, endpoints)) {
        const auto topic = demangle_topic_name(awaited.publisher->topic().name);
        text += (text.empty() ? "" : ", ") + awaited.node.fully_qualified() + " to " +
                (topic ? topic->name : awaited.publisher->topic().name);
      }
    }
    return text;
  }

 private:
  static constexpr const char* kParameter = "wait_for_subscribers";
  /// Longer than processes of a composition take to start and to find each other.
  static constexpr Duration kUsualWait = std::chrono::seconds(5);

  struct Awaited {
    NodeName node;
    std::shared_ptr<UntypedPublisher> publisher;
  };

  [[nodiscard]] NodeName resolve(const std::string& name, const std::string& parameter) const {
    try {
      if (name.starts_with('/')) {
        return NodeName::parse(name);
      }
      NodeName relative = NodeName::parse("/" + name);
      relative.ns = join_namespaces(node_.node_name().ns, relative.ns.substr(1));
      relative.validate();
      return relative;
    } catch (const InvalidName& error) {
      throw std::invalid_argument("parameter '" + parameter + "': " + error.what());
    }
  }

  static bool is_there(const Awaited& awaited, const std::vector<GraphEndpoint>& endpoints) {
    return std::ranges::any_of(endpoints, [&](const GraphEndpoint& endpoint) {
      return !endpoint.is_publisher && endpoint.node == awaited.node &&
             endpoint.wire_topic == awaited.publisher->topic().name &&
             (endpoint.in_this_process || awaited.publisher->is_matched_remotely(endpoint.gid));
    });
  }

  /// On any thread. One look serves all changes before it.
  void look_later() {
    if (look_is_due_.exchange(true)) {
      return;
    }
    node_.default_group()->post([weak = weak_from_this()] {
      if (const auto alive = weak.lock()) {
        alive->look_is_due_ = false;
        alive->look();
      }
    });
  }

  void look() {
    if (!arrived_) {
      return;
    }
    if (!awaited_.empty()) {
      const auto endpoints = node_.context().graph().endpoints();
      for (const Awaited& awaited : awaited_) {
        if (!is_there(awaited, endpoints)) {
          return;
        }
      }
    }
    all_there_ = true;
    changes_.reset();
    complaint_.reset();
    const auto arrived = std::exchange(arrived_, nullptr);
    arrived();
  }

  Node& node_;
  const std::string what_;
  std::vector<std::string> names_;  // of the parameters
  std::vector<Parameter<std::vector<std::string>>> parameters_;
  std::vector<Awaited> awaited_;
  std::function<void()> arrived_;  // empty: nobody waits
  std::shared_ptr<void> changes_;
  std::unique_ptr<Timer> complaint_;
  std::atomic<bool> look_is_due_ = false;
  bool all_there_ = false;
};

AwaitedSubscribers::AwaitedSubscribers(Node& node, std::string_view what,
                                       const std::vector<std::string>& topics)
    : impl_(std::make_shared<Impl>(node, what, topics)) {}

AwaitedSubscribers::~AwaitedSubscribers() {
  impl_->stop();
}

std::function<void(std::size_t)> AwaitedSubscribers::on_matched() {
  return impl_->on_matched();
}

void AwaitedSubscribers::watch(const std::vector<std::shared_ptr<UntypedPublisher>>& publishers,
                               std::function<void()> arrived) {
  impl_->watch(publishers, std::move(arrived));
}

void AwaitedSubscribers::stop() {
  impl_->stop();
}

bool AwaitedSubscribers::all_there() const {
  return impl_->all_there();
}

std::string AwaitedSubscribers::missing() const {
  return impl_->missing();
}

}  // namespace pipescout
