// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "pipescout/runtime/node.hpp"
#include "pipescout/runtime/publisher.hpp"
#include "pipescout/runtime/time.hpp"

namespace pipescout {

struct LockStepOptions {
  /// Between the beginnings of two steps at least; zero: as fast as the consumers go.
  Duration period = Duration::zero();
  /// How long the consumers may take for one step before those that are not through are left out.
  /// The default is beyond any callback of a robot that works, and short enough for a test.
  Duration time_out = std::chrono::seconds(10);
};

/// Runs the steps of a simulation in lock step with its consumers: a step begins when nothing that
/// the step before has caused is queued, running or under way, in this process and in all others
/// with nodes that follow the simulation's clock (`use_sim_time`). So no queue overflows, and
/// results do not depend on the load of the machine or on who else listens: a recorder, or a
/// process of stock ROS 2, is not waited for.
///
/// A node that hangs, or a process that does not answer, is left out after `time_out`: the others
/// go on. A process is waited for again once it has caught up; a node of this process is not.
///
/// Steps run in the node's default group, as do the functions that are given. Not thread-safe:
/// to be used in that group.
class LockStep {
 public:
  /// Makes one step: publishes the clock and the data of the sensors. False: it was the last.
  using Step = std::function<bool()>;
  /// Told who is left out, for people: "node '/a/b'", "the process of node '/c'"; and why: "it has
  /// not reported".
  using LeftOut = std::function<void(const std::string& who, const std::string& why)>;

  /// `clock`: publisher of the simulation's clock, which must exist as long as the lock step.
  /// Throws std::invalid_argument when `period` is negative or `time_out` not positive,
  /// TransportError.
  LockStep(Node& node, const UntypedPublisher& clock, LockStepOptions options, Step step,
           LeftOut left_out);
  LockStep(const LockStep&) = delete;
  LockStep& operator=(const LockStep&) = delete;
  ~LockStep();

  /// The first step, or the next one after `pause`, begins soon. Does nothing while steps run.
  void resume();
  /// No step begins.
  void pause();

 private:
  class Impl;
  std::shared_ptr<Impl> impl_;
};

}  // namespace pipescout
