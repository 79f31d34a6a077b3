// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/service.hpp"

#include <algorithm>
#include <deque>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "pipescout/runtime/names.hpp"

namespace pipescout {

namespace {

constexpr std::size_t kMaxHeldResponses = 1000;
constexpr Duration kLongestHold = std::chrono::seconds(1);

// RTPS 2.3, table 9.1: this bit of the entity kind is set for readers and not for writers.
bool is_reader(const Gid& gid) {
  constexpr std::uint8_t kReaderBit = 0x04;
  return (gid.bytes.back() & kReaderBit) != 0;
}

void require_group(const ServiceOptions& options) {
  if (!options.group) {
    throw std::invalid_argument("service " + options.name + ": there is no callback group");
  }
}

/// The calls of a client, from sending to answer. Shared with the callbacks of its endpoints and
/// with the executor, which may outlive the handle. Lock order: this one before those of endpoints
/// and executor; no lock is held while an answer is called.
class Calls final : public Waitable, public std::enable_shared_from_this<Calls> {
 public:
  using Answer = UntypedClient::Answer;

  explicit Calls(std::shared_ptr<CallbackGroup> group) : group_(std::move(group)) {}

  void attach(std::shared_ptr<UntypedPublisher> publisher,
              std::shared_ptr<UntypedSubscription> subscription) {
    const std::lock_guard lock(mutex_);
    publisher_ = std::move(publisher);
    subscription_ = std::move(subscription);
  }

  void close() {
    std::shared_ptr<UntypedPublisher> publisher;
    std::shared_ptr<UntypedSubscription> subscription;
    std::map<std::uint64_t, Call> calls;
    std::deque<Answer> cancelled;
    {
      const std::lock_guard lock(mutex_);
      publisher.swap(publisher_);
      subscription.swap(subscription_);
      calls.swap(calls_);
      cancelled.swap(refused_);
      waiting_.clear();
      deadlines_.clear();
      local_.clear();
      remote_.clear();
    }
    group_->cancel(shared_from_this());
    publisher.reset();
    subscription.reset();
    for (auto& [id, call] : calls) {
      cancelled.push_back(std::move(call.answer));
    }
    for (const Answer& answer : cancelled) {
      try {
        answer(ServiceResult<void>(ServiceError::kCancelled));
      } catch (...) {  // NOLINT(bugprone-empty-catch): called from a destructor, as documented
      }
    }
  }

  std::uint64_t call(std::shared_ptr<const void> request, Answer answer, Duration timeout) {
    if (!request || !answer) {
      throw std::invalid_argument(std::string("service call: the ") +
                                  (request ? "answer" : "request") + " is null");
    }
    {
      const std::lock_guard lock(mutex_);
      ++statistics_.calls;
      if (calls_.size() < UntypedClient::kMaxOutstandingCalls) {
        const std::uint64_t id = ++last_id_;
        const SteadyTime deadline =
            add_saturated(steady_now(), std::max(timeout, Duration::zero()));
        Call& call = calls_[id];
        call.request = std::move(request);
        call.answer = std::move(answer);
        call.deadline = deadline;
        waiting_.push_back(id);
        send_waiting();
        const auto position = deadlines_.emplace(deadline, id).first;
        if (position == deadlines_.begin()) {
          group_->schedule_at(deadline, shared_from_this());
        }
        return id;
      }
      ++statistics_.refused;
      if (refused_.size() >= UntypedClient::kMaxOutstandingCalls) {
        throw std::runtime_error(
            "service call: " + std::to_string(calls_.size()) + " calls wait for an answer, and " +
            std::to_string(refused_.size()) + " refused ones for the executor");
      }
      refused_.push_back(std::move(answer));
      if (refused_.size() > 1) {
        return 0;  // the one before it goes on with this one
      }
    }
    post_refusal();
    return 0;
  }

  bool forget(std::uint64_t id) {
    Call forgotten;  // destroyed after the lock is released
    const std::lock_guard lock(mutex_);
    if (!calls_.contains(id)) {
      return false;
    }
    forgotten = take(id);
    return true;
  }

  [[nodiscard]] bool is_matched(const Gid& server) const {
    const std::lock_guard lock(mutex_);
    return subscription_ && subscription_->is_matched(server);
  }

  [[nodiscard]] bool is_ready() const {
    const std::lock_guard lock(mutex_);
    return can_send();
  }

  void matches_changed() {
    const std::lock_guard lock(mutex_);
    end_unanswerable();
    send_waiting();
  }

  void reply(const std::shared_ptr<const void>& response, const MessageInfo& info) {
    Call answered;
    {
      const std::lock_guard lock(mutex_);
      // Every client of the service gets every reply.
      if (!publisher_ || (info.related.writer != subscription_->gid() &&
                          info.related.writer != publisher_->gid())) {
        return;
      }
      const auto& ids = info.from_this_process ? local_ : remote_;
      const auto found = ids.find(info.related.sequence_number);
      if (found == ids.end()) {
        ++statistics_.late_replies;
        return;
      }
      answered = take(found->second);
      ++statistics_.answered;
    }
    answered.answer(ServiceResult<void>(response, info.identity.writer));
  }

  /// One call whose time is over.
  void execute() override {
    Call expired;
    ServiceError error = ServiceError::kTimeout;
    {
      const std::lock_guard lock(mutex_);
      if (deadlines_.empty()) {
        return;
      }
      const auto [deadline, id] = *deadlines_.begin();
      if (deadline > steady_now()) {
        group_->schedule_at(deadline, shared_from_this());
        return;
      }
      expired = take(id);
      if (expired.is_unanswerable) {
        ++statistics_.server_gone;
        error = ServiceError::kServerGone;
      } else if (expired.is_sent) {
        ++statistics_.timed_out;
      } else {
        ++statistics_.without_server;
        error = ServiceError::kNoServer;
      }
      if (!deadlines_.empty()) {
        group_->schedule_at(deadlines_.begin()->first, shared_from_this());
      }
    }
    expired.answer(ServiceResult<void>(error));
  }

  [[nodiscard]] ClientStatistics statistics() const {
    const std::lock_guard lock(mutex_);
    return statistics_;
  }
  [[nodiscard]] std::shared_ptr<UntypedPublisher> publisher() const {
    const std::lock_guard lock(mutex_);
    return publisher_;
  }
  [[nodiscard]] std::shared_ptr<UntypedSubscription> subscription() const {
    const std::lock_guard lock(mutex_);
    return subscription_;
  }

 private:
  struct Call {
    std::shared_ptr<const void> request;  // null once sent
    Answer answer;
    SteadyTime deadline{};
    bool is_sent = false;
    bool is_unanswerable = false;  // no server is left that it was sent to
    PublishedSample sample;
  };

  /// One at a time, so that refusals do not fill the queue of the executor.
  void post_refusal() {
    group_->post([weak = weak_from_this()] {
      if (const auto alive = weak.lock()) {
        alive->answer_refused();
      }
    });
  }
  void answer_refused() {
    Answer answer;
    bool has_more = false;
    {
      const std::lock_guard lock(mutex_);
      if (refused_.empty()) {
        return;
      }
      answer = std::move(refused_.front());
      refused_.pop_front();
      has_more = !refused_.empty();
    }
    if (has_more) {
      post_refusal();
    }
    answer(ServiceResult<void>(ServiceError::kOverloaded));
  }

  // All under mutex_.
  [[nodiscard]] bool can_send() const {
    if (!publisher_) {
      return false;
    }
    const bool local =
        publisher_->local_subscription_count() > 0 && subscription_->local_publisher_count() > 0;
    return local || (publisher_->remote_subscription_count() > 0 &&
                     subscription_->remote_publisher_count() > 0);
  }
  // Which of several servers took a request is not known: only when the last one is gone is nobody
  // left to answer. Judged by the reply writers, since what they wrote before comes before their
  // end.
  void end_unanswerable() {
    if (!subscription_ || subscription_->local_publisher_count() > 0 ||
        subscription_->remote_publisher_count() > 0) {
      return;
    }
    bool has_ended = false;
    for (auto& [id, call] : calls_) {
      if (call.is_sent && !call.is_unanswerable) {
        deadlines_.erase({call.deadline, id});
        call.deadline = steady_now();
        call.is_unanswerable = true;
        deadlines_.emplace(call.deadline, id);
        has_ended = true;
      }
    }
    if (has_ended) {
      group_->schedule_at(deadlines_.begin()->first, shared_from_this());
    }
  }
  void send_waiting() {
    while (!waiting_.empty() && can_send() && send(waiting_.front())) {
      waiting_.pop_front();
    }
  }
  // The lock is held meanwhile: no reply is looked up before its call is registered. False when the
  // server left before the request reached it.
  bool send(std::uint64_t id) {
    Call& call = calls_.at(id);
    const bool has_local_server = publisher_->local_subscription_count() > 0;
    call.sample =
        publisher_->publish(call.request, {.writer = subscription_->gid(), .sequence_number = 0});
    if (!has_local_server && call.sample.remote_sequence_number == 0) {
      return false;
    }
    call.is_sent = true;
    call.request.reset();
    if (call.sample.local_sequence_number != 0) {
      local_[call.sample.local_sequence_number] = id;
    }
    if (call.sample.remote_sequence_number != 0) {
      remote_[call.sample.remote_sequence_number] = id;
    }
    return true;
  }
  Call take(std::uint64_t id) {
    const auto found = calls_.find(id);
    Call call = std::move(found->second);
    calls_.erase(found);
    deadlines_.erase({call.deadline, id});
    local_.erase(call.sample.local_sequence_number);
    remote_.erase(call.sample.remote_sequence_number);
    if (!call.is_sent) {
      std::erase(waiting_, id);
    }
    return call;
  }

  const std::shared_ptr<CallbackGroup> group_;
  mutable std::mutex mutex_;
  std::shared_ptr<UntypedPublisher> publisher_;  // both null before attach and after close
  std::shared_ptr<UntypedSubscription> subscription_;
  std::map<std::uint64_t, Call> calls_;  // in the order of calling
  std::deque<std::uint64_t> waiting_;    // not sent yet
  std::deque<Answer> refused_;           // to be told
  std::set<std::pair<SteadyTime, std::uint64_t>> deadlines_;
  // The samples of one request are counted apart here and on the network.
  std::unordered_map<std::int64_t, std::uint64_t> local_;
  std::unordered_map<std::int64_t, std::uint64_t> remote_;
  std::uint64_t last_id_ = 0;
  ClientStatistics statistics_;
};

class ProcessClient final : public UntypedClient {
 public:
  explicit ProcessClient(std::shared_ptr<Calls> calls) : calls_(std::move(calls)) {}
  ~ProcessClient() override { calls_->close(); }
  ProcessClient(const ProcessClient&) = delete;
  ProcessClient& operator=(const ProcessClient&) = delete;

  std::uint64_t call(std::shared_ptr<const void> request, Answer answer,
                     Duration timeout) override {
    return calls_->call(std::move(request), std::move(answer), timeout);
  }
  bool forget(std::uint64_t call) override { return calls_->forget(call); }
  bool is_matched(const Gid& server) const override { return calls_->is_matched(server); }
  bool is_ready() const override { return calls_->is_ready(); }
  ClientStatistics statistics() const override { return calls_->statistics(); }
  std::shared_ptr<UntypedPublisher> request_publisher() const override {
    return calls_->publisher();
  }
  std::shared_ptr<UntypedSubscription> reply_subscription() const override {
    return calls_->subscription();
  }

 private:
  const std::shared_ptr<Calls> calls_;
};

/// The responses of a service on their way out. Shared like `Calls`, with the same lock order.
class Responses final : public Waitable, public std::enable_shared_from_this<Responses> {
 public:
  Responses(std::shared_ptr<CallbackGroup> group, UntypedService::Handler handler)
      : group_(std::move(group)), handler_(std::move(handler)) {}

  void attach(std::shared_ptr<UntypedPublisher> publisher) {
    const std::lock_guard lock(mutex_);
    publisher_ = std::move(publisher);
  }

  void close() {
    std::shared_ptr<UntypedPublisher> publisher;
    std::deque<Held> dropped;
    {
      const std::lock_guard lock(mutex_);
      publisher.swap(publisher_);
      dropped.swap(held_);
    }
    group_->cancel(shared_from_this());
  }

  void request(const std::shared_ptr<const void>& request, const MessageInfo& info) {
    {
      const std::lock_guard lock(mutex_);
      ++statistics_.requests;
    }
    // A client that names its reply reader is answered there; one that does not looks for the
    // identity of its request.
    const bool names_reader = info.related.writer != Gid{};
    handler_(request, {.writer = names_reader ? info.related.writer : info.identity.writer,
                       .sequence_number = info.identity.sequence_number});
  }

  void respond(const SampleIdentity& caller, std::shared_ptr<const void> response) {
    if (!response) {
      throw std::invalid_argument("service: the response is null");
    }
    std::shared_ptr<const void> dropped;  // destroyed after the lock is released
    const std::lock_guard lock(mutex_);
    if (!publisher_) {
      return;
    }
    if (is_reachable(caller.writer)) {
      send(caller, std::move(response));
      return;
    }
    if (held_.size() >= kMaxHeldResponses) {
      dropped = std::move(held_.front().response);
      held_.pop_front();
      ++statistics_.responses_dropped;
    }
    held_.push_back({caller, std::move(response), add_saturated(steady_now(), kLongestHold)});
    if (held_.size() == 1) {
      group_->schedule_at(held_.front().deadline, shared_from_this());
    }
  }

  void matches_changed() {
    const std::lock_guard lock(mutex_);
    if (!publisher_) {
      return;
    }
    std::erase_if(held_, [&](Held& held) {
      if (!is_reachable(held.caller.writer)) {
        return false;
      }
      send(held.caller, std::move(held.response));
      return true;
    });
  }

  /// Drops what was held too long.
  void execute() override {
    std::vector<Held> dropped;
    const std::lock_guard lock(mutex_);
    const SteadyTime now = steady_now();
    while (!held_.empty() && held_.front().deadline <= now) {
      dropped.push_back(std::move(held_.front()));
      held_.pop_front();
      ++statistics_.responses_dropped;
    }
    if (!held_.empty()) {
      group_->schedule_at(held_.front().deadline, shared_from_this());
    }
  }

  [[nodiscard]] ServiceStatistics statistics() const {
    const std::lock_guard lock(mutex_);
    return statistics_;
  }

 private:
  struct Held {
    SampleIdentity caller;
    std::shared_ptr<const void> response;
    SteadyTime deadline{};
  };

  // Both under mutex_, so that responses leave in order.
  [[nodiscard]] bool is_reachable(const Gid& caller) const {
    return !is_reader(caller) || same_participant(caller, publisher_->gid()) ||
           publisher_->is_matched_remotely(caller);
  }
  void send(const SampleIdentity& caller, std::shared_ptr<const void> response) {
    publisher_->publish(std::move(response), caller);
    ++statistics_.responses;
  }

  const std::shared_ptr<CallbackGroup> group_;
  const UntypedService::Handler handler_;
  mutable std::mutex mutex_;
  std::shared_ptr<UntypedPublisher> publisher_;  // null before attach and after close
  std::deque<Held> held_;                        // in the order of deadlines
  ServiceStatistics statistics_;
};

class ProcessService final : public UntypedService {
 public:
  ProcessService(std::shared_ptr<Responses> responses, std::shared_ptr<UntypedPublisher> publisher,
                 std::shared_ptr<UntypedSubscription> subscription)
      : responses_(std::move(responses)),
        publisher_(std::move(publisher)),
        subscription_(std::move(subscription)) {}
  ~ProcessService() override {
    // First the end by which clients judge whether the service is there.
    subscription_.reset();
    responses_->close();
  }
  ProcessService(const ProcessService&) = delete;
  ProcessService& operator=(const ProcessService&) = delete;

  void respond(const SampleIdentity& caller, std::shared_ptr<const void> response) override {
    responses_->respond(caller, std::move(response));
  }
  void set_enabled(bool enabled) override { subscription_->set_enabled(enabled); }
  ServiceStatistics statistics() const override { return responses_->statistics(); }
  std::shared_ptr<UntypedPublisher> reply_publisher() const override { return publisher_; }
  std::shared_ptr<UntypedSubscription> request_subscription() const override {
    return subscription_;
  }

 private:
  const std::shared_ptr<Responses> responses_;
  const std::shared_ptr<UntypedPublisher> publisher_;
  std::shared_ptr<UntypedSubscription> subscription_;
};

template <class Core>
std::function<void(std::size_t)> on_matches(const std::shared_ptr<Core>& core,
                                            std::function<void()> told = {}) {
  return [weak = std::weak_ptr<Core>(core), told = std::move(told)](std::size_t) {
    if (const auto alive = weak.lock()) {
      alive->matches_changed();
    }
    if (told) {
      told();
    }
  };
}

}  // namespace

const char* to_string(ServiceError error) noexcept {
  switch (error) {
    case ServiceError::kNoServer:
      return "no server";
    case ServiceError::kServerGone:
      return "the server is gone";
    case ServiceError::kTimeout:
      return "timeout";
    case ServiceError::kCancelled:
      return "cancelled";
    case ServiceError::kOverloaded:
      return "too many calls outstanding";
  }
  return "unknown";
}

std::shared_ptr<UntypedService> create_untyped_service(Context& context,
                                                       const ServiceOptions& options,
                                                       UntypedService::Handler handler) {
  require_group(options);
  if (!handler) {
    throw std::invalid_argument("service " + options.name + ": there is no handler");
  }
  const auto responses = std::make_shared<Responses>(options.group, std::move(handler));
  // The reply end first: a client sees the service by its request end.
  auto publisher = context.create_publisher(
      {.topic = {mangle_topic_name(options.name, DdsTopicKind::kServiceReply), options.response},
       .qos = options.qos,
       .events = {.matched = on_matches(responses)},
       .group = options.group});
  responses->attach(publisher);
  auto subscription = context.create_subscription(
      {.topic = {mangle_topic_name(options.name, DdsTopicKind::kServiceRequest), options.request},
       .qos = options.qos,
       .callback =
           [weak = std::weak_ptr<Responses>(responses)](const std::shared_ptr<const void>& request,
                                                        const MessageInfo& info) {
             if (const auto alive = weak.lock()) {
               alive->request(request, info);
             }
           },
       .group = options.group,
       .enabled = options.enabled});
  return std::make_shared<ProcessService>(responses, std::move(publisher), std::move(subscription));
}

std::shared_ptr<UntypedClient> create_untyped_client(Context& context,
                                                     const ServiceOptions& options) {
  require_group(options);
  const auto calls = std::make_shared<Calls>(options.group);
  auto subscription = context.create_subscription(
      {.topic = {mangle_topic_name(options.name, DdsTopicKind::kServiceReply), options.response},
       .qos = options.qos,
       .callback =
           [weak = std::weak_ptr<Calls>(calls)](const std::shared_ptr<const void>& response,
                                                const MessageInfo& info) {
             if (const auto alive = weak.lock()) {
               alive->reply(response, info);
             }
           },
       .events = {.matched = on_matches(calls, options.matched)},
       .group = options.group,
       .own_reader = true});
  auto publisher = context.create_publisher(
      {.topic = {mangle_topic_name(options.name, DdsTopicKind::kServiceRequest), options.request},
       .qos = options.qos,
       .events = {.matched = on_matches(calls, options.matched)},
       .group = options.group});
  calls->attach(std::move(publisher), std::move(subscription));
  return std::make_shared<ProcessClient>(calls);
}

}  // namespace pipescout
