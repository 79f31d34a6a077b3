// SPDX-License-Identifier: Apache-2.0
#include <stdexcept>
#include <string>

#include "pipescout/runtime/register_component.hpp"

/// Components that tests load by name: one that works, and one for each way of not working.
namespace loadable {

/// Works. Its parameter `gain` must be positive.
class Counter : public pipescout::Component {
 public:
  explicit Counter(pipescout::ComponentOptions options) : Component(std::move(options)) {
    parameters().declare<double>(
        "gain", 1.0, {.floating_point_range = pipescout::FloatingPointRange{0.1, 10.0}});
  }
};

class ThrowsWhenConstructed : public pipescout::Component {
 public:
  explicit ThrowsWhenConstructed(pipescout::ComponentOptions options)
      : Component(std::move(options)) {
    throw std::runtime_error("the sensor has no serial number");
  }
};

class ThrowsNoException : public pipescout::Component {
 public:
  explicit ThrowsNoException(pipescout::ComponentOptions options) : Component(std::move(options)) {
    throw 42;
  }
};

class FailsToConfigure : public pipescout::Component {
 public:
  using Component::Component;

 private:
  pipescout::CallbackReturn on_configure() override { return pipescout::CallbackReturn::kFailure; }
};

class ThrowsInActivate : public pipescout::Component {
 public:
  using Component::Component;

 private:
  pipescout::CallbackReturn on_activate() override { throw std::runtime_error("no power"); }
};

/// Refuses to go down in an orderly way.
class Stubborn : public pipescout::Component {
 public:
  using Component::Component;

 private:
  pipescout::CallbackReturn on_deactivate() override { return pipescout::CallbackReturn::kFailure; }
  pipescout::CallbackReturn on_shutdown() override { throw std::runtime_error("no"); }
};

}  // namespace loadable

PIPESCOUT_REGISTER_COMPONENT(loadable::Counter)
PIPESCOUT_REGISTER_COMPONENT(loadable::ThrowsWhenConstructed)
PIPESCOUT_REGISTER_COMPONENT(loadable::ThrowsNoException)
PIPESCOUT_REGISTER_COMPONENT(loadable::FailsToConfigure)
PIPESCOUT_REGISTER_COMPONENT(loadable::ThrowsInActivate)
PIPESCOUT_REGISTER_COMPONENT(loadable::Stubborn)
