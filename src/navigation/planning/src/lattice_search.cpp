// SPDX-License-Identifier: Apache-2.0
#include "lattice_search.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace pipescout::navigation {
namespace {

int sign_of(double value) {
  return value > 0 ? 1 : (value < 0 ? -1 : 0);
}

std::uint64_t key_of(int column, int row, int heading, bool reverse) {
  constexpr unsigned kBits = 24;
  constexpr std::uint64_t kMask = (1U << kBits) - 1;
  return (static_cast<std::uint64_t>(column) & kMask) << 40U |
         (static_cast<std::uint64_t>(row) & kMask) << 16U |
         static_cast<std::uint64_t>(heading) << 1U | (reverse ? 1U : 0U);
}

}  // namespace

LatticeSearch::LatticeSearch(LatticePrimitives primitives, const LatticeSettings& settings,
                             const FootprintSweep& sweep)
    : headings_(primitives.headings),
      radius_(primitives.turning_radius),
      spacing_(primitives.spacing),
      settings_(settings),
      sweep_(sweep) {
  primitives.validate();
  motions_.resize(headings_.size());
  for (MotionPrimitive& primitive : primitives.primitives) {
    const double length = primitive.length();
    Motion forward{primitive.columns,
                   primitive.rows,
                   primitive.end_heading,
                   false,
                   sign_of(primitive.pieces.front().curvature),
                   sign_of(primitive.pieces.back().curvature),
                   length,
                   primitive.pieces};
    Motion back{
        -primitive.columns, -primitive.rows, primitive.start_heading,   true, forward.last_turn,
        forward.first_turn, length,          reversed(primitive.pieces)};
    motions_[static_cast<std::size_t>(primitive.start_heading)].push_back(std::move(forward));
    motions_[static_cast<std::size_t>(primitive.end_heading)].push_back(std::move(back));
  }
}

void LatticeSearch::lay_out(const Pose2d& start) {
  // The start stands at the lattice's heading 0.
  origin_ = {start.x, start.y, start.heading - headings_.front()};
  column_step_ = {spacing_ * std::cos(origin_.heading), spacing_ * std::sin(origin_.heading)};
  headings_in_map_.clear();
  for (const double heading : headings_) {
    headings_in_map_.push_back(wrap_angle(origin_.heading + heading));
  }
}

Pose2d LatticeSearch::pose_of(int column, int row, int heading) const {
  return {origin_.x + column * column_step_.x - row * column_step_.y,
          origin_.y + column * column_step_.y + row * column_step_.x,
          headings_in_map_[static_cast<std::size_t>(heading)]};
}

double LatticeSearch::bound_of_position(const Query& query, const Pose2d& pose) {
  const double straight = distance(pose, query.goal);
  return query.to_goal == nullptr ? straight
                                  : std::max(straight, query.to_goal->bound(pose.position()));
}

double LatticeSearch::bound_of_pose(const Query& query, const Pose2d& pose, double bound) const {
  constexpr double kNear = 8;  // turning radii; beyond, headings hardly matter
  return bound < kNear * radius_ ? std::max(bound, reeds_shepp_length(pose, query.goal, radius_))
                                 : bound;
}

double LatticeSearch::step_cost(const Query& query, const Node& from, const Motion& motion) const {
  const bool driven_in_reverse = motion.reverse != query.backwards;
  double cost = motion.length * (driven_in_reverse ? settings_.reverse_factor : 1);
  if (from.motion != nullptr) {
    cost += from.motion->reverse != motion.reverse ? settings_.cusp_cost : 0;
    cost += from.motion->last_turn != motion.first_turn ? settings_.steering_cost : 0;
  }
  return cost;
}

double LatticeSearch::cost(const Pose2d& start, const ArcList& arcs) const {
  double cost = 0;
  for (std::size_t i = 0; i < arcs.size(); ++i) {
    const bool reverse = arcs[i].length < 0;
    cost += std::abs(arcs[i].length) * (reverse ? settings_.reverse_factor : 1);
    if (i > 0) {
      cost += (arcs[i - 1].length < 0) != reverse ? settings_.cusp_cost : 0;
      cost += arcs[i - 1].curvature != arcs[i].curvature ? settings_.steering_cost : 0;
    }
  }
  return settings_.nearness_factor > 0
             ? cost + settings_.nearness_factor * sweep_.nearness(start, arcs)
             : cost;
}

ArcList LatticeSearch::arcs_to(std::int32_t node) const {
  std::vector<const Motion*> motions;
  for (std::int32_t i = node; nodes_[static_cast<std::size_t>(i)].parent >= 0;
       i = nodes_[static_cast<std::size_t>(i)].parent) {
    motions.push_back(nodes_[static_cast<std::size_t>(i)].motion);
  }
  ArcList arcs;
  for (auto motion = motions.rbegin(); motion != motions.rend(); ++motion) {
    arcs.insert(arcs.end(), (*motion)->arcs.begin(), (*motion)->arcs.end());
  }
  return arcs;
}

std::optional<ArcList> LatticeSearch::expand_analytically(const Query& query, const Node& node,
                                                          std::size_t expansions,
                                                          const ShouldStop& should_stop) const {
  // Seldom far from the goal, always near it.
  const double far = node.rest / (2 * radius_);
  const auto every = static_cast<std::size_t>(std::max(1.0, far * far / 4));
  if (expansions % every != 0) {
    return std::nullopt;
  }
  constexpr double kNear = 6;  // turning radii; there, other words than the shortest help too
  constexpr std::size_t kWords = 8;
  const Pose2d pose = pose_of(node.column, node.row, node.heading);
  const auto words = reeds_shepp_words(pose, query.goal, radius_);
  const std::size_t count = node.rest < kNear * radius_ ? std::min(kWords, words.size()) : 1;
  for (std::size_t i = 0; i < count; ++i) {
    if (node.cost + words[i].length() >= query.below || (i > 0 && should_stop())) {
      break;
    }
    ArcList arcs = arcs_of_word(words[i], radius_);
    if (sweep_.is_free(pose, arcs)) {
      return arcs;
    }
  }
  return std::nullopt;
}

void LatticeSearch::push(const Query& query, const Candidate& candidate) {
  if (candidate.cost + candidate.rest >= query.below) {
    return;
  }
  open_.push_back(candidate);
  open_.back().key = candidate.cost + query.weight * candidate.rest;
  std::push_heap(open_.begin(), open_.end(),
                 [](const Candidate& a, const Candidate& b) { return a.key > b.key; });
}

void LatticeSearch::add_neighbours(const Query& query, std::int32_t index) {
  const Node node = nodes_[static_cast<std::size_t>(index)];
  for (const Motion& motion : motions_[static_cast<std::size_t>(node.heading)]) {
    const int column = node.column + motion.columns;
    const int row = node.row + motion.rows;
    if (seen_.contains(key_of(column, row, motion.end_heading, motion.reverse))) {
      continue;
    }
    const Pose2d pose = pose_of(column, row, motion.end_heading);
    if (!sweep_.grid().cell_at(pose.position())) {
      continue;
    }
    push(query, {.key = 0,
                 .cost = node.cost + step_cost(query, node, motion),
                 .rest = bound_of_position(query, pose),
                 .parent = index,
                 .refined = false,
                 .motion = &motion});
  }
}

std::optional<std::int32_t> LatticeSearch::take_up_best(const Query& query,
                                                        const ShouldStop& should_stop,
                                                        bool& stopped) {
  constexpr std::size_t kCandidatesPerQuestion = 16;
  for (std::size_t tried = 1; !open_.empty(); ++tried) {
    if (tried % kCandidatesPerQuestion == 0 && should_stop()) {
      stopped = true;
      return std::nullopt;
    }
    std::pop_heap(open_.begin(), open_.end(),
                  [](const Candidate& a, const Candidate& b) { return a.key > b.key; });
    Candidate best = open_.back();
    open_.pop_back();
    const Node& parent = nodes_[static_cast<std::size_t>(best.parent)];
    Node next{parent.column + best.motion->columns,
              parent.row + best.motion->rows,
              best.motion->end_heading,
              best.parent,
              best.motion,
              best.cost,
              best.rest};
    const std::uint64_t key = key_of(next.column, next.row, next.heading, best.motion->reverse);
    if (seen_.contains(key)) {
      continue;
    }
    if (!best.refined) {
      // The bound that costs more, only for what the cheap one has brought to the top.
      best.refined = true;
      best.rest = bound_of_pose(query, pose_of(next.column, next.row, next.heading), next.rest);
      if (best.rest > next.rest) {
        push(query, best);
        continue;
      }
    }
    const Pose2d from = pose_of(parent.column, parent.row, parent.heading);
    if (!sweep_.is_free(from, best.motion->arcs)) {
      continue;
    }
    if (settings_.nearness_factor > 0) {
      next.cost += settings_.nearness_factor * sweep_.nearness(from, best.motion->arcs);
    }
    seen_.insert(key);
    nodes_.push_back(next);
    return static_cast<std::int32_t>(nodes_.size() - 1);
  }
  return std::nullopt;
}

LatticeSearch::Result LatticeSearch::search(const Query& query, const ShouldStop& should_stop) {
  Result result;
  lay_out(query.start);
  nodes_.clear();
  open_.clear();
  seen_.clear();
  nodes_.push_back({0, 0, 0, -1, nullptr, 0,
                    bound_of_pose(query, query.start, bound_of_position(query, query.start))});
  std::optional<std::int32_t> index = 0;
  while (index) {
    const Node node = nodes_[static_cast<std::size_t>(*index)];
    if (auto arcs = expand_analytically(query, node, result.expansions, should_stop)) {
      ArcList all = arcs_to(*index);
      all.insert(all.end(), arcs->begin(), arcs->end());
      tidy(all);
      result.arcs = std::move(all);
      return result;
    }
    ++result.expansions;
    add_neighbours(query, *index);
    if (result.expansions >= query.most_expansions) {
      return result;
    }
    result.stopped = should_stop();
    if (result.stopped) {
      return result;
    }
    index = take_up_best(query, should_stop, result.stopped);
  }
  result.exhausted = !result.stopped;
  return result;
}

}  // namespace pipescout::navigation
