// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/lock_step.hpp"

#include <algorithm>
#include <cstdint>
#include <map>
#include <optional>
#include <pipescout_msgs/msg/step_report.hpp>
#include <set>
#include <stdexcept>
#include <utility>
#include <vector>

#include "pipescout/runtime/activity.hpp"
#include "pipescout/runtime/context.hpp"
#include "pipescout/runtime/graph.hpp"
#include "pipescout/runtime/timer.hpp"
#include "step_reporter.hpp"

namespace pipescout {

namespace {

using Report = pipescout_msgs::msg::StepReport;

/// A process with nodes that follow the clock.
struct Participant {
  bool has_reported = false;
  bool is_left_out = false;
  std::vector<std::string> nodes;
  StepTraffic::Counts counts;
};

using Participants = std::map<Gid, Participant>;

std::string quoted(const std::vector<std::string>& nodes) {
  std::string text = nodes.size() == 1 ? "node " : "nodes ";
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    text += (i > 0 ? ", '" : "'") + nodes[i] + "'";
  }
  return text;
}

StepTraffic::Counts counts_of(const Report& report) {
  StepTraffic::Counts counts;
  for (const auto& traffic : report.received) {
    counts.received[Gid{traffic.writer}] = traffic.sequence_number;
  }
  for (const auto& traffic : report.sent) {
    counts.sent[{Gid{traffic.writer}, Gid{traffic.reader}}] = traffic.sequence_number;
  }
  return counts;
}

bool has_received(const StepTraffic::Counts& counts, const Gid& writer, std::int64_t last) {
  const auto found = counts.received.find(writer);
  return found != counts.received.end() && found->second >= last;
}

}  // namespace

class LockStep::Impl : public std::enable_shared_from_this<LockStep::Impl> {
 public:
  Impl(Node& node, LockStepOptions options, Step step, LeftOut left_out)
      : own_name_(node.node_name().fully_qualified()),
        context_(node.context().shared_from_this()),
        group_(node.default_group()),
        options_(options),
        step_(std::move(step)),
        left_out_(std::move(left_out)) {}

  void start(Node& node, const std::string& clock) {
    const auto weak = weak_from_this();
    const auto in_group = [weak, group = group_](auto call) {
      group->post([weak, call = std::move(call)] {
        if (const auto self = weak.lock()) {
          call(*self);
        }
      });
    };
    watch_ = QuiescenceWatch::create(
        context_->activity(), context_->step_traffic(), context_->create_watch_group(),
        [in_group](const StepTraffic::Counts& counts, std::uint64_t steps) {
          in_group([counts, steps](Impl& self) { self.on_quiescent(counts, steps); });
        });
    if (context_->transport() == nullptr) {
      return;
    }
    participant_ = participant_of(context_->transport()->participant());
    context_->step_traffic()->enable();
    reports_ = context_->create_subscription(
        {.topic = {step_report_topic(clock), &message_type<Report>()},
         // All processes may report at once.
         .qos = QoS::reliable(1000),
         .callback =
             [weak](const std::shared_ptr<const void>& message, const MessageInfo& info) {
               const auto self = weak.lock();
               if (self && !info.from_this_process) {
                 self->on_report(*static_cast<const Report*>(message.get()), info);
               }
             },
         .events = {.matched =
                        [weak](std::size_t) {
                          if (const auto self = weak.lock()) {
                            self->find_participants();
                          }
                        }},
         .group = group_});
    context_->graph().add_endpoint(node.node_name(), reports_);
  }

  void resume() {
    if (std::exchange(is_running_, true)) {
      return;
    }
    group_->post([weak = weak_from_this()] {
      if (const auto self = weak.lock()) {
        self->find_participants();  // the event that tells of them may be on its way
        if (!self->is_waiting_) {
          self->next();
        }
      }
    });
  }

  void pause() {
    is_running_ = false;
    next_step_.reset();
  }

 private:
  std::unique_ptr<Timer> once(Duration delay, void (Impl::*call)()) {
    return std::make_unique<Timer>(
        group_, std::max(delay, Duration(1)),
        [weak = weak_from_this(), call] {
          if (const auto self = weak.lock()) {
            ((*self).*call)();
          }
        },
        nullptr);
  }

  /// A step now, or when its time has come.
  void next() {
    next_step_.reset();
    if (!is_running_) {
      return;
    }
    const SteadyTime now = steady_now();
    if (now < not_before_) {
      next_step_ = once(not_before_ - now, &Impl::next);
      return;
    }
    not_before_ = add_saturated(now, options_.period);
    watch_->count_step();
    own_counts_.reset();
    if (!step_()) {
      is_running_ = false;
      return;
    }
    is_waiting_ = true;
    patience_ = once(options_.time_out, &Impl::on_time_out);
    watch_->request();
  }

  void on_quiescent(const StepTraffic::Counts& counts, std::uint64_t steps) {
    if (steps == watch_->steps()) {  // else the next step has begun meanwhile
      own_counts_ = counts;
      consider();
    }
  }

  void on_report(const Report& report, const MessageInfo& info) {
    Participant& participant = participants_[participant_of(info.identity.writer)];
    participant.has_reported = true;
    participant.nodes = report.nodes;
    participant.counts = counts_of(report);
    if (participant.is_left_out && own_counts_ &&
        has_caught_up(participant_of(info.identity.writer))) {
      participant.is_left_out = false;
    }
    consider();
  }

  void find_participants() {
    if (!reports_) {
      return;
    }
    std::set<Gid> present;
    for (const DiscoveredEndpoint& endpoint : context_->transport()->remote_endpoints()) {
      if (endpoint.is_writer && endpoint.topic == reports_->topic().name) {
        present.insert(participant_of(endpoint.gid));
      }
    }
    std::erase_if(participants_, [&](const auto& entry) { return !present.contains(entry.first); });
    for (const Gid& gid : present) {
      participants_.try_emplace(gid);
    }
    consider();
  }

  /// The consumers may be through with the step.
  void consider() {
    if (!is_waiting_ || !own_counts_ || !late_participants().empty() ||
        !has_caught_up(participant_)) {
      return;
    }
    is_waiting_ = false;
    patience_.reset();
    next();
  }

  [[nodiscard]] const StepTraffic::Counts* counts_of_process(const Gid& gid) const {
    if (gid == participant_) {
      return &*own_counts_;
    }
    const auto found = participants_.find(gid);
    return found != participants_.end() && found->second.has_reported ? &found->second.counts
                                                                      : nullptr;
  }

  /// Whether a process that has reported has received all that the others have sent to it.
  [[nodiscard]] bool has_caught_up(const Gid& receiver) const {
    const StepTraffic::Counts& counts = *counts_of_process(receiver);
    const auto has_all_of = [&](const StepTraffic::Counts& sender) {
      return std::all_of(sender.sent.begin(), sender.sent.end(), [&](const auto& sent) {
        const auto& [ends, last] = sent;
        return ends.second != receiver || has_received(counts, ends.first, last);
      });
    };
    if (!has_all_of(*own_counts_)) {
      return false;
    }
    return std::all_of(participants_.begin(), participants_.end(), [&](const auto& entry) {
      return entry.second.is_left_out || has_all_of(entry.second.counts);
    });
  }

  /// Of a late process, for people.
  [[nodiscard]] std::string what_is_missing(const Gid& receiver) const {
    if (!participants_.at(receiver).has_reported) {
      return "it has not reported";
    }
    const StepTraffic::Counts& counts = participants_.at(receiver).counts;
    const auto first_in = [&](const StepTraffic::Counts& sender) -> std::string {
      for (const auto& [ends, last] : sender.sent) {
        if (ends.second == receiver && !has_received(counts, ends.first, last)) {
          const auto found = counts.received.find(ends.first);
          return "it has not reported the end of message " + std::to_string(last) + " of " +
                 topic_of(ends.first) + ", but of message " +
                 std::to_string(found != counts.received.end() ? found->second : 0);
        }
      }
      return {};
    };
    std::string missing = first_in(*own_counts_);
    for (const auto& [gid, sender] : participants_) {
      if (missing.empty() && !sender.is_left_out) {
        missing = first_in(sender.counts);
      }
    }
    return missing;
  }

  [[nodiscard]] std::string topic_of(const Gid& writer) const {
    for (const GraphEndpoint& endpoint : context_->graph().endpoints()) {
      if (endpoint.gid == writer) {
        return "'" + endpoint.wire_topic + "'" +
               (endpoint.node ? " of node '" + endpoint.node->fully_qualified() + "'" : "");
      }
    }
    return "writer " + to_string(writer);
  }

  [[nodiscard]] std::vector<Gid> late_participants() const {
    std::vector<Gid> late;
    for (const auto& [gid, participant] : participants_) {
      if (!participant.is_left_out && (!participant.has_reported || !has_caught_up(gid))) {
        late.push_back(gid);
      }
    }
    return late;
  }

  void on_time_out() {
    patience_.reset();
    if (!is_waiting_) {
      return;
    }
    if (!own_counts_) {
      for (const std::string& node : context_->activity()->busy_nodes()) {
        if (node != own_name_) {  // this very callback
          context_->activity()->leave_out(node);
          left_out_("node '" + node + "'", "a callback of it does not return");
        }
      }
    } else {
      leave_out_late_participants();
    }
    patience_ = once(options_.time_out, &Impl::on_time_out);
    watch_->request();
  }

  void leave_out_late_participants() {
    const auto late = late_participants();
    for (const Gid& gid : late) {
      Participant& participant = participants_.at(gid);
      const std::string why = what_is_missing(gid);
      participant.is_left_out = true;
      left_out_("the process of " + (participant.nodes.empty() ? "participant " + to_string(gid)
                                                               : quoted(participant.nodes)),
                why);
    }
    if (late.empty()) {
      // What was sent to this process has not come: the sender counts for nothing any more.
      for (auto& [gid, participant] : participants_) {
        participant.counts.sent.clear();
      }
    }
  }

  const std::string own_name_;
  const std::shared_ptr<Context> context_;
  const std::shared_ptr<CallbackGroup> group_;
  const LockStepOptions options_;
  const Step step_;
  const LeftOut left_out_;
  Gid participant_;
  std::shared_ptr<QuiescenceWatch> watch_;
  std::shared_ptr<UntypedSubscription> reports_;  // null without a transport
  std::unique_ptr<Timer> next_step_;
  std::unique_ptr<Timer> patience_;
  SteadyTime not_before_{};
  bool is_running_ = false;
  bool is_waiting_ = false;                        // for what the last step has caused
  std::optional<StepTraffic::Counts> own_counts_;  // since the last step; none: not quiescent yet
  Participants participants_;
};

LockStep::LockStep(Node& node, const UntypedPublisher& clock, LockStepOptions options, Step step,
                   LeftOut left_out) {
  if (options.period < Duration::zero()) {
    throw std::invalid_argument("LockStep: period is negative");
  }
  if (options.time_out <= Duration::zero()) {
    throw std::invalid_argument("LockStep: time_out is not positive");
  }
  impl_ = std::make_shared<Impl>(node, options, std::move(step), std::move(left_out));
  impl_->start(node, clock.topic().name);
}

LockStep::~LockStep() = default;

void LockStep::resume() {
  impl_->resume();
}

void LockStep::pause() {
  impl_->pause();
}

}  // namespace pipescout
