// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <iosfwd>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

namespace pipescout::benchmarks {

/// What a benchmark reports: named figures with their targets, and the rows behind them.
class Figures {
 public:
  enum class Bound { kAtLeast, kAtMost };

  void add(const std::string& name, double value, Bound bound, double target);
  /// Without a target: something to compare with.
  void add(const std::string& name, double value) { figures_.push_back({name, value, {}, {}}); }
  void add_row(nlohmann::json row) { rows_.push_back(std::move(row)); }

  /// One that the input was drawn from.
  void add_seed(std::uint64_t seed) { seeds_.push_back(seed); }

  void print(std::ostream& out) const;
  /// {"figures": {name: number}, "rows": [...], "seeds": [...]}. Throws std::runtime_error naming
  /// the file when it cannot be written.
  void write_json(const std::string& file) const;

 private:
  struct Figure {
    std::string name;
    double value;
    Bound bound;
    std::optional<double> target;
  };
  std::vector<Figure> figures_;
  nlohmann::json rows_ = nlohmann::json::array();
  nlohmann::json seeds_ = nlohmann::json::array();
};

}  // namespace pipescout::benchmarks
