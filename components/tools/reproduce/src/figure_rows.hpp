// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <limits>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include "reproduce.hpp"

namespace pipescout::reproduce {

/// What a figure has to be.
struct Target {
  double least = -std::numeric_limits<double>::infinity();
  double most = std::numeric_limits<double>::infinity();

  /// Whether there is anything that it must be; a target without only says which way is worse.
  [[nodiscard]] bool asks() const { return least > 0 || std::isfinite(most); }
  [[nodiscard]] bool met_by(double value) const { return value >= least && value <= most; }
  /// How far from what is good: what of the values of several seeds is worst.
  [[nodiscard]] double badness(double value) const;
  /// "at most 0.05"
  [[nodiscard]] std::string text() const;
};

// Without anything that it must be; which way is worse.
inline constexpr Target kSmallIsGood{};
inline constexpr Target kLargeIsGood{.least = 0.0};

inline constexpr Target kNone{.least = 0.0, .most = 0.0};

constexpr Target at_most(double most) {
  return {.most = most};
}

constexpr Target at_least(double least) {
  return {.least = least};
}

constexpr Target within(double least, double most) {
  return {.least = least, .most = most};
}

/// A quantity of a study, one value per seed.
struct Measure {
  std::string name;           ///< with its unit
  double value = 0.0;         ///< over all seeds
  std::vector<double> seeds;  ///< per seed; empty: it has none
  Target good{};              ///< which way is worse
  std::string figure{};       ///< the name under which `value` is a figure; empty: it
                              ///< is a row only
};

/// Gathers measures into a reproduction, and prints each study as a table.
class FigureRows {
 public:
  FigureRows(Reproduction& result, std::ostream& out) : result_(result), out_(out) {}

  /// Its rows: {"study", "measure", "value", "mean", "p95", "worst",
  /// "per_seed"}, where 95 % of the seeds are no worse than p95.
  void add_study(const std::string& study, const std::vector<Measure>& measures);

 private:
  Reproduction& result_;
  std::ostream& out_;
};

}  // namespace pipescout::reproduce
