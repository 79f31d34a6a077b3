// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "pipescout/runtime/component.hpp"

namespace pipescout {

/// Reports the fault COUNTER ("image.silent") when an input that was heard before falls silent.
/// A source that has not begun yet is not silent: a driver may take its time, and simulated time
/// may leap to that of the first message. Of it an information in the log tells, once.
///
/// Looks once per period of the component's clock while the component is active, so a silence is
/// reported after one period at least and two at most. To be used in the component's default group.
class SilenceWatch {
 public:
  /// `Component::report_fault` of the component.
  using ReportFault = std::function<void(std::string_view counter, std::string_view text)>;

  /// `component` must outlive it.
  SilenceWatch(Component& component, std::string counter, ReportFault report_fault);

  /// Forgets what was heard, and looks from now on. `what`: the input in the text "no WHAT for
  /// 5 s"; `silent_after`: s, the period. Throws std::invalid_argument when it is not positive.
  void start(std::string what, double silent_after);
  /// Does not look any more.
  void stop();
  /// A message of the input came.
  void heard();

 private:
  void look();

  Component& component_;
  const std::string counter_;
  const ReportFault report_fault_;
  std::string what_;
  double silent_after_ = 0.0;
  std::shared_ptr<Timer> timer_;
  bool has_begun_ = false;  // something was heard since `start`
  bool heard_ = false;      // since the last look
  int looks_in_vain_ = 0;   // before anything was heard
};

}  // namespace pipescout
