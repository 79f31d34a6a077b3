// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/component.hpp"

#include <algorithm>
#include <atomic>
#include <deque>
#include <exception>
#include <functional>
#include <limits>
#include <mutex>
#include <optional>
#include <pipescout_msgs/msg/mission_status.hpp>
#include <utility>

#include "diagnostics_publisher.hpp"
#include "lifecycle_services.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "pipescout/runtime/standard_topics.hpp"

namespace pipescout {

namespace {

std::string text_of(const std::exception_ptr& error) {
  try {
    std::rethrow_exception(error);
  } catch (const std::exception& exception) {
    return exception.what();
  } catch (...) {
    return "an object that is not a std::exception";
  }
}

/// Ids of lifecycle_msgs/msg/Transition: the outcome of a callback is 10 times the callback's own
/// number, plus 0, 1 or 2.
constexpr unsigned kOutcomeOfConfigure = 10;
constexpr unsigned kOutcomeOfCleanup = 20;
constexpr unsigned kOutcomeOfActivate = 30;
constexpr unsigned kOutcomeOfDeactivate = 40;
constexpr unsigned kOutcomeOfShutdown = 50;
constexpr unsigned kOutcomeOfError = 60;

/// An exception in a callback of an active or inactive component. ROS 2 has no such transition; the
/// number is that of its TRANSITION_CALLBACK_ERROR.
constexpr LifecycleEdge raised_error(LifecycleState from) {
  return {99, "raise_error", from, LifecycleState::kErrorProcessing};
}

}  // namespace

/// Takes the component from state to state, one transition at a time. A transition begins in the
/// default group, and goes on there once no callback of any other group is running: nothing waits
/// for them, so one that never returns stops this component and no other.
class Component::Lifecycle {
 public:
  using Done = std::function<void(const TransitionResult&)>;

  explicit Lifecycle(Component& component)
      : component_(component),
        mission_status_(component.create_publisher(topics::kMissionStatus, {.managed = false})) {}

  /// Second part: these call back into the component, which must know its lifecycle by then.
  void serve() {
    if (component_.has_standard_interfaces()) {
      services_ = std::make_unique<LifecycleServices>(component_);
      diagnostics_publisher_ = std::make_unique<DiagnosticsPublisher>(component_);
    }
  }

  LifecycleState state() const { return state_; }
  Diagnostics& diagnostics() { return diagnostics_; }

  /// In the default group. Transitions that are asked for meanwhile follow in turn.
  void request(LifecycleTransition transition, Done done) {
    add({transition, {}, std::move(done)});
  }

  void callback_failed(const std::exception_ptr& error) {
    {
      // At once, on whatever thread this is: no further callback begins, also where a transition to
      // active is just ending on another thread.
      const std::lock_guard lock(enabling_);
      ++unprocessed_failures_;
      component_.set_managed_active(false);
      component_.set_services_enabled(false);
    }
    const std::string why = "exception in a callback: " + text_of(error);
    diagnostics_.count("exceptions");
    component_.logger().error(why);
    component_.default_group()->post([this, why] { add({std::nullopt, why, {}}); });
  }

  void report(std::uint8_t mission_state, std::uint32_t done, std::uint32_t total,
              std::string_view message) {
    pipescout_msgs::msg::MissionStatus status;
    status.header.stamp = to_message(component_.now());
    status.node = component_.node_name().fully_qualified();
    status.state = mission_state;
    status.done = done;
    status.total = total;
    status.message = std::string(message);
    mission_status_.publish(std::move(status));
  }

 private:
  struct Job {
    std::optional<LifecycleTransition> transition;  // none: an exception in a callback
    std::string failure;                            // what it said
    Done done;
  };

  void add(Job job) {
    jobs_.push_back(std::move(job));
    if (jobs_.size() == 1) {
      proceed();
    }
  }

  void proceed() {
    while (!jobs_.empty()) {
      begun_ = begin(jobs_.front());
      const bool idle = !begun_ || component_.hold_other_groups([this] {
        end();
        proceed();
      });
      if (!idle) {
        return;
      }
      end();
    }
  }

  /// False when the job is not possible in the state that its turn finds.
  bool begin(const Job& job) {
    const LifecycleState before = state_;
    if (!job.transition) {
      if (before != LifecycleState::kActive && before != LifecycleState::kInactive) {
        return false;
      }
      enter(raised_error(before));
      return true;
    }
    const auto id = static_cast<std::uint8_t>(*job.transition);
    if (requested_transition(before, id, {}) != job.transition) {
      return false;
    }
    component_.set_managed_active(false);
    enter(id);
    return true;
  }

  void end() {
    const Job job = std::move(jobs_.front());
    jobs_.pop_front();
    if (!job.transition) {
      const std::lock_guard lock(enabling_);
      --unprocessed_failures_;
    }
    TransitionResult result;
    contained([&] { result = begun_ ? perform(job) : refuse(job); });
    enable_endpoints();
    component_.release_other_groups();
    if (std::exchange(begun_, false)) {
      contained([this] { tell(); });
    }
    if (job.done) {
      contained([&] { job.done(result); });
    }
  }

  /// What is thrown must not keep the jobs that wait in line.
  template <class Function>
  void contained(const Function& function) {
    try {
      function();
    } catch (...) {
      component_.on_callback_exception(std::current_exception());
    }
  }

  TransitionResult refuse(const Job& job) {
    if (!job.transition) {
      diagnostics_.set_status(DiagnosticLevel::kError, job.failure);
      return {};
    }
    return {false, state_,
            "'" + std::string(to_string(*job.transition)) + "' is not possible in state '" +
                std::string(to_string(state_)) + "'"};
  }

  TransitionResult perform(const Job& job) {
    if (!job.transition) {
      process_error(job.failure);
      return {};
    }
    std::string why;
    CallbackReturn outcome = CallbackReturn::kSuccess;
    unsigned outcome_id = 0;
    switch (*job.transition) {
      case LifecycleTransition::kConfigure:
        outcome_id = kOutcomeOfConfigure;
        outcome = guarded(
            "on_configure",
            [this](Component& component) {
              if (diagnostics_publisher_) {
                diagnostics_publisher_->configure();
              }
              return component.on_configure();
            },
            why);
        break;
      case LifecycleTransition::kCleanup:
        outcome_id = kOutcomeOfCleanup;
        outcome = guarded("on_cleanup", &Component::on_cleanup, why);
        break;
      case LifecycleTransition::kActivate:
        outcome_id = kOutcomeOfActivate;
        outcome = guarded("on_activate", &Component::on_activate, why);
        break;
      case LifecycleTransition::kDeactivate:
        outcome_id = kOutcomeOfDeactivate;
        outcome = guarded("on_deactivate", &Component::on_deactivate, why);
        break;
      case LifecycleTransition::kUnconfiguredShutdown:
      case LifecycleTransition::kInactiveShutdown:
      case LifecycleTransition::kActiveShutdown:
        outcome_id = kOutcomeOfShutdown;
        outcome = guarded("on_shutdown", &Component::on_shutdown, why);
        break;
    }
    enter(outcome_id + static_cast<unsigned>(outcome));
    if (state_ == LifecycleState::kErrorProcessing) {
      process_error(why);
    } else if (outcome == CallbackReturn::kSuccess) {
      diagnostics_.set_status(DiagnosticLevel::kOk, std::string(to_string(state())));
    } else {
      diagnostics_.set_status(DiagnosticLevel::kError, why);
    }
    return {outcome == CallbackReturn::kSuccess, state_, std::move(why)};
  }

  /// `callback` takes the component and returns a CallbackReturn.
  template <class Callback>
  CallbackReturn guarded(const char* name, const Callback& callback, std::string& why) {
    CallbackReturn result = CallbackReturn::kError;
    const Diagnostics::Status before = diagnostics_.status();
    try {
      result = std::invoke(callback, component_);
      if (result == CallbackReturn::kSuccess) {
        return result;
      }
      why = std::string(name) +
            (result == CallbackReturn::kFailure ? " failed" : " reported an error");
      // The callback may have said why, in words better than these.
      const Diagnostics::Status said = diagnostics_.status();
      if (said != before && said.level != DiagnosticLevel::kOk) {
        why += ": " + said.message;
      }
      component_.logger().error(why);
    } catch (...) {
      why = std::string(name) + ": " + text_of(std::current_exception());
      diagnostics_.count("exceptions");
      component_.logger().error(why);
    }
    return result;
  }

  void enable_endpoints() {
    const std::lock_guard lock(enabling_);
    component_.set_services_enabled(unprocessed_failures_ == 0);
    component_.set_managed_active(state_ == LifecycleState::kActive && unprocessed_failures_ == 0);
  }

  void process_error(const std::string& why) {
    std::string then;
    const CallbackReturn outcome = guarded("on_error", &Component::on_error, then);
    enter(kOutcomeOfError + static_cast<unsigned>(outcome));
    diagnostics_.set_status(DiagnosticLevel::kError, then.empty() ? why : why + "; " + then);
  }

  void enter(unsigned edge_id) {
    for (const LifecycleEdge& edge : lifecycle_edges()) {
      if (edge.id == edge_id && edge.start == state_) {
        enter(edge);
        return;
      }
    }
    throw std::logic_error("lifecycle: no edge " + std::to_string(edge_id) + " from state " +
                           std::string(to_string(state_)));
  }

  void enter(const LifecycleEdge& edge) {
    state_ = edge.goal;
    if (services_) {
      contained([&] { services_->publish_transition(edge); });
    }
  }

  void tell() {
    if (diagnostics_publisher_) {
      diagnostics_publisher_->publish_now();
    }
  }

  Component& component_;
  std::atomic<LifecycleState> state_{LifecycleState::kUnconfigured};
  // Both are used in the default group only.
  std::deque<Job> jobs_;                  // the foremost is in progress
  bool begun_ = false;                    // its state is entered
  std::mutex enabling_;                   // taken before the locks of node and endpoints
  std::size_t unprocessed_failures_ = 0;  // exceptions that the default group has yet to deal with
  Diagnostics diagnostics_;
  Publisher<pipescout_msgs::msg::MissionStatus> mission_status_;
  std::unique_ptr<LifecycleServices> services_;
  std::unique_ptr<DiagnosticsPublisher> diagnostics_publisher_;
};

Component::Component(ComponentOptions options)
    : Node(std::move(options), CallbackStart::kWhenAllowed) {
  set_managed_active(false);
  lifecycle_ = std::make_unique<Lifecycle>(*this);
  lifecycle_->serve();
}

Component::~Component() {
  close();
}

void Component::request_transition(LifecycleTransition transition,
                                   std::function<void(const TransitionResult&)> done) {
  allow_callbacks();
  default_group()->post(
      [this, transition, done = std::move(done)] { lifecycle_->request(transition, done); });
}

LifecycleState Component::state() const {
  return lifecycle_->state();
}
Diagnostics& Component::diagnostics() const {
  return lifecycle_->diagnostics();
}

void Component::report_progress(std::uint64_t done, std::uint64_t total, std::string_view message) {
  const auto cut_off = [](std::uint64_t count) {
    return static_cast<std::uint32_t>(
        std::min<std::uint64_t>(count, std::numeric_limits<std::uint32_t>::max()));
  };
  lifecycle_->report(pipescout_msgs::msg::MissionStatus::RUNNING, cut_off(done), cut_off(total),
                     message);
}

void Component::report_complete(std::string_view message) {
  lifecycle_->report(pipescout_msgs::msg::MissionStatus::COMPLETE, 0, 0, message);
}

void Component::report_failed(std::string_view message) {
  logger().error(message);
  diagnostics().set_status(DiagnosticLevel::kError, std::string(message));
  lifecycle_->report(pipescout_msgs::msg::MissionStatus::FAILED, 0, 0, message);
}

void Component::report_fault(std::string_view counter, std::string_view text,
                             const Logger::Location& where) {
  diagnostics().count(counter);
  if (diagnostics().counter(counter) == 1) {
    logger().warn(
        std::string(text) + " (further ones are only counted, as " + std::string(counter) + ")",
        where);
  }
}

void Component::on_callback_exception(std::exception_ptr error) {
  lifecycle_->callback_failed(error);
}

}  // namespace pipescout
