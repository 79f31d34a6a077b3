// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "pipescout/runtime/component.hpp"
#include "pipescout/runtime/conversions.hpp"
#include "pipescout/runtime/synchronizer.hpp"

namespace pipescout {

/// A synchroniser behind a lock, and what it lost on the diagnostics of a component. For
/// `SynchronizedSubscriptions`.
class SharedSynchronizer {
 public:
  /// `topics`: what the streams are called. The component must outlive the messages.
  SharedSynchronizer(Component& component, std::vector<std::string> topics,
                     SynchronizerOptions options, Synchronizer::Callback callback);

  /// Tells the sets that are now complete, on this thread, under no lock.
  void add(std::size_t stream, Time stamp, Synchronizer::Message message);
  [[nodiscard]] SynchronizerStatistics statistics() const;

 private:
  void report(const SynchronizerStatistics& before);  // under mutex_

  Component& component_;
  const std::vector<std::string> topics_;
  const Synchronizer::Callback callback_;
  mutable std::mutex mutex_;
  std::vector<std::vector<Synchronizer::Message>> complete_;
  Synchronizer synchronizer_;
};

/// Subscriptions of 2 to 9 topics of a component whose messages are delivered together, in sets
/// whose header stamps are equal or lie as close as they can; see `Synchronizer` for what a set is.
///
///     inputs_.emplace(*this, SynchronizerOptions{.queue_size = 5},
///                     [this](const auto& image, const auto& depth) { on_pair(*image, *depth); },
///                     topics::kImage, topics::kDepth);
///
/// The callback runs in the component's default group, and takes a `std::shared_ptr<const T>` of
/// each topic. On `/diagnostics` are counted, by topic: `TOPIC.sync.queue_full`, messages that were
/// dropped before their set was known, `TOPIC.sync.late`, those whose stamp is not after that of
/// the one before, and `sync.set_back`; shown without a warning are `sync.sets` and
/// `TOPIC.sync.unmatched`, as streams of different rates leave messages over.
template <class... Messages>
class SynchronizedSubscriptions {
  static_assert(sizeof...(Messages) >= 2 && sizeof...(Messages) <= 9, "2 to 9 topics");

 public:
  using Callback = std::function<void(const std::shared_ptr<const Messages>&...)>;

  /// Throws as `create_subscription`, and std::invalid_argument for options out of range.
  SynchronizedSubscriptions(Component& component, SynchronizerOptions options, Callback callback,
                            const Topic<Messages>&... topics)
      : shared_(std::make_shared<SharedSynchronizer>(
            component, std::vector<std::string>{std::string(topics.name)...}, std::move(options),
            [callback = std::move(callback)](const std::vector<Synchronizer::Message>& set) {
              call(callback, set, std::index_sequence_for<Messages...>());
            })) {
    subscribe(component, std::index_sequence_for<Messages...>(), topics...);
  }

  [[nodiscard]] SynchronizerStatistics statistics() const { return shared_->statistics(); }

 private:
  template <std::size_t... kStreams>
  static void call(const Callback& callback, const std::vector<Synchronizer::Message>& set,
                   std::index_sequence<kStreams...> /*streams*/) {
    callback(std::static_pointer_cast<const Messages>(set[kStreams])...);
  }

  template <std::size_t... kStreams>
  void subscribe(Component& component, std::index_sequence<kStreams...> /*streams*/,
                 const Topic<Messages>&... topics) {
    ((std::get<kStreams>(subscriptions_) = component.create_subscription(
          topics,
          [shared = shared_](const std::shared_ptr<const Messages>& message) {
            shared->add(kStreams, from_message(message->header.stamp), message);
          })),
     ...);
  }

  std::shared_ptr<SharedSynchronizer> shared_;
  std::tuple<Subscription<Messages>...> subscriptions_;
};

}  // namespace pipescout
