// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/simulation_run.hpp"

#include <utility>

#include "pipescout/runtime/parameters.hpp"

namespace pipescout {

SimulationRun::SimulationRun(Node& node, const std::vector<std::string>& topics)
    : node_(node), awaited_(node, "the simulation starts", topics) {
  rate_ = node.parameters().declare<double>(
      "rate", 1.0,
      {.description = "largest speed of the simulation, as a multiple of real time",
       .floating_point_range = FloatingPointRange{1e-2, 1e3}});
  step_time_out_ = node.parameters().declare<double>(
      "step_time_out", to_seconds(LockStepOptions{}.time_out),
      {.description = "s of real time that consumers may take for one step before those that are "
                      "not through are left out",
       .floating_point_range = FloatingPointRange{1e-3, 1e3}});
}

void SimulationRun::configure(const UntypedPublisher& clock,
                              const std::vector<std::shared_ptr<UntypedPublisher>>& publishers,
                              Duration period, Step step, ReportFault report_fault) {
  has_ended_ = false;
  lock_step_.emplace(
      node_, clock,
      LockStepOptions{.period = from_seconds(to_seconds(period) / rate_.get()),
                      .time_out = from_seconds(step_time_out_.get())},
      [this, step = std::move(step)] {
        has_ended_ = !step();
        return !has_ended_;
      },
      [report_fault = std::move(report_fault)](const std::string& who, const std::string& why) {
        report_fault("step.left_out", who +
                                          " does not get through with a step: it is not waited for "
                                          "any more (" +
                                          why + ")");
      });
  awaited_.watch(publishers, [this] { resume(); });
}

void SimulationRun::activate() {
  active_ = true;
  resume();
}

void SimulationRun::deactivate() {
  active_ = false;
  if (lock_step_) {
    lock_step_->pause();
  }
}

void SimulationRun::clean_up() {
  active_ = false;
  awaited_.stop();
  lock_step_.reset();
}

void SimulationRun::resume() {
  if (active_ && !has_ended_ && awaited_.all_there()) {
    lock_step_->resume();
  }
}

}  // namespace pipescout
