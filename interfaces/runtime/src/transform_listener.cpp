// SPDX-License-Identifier: Apache-2.0
#include "transform_listener.hpp"

#include <algorithm>
#include <tf2_msgs/msg/tf_message.hpp>

#include "pipescout/runtime/conversions.hpp"
#include "pipescout/runtime/graph.hpp"
#include "pipescout/runtime/names.hpp"
#include "pipescout/runtime/standard_topics.hpp"
#include "text_for_people.hpp"

namespace pipescout {
namespace {

/// A transform further ahead of the clock is of a publisher whose clock is wrong: taken, it would
/// push all that is right out of the history.
constexpr Duration kLongestLead = std::chrono::seconds(10);
constexpr std::size_t kMostWaits = 1000;
/// Kinds and children of refusals of which each is logged once.
constexpr std::size_t kMostLogged = 100;

}  // namespace

TransformListener::TransformListener(Context& context) : context_(context.weak_from_this()) {}

std::shared_ptr<TransformListener> TransformListener::create(Context& context,
                                                             const std::string& tf_topic,
                                                             const std::string& tf_static_topic) {
  struct Owner {
    std::shared_ptr<TransformListener> listener;
    std::vector<std::shared_ptr<UntypedSubscription>> subscriptions;
  };
  const auto owner = std::make_shared<Owner>();
  owner->listener = std::make_shared<TransformListener>(context);
  const auto subscribe = [&](const std::string& topic, const QoS& qos, bool is_static) {
    // Without a group: a lookup in a callback is to find what was published before.
    owner->subscriptions.push_back(context.create_subscription(
        {.topic = {mangle_topic_name(topic, DdsTopicKind::kTopic),
                   &message_type<tf2_msgs::msg::TFMessage>()},
         .qos = qos,
         .callback = [listener = owner->listener, is_static](
                         const std::shared_ptr<const void>& message, const MessageInfo& info) {
           listener->take(*static_cast<const tf2_msgs::msg::TFMessage*>(message.get()), is_static,
                          info.identity.writer);
         }}));
  };
  subscribe(tf_static_topic, topics::kTfStatic.requested, true);
  subscribe(tf_topic, topics::kTf.requested, false);
  owner->listener->subscriptions_.assign(owner->subscriptions.begin(), owner->subscriptions.end());
  return {owner, owner->listener.get()};
}

TransformBuffer& TransformListener::buffer() {
  return buffer_;
}

std::vector<std::shared_ptr<UntypedSubscription>> TransformListener::subscriptions() const {
  std::vector<std::shared_ptr<UntypedSubscription>> result;
  for (const auto& subscription : subscriptions_) {
    result.push_back(subscription.lock());
  }
  return result;
}

void TransformListener::add_reporter(const Logger& logger,
                                     const std::shared_ptr<CallbackGroup>& group) {
  const std::lock_guard lock(mutex_);
  std::erase_if(reporters_, [](const auto& reporter) { return reporter.second.expired(); });
  reporters_.emplace_back(logger, group);
}

void TransformListener::follow(std::shared_ptr<SimulatedClock> clock) {
  std::shared_ptr<void> set_back;
  if (clock) {
    set_back = clock->on_set_back([weak = weak_from_this()] {
      if (const auto self = weak.lock()) {
        self->buffer_.clear_moving();
      }
    });
  }
  const std::lock_guard lock(mutex_);
  clock_ = std::move(clock);
  clock_set_back_.swap(set_back);
}

void TransformListener::take(const tf2_msgs::msg::TFMessage& message, bool is_static,
                             const Gid& publisher) {
  Time now;
  {
    const std::lock_guard lock(mutex_);
    received_ += message.transforms.size();
    now = clock_ ? clock_->now() : SystemClock().now();
  }
  const bool is_running = now != Time();  // a simulated clock stands at zero until it is first set
  for (const auto& transform : message.transforms) {
    const Time stamp = from_message(transform.header.stamp);
    if (!is_static && is_running && stamp > now && stamp - now > kLongestLead) {
      refuse({TransformFault::kFromFuture,
              "transform of '" + transform.child_frame_id + "' in '" + transform.header.frame_id +
                  "': its stamp is " + text_for_people(to_seconds(stamp - now)) +
                  " s ahead of the clock",
              std::nullopt},
             transform.child_frame_id, publisher);
    } else if (auto refusal = buffer_.insert(transform, is_static, publisher)) {
      refuse(*std::move(refusal), transform.child_frame_id, publisher);
    }
  }
  notify();
}

void TransformListener::refuse(TransformRefusal refusal, const std::string& child,
                               const Gid& publisher) {
  const std::lock_guard lock(mutex_);
  const TransformFault fault = refusal.fault;
  ++refused_[fault];
  last_ = Refusal{std::move(refusal), publisher};
  if (logged_.size() >= kMostLogged || !logged_.emplace(fault, child).second) {
    return;
  }
  for (const auto& [logger, weak_group] : reporters_) {
    if (const auto group = weak_group.lock()) {
      // Not here: logging publishes, and asking the graph takes locks.
      group->post([self = weak_from_this(), logger = logger, refused = *last_] {
        if (const auto listener = self.lock()) {
          logger.warn("transform refused: " + listener->describe(refused));
        }
      });
      return;
    }
  }
}

void TransformListener::notify() {
  if (waiting_ == 0) {
    return;
  }
  // Kept beyond the lock: the last owner's end calls `remove`.
  std::vector<std::shared_ptr<TransformWait::State>> kept;
  const std::lock_guard lock(waits_mutex_);
  for (auto entry = waits_.begin(); entry != waits_.end();) {
    auto wait = entry->second.lock();
    if (!wait || wait->answer_if_known()) {
      entry = waits_.erase(entry);
    } else {
      ++entry;
    }
    if (wait) {
      kept.push_back(std::move(wait));
    }
  }
  waiting_ = waits_.size();
}

bool TransformListener::add(const std::shared_ptr<TransformWait::State>& wait) {
  const std::lock_guard lock(waits_mutex_);
  if (waits_.size() >= kMostWaits) {
    return false;
  }
  // Under the lock, so that what comes meanwhile is seen either here or in `notify`.
  if (!wait->answer_if_known()) {
    waits_.emplace(wait.get(), wait);
    waiting_ = waits_.size();
  }
  return true;
}

void TransformListener::remove(const TransformWait::State* wait) {
  const std::lock_guard lock(waits_mutex_);
  waits_.erase(wait);
  waiting_ = waits_.size();
}

TransformStatistics TransformListener::statistics() const {
  TransformStatistics result;
  std::optional<Refusal> last;
  {
    const std::lock_guard lock(mutex_);
    result.received = received_;
    result.refused = refused_;
    last = last_;
  }
  if (last) {
    result.last_refused = describe(*last);
  }
  return result;
}

std::string TransformListener::describe(const Refusal& refused) const {
  const auto context = context_.lock();
  const auto endpoints = context ? context->graph().endpoints() : std::vector<GraphEndpoint>();
  const auto publisher = [&](const Gid& gid) {
    const auto found = std::ranges::find_if(endpoints, [&](const GraphEndpoint& endpoint) {
      return endpoint.gid == gid && endpoint.node;
    });
    return found == endpoints.end() ? "publisher " + to_string(gid)
                                    : found->node->fully_qualified();
  };
  std::string text = refused.refusal.text + " (sent by " + publisher(refused.publisher);
  if (refused.refusal.told_by) {
    text += "; believed is " + publisher(*refused.refusal.told_by);
  }
  return text + ")";
}

TransformWait::State::State(std::shared_ptr<TransformListener> listener, std::string target,
                            std::string source, Time time, Transforms::Callback callback,
                            std::shared_ptr<CallbackGroup> group,
                            std::shared_ptr<SimulatedClock> clock)
    : listener_(std::move(listener)),
      target_(std::move(target)),
      source_(std::move(source)),
      time_(time),
      group_(std::move(group)),
      clock_(std::move(clock)),
      callback_(std::move(callback)) {}

void TransformWait::State::begin(Duration timeout) {
  if (clock_) {
    clock_->schedule_at(add_saturated(clock_->now(), timeout), group_, shared_from_this());
  } else {
    group_->schedule_at(add_saturated(steady_now(), timeout), shared_from_this());
  }
}

bool TransformWait::State::answer_if_known() {
  TransformResult result = listener_->buffer().lookup(target_, source_, time_);
  if (!result && result.failure().error != TransformError::kPast) {
    return false;
  }
  {
    const std::lock_guard lock(mutex_);
    answer_ = std::move(result);
  }
  group_->schedule(shared_from_this());
  return true;
}

void TransformWait::State::refuse(TransformFailure failure) {
  {
    const std::lock_guard lock(mutex_);
    answer_.emplace(std::move(failure));
  }
  group_->schedule(shared_from_this());
}

void TransformWait::State::cancel() {
  {
    const std::lock_guard lock(mutex_);
    callback_ = nullptr;
  }
  listener_->remove(this);
  if (clock_) {
    clock_->cancel(this);
  } else {
    group_->cancel(shared_from_this());
  }
}

bool TransformWait::State::is_waiting() const {
  const std::lock_guard lock(mutex_);
  return callback_ != nullptr;
}

void TransformWait::State::execute() {
  // The answer that came with a transform, else the time is over.
  Transforms::Callback callback;
  std::optional<TransformResult> answer;
  {
    const std::lock_guard lock(mutex_);
    callback = std::exchange(callback_, nullptr);
    answer = std::exchange(answer_, std::nullopt);
  }
  if (!callback) {
    return;
  }
  cancel();
  callback(answer ? *answer : listener_->buffer().lookup(target_, source_, time_));
}

}  // namespace pipescout
