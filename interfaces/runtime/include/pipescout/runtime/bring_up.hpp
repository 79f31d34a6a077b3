// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

#include "pipescout/runtime/component.hpp"

/// The whole way up and down the lifecycle, for whoever owns a component. The executor must spin.
namespace pipescout {

/// Configures and activates; stops where it fails. `done` is called with the outcome of the last
/// transition, in the component's default group: it must not be the last owner of the component.
/// Thread-safe.
void bring_up(Component& component, std::function<void(const TransitionResult&)> done);

/// Deactivates, cleans up and shuts down, whatever of it fails, from the state that the component
/// is in. `finished` is called in the component's default group when nothing is left to try; the
/// component can be destroyed then, but not by that call. Thread-safe.
void take_down(Component& component, std::function<void()> finished);

}  // namespace pipescout
