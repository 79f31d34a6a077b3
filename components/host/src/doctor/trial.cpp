// SPDX-License-Identifier: Apache-2.0
#include "doctor/trial.hpp"

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <exception>
#include <future>
#include <iostream>
#include <locale>
#include <mutex>
#include <optional>
#include <sstream>
#include <thread>

#include "pipescout/runtime/component_registry.hpp"

namespace pipescout::host::doctor {
namespace {

/// What became of a component.
struct Outcome {
  ComponentPtr<> component;  ///< null when it cannot be made
  std::string failure;
  std::vector<UnusedOverride> unused_parameters;
  std::optional<std::vector<double>> datum;
};

/// What the thread of a component uses; shared with it, as it may never end.
struct Attempt {
  std::shared_ptr<Context> context;
  std::shared_ptr<Executor> executor;
  std::shared_ptr<const ComponentRegistry> registry;
  ComponentEntry entry;
  std::atomic<bool> is_made = false;
  std::promise<Outcome> outcome;
};

std::string configure(Component& component, Executor& executor) {
  // Shared with the component, which may answer after a callback of another one has thrown.
  const auto result = std::make_shared<TransitionResult>();
  component.request_transition(LifecycleTransition::kConfigure,
                               [result, &executor](const TransitionResult& done) {
                                 *result = done;
                                 executor.stop();
                               });
  executor.spin();
  return result->success ? "" : result->message;
}

Outcome make_and_configure(Attempt& attempt) {
  Outcome outcome;
  try {
    ComponentOptions options;
    options.context = attempt.context;
    options.executor = attempt.executor.get();
    options.name = attempt.entry.name;
    options.remap_rules = attempt.entry.remappings;
    options.parameter_overrides = attempt.entry.parameters;
    auto component = attempt.registry->create(attempt.entry.type, std::move(options));
    attempt.is_made = true;
    outcome.unused_parameters = component->parameters().unused_overrides();
    outcome.failure = configure(*component, *attempt.executor);
    const auto datum = component->parameters().get_optional("datum");
    if (datum && datum->type() == ParameterType::kDoubleArray) {
      outcome.datum = datum->get<std::vector<double>>();
    }
    outcome.component = std::move(component);
  } catch (const std::exception& error) {
    outcome.failure = error.what();
  }
  return outcome;
}

/// A thread that was left behind may still use static objects, so none is destroyed.
void leave_without_destruction() {
  static std::once_flag once;
  std::call_once(once, [] {
    on_exit(
        [](int status, void*) {
          std::cout.flush();
          std::cerr.flush();
          std::_Exit(status);
        },
        nullptr);
  });
}

std::string too_late(bool is_made, Duration patience) {
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text << (is_made ? "it is not configured" : "its constructor has not returned") << " after "
       << to_seconds(patience) << " s.";
  return text.str();
}

/// Nothing when the component takes too long.
std::optional<Outcome> try_component(const std::shared_ptr<Attempt>& attempt, Duration patience) {
  auto outcome = attempt->outcome.get_future();
  std::thread thread([attempt] { attempt->outcome.set_value(make_and_configure(*attempt)); });
  if (outcome.wait_for(patience) == std::future_status::ready) {
    thread.join();
    return outcome.get();
  }
  thread.detach();
  leave_without_destruction();
  return std::nullopt;
}

}  // namespace

void try_composition(const Composition& composition, Duration patience, Observation& seen) {
  const auto context = Context::create_in_process();
  const auto registry = std::make_shared<const ComponentRegistry>();
  std::vector<std::shared_ptr<Executor>> executors{std::make_shared<Executor>()};
  std::vector<ComponentPtr<>> components;
  for (const auto& entry : composition.components) {
    const auto attempt = std::make_shared<Attempt>();
    attempt->context = context;
    attempt->executor = executors.back();
    attempt->registry = registry;
    attempt->entry = entry;
    Trial trial{
        .location = entry.location, .node = entry.name, .failure = {}, .unused_parameters = {}};
    if (auto outcome = try_component(attempt, patience)) {
      trial.failure = std::move(outcome->failure);
      trial.unused_parameters = std::move(outcome->unused_parameters);
      if (outcome->datum) {
        seen.datums[entry.name] = *outcome->datum;
      }
      if (outcome->component) {
        components.push_back(std::move(outcome->component));
      }
    } else {
      trial.failure = too_late(attempt->is_made, patience);
      // The thread that was left behind may still be in the last one.
      executors.push_back(std::make_shared<Executor>());
    }
    seen.trials.push_back(std::move(trial));
  }
  const auto is_running = [running = seen.nodes](const NodeName& node) {
    return std::find(running.begin(), running.end(), node) != running.end();
  };
  for (const auto& node : context->graph().nodes()) {
    if (!is_running(node)) {
      seen.nodes.push_back(node);
    }
  }
  for (auto& endpoint : context->graph().endpoints()) {
    if (endpoint.node && !is_running(*endpoint.node)) {
      seen.endpoints.push_back(std::move(endpoint));
    }
  }
}

}  // namespace pipescout::host::doctor
