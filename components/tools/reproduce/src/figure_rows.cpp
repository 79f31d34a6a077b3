// SPDX-License-Identifier: Apache-2.0
#include "figure_rows.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numeric>

#include "pipescout/command_line/text_table.hpp"
#include "pipescout/odometry_study/quantile.hpp"

namespace pipescout::reproduce {
namespace {

using command_line::TextTable;

std::string number(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.4g", value);
  return text.data();
}

/// The value that this part of them is no worse than.
double bad_quantile(const std::vector<double>& values, const Target& good, double part) {
  std::vector<double> badness;
  badness.reserve(values.size());
  for (const double value : values) {
    badness.push_back(good.badness(value));
  }
  const double limit = odometry_study::quantile(badness, part);
  const auto found = std::find(badness.begin(), badness.end(), limit) - badness.begin();
  return values[static_cast<std::size_t>(found)];
}

}  // namespace

double Target::badness(double value) const {
  if (std::isfinite(least) && std::isfinite(most)) {
    return std::abs(value - 0.5 * (least + most));
  }
  return std::isfinite(least) ? -value : value;
}

std::string Target::text() const {
  if (least == most) {
    return number(most);
  }
  if (std::isfinite(least) && std::isfinite(most)) {
    return number(least) + " to " + number(most);
  }
  return std::isfinite(least) ? "at least " + number(least) : "at most " + number(most);
}

void FigureRows::add_study(const std::string& study, const std::vector<Measure>& measures) {
  TextTable table({"", "value", "target", "", "mean of seeds", "95 %", "worst"});
  for (const Measure& measure : measures) {
    nlohmann::json row{{"study", study}, {"measure", measure.name}, {"value", measure.value}};
    std::vector<TextTable::Cell> cells{measure.name, number(measure.value), "", ""};
    if (!measure.figure.empty()) {
      result_.figures[measure.figure] = measure.value;
      row["figure"] = measure.figure;
      cells[0] = measure.figure;
    }
    if (measure.good.asks()) {
      cells[2] = measure.good.text();
      cells[3] = measure.good.met_by(measure.value) ? "met" : "NOT MET";
    }
    if (measure.seeds.empty()) {
      cells.insert(cells.end(), 3, TextTable::Cell{""});
    } else {
      const double mean = std::accumulate(measure.seeds.begin(), measure.seeds.end(), 0.0) /
                          static_cast<double>(measure.seeds.size());
      const double p95 = bad_quantile(measure.seeds, measure.good, 0.95);
      const double worst = bad_quantile(measure.seeds, measure.good, 1.0);
      row.update({{"mean", mean}, {"p95", p95}, {"worst", worst}, {"per_seed", measure.seeds}});
      cells.insert(cells.end(), {number(mean), number(p95), number(worst)});
    }
    result_.rows.push_back(std::move(row));
    table.add_row(std::move(cells));
  }
  out_ << study << "\n\n";
  table.print(out_, "  ");
  out_ << '\n';
}

}  // namespace pipescout::reproduce
