// SPDX-License-Identifier: Apache-2.0
#include "run/name_keeper.hpp"

#include <algorithm>
#include <set>
#include <vector>

#include "run/mission.hpp"

namespace pipescout::host {
namespace {

/// So often it is looked whether the robot stands.
constexpr Duration kBetweenLooks = std::chrono::milliseconds(200);

}  // namespace

NameKeeper::NameKeeper(const Composition& composition, const DdsOptions& dds, Context& context,
                       EventLoop& loop)
    : composition_(composition), loop_(loop) {
  std::vector<NodeName> names;
  for (const auto& entry : composition.components) {
    names.push_back(entry.name);
  }
  if (!names.empty()) {
    guard_.emplace(dds.announcements, context.transport()->participant(), names,
                   NameGuard::pace_for(dds), [&loop] { loop.post([] {}); });
  }
}

void NameKeeper::await(const std::function<bool()>& stopping, Duration grace) {
  if (!guard_) {
    return;
  }
  const auto holds = [this] { return guard_->state() == NameClaim::State::kHolding; };
  const auto loses = [this] {
    const auto rival = guard_->rival();
    return rival && rival->wins;
  };
  loop_.run_until([&] { return stopping() || holds() || loses(); });
  loop_.run_until([&] { return stopping() || holds(); }, steady_now() + grace);
  if (!stopping() && !holds()) {
    has_lost_ = true;
    // Without a rival by now: it has gone a moment ago, and its names are not confirmed yet.
    const auto rival = guard_->rival();
    refuse(rival ? rival->name : composition_.components.front().name.fully_qualified());
  }
}

void NameKeeper::refuse(const std::string& name) const {
  const auto entry =
      std::find_if(composition_.components.begin(), composition_.components.end(),
                   [&](const auto& each) { return each.name.fully_qualified() == name; });
  throw StartError((entry == composition_.components.end() ? "" : entry->location + ": ") +
                   "another process in this DDS domain has a node " + name +
                   " already; give this composition another namespace (--namespace) or another "
                   "ROS_DOMAIN_ID");
}

void NameKeeper::check() const {
  if (has_lost_) {
    refuse(told_->name);
  }
}

std::optional<SteadyTime> NameKeeper::look(Node& node, const std::function<void()>& deactivate,
                                           SteadyTime now) {
  if (guard_) {
    tell(node);
  }
  if (!motion_ || is_inactive_) {
    return std::nullopt;
  }
  // Who drives a robot, and who tells it where it is, goes on until it stands.
  if (!motion_->stands(now)) {
    return now + kBetweenLooks;
  }
  is_inactive_ = true;
  conflict_ += " Its components are inactive.";
  node.logger().error("the robot stands: the components become inactive");
  deactivate();
  return std::nullopt;
}

/// Says what has become of a name that another process has too.
void NameKeeper::tell(Node& node) {
  const auto rival = guard_->rival();
  const bool gives_way = guard_->state() == NameClaim::State::kGivenUp;
  if (!rival || has_lost_ || (!gives_way && told_ && told_->participant == rival->participant)) {
    return;
  }
  told_ = rival;
  const std::string who = "another process in this DDS domain has a node " + rival->name + " too";
  if (!gives_way) {
    node.logger().warn(who + "; the one that has had it for a shorter time has to give way");
    return;
  }
  has_lost_ = true;
  conflict_ = who + ", and has had it for longer: this one gives way.";
  node.logger().error(conflict_ + " Its components become inactive once the robot stands");
  std::set<std::string> namespaces;
  for (const auto& entry : composition_.components) {
    namespaces.insert(entry.name.ns);
  }
  motion_.emplace(node, namespaces);
}

}  // namespace pipescout::host
