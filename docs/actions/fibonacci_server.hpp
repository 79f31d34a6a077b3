// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <example_interfaces/action/fibonacci.hpp>
#include <memory>
#include <vector>

#include "pipescout/runtime/component.hpp"

namespace tutorial {

/// Computes Fibonacci numbers, one each `period`, for one client at a time.
class FibonacciServer final : public pipescout::Component {
 public:
  explicit FibonacciServer(pipescout::ComponentOptions options);

 protected:
  pipescout::CallbackReturn on_configure() override;
  pipescout::CallbackReturn on_deactivate() override;
  pipescout::CallbackReturn on_cleanup() override;

 private:
  using Fibonacci = example_interfaces::action::Fibonacci;
  using Goal = pipescout::ServerGoal<Fibonacci>;

  void begin(Goal goal);
  void compute_next();
  [[nodiscard]] Fibonacci::Result result() const;

  pipescout::Parameter<double> period_;
  pipescout::ActionServer<Fibonacci> server_;
  std::shared_ptr<pipescout::Timer> timer_;
  Goal goal_;  // in progress, if any
  std::vector<std::int32_t> sequence_;
};

}  // namespace tutorial
