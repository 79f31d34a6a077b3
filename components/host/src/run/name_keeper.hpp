// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "core/composition.hpp"
#include "pipescout/dds/dds_transport.hpp"
#include "pipescout/runtime/context.hpp"
#include "pipescout/runtime/node.hpp"
#include "run/event_loop.hpp"
#include "run/motion_watch.hpp"
#include "run/name_guard.hpp"

namespace pipescout::host {

/// The names of a composition's components, which no other process of the domain has: two missions
/// that share names would take each other's messages for their own. The names stay claimed as long
/// as the mission runs, since another one may come into reach; then the later one of the two gives
/// way, once its robot stands. For the main thread.
class NameKeeper {
 public:
  /// Begins to claim the names; `dds.announcements` must be those of the context's transport.
  NameKeeper(const Composition& composition, const DdsOptions& dds, Context& context,
             EventLoop& loop);

  /// Until the claim is confirmed, or `stopping` holds. A process that has a name already may be a
  /// mission that is just ending: it gets `grace`. Throws StartError naming the component.
  void await(const std::function<bool()>& stopping, Duration grace);

  /// Looks for rivals, and logs what becomes of them at the node. `deactivate` is called once, when
  /// the components have to become inactive. Returns when to look again.
  std::optional<SteadyTime> look(Node& node, const std::function<void()>& deactivate,
                                 SteadyTime now);
  /// Throws StartError when another process has the names.
  void check() const;

  /// Another process has the names: from then on.
  [[nodiscard]] bool has_lost() const noexcept { return has_lost_; }
  /// The components have been deactivated for that.
  [[nodiscard]] bool is_inactive() const noexcept { return is_inactive_; }
  /// For /diagnostics; empty while the names are this process's own.
  [[nodiscard]] const std::string& conflict() const noexcept { return conflict_; }

 private:
  void tell(Node& node);
  [[noreturn]] void refuse(const std::string& name) const;

  const Composition& composition_;
  EventLoop& loop_;
  std::optional<NameClaim::Rival> told_;
  std::optional<MotionWatch> motion_;
  std::string conflict_;
  bool has_lost_ = false;
  bool is_inactive_ = false;
  std::optional<NameGuard> guard_;  // none: there are no names
};

}  // namespace pipescout::host
