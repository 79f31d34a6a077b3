// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/synchronized_subscriptions.hpp"

namespace pipescout {

SharedSynchronizer::SharedSynchronizer(Component& component, std::vector<std::string> topics,
                                       SynchronizerOptions options, Synchronizer::Callback callback)
    : component_(component),
      topics_(std::move(topics)),
      callback_(std::move(callback)),
      synchronizer_(
          topics_.size(), std::move(options),
          [this](const std::vector<Synchronizer::Message>& set) { complete_.push_back(set); }) {}

void SharedSynchronizer::add(std::size_t stream, Time stamp, Synchronizer::Message message) {
  std::vector<std::vector<Synchronizer::Message>> complete;
  {
    const std::lock_guard lock(mutex_);
    const SynchronizerStatistics before = synchronizer_.statistics();
    synchronizer_.add(stream, stamp, std::move(message));
    report(before);
    complete.swap(complete_);
  }
  for (const auto& set : complete) {
    callback_(set);
  }
}

void SharedSynchronizer::report(const SynchronizerStatistics& before) {
  const SynchronizerStatistics& now = synchronizer_.statistics();
  Diagnostics& diagnostics = component_.diagnostics();
  for (std::size_t i = 0; i < topics_.size(); ++i) {
    const auto& stream = now.streams[i];
    diagnostics.count(topics_[i] + ".sync.queue_full",
                      stream.queue_full - before.streams[i].queue_full);
    diagnostics.count(topics_[i] + ".sync.late", stream.late - before.streams[i].late);
    if (stream.unmatched != before.streams[i].unmatched) {
      diagnostics.set_value(topics_[i] + ".sync.unmatched", std::to_string(stream.unmatched));
    }
  }
  diagnostics.count("sync.set_back", now.set_back - before.set_back);
  if (now.sets != before.sets) {
    diagnostics.set_value("sync.sets", std::to_string(now.sets));
  }
}

SynchronizerStatistics SharedSynchronizer::statistics() const {
  const std::lock_guard lock(mutex_);
  return synchronizer_.statistics();
}

}  // namespace pipescout
