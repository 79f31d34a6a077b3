// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

#include "pipescout/runtime/component.hpp"

/// Complete bring-up and shutdown through the lifecycle, for the owner of a component. The executor
/// must spin.
namespace pipescout {

/// Configures and activates; stops at the first failure. `done` is called with the outcome of the
/// last transition, in the component's default group: it must not be the last owner of the
/// component. Thread-safe.
void bring_up(Component& component, std::function<void(const TransitionResult&)> done);

/// Deactivates, cleans up and shuts down, from the current state of the component; a failed
/// transition does not stop the sequence. `finished` is called in the component's default group
/// after the last transition; the component can be destroyed then, but not by that call.
/// Thread-safe.
void take_down(Component& component, std::function<void()> finished);

}  // namespace pipescout
