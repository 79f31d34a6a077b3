// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/silence_watch.hpp"

#include <utility>

#include "text_for_people.hpp"

namespace pipescout {

namespace {

/// Before the first of two looks the clock may not have begun, so only the time between them has
/// passed for certain.
constexpr int kLooksBeforeWord = 2;

}  // namespace

SilenceWatch::SilenceWatch(Component& component, std::string counter, ReportFault report_fault)
    : component_(component), counter_(std::move(counter)), report_fault_(std::move(report_fault)) {}

void SilenceWatch::start(std::string what, double silent_after) {
  what_ = std::move(what);
  silent_after_ = silent_after;
  has_begun_ = false;
  heard_ = false;
  looks_in_vain_ = 0;
  timer_ = component_.create_timer(from_seconds(silent_after), [this] { look(); });
}

void SilenceWatch::stop() {
  timer_.reset();
}

void SilenceWatch::heard() {
  heard_ = true;
  if (!has_begun_) {
    has_begun_ = true;
    if (timer_) {
      timer_->reset();
    }
  }
}

void SilenceWatch::look() {
  if (!has_begun_) {
    if (++looks_in_vain_ == kLooksBeforeWord) {
      component_.logger().info("waits for the first " + what_);
    }
    return;
  }
  if (!std::exchange(heard_, false)) {
    report_fault_(counter_, "no " + what_ + " for " + text_for_people(silent_after_) + " s");
  }
}

}  // namespace pipescout
