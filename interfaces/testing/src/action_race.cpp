// SPDX-License-Identifier: Apache-2.0
#include "pipescout/testing/action_race.hpp"

#include <chrono>
#include <condition_variable>
#include <example_interfaces/action/fibonacci.hpp>
#include <map>
#include <mutex>
#include <optional>
#include <utility>

#include "pipescout/runtime/executor_thread.hpp"
#include "pipescout/runtime/node.hpp"

namespace pipescout::testing {

namespace {

using example_interfaces::action::Fibonacci;

constexpr std::size_t kThreads = 3;
constexpr std::size_t kNamedFaults = 5;
constexpr auto kPatience = std::chrono::minutes(1);

enum class Kind { kNotCancelled, kCancelledWhileItEnds, kCancelledTooLate };

Kind kind_of(std::size_t number) {
  return number % 2 == 0   ? Kind::kNotCancelled
         : number % 4 == 1 ? Kind::kCancelledWhileItEnds
                           : Kind::kCancelledTooLate;
}

std::size_t number_of(const ServerGoal<Fibonacci>& goal) {
  return static_cast<std::size_t>(goal.goal().order);
}

/// One goal, as both sides saw it.
struct Story {
  std::optional<GoalStatus> server_end;  // what the server's first word was
  bool has_response = false;
  std::optional<CancelCode> cancel_code;
  std::optional<GoalEnd> client_end;
};

class Race {
 public:
  Race(const std::shared_ptr<Context>& server, const std::shared_ptr<Context>& client,
       const ActionRace& race)
      : race_(race),
        stories_(race.goals),
        server_node_({.context = server,
                      .executor = &server_executor_,
                      .name = {"/", "race_server"},
                      .standard_interfaces = false}),
        client_node_({.context = client,
                      .executor = &client_executor_,
                      .name = {"/", "race_client"},
                      .standard_interfaces = false}) {
    const auto group = server_node_.create_callback_group(CallbackGroupType::kReentrant);
    server_ = server_node_.create_action_server<Fibonacci>(
        "race",
        {.accepted =
             [this](const ServerGoal<Fibonacci>& goal) {
               goal.publish_feedback({});
               if (kind_of(number_of(goal)) == Kind::kCancelledWhileItEnds) {
                 const std::lock_guard lock(mutex_);
                 held_[number_of(goal)] = goal;
               } else {
                 end(goal, GoalStatus::kSucceeded);
               }
             },
         .cancel =
             [this, group](const ServerGoal<Fibonacci>& goal) {
               // On another thread, while this one goes on to say that the goal is canceling.
               group->post([this, goal] { end(goal, GoalStatus::kSucceeded); });
               return CancelDecision::kAccept;
             },
         .canceling =
             [this](const ServerGoal<Fibonacci>& goal) { end(goal, GoalStatus::kCanceled); }},
        {.group = group, .max_goals = race.lanes});
    client_ = client_node_.create_action_client<Fibonacci>(
        "race", {.group = client_node_.create_callback_group(CallbackGroupType::kReentrant)});
  }

  ActionRaceReport run() {
    const auto start = std::chrono::steady_clock::now();
    {
      const ExecutorThread server(server_executor_, {});
      const ExecutorThread client(client_executor_, {});
      for (std::size_t lane = 0; lane < race_.lanes; ++lane) {
        send_next();
      }
      std::unique_lock lock(mutex_);
      std::size_t seen = 0;
      do {
        seen = told_;
      } while (changed_.wait_for(lock, kPatience, [&] { return told_ != seen || is_done(); }) &&
               !is_done());
    }
    ActionRaceReport report = judge();
    report.seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return report;
  }

 private:
  /// The end of a goal of the last kind may be told before the answer to its cancellation.
  [[nodiscard]] bool is_done() const {  // under mutex_
    return told_ == race_.goals && open_cancellations_ == 0;
  }

  void end(const ServerGoal<Fibonacci>& goal, GoalStatus status) {
    const std::size_t number = number_of(goal);
    Fibonacci::Result result;
    result.sequence = {goal.goal().order, static_cast<std::int32_t>(status)};
    const bool is_first = status == GoalStatus::kSucceeded ? goal.succeed(std::move(result))
                                                           : goal.canceled(std::move(result));
    ServerGoal<Fibonacci> held;  // goes without the lock
    const std::lock_guard lock(mutex_);
    std::swap(held, held_[number]);
    held_.erase(number);
    if (is_first && std::exchange(stories_.at(number).server_end, status)) {
      fault(number, "the server ended it twice");
    }
  }

  void send_next() {
    std::size_t number = 0;
    {
      const std::lock_guard lock(mutex_);
      if (sent_ == race_.goals) {
        return;
      }
      number = sent_++;
    }
    Fibonacci::Goal goal;
    goal.order = static_cast<std::int32_t>(number);
    client_.send_goal(
        goal,
        {.response = [this, number](const GoalResponse& told) { response(number, told); },
         .feedback =
             [this, number](const std::shared_ptr<const Fibonacci::Feedback>&) {
               const std::lock_guard lock(mutex_);
               if (!stories_[number].has_response) {
                 fault(number, "feedback before the response");
               }
             },
         .result = [this, number](const GoalOutcome<Fibonacci>& told) { result(number, told); }},
        kPatience);
  }

  void response(std::size_t number, const GoalResponse& told) {
    bool cancels = false;
    {
      const std::lock_guard lock(mutex_);
      stories_[number].has_response = true;
      if (!told.accepted) {
        fault(number, told.error ? to_string(*told.error) : "rejected");
        ++told_;
        changed_.notify_all();
      } else if (kind_of(number) != Kind::kNotCancelled) {
        cancels = true;
        ++open_cancellations_;
      }
    }
    if (cancels) {
      client_.cancel(
          told.id,
          [this, number](const CancelResponse& answer) {
            const std::lock_guard lock(mutex_);
            --open_cancellations_;
            if (answer.error) {
              fault(number, std::string("cancellation: ") + to_string(*answer.error));
            } else {
              stories_[number].cancel_code = answer.code;
            }
            changed_.notify_all();
          },
          kPatience);
    }
    if (!told.accepted) {
      send_next();
    }
  }

  void result(std::size_t number, const GoalOutcome<Fibonacci>& told) {
    {
      const std::lock_guard lock(mutex_);
      Story& story = stories_[number];
      if (!story.has_response) {
        fault(number, "a result before the response");
      }
      if (std::exchange(story.client_end, told.end)) {
        fault(number, "a second result");
      }
      if (told.result && (told.result->sequence.size() != 2 ||
                          told.result->sequence[0] != static_cast<std::int32_t>(number))) {
        fault(number, "the result of another goal");
      }
      ++told_;
    }
    changed_.notify_all();
    send_next();
  }

  void fault(std::size_t number, const std::string& text) {  // under mutex_
    ++wrong_;
    if (faults_.size() < kNamedFaults) {
      faults_.push_back("goal " + std::to_string(number) + ": " + text);
    }
  }

  ActionRaceReport judge() {
    const std::lock_guard lock(mutex_);
    ActionRaceReport report;
    for (std::size_t number = 0; number < stories_.size(); ++number) {
      const Story& story = stories_[number];
      const auto end = story.client_end;
      if (end == GoalEnd::kSucceeded) {
        ++report.succeeded;
      } else if (end == GoalEnd::kCanceled) {
        ++report.canceled;
      } else if (!end || *end == GoalEnd::kLost || *end == GoalEnd::kUnknown) {
        ++report.lost;
        continue;
      }
      const bool agrees =
          (end == GoalEnd::kSucceeded && story.server_end == GoalStatus::kSucceeded) ||
          (end == GoalEnd::kCanceled && story.server_end == GoalStatus::kCanceled);
      if (!agrees) {
        fault(number, std::string("the client was told: ") + to_string(*end));
      }
      // A goal that was canceling may succeed all the same; one that had ended before may not be
      // canceled.
      const bool fits =
          !story.cancel_code || story.cancel_code == CancelCode::kNone ||
          (story.cancel_code == CancelCode::kTerminated && end == GoalEnd::kSucceeded);
      if (!fits) {
        fault(number, "cancellation: " + std::string(to_string(*story.cancel_code)) +
                          ", but it was " + to_string(*end));
      }
    }
    report.wrong = wrong_;
    report.faults = faults_;
    return report;
  }

  const ActionRace race_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<Story> stories_;  // by the goal's number; all that follow under mutex_ too
  std::size_t sent_ = 0;
  std::size_t told_ = 0;  // goals whose end the client knows
  std::size_t open_cancellations_ = 0;
  std::size_t wrong_ = 0;
  std::vector<std::string> faults_;
  std::map<std::size_t, ServerGoal<Fibonacci>> held_;

  Executor server_executor_{kThreads};
  Executor client_executor_{kThreads};
  Node server_node_;
  Node client_node_;
  ActionServer<Fibonacci> server_;
  ActionClient<Fibonacci> client_;
};

}  // namespace

ActionRaceReport race_actions(const std::shared_ptr<Context>& server,
                              const std::shared_ptr<Context>& client, const ActionRace& race) {
  return Race(server, client, race).run();
}

}  // namespace pipescout::testing
