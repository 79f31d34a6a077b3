// SPDX-License-Identifier: Apache-2.0
#include "ledger_report.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "pipescout/command_line/text_table.hpp"
#include "pipescout/csv/csv_cell.hpp"
#include "pipescout/validation/number_text.hpp"
#include "report_text.hpp"

namespace pipescout::ledger {
namespace {

using odometry::MapFrame;
using odometry::WeldLedger;
using odometry::WeldMatch;

std::string percent(std::size_t part, std::size_t whole) {
  return validation::fixed_text(100.0 * static_cast<double>(part) / static_cast<double>(whole), 2) +
         " %";
}

/// Degrees keep what a millimetre needs.
double coordinate(MapFrame frame, std::size_t axis, double value) {
  const double unit = frame == MapFrame::kGeodetic && axis < 2 ? 1e8 : 1e3;
  return std::round(value * unit) / unit;
}

std::array<const char*, 3> map_columns(MapFrame frame) {
  return frame == MapFrame::kGeodetic
             ? std::array<const char*, 3>{"latitude_deg", "longitude_deg", "height_m"}
             : std::array<const char*, 3>{"x_m", "y_m", "z_m"};
}

}  // namespace

AlignmentReport::AlignmentReport(const RunFile& run, const WeldLedger& ledger,
                                 const odometry::LedgerUpdate& update)
    : run_(run), ledger_(ledger), update_(update) {
  find_welds();
  measure();
  find_replaced();
  for (const auto& feature : run_.features) {
    const auto mapped = update_.alignment.a_to_b.map(feature.chainage);
    places_.push_back({.feature = &feature,
                       .place = locate(ledger_, mapped),
                       .between_welds = mapped.between_welds});
  }
}

void AlignmentReport::find_welds() {
  const auto& alignment = update_.alignment;
  const std::set<std::size_t> ambiguous(update_.ambiguous.begin(), update_.ambiguous.end());
  for (const auto& weld : alignment.only_a) {
    const double chainage = run_.welds[weld.index].chainage;
    const auto place = alignment.a_to_b.map(chainage);
    run_beyond_ += place.between_welds ? 0U : 1U;
    welds_.push_back({.what = ambiguous.contains(weld.index) ? "ambiguous"
                              : place.between_welds          ? "new"
                                                             : "beyond",
                      .run_chainage = chainage,
                      .ledger_chainage = place.chainage,
                      .standard_deviation = place.standard_deviation,
                      .weld = locate(ledger_, place).weld,
                      .best_probability = weld.best_probability});
  }
  const auto to_run = alignment.a_to_b.inverse();
  for (const auto& weld : alignment.only_b) {
    const auto& missing = ledger_.welds[weld.index];
    const auto place = to_run.map(missing.chainage);
    if (!place.between_welds) {
      ++ledger_beyond_;
      continue;
    }
    welds_.push_back({.what = "missing",
                      .run_chainage = place.chainage,
                      .ledger_chainage = missing.chainage,
                      .standard_deviation = place.standard_deviation,
                      .weld = missing.id,
                      .best_probability = weld.best_probability});
  }
  std::stable_sort(welds_.begin(), welds_.end(), [](const Weld& one, const Weld& next) {
    return one.ledger_chainage < next.ledger_chainage;
  });
}

void AlignmentReport::measure() {
  const auto& matches = update_.alignment.matches;
  const auto knots = update_.alignment.a_to_b.knots();
  const double length = knots.back().from - knots.front().from;
  scale_ = length > 0.0 ? std::abs(knots.back().to - knots.front().to) / length : 1.0;
  for (std::size_t k = 1; k < matches.size(); ++k) {
    if (std::abs(matches[k].residual) > std::abs(matches[largest_slip_].residual)) {
      largest_slip_ = k;
    }
    if (difference(matches[k]) < difference(matches[least_difference_])) {
      least_difference_ = k;
    }
    if (difference(matches[k]) > difference(matches[largest_difference_])) {
      largest_difference_ = k;
    }
  }
}

void AlignmentReport::find_replaced() {
  const auto& matches = update_.alignment.matches;
  for (std::size_t k = 1; k < matches.size(); ++k) {
    const auto joints = [](std::size_t one, std::size_t other) {
      return one < other ? other - one : one - other;
    };
    const ReplacedSection section{
        .first_match = k - 1,
        .ledger_joints = joints(matches[k - 1].b, matches[k].b),
        .run_joints = joints(matches[k - 1].a, matches[k].a),
        .ledger_length = std::abs(ledger_.welds[matches[k].b].chainage -
                                  ledger_.welds[matches[k - 1].b].chainage),
        .run_length = scale_ * std::abs(run_.welds[matches[k].a].chainage -
                                        run_.welds[matches[k - 1].a].chainage)};
    if (section.ledger_joints > 1 && section.run_joints > 1) {
      replaced_.push_back(section);
    }
  }
}

double AlignmentReport::difference(const WeldMatch& match) const {
  const double by_run = run_.welds[match.a].chainage;
  return ledger_.welds[match.b].chainage + (update_.alignment.reversed ? by_run : -by_run);
}

std::size_t AlignmentReport::count(std::string_view what) const {
  return static_cast<std::size_t>(std::count_if(
      welds_.begin(), welds_.end(), [what](const Weld& weld) { return weld.what == what; }));
}

void AlignmentReport::print(std::ostream& out, std::size_t most_rows, bool features) const {
  const auto& alignment = update_.alignment;
  const auto& matches = alignment.matches;
  const auto at = [&](const WeldMatch& match) {
    return "at " + ledger_.welds[match.b].id + ", " +
           validation::fixed_text(ledger_.welds[match.b].chainage, 1) + " m";
  };
  const std::size_t within = run_.welds.size() - run_beyond_;
  out << run_.path << ": " << of(run_.welds.size(), "girth weld") << " and "
      << of(run_.features.size(), "other feature") << ", "
      << validation::fixed_text(run_.welds.front().chainage, 1) << " to "
      << validation::fixed_text(run_.welds.back().chainage, 1) << " m\n"
      << "The ledger: " << of(ledger_.welds.size(), "girth weld") << " of "
      << of(ledger_.runs.size(), "run") << ", "
      << validation::fixed_text(ledger_.welds.front().chainage, 1) << " to "
      << validation::fixed_text(ledger_.welds.back().chainage, 1) << " m\n"
      << (alignment.reversed ? "Aligned: the run has the opposite direction of the ledger\n"
                             : "Aligned\n")
      << "  matched       " << matches.size() << " of the run's " << within
      << " welds where the two overlap, " << percent(matches.size(), within) << '\n'
      << "  missing       " << count("missing") << " in the ledger and not in the run\n"
      << "  new           " << count("new") << " in the run and not in the ledger\n"
      << "  ambiguous     " << count("ambiguous")
      << " in the run, too close to a weld of the ledger to be a different one\n"
      << "  beyond        " << count("beyond") << " of the run and " << ledger_beyond_
      << " of the ledger, before the first or behind the last that matched\n"
      << "  scale         " << validation::fixed_text(scale_, 6)
      << " m of the ledger per metre of the run\n"
      << "  largest slip  " << validation::fixed_text(matches[largest_slip_].residual, 3)
      << " m in the joint that ends " << at(matches[largest_slip_]) << '\n'
      << "  difference    " << validation::fixed_text(difference(matches[least_difference_]), 3)
      << " m (" << at(matches[least_difference_]) << ") to "
      << validation::fixed_text(difference(matches[largest_difference_]), 3) << " m ("
      << at(matches[largest_difference_]) << "), the ledger's chainage "
      << (alignment.reversed ? "plus" : "minus") << " the run's\n";
  if (!replaced_.empty()) {
    out << "\nReplaced sections (between two welds that both have, other joints than in the "
           "ledger)\n";
    TextTable table({"from weld", "to weld", "joints", "m", "joints now", "m now"});
    for (std::size_t k = 0; k < std::min(most_rows, replaced_.size()); ++k) {
      const auto& section = replaced_[k];
      table.add_row({ledger_.welds[matches[section.first_match].b].id,
                     ledger_.welds[matches[section.first_match + 1].b].id,
                     number(section.ledger_joints), metres(section.ledger_length),
                     number(section.run_joints), metres(section.run_length)});
    }
    table.print(out, "  ");
  }
  if (!welds_.empty()) {
    out << "\nUnmatched welds (probability: that the weld has a match)\n";
    TextTable table({"", "run m", "ledger m", "+- m", "weld", "probability"});
    for (std::size_t k = 0; k < std::min(most_rows, welds_.size()); ++k) {
      const auto& weld = welds_[k];
      const bool known = std::string_view(weld.what) == "missing";
      table.add_row({std::string(weld.what), metres(weld.run_chainage),
                     metres(weld.ledger_chainage), metres(weld.standard_deviation),
                     known || weld.weld.empty() ? text(weld.weld) : "after " + weld.weld,
                     std::round(weld.best_probability * 100.0) / 100.0});
    }
    table.print(out, "  ");
    if (welds_.size() > most_rows) {
      out << "  ... and " << welds_.size() - most_rows << " more: --json FILE writes all\n";
    }
  }
  if (!places_.empty()) {
    print_features(out, features ? most_rows : 0);
  }
}

void AlignmentReport::print_features(std::ostream& out, std::size_t most) const {
  constexpr double kSame = 0.1;  // m
  std::size_t given = 0;
  std::size_t apart = 0;
  const RunFeature* worst = nullptr;
  const auto departure = [](const RunFeature& feature) {
    return std::abs(feature.given_from_weld - feature.from_weld);
  };
  for (const auto& feature : run_.features) {
    if (std::isfinite(departure(feature))) {
      ++given;
      apart += departure(feature) > kSame ? 1U : 0U;
      worst = worst == nullptr || departure(feature) > departure(*worst) ? &feature : worst;
    }
  }
  out << '\n'
      << of(places_.size(), "feature")
      << " on the ledger (located by a weld and the distance behind it; \"at m\" is from the "
         "origin)\n";
  if (worst != nullptr) {
    out << "  The list itself says for " << given
        << " how far from the weld above they lie; by its "
        << "odometer " << apart << " of them are more than 0.1 m elsewhere, at most "
        << validation::fixed_text(departure(*worst), 3) << " m (line " << worst->line << ")\n";
  }
  if (most == 0) {
    return;
  }
  std::vector<std::string> columns{"line", "kind", "o'clock", "run m", "weld",
                                   "+m",   "+- m", "at m",    "+- m"};
  const bool mapped = ledger_.frame != MapFrame::kNone;
  if (mapped) {
    for (const char* column : map_columns(ledger_.frame)) {
      columns.emplace_back(column);
    }
  }
  TextTable table(columns);
  for (std::size_t k = 0; k < std::min(most, places_.size()); ++k) {
    const auto& [feature, place, between] = places_[k];
    std::vector<TextTable::Cell> row{number(feature->line),
                                     text(feature->kind),
                                     text(feature->clock),
                                     metres(feature->chainage),
                                     text(place.weld),
                                     metres(place.from_weld),
                                     metres(place.from_weld_standard_deviation),
                                     metres(place.chainage),
                                     metres(place.standard_deviation)};
    for (std::size_t axis = 0; mapped && axis < 3; ++axis) {
      row.push_back(place.position ? TextTable::Cell(coordinate(ledger_.frame, axis,
                                                                place.position->coordinates[axis]))
                                   : TextTable::Cell());
    }
    table.add_row(std::move(row));
  }
  table.print(out, "  ");
  if (places_.size() > most) {
    out << "  ... and " << places_.size() - most << " more: --features FILE writes all\n";
  }
}

std::string AlignmentReport::matches_csv() const {
  const auto& alignment = update_.alignment;
  std::string csv =
      "run_chainage,ledger_chainage,ledger_id,difference,standard_deviation,probability\n";
  for (std::size_t k = 0; k < alignment.matches.size(); ++k) {
    const auto& match = alignment.matches[k];
    const auto& weld = ledger_.welds[match.b];
    csv += format_optional_csv_number(run_.welds[match.a].chainage) + ',' +
           format_optional_csv_number(weld.chainage) + ',' + csv_cell(weld.id) + ',' +
           format_optional_csv_number(difference(match)) + ',' +
           format_optional_csv_number(alignment.a_to_b.knots()[k].standard_deviation) + ',' +
           format_optional_csv_number(match.probability) + '\n';
  }
  return csv;
}

std::string AlignmentReport::features_csv() const {
  std::string csv =
      "line,kind,clock,run_chainage_m,weld,from_weld_m,from_weld_sd_m,given_from_weld_m,"
      "chainage_m,chainage_sd_m,between_welds";
  const bool mapped = ledger_.frame != MapFrame::kNone;
  if (mapped) {
    for (const char* column : map_columns(ledger_.frame)) {
      csv += ',' + std::string(column);
    }
    csv += ",position_sd_m";
  }
  csv += '\n';
  for (const auto& [feature, place, between] : places_) {
    csv += std::to_string(feature->line) + ',' + csv_cell(feature->kind) + ',' +
           csv_cell(feature->clock) + ',' + format_optional_csv_number(feature->chainage) + ',' +
           csv_cell(place.weld);
    for (const double value :
         {place.from_weld, place.from_weld_standard_deviation, feature->given_from_weld,
          place.chainage, place.standard_deviation}) {
      csv += ',' + format_optional_csv_number(value);
    }
    csv += between ? ",1" : ",0";
    if (mapped) {
      const auto position = place.position.value_or(odometry::MapPosition{});
      for (const double value : position.coordinates) {
        csv += ',' + format_optional_csv_number(value);
      }
      csv += ',' + format_optional_csv_number(position.standard_deviation);
    }
    csv += '\n';
  }
  return csv;
}

nlohmann::json AlignmentReport::to_json() const {
  const auto& alignment = update_.alignment;
  const auto& matches = alignment.matches;
  const auto place = [&](std::size_t match) {
    return nlohmann::json{{"weld", ledger_.welds[matches[match].b].id},
                          {"chainage_m", ledger_.welds[matches[match].b].chainage}};
  };
  auto slip = place(largest_slip_);
  slip["slip_m"] = matches[largest_slip_].residual;
  auto least = place(least_difference_);
  least["difference_m"] = difference(matches[least_difference_]);
  auto largest = place(largest_difference_);
  largest["difference_m"] = difference(matches[largest_difference_]);
  auto welds = nlohmann::json::array();
  for (const auto& weld : welds_) {
    welds.push_back({{"what", weld.what},
                     {"run_chainage_m", weld.run_chainage},
                     {"ledger_chainage_m", weld.ledger_chainage},
                     {"standard_deviation_m", weld.standard_deviation},
                     {"weld", weld.weld},
                     {"probability", weld.best_probability}});
  }
  auto replaced = nlohmann::json::array();
  for (const auto& section : replaced_) {
    replaced.push_back({{"from_weld", ledger_.welds[matches[section.first_match].b].id},
                        {"to_weld", ledger_.welds[matches[section.first_match + 1].b].id},
                        {"ledger_joints", section.ledger_joints},
                        {"ledger_length_m", section.ledger_length},
                        {"run_joints", section.run_joints},
                        {"run_length_m", section.run_length}});
  }
  return {{"run", run_.path},
          {"figures",
           {{"run_welds", run_.welds.size()},
            {"ledger_welds", ledger_.welds.size()},
            {"matched", matches.size()},
            {"missing", count("missing")},
            {"new", count("new")},
            {"ambiguous", count("ambiguous")},
            {"run_welds_beyond_ledger", count("beyond")},
            {"ledger_welds_beyond_run", ledger_beyond_},
            {"features", places_.size()},
            {"replaced_sections", replaced_.size()},
            {"scale", scale_},
            {"score", alignment.score}}},
          {"reversed", alignment.reversed},
          {"largest_slip", slip},
          {"least_difference", least},
          {"largest_difference", largest},
          {"welds_without_partner", welds},
          {"replaced_sections", replaced}};
}

}  // namespace pipescout::ledger
