// SPDX-License-Identifier: Apache-2.0
#include "action_cases.hpp"

#include <benchmark/benchmark.h>

#include <cstddef>
#include <example_interfaces/action/fibonacci.hpp>
#include <iostream>
#include <memory>
#include <string>

#include "pipescout/dds/dds_transport.hpp"
#include "pipescout/runtime/node.hpp"
#include "pipescout/testing/action_race.hpp"

namespace pipescout::benchmarks {

namespace {

using example_interfaces::action::Fibonacci;

constexpr std::size_t kGoals = 10000;

void goal_in_process(benchmark::State& state) {
  Executor executor;
  Node node({.context = Context::create_in_process(),
             .executor = &executor,
             .name = {"/", "benchmark"},
             .standard_interfaces = false});
  const auto server = node.create_action_server<Fibonacci>(
      "goal", {.accepted = [](const ServerGoal<Fibonacci>& goal) { goal.succeed(); }},
      {.max_results = 10});
  auto client = node.create_action_client<Fibonacci>("goal");
  std::size_t succeeded = 0;
  std::size_t sent = 0;
  for (auto _ : state) {
    client.send_goal({}, {.result = [&](const GoalOutcome<Fibonacci>& outcome) {
                       succeeded += outcome ? 1 : 0;
                     }});
    ++sent;
    executor.spin_ready();
  }
  if (succeeded != sent) {
    state.SkipWithError("goals are missing");
  }
}

}  // namespace

void register_action_cases() {
  benchmark::RegisterBenchmark("action/goal_in_process", goal_in_process);
}

void add_action_figures(Figures& figures) {
  const auto process = [] {
    return Context::create(create_dds_transport(DdsOptions::from_environment()));
  };
  std::size_t lost = 0;
  std::size_t wrong = 0;
  for (const bool over_dds : {false, true}) {
    const std::shared_ptr<Context> server = over_dds ? process() : Context::create_in_process();
    const std::shared_ptr<Context> client = over_dds ? process() : server;
    const std::string path = over_dds ? "over DDS" : "in process";
    // One after the other, and four at a time.
    for (const std::size_t lanes : {std::size_t{1}, std::size_t{4}}) {
      const auto report = testing::race_actions(server, client, {.goals = kGoals, .lanes = lanes});
      lost += report.lost;
      wrong += report.wrong;
      for (const std::string& fault : report.faults) {
        std::cerr << "actions " << path << ": " << fault << '\n';
      }
      figures.add_row({{"case", "actions " + path},
                       {"lanes", lanes},
                       {"goals", kGoals},
                       {"succeeded", report.succeeded},
                       {"canceled", report.canceled},
                       {"lost", report.lost},
                       {"wrong", report.wrong},
                       {"seconds", report.seconds}});
      if (lanes == 1) {
        figures.add(over_dds ? "actions_per_second_dds" : "actions_per_second_in_process",
                    static_cast<double>(kGoals) / report.seconds);
      }
    }
  }
  figures.add("actions_lost", static_cast<double>(lost), Figures::Bound::kAtMost, 0.0);
  figures.add("actions_wrong", static_cast<double>(wrong), Figures::Bound::kAtMost, 0.0);
}

}  // namespace pipescout::benchmarks
