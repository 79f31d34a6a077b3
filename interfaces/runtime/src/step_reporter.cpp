// SPDX-License-Identifier: Apache-2.0
#include "step_reporter.hpp"

#include <algorithm>
#include <pipescout_msgs/msg/step_report.hpp>
#include <utility>

#include "broker.hpp"
#include "pipescout/idl/message_type.hpp"

namespace pipescout {

std::string step_report_topic(const std::string& clock) {
  return clock + "/_steps";
}

std::shared_ptr<QuiescenceWatch> QuiescenceWatch::create(std::shared_ptr<Activity> activity,
                                                         std::shared_ptr<StepTraffic> traffic,
                                                         std::shared_ptr<CallbackGroup> group,
                                                         Quiescent quiescent) {
  std::shared_ptr<QuiescenceWatch> watch(new QuiescenceWatch(
      std::move(activity), std::move(traffic), std::move(group), std::move(quiescent)));
  watch->on_change_ =
      std::make_shared<const std::function<void()>>([weak = watch->weak_from_this()] {
        if (const auto self = weak.lock()) {
          self->post_request();
        }
      });
  watch->traffic_->on_change(watch->on_change_);
  return watch;
}

QuiescenceWatch::QuiescenceWatch(std::shared_ptr<Activity> activity,
                                 std::shared_ptr<StepTraffic> traffic,
                                 std::shared_ptr<CallbackGroup> group, Quiescent quiescent)
    : activity_(std::move(activity)),
      traffic_(std::move(traffic)),
      group_(std::move(group)),
      quiescent_(std::move(quiescent)) {}

QuiescenceWatch::~QuiescenceWatch() = default;

void QuiescenceWatch::post_request() {
  if (!requested_.exchange(true)) {
    group_->post([weak = weak_from_this()] {
      if (const auto self = weak.lock()) {
        self->requested_ = false;
        self->request();
      }
    });
  }
}

void QuiescenceWatch::request() {
  activity_->when_quiescent([weak = weak_from_this()](Activity::Moment moment) {
    if (const auto self = weak.lock()) {
      self->tell(moment);
    }
  });
}

void QuiescenceWatch::tell(Activity::Moment moment) {
  // Executor threads and the watch thread may come here at once: what was counted earlier must not
  // be told later.
  const std::lock_guard lock(mutex_);
  // A step that begins from here on makes this moment one before it.
  const std::uint64_t steps = steps_.load();
  const StepTraffic::Counts counts = traffic_->counts();
  // A sample that arrived meanwhile may be counted as received and not have been processed; its
  // arrival asks again.
  if (activity_->is_quiescent_since(moment)) {
    quiescent_(counts, steps);
  } else {
    post_request();
  }
}

class StepReporter::Impl : public std::enable_shared_from_this<StepReporter::Impl> {
 public:
  using Report = pipescout_msgs::msg::StepReport;

  Impl(const std::shared_ptr<Broker>& broker, std::shared_ptr<CallbackGroup> group)
      : traffic_(broker->step_traffic()), group_(std::move(group)) {}

  void start(const std::shared_ptr<Broker>& broker, const std::shared_ptr<Activity>& activity,
             const std::string& clock) {
    // Not later, when a simulation listens: what it sends at once must be counted.
    traffic_->enable();
    activity_ = activity;
    const auto weak = weak_from_this();
    publisher_ =
        broker->create_publisher({.topic = {step_report_topic(clock), &message_type<Report>()},
                                  .qos = QoS::reliable(1),
                                  .events = {.matched =
                                                 [weak](std::size_t readers) {
                                                   if (const auto self = weak.lock()) {
                                                     self->on_listeners(readers);
                                                   }
                                                 }},
                                  .group = group_});
  }

  void close() {
    group_->close();
    std::shared_ptr<UntypedPublisher> closed;
    const std::lock_guard lock(mutex_);
    closed.swap(publisher_);
  }

  std::shared_ptr<UntypedPublisher> publisher() {
    const std::lock_guard lock(mutex_);
    return publisher_;
  }

  void change_nodes(const std::function<void(std::multiset<std::string>&)>& change) {
    const std::lock_guard lock(mutex_);
    change(nodes_);
  }

 private:
  /// In group_. Without a simulation nobody asks, after each sample, whether the process is
  /// quiescent.
  void on_listeners(std::size_t simulations) {
    if (simulations == 0) {
      watch_.reset();
      return;
    }
    {
      const std::lock_guard lock(mutex_);
      is_reported_ = false;  // the new one knows nothing of this process
    }
    if (!watch_) {
      watch_ = QuiescenceWatch::create(
          activity_, traffic_, group_,
          [weak = weak_from_this()](const StepTraffic::Counts& counts, std::uint64_t) {
            if (const auto self = weak.lock()) {
              self->report(counts);
            }
          });
    }
    watch_->request();
  }

  void report(const StepTraffic::Counts& counts) {
    const std::lock_guard lock(mutex_);
    if (!publisher_ || (is_reported_ && counts == reported_)) {
      return;
    }
    is_reported_ = true;
    reported_ = counts;
    auto message = std::make_shared<Report>();
    for (const auto& [writer, last] : counts.received) {
      message->received.push_back({.writer = writer.bytes, .reader = {}, .sequence_number = last});
    }
    for (const auto& [ends, last] : counts.sent) {
      message->sent.push_back(
          {.writer = ends.first.bytes, .reader = ends.second.bytes, .sequence_number = last});
    }
    message->nodes.assign(nodes_.begin(), nodes_.end());
    publisher_->publish(std::move(message), {});
  }

  const std::shared_ptr<StepTraffic> traffic_;
  const std::shared_ptr<CallbackGroup> group_;
  std::shared_ptr<Activity> activity_;
  std::shared_ptr<QuiescenceWatch> watch_;  // only in group_; null while no simulation listens
  std::mutex mutex_;
  std::shared_ptr<UntypedPublisher> publisher_;  // null once closed
  std::multiset<std::string> nodes_;
  bool is_reported_ = false;
  StepTraffic::Counts reported_;
};

StepReporter::StepReporter(const std::shared_ptr<Broker>& broker,
                           const std::shared_ptr<Activity>& activity, const std::string& clock)
    : impl_(std::make_shared<Impl>(broker, broker->watch_thread().create_group())) {
  impl_->start(broker, activity, clock);
}

StepReporter::~StepReporter() {
  impl_->close();
}

std::shared_ptr<UntypedPublisher> StepReporter::publisher() const {
  return impl_->publisher();
}

void StepReporter::add_node(const std::string& name) {
  impl_->change_nodes([&](auto& nodes) { nodes.insert(name); });
}

void StepReporter::remove_node(const std::string& name) {
  impl_->change_nodes([&](auto& nodes) {
    if (const auto found = nodes.find(name); found != nodes.end()) {
      nodes.erase(found);
    }
  });
}

}  // namespace pipescout
