// SPDX-License-Identifier: Apache-2.0
#include "pipescout/planning/lattice_planner.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include "arc_list.hpp"
#include "footprint_sweep.hpp"
#include "grid_distance.hpp"
#include "lattice_search.hpp"
#include "pipescout/planning/reeds_shepp.hpp"
#include "pipescout/validation/check.hpp"

namespace pipescout::navigation {
namespace {

constexpr double kNoImprovement = 1e-6;  // m

}  // namespace

void LatticeSettings::validate() const {
  constexpr double kLargestFactor = 100;
  constexpr double kLargestCost = 1000;  // m
  constexpr double kLargestNear = 10;    // m
  validation::check_within("reverse_factor", reverse_factor, 1, kLargestFactor);
  validation::check_within("cusp_cost", cusp_cost, 0, kLargestCost);
  validation::check_within("steering_cost", steering_cost, 0, kLargestCost);
  validation::check_within("nearness_factor", nearness_factor, 0, kLargestFactor);
  validation::check_above("near", near, 0, kLargestNear);
  validation::check_above("step", step, 0, 1);
  validation::require("most_expansions", static_cast<double>(most_expansions), most_expansions > 0,
                      "at least 1");
}

std::string_view text_of(PlanStatus status) {
  switch (status) {
    case PlanStatus::kFound:
      return "found";
    case PlanStatus::kStartNotFinite:
      return "the start pose is not finite";
    case PlanStatus::kGoalNotFinite:
      return "the goal pose is not finite";
    case PlanStatus::kStartOutside:
      return "the start is outside the grid";
    case PlanStatus::kGoalOutside:
      return "the goal is outside the grid";
    case PlanStatus::kStartInCollision:
      return "the robot collides at the start";
    case PlanStatus::kGoalInCollision:
      return "the robot collides at the goal";
    case PlanStatus::kUnreachable:
      return "obstacles separate the goal from the start";
    case PlanStatus::kNotFound:
      return "no path was found";
    case PlanStatus::kStopped:
      return "told to stop before a path was found";
  }
  return "";
}

class LatticePlanner::Search {
 public:
  Search(OccupancyGrid grid, Footprint footprint, LatticePrimitives primitives,
         const LatticeSettings& settings)
      : sweep_(std::move(grid), std::move(footprint), checked(settings)),
        lattice_(std::move(primitives), settings, sweep_),
        proof_(sweep_.grid(), sweep_.field(), sweep_.inscribed_radius(), GridDistance::Use::kProof),
        to_goal_(sweep_.grid(), sweep_.field(), sweep_.inscribed_radius(),
                 GridDistance::Use::kGuide),
        to_start_(sweep_.grid(), sweep_.field(), sweep_.inscribed_radius(),
                  GridDistance::Use::kGuide),
        settings_(settings) {}

  [[nodiscard]] const OccupancyGrid& grid() const { return sweep_.grid(); }
  void change(std::span<const CellChange> cells) {
    const CellBox box = sweep_.change(cells);
    // What the distance field says changes as far as it reaches.
    const int reach =
        static_cast<int>(std::ceil(sweep_.field().largest() / grid().resolution())) + 1;
    const CellBox near{{box.low.column - reach, box.low.row - reach},
                       {box.high.column + reach, box.high.row + reach}};
    proof_.forget(near);
    to_goal_.forget(near);
    to_start_.forget(near);
  }

  Plan plan(const Pose2d& start, const Pose2d& goal, const ShouldStop& should_stop,
            const OnPath& on_path) {
    Plan plan;
    last_.clear();
    plan.status = check_ends(start, goal);
    if (plan.status != PlanStatus::kFound) {
      return plan;
    }
    last_goal_ = goal;
    std::optional<ArcList> best = first_path(start, goal, should_stop, plan);
    if (!best) {
      return plan;
    }
    double cost = lattice_.cost(start, *best);
    const auto tell = [&] {
      if (on_path) {
        on_path(sampled(start, *best, settings_.step), cost);
      }
    };
    tell();
    prove(start, goal, should_stop);
    plan.lower_bound = std::max(reeds_shepp_length(start, goal, lattice_.radius()),
                                proof_.bound(start.position()));
    improve(start, goal, *best, cost, should_stop, plan, tell);
    finish(start, std::move(*best), cost, plan);
    return plan;
  }

  Plan replan(const Pose2d& start, const ShouldStop& should_stop) {
    Plan plan;
    if (last_.empty()) {
      return plan;
    }
    plan.status = check_ends(start, last_goal_);
    if (plan.status != PlanStatus::kFound) {
      return plan;
    }
    if (std::optional<ArcList> rest = reuse(start, should_stop, plan)) {
      plan.reused = true;
      plan.lower_bound = reeds_shepp_length(start, last_goal_, lattice_.radius());
      const double cost = lattice_.cost(start, *rest);
      finish(start, std::move(*rest), cost, plan);
      return plan;
    }
    const Pose2d goal = last_goal_;
    bool found = false;
    return this->plan(
        start, goal, [&] { return found || should_stop(); },
        [&](const Path&, double) { found = true; });
  }

  [[nodiscard]] bool is_free(const Path& path) const {
    if (path.empty()) {
      return true;
    }
    const Pose2d& start = path.poses().front().pose;
    return sweep_.is_free(start) && sweep_.is_free(start, arcs_of_path(path));
  }

 private:
  static const LatticeSettings& checked(const LatticeSettings& settings) {
    settings.validate();
    return settings;
  }

  [[nodiscard]] PlanStatus check_ends(const Pose2d& start, const Pose2d& goal) const {
    if (!is_finite(start)) {
      return PlanStatus::kStartNotFinite;
    }
    if (!is_finite(goal)) {
      return PlanStatus::kGoalNotFinite;
    }
    if (!grid().cell_at(start.position())) {
      return PlanStatus::kStartOutside;
    }
    if (!grid().cell_at(goal.position())) {
      return PlanStatus::kGoalOutside;
    }
    if (!sweep_.is_free(start)) {
      return PlanStatus::kStartInCollision;
    }
    return sweep_.is_free(goal) ? PlanStatus::kFound : PlanStatus::kGoalInCollision;
  }

  /// The distances of proofs, as far as there is time. False if there is proven to be no way.
  bool prove(const Pose2d& start, const Pose2d& goal, const ShouldStop& should_stop) {
    bool stopped = false;
    proof_.set_root(goal.position(), start.position());
    return proof_.reach(should_stop, stopped) || stopped;
  }

  /// From the start, and from the goal backwards, in turns: where one end stands in a narrow place,
  /// it is easier to leave it than to find it.
  std::optional<ArcList> first_path(const Pose2d& start, const Pose2d& goal,
                                    const ShouldStop& should_stop, Plan& plan) {
    constexpr std::size_t kFirstTry = 2000;
    constexpr double kGreedy = 2.5;
    bool stopped = should_stop();
    to_goal_.set_root(goal.position(), start.position());
    to_start_.set_root(start.position(), goal.position());
    const GridDistance* ahead = &to_goal_;
    const GridDistance* back = &to_start_;
    if (!stopped && !to_goal_.reach(should_stop, stopped) && !stopped) {
      // The guide sees no way: it closes more than it can prove to be closed.
      if (!prove(start, goal, should_stop)) {
        plan.status = PlanStatus::kUnreachable;
        return std::nullopt;
      }
      ahead = &proof_;
      back = nullptr;
    }
    bool has_back = false;
    for (std::size_t most = kFirstTry; most <= 2 * settings_.most_expansions && !stopped;
         most *= 4) {
      const std::size_t limit = std::min(most, settings_.most_expansions);
      LatticeSearch::Result forwards = lattice_.search(
          {start, goal, ahead, kGreedy, limit, std::numeric_limits<double>::infinity(), false},
          should_stop);
      plan.expansions += forwards.expansions;
      if (forwards.arcs) {
        plan.status = PlanStatus::kFound;
        return forwards.arcs;
      }
      stopped = forwards.stopped;
      if (!stopped && !has_back) {
        has_back = back != nullptr && to_start_.reach(should_stop, stopped);
        back = has_back ? back : nullptr;
      }
      LatticeSearch::Result backwards;
      if (!stopped) {
        backwards = lattice_.search(
            {goal, start, back, kGreedy, limit, std::numeric_limits<double>::infinity(), true},
            should_stop);
        plan.expansions += backwards.expansions;
        stopped = backwards.stopped;
      }
      if (backwards.arcs) {
        plan.status = PlanStatus::kFound;
        return reversed(*backwards.arcs);
      }
      if (forwards.exhausted && backwards.exhausted) {
        break;
      }
    }
    plan.status = stopped ? PlanStatus::kStopped : PlanStatus::kNotFound;
    return std::nullopt;
  }

  template <typename Tell>
  void improve(const Pose2d& start, const Pose2d& goal, ArcList& best, double& cost,
               const ShouldStop& should_stop, Plan& plan, const Tell& tell) {
    shorten(start, best, cost, should_stop);
    tell();
    for (const double weight : {1.5, 1.2, 1.0}) {
      if (should_stop()) {
        return;
      }
      LatticeSearch::Result found = lattice_.search(
          {start, goal, &proof_, weight, settings_.most_expansions, cost, false}, should_stop);
      plan.expansions += found.expansions;
      if (!found.arcs) {
        continue;
      }
      double other = lattice_.cost(start, *found.arcs);
      shorten(start, *found.arcs, other, should_stop);
      if (other < cost - kNoImprovement) {
        best = std::move(*found.arcs);
        cost = other;
        tell();
      }
    }
  }

  /// Replaces stretches between two drawn places by the Reeds-Shepp path where that is cheaper and
  /// free, until hardly anything is won any more.
  void shorten(const Pose2d& start, ArcList& arcs, double& cost, const ShouldStop& should_stop) {
    constexpr int kPatience = 150;  // tries in a row that win nothing
    constexpr std::uint64_t kSeed = 1;
    std::mt19937_64 engine(kSeed);
    const auto draw = [&] { return static_cast<double>(engine() >> 11U) * 0x1p-53; };
    for (int failures = 0; failures < kPatience && !should_stop();) {
      const double length = length_of(arcs);
      // Stretches of all sizes, from the whole path to a turning radius.
      const double span = std::min(length, lattice_.radius()) *
                          std::pow(std::max(1.0, length / lattice_.radius()), draw());
      const double from = draw() * (length - span);
      ++failures;
      if (auto shorter = with_shortcut(start, arcs, from, from + span)) {
        const double other = lattice_.cost(start, *shorter);
        if (other < cost - kNoImprovement) {
          failures = other < cost * (1 - kWorthIt) ? 0 : failures;
          arcs = std::move(*shorter);
          cost = other;
        }
      }
    }
  }

  std::optional<ArcList> with_shortcut(const Pose2d& start, const ArcList& arcs, double from,
                                       double to) const {
    ArcList result = cut(arcs, 0, from);
    const ArcList between = cut(arcs, from, to);
    const Pose2d a = end_of_arcs(start, result);
    const Pose2d b = end_of_arcs(a, between);
    const auto words = reeds_shepp_words(a, b, lattice_.radius());
    const double now = lattice_.cost(a, between);
    constexpr std::size_t kWords = 3;
    for (std::size_t i = 0; i < std::min(kWords, words.size()); ++i) {
      const ArcList direct = arcs_of_word(words[i], lattice_.radius());
      if (words[i].length() < now && sweep_.is_free(a, direct)) {
        result.insert(result.end(), direct.begin(), direct.end());
        const ArcList rest = cut(arcs, to, length_of(arcs));
        result.insert(result.end(), rest.begin(), rest.end());
        tidy(result);
        return result;
      }
    }
    return std::nullopt;
  }

  /// The last path from where the robot is, led around what blocks it; nothing if that fails.
  std::optional<ArcList> reuse(const Pose2d& start, const ShouldStop& should_stop, Plan& plan) {
    const double length = length_of(last_);
    const double here = nearest_on_last(start);
    const ArcList rest = cut(last_, here, length);
    const Pose2d on_path = end_of_arcs(last_start_, cut(last_, 0, here));
    constexpr double kOnPath = 1e-4;  // m and rad
    const bool is_on_path = distance(start, on_path) < kOnPath &&
                            std::abs(wrap_angle(start.heading - on_path.heading)) < kOnPath;
    const double free = sweep_.free_length(on_path, rest);
    const bool all_free = free >= length - here;
    if (is_on_path && all_free) {
      return rest;
    }
    // Left ever earlier and joined again ever later: behind the first place that is blocked.
    const double blocked = all_free ? here : here + free;
    constexpr std::array kAhead{2.5, 4.0, 8.0, 16.0};  // turning radii
    for (const double ahead : kAhead) {
      const double reach = ahead * lattice_.radius();
      const double leave = is_on_path ? std::max(here, blocked - reach) : here;
      const double join = std::min(length, blocked + reach);
      const Pose2d target = end_of_arcs(last_start_, cut(last_, 0, join));
      const ArcList after = cut(last_, join, length);
      if (sweep_.is_free(target) && sweep_.is_free(target, after)) {
        ArcList arcs = is_on_path ? cut(last_, here, leave) : ArcList{};
        const Pose2d from = end_of_arcs(start, arcs);
        std::optional<ArcList> around;
        if (!all_free) {
          around = swerve(from, end_of_arcs(last_start_, cut(last_, 0, blocked)), target);
        }
        if (!around) {
          around = search_around(from, target, should_stop, plan);
        }
        if (around) {
          arcs.insert(arcs.end(), around->begin(), around->end());
          arcs.insert(arcs.end(), after.begin(), after.end());
          tidy(arcs);
          return arcs;
        }
      }
      if (join >= length || should_stop()) {
        return std::nullopt;
      }
    }
    return std::nullopt;
  }

  /// Past an obstacle at `blocked` on either side of it, and back onto the path.
  [[nodiscard]] std::optional<ArcList> swerve(const Pose2d& from, const Pose2d& blocked,
                                              const Pose2d& target) const {
    constexpr std::array kAside{0.5, -0.5, 0.8, -0.8, 1.2, -1.2, 1.8, -1.8};  // turning radii
    for (const double aside : kAside) {
      const Pose2d beside = compose(blocked, {0, aside * lattice_.radius(), 0});
      if (!sweep_.is_free(beside)) {
        continue;
      }
      ArcList arcs = shortest_word(from, beside);
      const ArcList back = shortest_word(beside, target);
      // No detour that begins with turning about.
      if (length_of(arcs) + length_of(back) >
          2 * distance(from, beside) + 2 * distance(beside, target)) {
        continue;
      }
      if (sweep_.is_free(from, arcs) && sweep_.is_free(beside, back)) {
        arcs.insert(arcs.end(), back.begin(), back.end());
        return arcs;
      }
    }
    return std::nullopt;
  }

  [[nodiscard]] ArcList shortest_word(const Pose2d& from, const Pose2d& to) const {
    const auto words = reeds_shepp_words(from, to, lattice_.radius());
    return words.empty() ? ArcList{} : arcs_of_word(words.front(), lattice_.radius());
  }

  std::optional<ArcList> search_around(const Pose2d& from, const Pose2d& target,
                                       const ShouldStop& should_stop, Plan& plan) {
    constexpr std::size_t kMostExpansions = 3000;
    constexpr double kGreedy = 2.5;
    bool stopped = false;
    to_start_.set_root(target.position(), from.position());
    if (!to_start_.reach(should_stop, stopped)) {
      return std::nullopt;
    }
    LatticeSearch::Result found =
        lattice_.search({from, target, &to_start_, kGreedy, kMostExpansions,
                         std::numeric_limits<double>::infinity(), false},
                        should_stop);
    plan.expansions += found.expansions;
    return std::move(found.arcs);
  }

  /// m along the last path, of its pose nearest to another.
  [[nodiscard]] double nearest_on_last(const Pose2d& pose) const {
    constexpr double kCoarse = 0.5;  // m
    const double length = length_of(last_);
    double best = std::numeric_limits<double>::infinity();
    double place = 0;
    const auto try_between = [&](double from, double to, double step) {
      const Path path =
          sampled(end_of_arcs(last_start_, cut(last_, 0, from)), cut(last_, from, to), step);
      for (const PathPose& candidate : path.poses()) {
        const double away =
            distance(candidate.pose, pose) +
            lattice_.radius() * std::abs(wrap_angle(candidate.pose.heading - pose.heading));
        if (away < best) {
          best = away;
          place = from + candidate.arc_length;
        }
      }
    };
    try_between(0, length, kCoarse);
    const double near = place;
    try_between(std::max(0.0, near - kCoarse), std::min(length, near + kCoarse), settings_.step);
    return place;
  }

  void finish(const Pose2d& start, ArcList arcs, double cost, Plan& plan) {
    plan.status = PlanStatus::kFound;
    plan.path = sampled(start, arcs, settings_.step);
    plan.cost = cost;
    plan.suboptimality = plan.lower_bound > 0 ? std::max(1.0, cost / plan.lower_bound) : 1.0;
    last_start_ = start;
    last_ = std::move(arcs);
  }

  static constexpr double kWorthIt = 1e-3;  ///< share of the cost

  FootprintSweep sweep_;
  LatticeSearch lattice_;
  GridDistance proof_;    ///< to the goal
  GridDistance to_goal_;  ///< guides
  GridDistance to_start_;
  LatticeSettings settings_;
  ArcList last_;
  Pose2d last_start_;
  Pose2d last_goal_;
};

LatticePlanner::LatticePlanner(OccupancyGrid grid, Footprint footprint,
                               LatticePrimitives primitives, const LatticeSettings& settings)
    : search_(std::make_unique<Search>(std::move(grid), std::move(footprint), std::move(primitives),
                                       settings)) {}
LatticePlanner::~LatticePlanner() = default;
LatticePlanner::LatticePlanner(LatticePlanner&&) noexcept = default;
LatticePlanner& LatticePlanner::operator=(LatticePlanner&&) noexcept = default;

const OccupancyGrid& LatticePlanner::grid() const {
  return search_->grid();
}
void LatticePlanner::change(std::span<const CellChange> cells) {
  search_->change(cells);
}
Plan LatticePlanner::plan(const Pose2d& start, const Pose2d& goal, const ShouldStop& should_stop,
                          const OnPath& on_path) {
  return search_->plan(start, goal, should_stop, on_path);
}
Plan LatticePlanner::replan(const Pose2d& start, const ShouldStop& should_stop) {
  return search_->replan(start, should_stop);
}
bool LatticePlanner::is_free(const Path& path) const {
  return search_->is_free(path);
}

}  // namespace pipescout::navigation
