// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <iosfwd>
#include <nlohmann/json.hpp>
#include <string>

namespace pipescout::benchmarks {

/// What a benchmark reports: named figures with their targets, and the rows behind them.
class Figures {
 public:
  enum class Bound { kAtLeast, kAtMost };

  void add(const std::string& name, double value, Bound bound, double target);
  void add_row(nlohmann::json row) { rows_.push_back(std::move(row)); }

  void print(std::ostream& out) const;
  /// {"figures": {name: number}, "rows": [...], "seeds": [...]}. Throws std::runtime_error naming
  /// the file when it cannot be written.
  void write_json(const std::string& file) const;

 private:
  struct Figure {
    std::string name;
    double value;
    Bound bound;
    double target;
  };
  std::vector<Figure> figures_;
  nlohmann::json rows_ = nlohmann::json::array();
};

}  // namespace pipescout::benchmarks
