// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "pipescout/runtime/diagnostics.hpp"
#include "pipescout/runtime/lifecycle.hpp"
#include "pipescout/runtime/node.hpp"

namespace pipescout {

using ComponentOptions = NodeOptions;

/// The outcome of a requested transition.
struct TransitionResult {
  bool success = false;
  LifecycleState state = LifecycleState::kUnknown;  ///< the state afterwards
  std::string message;                              ///< why it failed; empty on success
};

/// A managed (lifecycle) node, the unit of composition. A derived class owns one algorithm and its
/// topics. It declares its parameters in the constructor, creates the algorithm and the endpoints
/// in `on_configure`, and releases them in `on_cleanup`.
///
/// Publishers, subscriptions and timers work only while the component is active: what is published
/// earlier is dropped and counted, and arriving messages wait in their queues. Services answer in
/// every state (see NodeServiceOptions). An exception that
/// leaves any callback, of the lifecycle or of a message, is logged, counted on `/diagnostics` and
/// takes the component through its error state; other components do not notice. A lifecycle
/// callback that fails or reports an error says why with `diagnostics().set_status` or
/// `report_failed`; the reason appears in the result of the transition, and on `/diagnostics` until
/// a transition succeeds.
///
/// No callback runs before the object is completely constructed, so a constructor may create
/// endpoints while the executor spins. `make_component`, or the first requested transition, marks
/// that point.
///
/// The lifecycle callbacks run in the default callback group, and never at the same time as another
/// callback of the component: before one begins, the callbacks of all groups that are running have
/// returned, and no other begins until it is over. They must not block, nor must a callback wait
/// for a transition of its own component.
///
/// The owner closes a component before it destroys it, so that no callback meets a half-destroyed
/// object; ComponentPtr does both.
class Component : public Node {
 public:
  explicit Component(ComponentOptions options);
  ~Component() override;

  /// Allows callbacks, including those of the node's services: the object is completely
  /// constructed. Called by the creator of a component, see `make_component`; a constructor must
  /// not call it. Thread-safe.
  using Node::allow_callbacks;
  using Node::close;
  using Node::stop_callbacks;

  /// Requests a transition. It runs in the default callback group, so the executor must spin;
  /// `done` (optional) is called there with the outcome. Transitions requested while one is in
  /// progress are queued. Allows callbacks, so constructors must not call it. Thread-safe.
  void request_transition(LifecycleTransition transition,
                          std::function<void(const TransitionResult&)> done = {});
  /// Thread-safe.
  [[nodiscard]] LifecycleState state() const;
  [[nodiscard]] Diagnostics& diagnostics() const;

 protected:
  /// Unconfigured -> inactive. Reads parameters, creates the algorithm and the endpoints.
  virtual CallbackReturn on_configure() { return CallbackReturn::kSuccess; }
  /// Inactive -> active. Endpoints are enabled after it succeeded.
  virtual CallbackReturn on_activate() { return CallbackReturn::kSuccess; }
  /// Active -> inactive. Endpoints are disabled before it.
  virtual CallbackReturn on_deactivate() { return CallbackReturn::kSuccess; }
  /// Inactive -> unconfigured. Releases what on_configure created.
  virtual CallbackReturn on_cleanup() { return CallbackReturn::kSuccess; }
  /// Any -> finalized. The default is usually sufficient: the destructor releases the rest.
  virtual CallbackReturn on_shutdown() { return CallbackReturn::kSuccess; }
  /// After an error anywhere: success -> unconfigured, anything else -> finalized. Must release
  /// what on_configure created. The default calls on_cleanup.
  virtual CallbackReturn on_error() { return on_cleanup(); }

  /// Publishes the progress of the component's part of the mission on `mission/status`; `total` 0:
  /// unknown. Counts beyond the range of MissionStatus saturate.
  void report_progress(std::uint64_t done, std::uint64_t total, std::string_view message = {});
  /// Reports that the component's part is complete: the run ends when all components in the
  /// composition's `complete_when` have reported it.
  void report_complete(std::string_view message = {});
  /// Reports that the component's part cannot be completed: the run ends with an error.
  void report_failed(std::string_view message);
  /// Counts a fault of the input on `/diagnostics`; the first of its kind is also logged.
  void report_fault(std::string_view counter, std::string_view text,
                    const Logger::Location& where = Logger::Location::current());

  void on_callback_exception(std::exception_ptr error) override;

 private:
  class Lifecycle;
  std::unique_ptr<Lifecycle> lifecycle_;
};

/// Closes a component, then destroys it.
struct ComponentDeleter {
  void operator()(Component* component) const {
    component->close();
    delete component;
  }
};

/// Owns a component. Converts to std::shared_ptr<Component>, which closes it too.
template <std::derived_from<Component> T = Component>
using ComponentPtr = std::unique_ptr<T, ComponentDeleter>;

/// Creates a component and allows its callbacks. Throws what its constructor throws.
template <std::derived_from<Component> T, class... Arguments>
[[nodiscard]] ComponentPtr<T> make_component(Arguments&&... arguments) {
  ComponentPtr<T> component(new T(std::forward<Arguments>(arguments)...));
  component->allow_callbacks();
  return component;
}

/// Factory of components of one class, by `make_component`; exported by a component library.
class ComponentFactory {
 public:
  virtual ~ComponentFactory() = default;
  [[nodiscard]] virtual ComponentPtr<> create(ComponentOptions options) const = 0;
};

template <class T>
class ComponentFactoryFor final : public ComponentFactory {
 public:
  [[nodiscard]] ComponentPtr<> create(ComponentOptions options) const override {
    return make_component<T>(std::move(options));
  }
};

}  // namespace pipescout
