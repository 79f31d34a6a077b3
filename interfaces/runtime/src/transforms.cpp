// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/transforms.hpp"

#include <stdexcept>

#include "pipescout/runtime/node.hpp"
#include "pipescout/runtime/standard_topics.hpp"
#include "text_for_people.hpp"
#include "transform_listener.hpp"

namespace pipescout {

TransformWait& TransformWait::operator=(TransformWait&& other) noexcept {
  TransformWait replaced(std::move(*this));
  state_ = std::move(other.state_);
  return *this;
}

TransformWait::~TransformWait() {
  if (state_) {
    state_->cancel();
  }
}

bool TransformWait::is_waiting() const {
  return state_ && state_->is_waiting();
}

Transforms::Transforms(Node& node)
    : node_(node),
      listener_(node.context().transform_listener(node.resolve_topic(topics::kTf.name),
                                                  node.resolve_topic(topics::kTfStatic.name))) {
  listener_->add_reporter(node.logger(), node.default_group());
}

Transforms::~Transforms() = default;

void Transforms::require_history(Duration history) {
  listener_->buffer().extend_history(history);
}

TransformResult Transforms::lookup(std::string_view target, std::string_view source,
                                   Time time) const {
  return listener_->buffer().lookup(target, source, time);
}

TransformResult Transforms::lookup(std::string_view target, Time target_time,
                                   std::string_view source, Time source_time,
                                   std::string_view fixed) const {
  return listener_->buffer().lookup(target, target_time, source, source_time, fixed);
}

bool Transforms::can_transform(std::string_view target, std::string_view source, Time time,
                               TransformFailure* reason) const {
  return listener_->buffer().can_transform(target, source, time, reason);
}

TransformWait Transforms::wait_for(std::string_view target, std::string_view source, Time time,
                                   Duration timeout, Callback callback,
                                   std::shared_ptr<CallbackGroup> group) {
  if (timeout < Duration::zero()) {
    throw std::invalid_argument("the timeout of a wait for a transform is " +
                                text_for_people(to_seconds(timeout)) + " s, negative");
  }
  auto state = std::make_shared<TransformWait::State>(
      listener_->shared_from_this(), std::string(target), std::string(source), time,
      std::move(callback), group ? std::move(group) : node_.default_group(),
      node_.simulated_clock());
  TransformWait wait(state);
  state->begin(timeout);
  if (!listener_->add(state)) {
    state->refuse({TransformError::kTooManyWaits,
                   "no transform from '" + std::string(source) + "' to '" + std::string(target) +
                       "': too many waits for transforms go on already"});
  }
  return wait;
}

const TransformBuffer& Transforms::buffer() const {
  return listener_->buffer();
}

TransformStatistics Transforms::statistics() const {
  return listener_->statistics();
}

void Transforms::follow(std::shared_ptr<SimulatedClock> clock) {
  listener_->follow(std::move(clock));
}

}  // namespace pipescout
