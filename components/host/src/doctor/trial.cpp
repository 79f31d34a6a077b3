// SPDX-License-Identifier: Apache-2.0
#include "doctor/trial.hpp"

#include <algorithm>
#include <exception>

#include "pipescout/runtime/component_registry.hpp"

namespace pipescout::host::doctor {
namespace {

// Maps and pictures are read when a component is configured.
constexpr Duration kPatience = std::chrono::seconds(60);

std::string configure(Component& component, Executor& executor) {
  // Shared with the component, which may answer after the time is over.
  const auto result = std::make_shared<std::optional<TransitionResult>>();
  component.request_transition(LifecycleTransition::kConfigure,
                               [result](const TransitionResult& done) { *result = done; });
  executor.spin_until([&] { return result->has_value(); }, kPatience);
  if (!result->has_value()) {
    return "it is not configured after " + std::to_string(to_seconds(kPatience)) + " s.";
  }
  return (*result)->success ? "" : (*result)->message;
}

}  // namespace

void try_composition(const Composition& composition, Observation& seen) {
  const auto context = Context::create_in_process();
  Executor executor;
  const ComponentRegistry registry;
  std::vector<ComponentPtr<>> components;
  for (const auto& entry : composition.components) {
    Trial trial{
        .location = entry.location, .node = entry.name, .failure = {}, .unused_parameters = {}};
    try {
      ComponentOptions options;
      options.context = context;
      options.executor = &executor;
      options.name = entry.name;
      options.remap_rules = entry.remappings;
      options.parameter_overrides = entry.parameters;
      auto component = registry.create(entry.type, std::move(options));
      trial.unused_parameters = component->parameters().unused_overrides();
      trial.failure = configure(*component, executor);
      const auto datum = component->parameters().get_optional("datum");
      if (datum && datum->type() == ParameterType::kDoubleArray) {
        seen.datums[entry.name] = datum->get<std::vector<double>>();
      }
      components.push_back(std::move(component));
    } catch (const std::exception& error) {
      trial.failure = error.what();
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
