// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/bring_up.hpp"

#include <algorithm>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

namespace pipescout {
namespace {

/// The next step down from a state; nothing when there is none that was not tried yet.
std::optional<LifecycleTransition> step_down(LifecycleState state,
                                             const std::vector<LifecycleTransition>& tried) {
  std::vector<LifecycleTransition> steps;
  switch (state) {
    case LifecycleState::kActive:
      steps = {LifecycleTransition::kDeactivate, LifecycleTransition::kActiveShutdown};
      break;
    case LifecycleState::kInactive:
      steps = {LifecycleTransition::kCleanup, LifecycleTransition::kInactiveShutdown};
      break;
    case LifecycleState::kUnconfigured:
      steps = {LifecycleTransition::kUnconfiguredShutdown};
      break;
    case LifecycleState::kFinalized:
    case LifecycleState::kUnknown:
      break;
    default:
      // A transition is in progress. This one takes its turn behind it, whether it is possible or
      // not; the state is settled then.
      return LifecycleTransition::kUnconfiguredShutdown;
  }
  for (const LifecycleTransition step : steps) {
    if (std::find(tried.begin(), tried.end(), step) == tried.end()) {
      return step;
    }
  }
  return std::nullopt;
}

/// Takes one component down, inside the component's default group: the component exists as long as
/// its callbacks run, so a plain reference is enough.
class TakingDown : public std::enable_shared_from_this<TakingDown> {
 public:
  TakingDown(Component& component, std::function<void()> finished)
      : component_(component), finished_(std::move(finished)) {}

  void proceed() {
    const auto step = step_down(component_.state(), tried_);
    if (!step) {
      finished_();
      return;
    }
    tried_.push_back(*step);
    component_.request_transition(
        *step, [self = shared_from_this()](const TransitionResult&) { self->proceed(); });
  }

 private:
  Component& component_;
  const std::function<void()> finished_;
  std::vector<LifecycleTransition> tried_;
};

}  // namespace

void bring_up(Component& component, std::function<void(const TransitionResult&)> done) {
  component.request_transition(
      LifecycleTransition::kConfigure,
      [&component, done = std::move(done)](const TransitionResult& configured) {
        if (configured.success) {
          component.request_transition(LifecycleTransition::kActivate, done);
        } else {
          done(configured);
        }
      });
}

void take_down(Component& component, std::function<void()> finished) {
  const auto taking_down = std::make_shared<TakingDown>(component, std::move(finished));
  component.default_group()->post([taking_down] { taking_down->proceed(); });
}

}  // namespace pipescout
