// SPDX-License-Identifier: Apache-2.0
#include "figures.hpp"

#include <fstream>
#include <iomanip>
#include <ostream>
#include <stdexcept>

namespace pipescout::benchmarks {

void Figures::add(const std::string& name, double value, Bound bound, double target) {
  figures_.push_back({name, value, bound, target});
}

void Figures::print(std::ostream& out) const {
  out << std::fixed << std::setprecision(3);
  for (const auto& row : rows_) {
    out << std::left << std::setw(44) << row.at("case").get<std::string>();
    for (const auto& [key, value] : row.items()) {
      if (key != "case") {
        out << "  " << key << " " << value;
      }
    }
    out << '\n';
  }
  out << '\n';
  for (const Figure& figure : figures_) {
    out << std::left << std::setw(32) << figure.name << std::right << std::setw(12) << figure.value;
    if (figure.target) {
      const bool met = figure.bound == Bound::kAtLeast ? figure.value >= *figure.target
                                                       : figure.value <= *figure.target;
      out << (figure.bound == Bound::kAtLeast ? "   at least " : "   at most  ") << std::setw(8)
          << *figure.target << (met ? "   met" : "   NOT MET");
    }
    out << '\n';
  }
}

void Figures::write_json(const std::string& file) const {
  nlohmann::json document = {
      {"figures", nlohmann::json::object()}, {"rows", rows_}, {"seeds", seeds_}};
  for (const Figure& figure : figures_) {
    document["figures"][figure.name] = figure.value;
  }
  std::ofstream out(file);
  out << document.dump(2) << '\n';
  if (!out.flush()) {
    throw std::runtime_error("cannot write " + file);
  }
}

}  // namespace pipescout::benchmarks
