// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "core/name_claim.hpp"
#include "pipescout/dds/dds_transport.hpp"

namespace pipescout::host {

/// Makes the claim of this process to the names of its nodes, and answers those of others, on a
/// thread of its own: also while components are being made. Thread-safe.
class NameGuard {
 public:
  /// How fast announcements come to others, and the more slowly the fewer get lost.
  [[nodiscard]] static NameClaim::Pace pace_for(const DdsOptions& options);

  /// `self`: the participant of the transport that the announcements belong to. `changed` is called
  /// on the guard's thread when the state or the rival may have changed.
  NameGuard(std::shared_ptr<Announcements> announcements, Gid self,
            const std::vector<NodeName>& names, NameClaim::Pace pace,
            std::function<void()> changed);
  NameGuard(const NameGuard&) = delete;
  NameGuard& operator=(const NameGuard&) = delete;
  ~NameGuard();

  [[nodiscard]] NameClaim::State state() const;
  /// See NameClaim. Of a holder that has given up: the one that it has given way to.
  [[nodiscard]] std::optional<NameClaim::Rival> rival() const;

 private:
  void run();

  const std::shared_ptr<Announcements> announcements_;
  const std::function<void()> changed_;
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  NameClaim claim_;
  std::optional<NameClaim::Rival> rival_;
  bool has_news_ = false;
  bool ends_ = false;
  std::thread thread_;
};

}  // namespace pipescout::host
