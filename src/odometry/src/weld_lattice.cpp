// SPDX-License-Identifier: Apache-2.0
#include "weld_lattice.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace pipescout::odometry::alignment {
namespace {

constexpr double kNever = -std::numeric_limits<double>::infinity();
constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();
constexpr double kBandJoints = 3.0;         // half width of the band, mean joints
constexpr double kBeam = 35.0;              // cells this much less likely than the best are dropped
constexpr double kEdgeBeam = 20.0;          // the same among the ways into one cell
constexpr double kTraceDrop = 100.0;        // a trace ends when it has lost this much
constexpr double kLeastProbability = 1e-3;  // of a pair that is worth reporting

/// A way into a cell.
struct Edge {
  std::size_t from = kNone;
  double log_weight = 0.0;
  RatioState ratio;
};

/// The pair (a, b) as the end of a path.
struct Cell {
  std::size_t a = 0;
  std::size_t b = 0;
  double sum = kNever;           // log weight of all paths that end here
  double best = kNever;          // of the likeliest
  std::size_t previous = kNone;  // on the likeliest
  RatioState ratio;              // of the likeliest
  std::size_t first_edge = 0;
  std::size_t last_edge = 0;
};

/// Pairs in a band, filled row by row (row: weld of A) in rising order without leaving any out.
class Lattice {
 public:
  Lattice(const AlignmentModel& model, std::size_t first_row)
      : model_(model), first_row_(first_row), rows_{0} {}

  /// A row of one pair only, at which paths begin for free.
  void begin_at(std::size_t a, std::size_t b) {
    cells_.push_back({.a = a, .b = b, .sum = 0.0, .best = 0.0, .ratio = model_.first_ratio()});
    rows_.push_back(cells_.size());
    row_best_.push_back(0);
  }

  /// The next row: the pairs with the welds [from, to) of B.
  void add_row(std::size_t from, std::size_t to, bool may_begin);

  [[nodiscard]] std::size_t next_row() const { return first_row_ + rows_.size() - 1; }
  [[nodiscard]] const std::vector<Cell>& cells() const { return cells_; }
  [[nodiscard]] const std::vector<Edge>& edges() const { return edges_; }

  /// The likeliest cell of the rows that a step can start from, or kNone.
  [[nodiscard]] std::size_t recent_best() const;

 private:
  void enter(Cell& cell);

  const AlignmentModel& model_;
  std::size_t first_row_;
  std::vector<std::size_t> rows_;      // first cell of each row, and the end
  std::vector<std::size_t> row_best_;  // per row, or kNone
  std::vector<Cell> cells_;
  std::vector<Edge> edges_;
  std::vector<Edge> row_edges_;  // scratch
  std::vector<Cell> row_cells_;  // scratch
};

std::size_t Lattice::recent_best() const {
  std::size_t best = kNone;
  const std::size_t reach = std::min(row_best_.size(), model_.parameters().longest_gap + 1);
  for (std::size_t k = 1; k <= reach; ++k) {
    const std::size_t candidate = row_best_[row_best_.size() - k];
    if (candidate != kNone && (best == kNone || cells_[candidate].best > cells_[best].best)) {
      best = candidate;
    }
  }
  return best;
}

/// All steps that end in the pair of `cell`; leaves them in `row_edges_`.
void Lattice::enter(Cell& cell) {
  const std::vector<double>& x_a = model_.a().chainage;
  const std::vector<double>& x_b = model_.b().chainage;
  const std::size_t longest_step = model_.parameters().longest_gap + 1;
  const std::size_t filled = rows_.size() - 1;
  cell.first_edge = row_edges_.size();
  double best_edge = kNever;
  for (std::size_t back = 1; back <= std::min(filled, longest_step); ++back) {
    const std::size_t row = filled - back;
    const double length_a = x_a[cell.a] - x_a[cell.a - back];
    const double gate = model_.gate(length_a);
    for (std::size_t source = rows_[row]; source < rows_[row + 1]; ++source) {
      const Cell& before = cells_[source];
      if (before.b >= cell.b || cell.b - before.b > longest_step ||
          std::abs(x_b[cell.b] - x_b[before.b] - before.ratio.mean * length_a) > gate ||
          before.sum + model_.log_bound(before.a, before.b, cell.a, cell.b) <
              best_edge - kEdgeBeam) {
        continue;
      }
      const Step step = model_.step(before.a, before.b, cell.a, cell.b, before.ratio);
      if (before.sum + step.log_weight < best_edge - kEdgeBeam) {
        continue;
      }
      best_edge = std::max(best_edge, before.sum + step.log_weight);
      row_edges_.push_back({.from = source, .log_weight = step.log_weight, .ratio = step.ratio});
      cell.sum = log_add(cell.sum, before.sum + step.log_weight);
      if (before.best + step.log_weight > cell.best) {
        cell.best = before.best + step.log_weight;
        cell.previous = source;
        cell.ratio = step.ratio;
      }
    }
  }
  cell.last_edge = row_edges_.size();
}

void Lattice::add_row(std::size_t from, std::size_t to, bool may_begin) {
  const std::size_t a = next_row();
  row_cells_.clear();
  row_edges_.clear();
  const std::size_t recent = recent_best();
  double best = recent == kNone ? kNever : cells_[recent].sum;
  for (std::size_t b = from; b < to; ++b) {
    Cell cell;
    cell.a = a;
    cell.b = b;
    if (may_begin) {
      cell.ratio = model_.first_ratio();
      cell.sum = cell.best = model_.log_begin(a, b, cell.ratio);
    }
    enter(cell);
    best = std::max(best, cell.sum);
    row_cells_.push_back(cell);
  }
  std::size_t row_best = kNone;
  for (Cell& cell : row_cells_) {
    if (!(cell.sum > best - kBeam)) {
      continue;
    }
    const auto edges = row_edges_.begin();
    const std::size_t first_edge = edges_.size();
    edges_.insert(edges_.end(), edges + static_cast<std::ptrdiff_t>(cell.first_edge),
                  edges + static_cast<std::ptrdiff_t>(cell.last_edge));
    cell.first_edge = first_edge;
    cell.last_edge = edges_.size();
    if (row_best == kNone || cell.best > cells_[row_best].best) {
      row_best = cells_.size();
    }
    cells_.push_back(cell);
  }
  rows_.push_back(cells_.size());
  row_best_.push_back(row_best);
}

/// Welds of B within the band around the chainage `centre`: [first, second).
std::pair<std::size_t, std::size_t> band(const AlignmentModel& model, double centre) {
  const std::vector<double>& x_b = model.b().chainage;
  const double half = kBandJoints * model.mean_joint();
  const auto from = std::lower_bound(x_b.begin(), x_b.end(), centre - half);
  const auto to = std::upper_bound(from, x_b.end(), centre + half);
  return {static_cast<std::size_t>(from - x_b.begin()), static_cast<std::size_t>(to - x_b.begin())};
}

/// From the pair to the end of the lists, or to where the path was best.
Trace follow(const AlignmentModel& model, std::size_t a, std::size_t b) {
  Lattice lattice(model, a);
  lattice.begin_at(a, b);
  const std::vector<double>& x_a = model.a().chainage;
  std::size_t best = 0;
  for (std::size_t row = a + 1; row < x_a.size(); ++row) {
    const std::size_t recent = lattice.recent_best();
    if (recent == kNone || lattice.cells()[recent].best < lattice.cells()[best].best - kTraceDrop) {
      break;
    }
    const Cell& cell = lattice.cells()[recent];
    if (lattice.cells()[recent].best > lattice.cells()[best].best) {
      best = recent;
    }
    const auto [from, to] =
        band(model, model.b().chainage[cell.b] + cell.ratio.mean * (x_a[row] - x_a[cell.a]));
    lattice.add_row(from, to, false);
  }
  for (std::size_t k = 0; k < lattice.cells().size(); ++k) {
    if (lattice.cells()[k].best > lattice.cells()[best].best) {
      best = k;
    }
  }
  Trace found;
  found.score = lattice.cells()[best].best;
  for (std::size_t k = best; k != kNone; k = lattice.cells()[k].previous) {
    found.path.push_back({.a = lattice.cells()[k].a, .b = lattice.cells()[k].b});
  }
  std::reverse(found.path.begin(), found.path.end());
  return found;
}

/// Chainage of B that the path gives the chainage of A; beyond its ends by its overall ratio there.
double along(const AlignmentModel& model, const std::vector<Pair>& path, double chainage) {
  const std::vector<double>& x_a = model.a().chainage;
  const std::vector<double>& x_b = model.b().chainage;
  if (path.size() == 1) {
    return x_b[path[0].b] + model.first_ratio().mean * (chainage - x_a[path[0].a]);
  }
  const auto next =
      std::upper_bound(path.begin() + 1, path.end() - 1, chainage,
                       [&](double value, const Pair& pair) { return value < x_a[pair.a]; });
  const std::size_t upper = static_cast<std::size_t>(next - path.begin());
  const bool inside = chainage >= x_a[path.front().a] && chainage <= x_a[path.back().a];
  // Beyond the ends a single joint's ratio would swing the band: take many.
  constexpr std::size_t kJoints = 20;
  const std::size_t low = inside || upper > 1 ? upper - std::min(upper, inside ? 1 : kJoints) : 0;
  const std::size_t high = inside || upper > 1 ? upper : std::min(path.size() - 1, kJoints);
  const double ratio =
      (x_b[path[high].b] - x_b[path[low].b]) / (x_a[path[high].a] - x_a[path[low].a]);
  const std::size_t anchor = chainage < x_a[path.front().a] ? 0 : inside ? low : path.size() - 1;
  return x_b[path[anchor].b] + ratio * (chainage - x_a[path[anchor].a]);
}

}  // namespace

Trace trace(const AlignmentModel& model, const AlignmentModel& mirror, const Proposal& proposal) {
  const std::size_t last_a = model.a().size() - 1;
  const std::size_t last_b = model.b().size() - 1;
  Trace whole = follow(mirror, last_a - proposal.a, last_b - proposal.b);
  std::reverse(whole.path.begin(), whole.path.end());
  for (Pair& pair : whole.path) {
    pair.a = last_a - pair.a;
    pair.b = last_b - pair.b;
  }
  const Trace ahead = follow(model, proposal.a, proposal.b);
  whole.score += ahead.score;
  whole.path.insert(whole.path.end(), ahead.path.begin() + 1, ahead.path.end());
  return whole;
}

bool in_band(const AlignmentModel& model, const std::vector<Pair>& path, std::size_t a,
             std::size_t b) {
  const double centre = along(model, path, model.a().chainage[a]);
  return std::abs(model.b().chainage[b] - centre) <= kBandJoints * model.mean_joint();
}

Posterior posterior(const AlignmentModel& model, const std::vector<Pair>& path) {
  const std::vector<double>& x_a = model.a().chainage;
  Lattice lattice(model, 0);
  for (std::size_t row = 0; row < x_a.size(); ++row) {
    const auto [from, to] = band(model, along(model, path, x_a[row]));
    lattice.add_row(from, to, true);
  }
  const std::vector<Cell>& cells = lattice.cells();
  const std::vector<Edge>& edges = lattice.edges();
  Posterior result{.log_evidence = kNever, .pairs = {}};
  std::vector<double> after(cells.size());
  for (std::size_t k = 0; k < cells.size(); ++k) {
    after[k] = model.log_end(cells[k].a, cells[k].b, cells[k].ratio);
    result.log_evidence = log_add(result.log_evidence, cells[k].sum + after[k]);
  }
  for (std::size_t k = cells.size(); k-- > 0;) {
    for (std::size_t e = cells[k].first_edge; e < cells[k].last_edge; ++e) {
      double& before = after[edges[e].from];
      before = log_add(before, edges[e].log_weight + after[k]);
    }
  }
  for (std::size_t k = 0; k < cells.size(); ++k) {
    const double probability = std::exp(cells[k].sum + after[k] - result.log_evidence);
    if (probability >= kLeastProbability) {
      result.pairs.push_back(
          {.a = cells[k].a, .b = cells[k].b, .probability = std::min(probability, 1.0)});
    }
  }
  return result;
}

}  // namespace pipescout::odometry::alignment
