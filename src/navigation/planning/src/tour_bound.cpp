// SPDX-License-Identifier: Apache-2.0
#include "tour_bound.hpp"

#include <algorithm>
#include <cstddef>
#include <limits>

namespace pipescout::navigation {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// The least 1-tree at the prices of the ends. End 0 is outside of its tree.
class OneTree {
 public:
  explicit OneTree(const RowEnds& ends)
      : ends_(ends),
        size_(2 * ends.along.size()),
        degrees_(size_),
        nearest_(size_),
        distances_(size_),
        taken_(size_) {}

  /// Its cost, where the prices of a tour add up to nothing.
  double build(const std::vector<double>& prices) {
    std::fill(degrees_.begin(), degrees_.end(), 0);
    std::fill(distances_.begin(), distances_.end(), kInfinity);
    std::fill(taken_.begin(), taken_.end(), false);
    cost_ = 0;
    taken_[0] = true;
    take(1, prices);
    add_edge(0, 1, ends_.along[0]);
    while (true) {
      // Prim's algorithm: the nearest end, and with it the other one of its row.
      std::size_t next = 0;
      for (std::size_t end = 2; end < size_; ++end) {
        if (!taken_[end] && (next == 0 || distances_[end] < distances_[next])) {
          next = end;
        }
      }
      if (next == 0) {
        break;
      }
      add_edge(nearest_[next], next, join(nearest_[next], next));
      take(next, prices);
      const std::size_t other = next ^ 1U;
      add_edge(next, other, ends_.along[next / 2]);
      take(other, prices);
    }
    std::size_t first = 2;
    for (std::size_t end = 3; end < size_; ++end) {
      first = join(0, end) + prices[end] < join(0, first) + prices[first] ? end : first;
    }
    add_edge(0, first, join(0, first));
    double priced = cost_;
    for (std::size_t end = 0; end < size_; ++end) {
      priced += prices[end] * excess(end);
    }
    return priced;
  }
  /// Edges at an end beyond the two of a tour.
  [[nodiscard]] double excess(std::size_t end) const { return degrees_[end] - 2; }

 private:
  [[nodiscard]] double join(std::size_t a, std::size_t b) const {
    return ends_.joins[a * size_ + b];
  }
  void add_edge(std::size_t a, std::size_t b, double cost) {
    ++degrees_[a];
    ++degrees_[b];
    cost_ += cost;
  }
  void take(std::size_t end, const std::vector<double>& prices) {
    taken_[end] = true;
    for (std::size_t other = 2; other < size_; ++other) {
      const double distance = join(end, other) + prices[end] + prices[other];
      if (!taken_[other] && other / 2 != end / 2 && distance < distances_[other]) {
        distances_[other] = distance;
        nearest_[other] = end;
      }
    }
  }

  const RowEnds& ends_;
  std::size_t size_;
  std::vector<int> degrees_;
  std::vector<std::size_t> nearest_;
  std::vector<double> distances_;
  std::vector<bool> taken_;
  double cost_ = 0;
};

}  // namespace

double bound_by_spanning_trees(const RowEnds& ends, double cost,
                               const std::function<bool()>& should_stop) {
  constexpr int kRounds = 400;
  constexpr int kPatience = 15;  // rounds without a better bound, then the steps are halved
  const std::size_t size = 2 * ends.along.size();
  std::vector<double> prices(size, 0);
  OneTree tree(ends);
  double best = 0;
  double step = 2;  // Held, Wolfe and Crowder, "Validation of subgradient optimization", 1974
  int failures = 0;
  for (int round = 0; round < kRounds; ++round) {
    const double bound = tree.build(prices);
    failures = bound > best ? 0 : failures + 1;
    best = std::max(best, bound);
    double squares = 0;
    for (std::size_t end = 0; end < size; ++end) {
      squares += tree.excess(end) * tree.excess(end);
    }
    if (squares == 0 || best >= cost || should_stop()) {
      break;
    }
    if (failures == kPatience) {
      failures = 0;
      step /= 2;
    }
    for (std::size_t end = 0; end < size; ++end) {
      prices[end] += step * std::max(0.0, cost - bound) / squares * tree.excess(end);
    }
  }
  return std::min(best, cost);
}

}  // namespace pipescout::navigation
