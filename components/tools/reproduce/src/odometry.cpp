// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "pipescout/command_line/installed_share_folder.hpp"
#include "pipescout/command_line/text_table.hpp"
#include "pipescout/csv/csv_file.hpp"
#include "pipescout/csv/csv_table.hpp"
#include "pipescout/odometry/consensus_fusion.hpp"
#include "pipescout/validation/number_text.hpp"
#include "reproduce.hpp"
#include "seed_values.hpp"

namespace pipescout::reproduce {
namespace {

using command_line::installed_share_folder;

using command_line::TextTable;

using odometry::ConsensusFusion;
using odometry::ConsensusFusionParameters;
using odometry::OdometerReading;
using odometry::Weighting;

constexpr std::array kSigmas{0.06, 0.055, 0.056};   // m, Table 1
constexpr std::array kOffsets{0.18, 0.155, 0.165};  // m, section 4
constexpr std::array kReadingColumns{"odometer_1", "odometer_2", "odometer_3"};
constexpr std::size_t kRows = 10;
constexpr std::size_t kDisputedRow = 10;  ///< counted from 1

struct PaperRow {
  std::int64_t number = 0;
  std::vector<OdometerReading> readings;
  double paper = 0.0;
};

std::vector<PaperRow> load_table() {
  const auto folder = installed_share_folder("pipescout_odometry");
  if (!folder) {
    throw std::runtime_error("the data of package pipescout_odometry is not installed");
  }
  const auto path = *folder + "/wang2008_table1.csv";
  const CsvTable table(read_csv_text(path), path);
  const auto cell = [&](std::size_t row, const char* column) {
    const auto index = table.find_column(column);
    if (!index) {
      throw CsvError(path, table.header_line(), std::string("no column '") + column + "'");
    }
    return table.required(row, *index);
  };
  std::vector<PaperRow> rows;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    auto& entry = rows.emplace_back();
    entry.number = std::lround(cell(row, "reading"));
    for (std::size_t i = 0; i < kSigmas.size(); ++i) {
      entry.readings.push_back(
          {.distance = cell(row, kReadingColumns[i]), .standard_deviation = kSigmas[i]});
    }
    entry.paper = cell(row, "paper");
  }
  if (rows.size() != kRows) {
    throw CsvError(path, 0, std::to_string(rows.size()) + " rows instead of 10");
  }
  return rows;
}

ConsensusFusion make_fusion(Weighting weighting) {
  ConsensusFusionParameters parameters;
  parameters.weighting = weighting;
  parameters.offsets.assign(kOffsets.begin(), kOffsets.end());
  return ConsensusFusion(std::move(parameters));
}

std::vector<int> members(const odometry::OdometerSet& set) {
  std::vector<int> result;
  for (std::size_t i = 0; i < kSigmas.size(); ++i) {
    if (set[i]) {
      result.push_back(static_cast<int>(i) + 1);
    }
  }
  return result;
}

std::string set_text(const std::vector<int>& members) {
  std::string text;
  for (const int member : members) {
    text += (text.empty() ? "" : ", ") + std::to_string(member);
  }
  return "{" + text + "}";
}

}  // namespace

Reproduction reproduce_odometry(const ReproduceOptions& /*options*/, std::ostream& out) {
  const auto maximum_likelihood = make_fusion(Weighting::kMaximumLikelihood);
  const auto equation_13 = make_fusion(Weighting::kPaperEquation13);
  Reproduction result;
  TextTable table({"reading", "odometer 1 [m]", "odometer 2 [m]", "odometer 3 [m]", "support",
                   "fused, 1/sigma^2 [m]", "fused, eq. 13 [m]", "paper [m]",
                   "1/sigma^2 - paper [m]"});
  std::array<double, 2> largest{};  // of rows 1 to 9: maximum likelihood, equation 13
  for (const auto& row : load_table()) {
    const auto ml = maximum_likelihood.fuse(row.readings);
    const auto printed = equation_13.fuse(row.readings);
    const double ml_error = ml.fused.distance - row.paper;
    const double printed_error = printed.fused.distance - row.paper;
    const auto support = members(ml.fusion_set);
    std::vector<double> readings;
    for (const auto& reading : row.readings) {
      readings.push_back(reading.distance);
    }
    result.rows.push_back({{"reading", row.number},
                           {"readings", readings},
                           {"support", support},
                           {"fused_ml", ml.fused.distance},
                           {"fused_ml_sd", ml.fused.standard_deviation},
                           {"fused_paper", printed.fused.distance},
                           {"fused_paper_sd", printed.fused.standard_deviation},
                           {"paper", row.paper},
                           {"difference_ml", ml_error},
                           {"difference_paper", printed_error}});
    table.add_row({row.number, readings[0], readings[1], readings[2], set_text(support),
                   rounded(ml.fused.distance), rounded(printed.fused.distance), row.paper,
                   rounded(ml_error)});
    if (row.number != kDisputedRow) {
      largest[0] = std::max(largest[0], std::abs(ml_error));
      largest[1] = std::max(largest[1], std::abs(printed_error));
      continue;
    }
    // What the printed figure follows from.
    const auto without_first = odometry::fuse_members(
        row.readings, kOffsets, odometry::OdometerSet(0b110), Weighting::kMaximumLikelihood);
    result.figures["row_10_error_m"] = std::abs(ml_error);
    result.figures["row_10_error_eq13_m"] = std::abs(printed_error);
    result.figures["row_10_largest_confidence_distance"] = ml.confidence_distance.maxCoeff();
    result.figures["row_10_without_odometer_1_m"] = without_first.distance;
  }
  result.figures["rows_1_to_9_max_abs_error_m"] = std::max(largest[0], largest[1]);
  result.figures["rows_1_to_9_max_abs_error_ml_m"] = largest[0];
  result.figures["rows_1_to_9_max_abs_error_eq13_m"] = largest[1];

  const auto figure = [&](const char* name) {
    return validation::fixed_text(result.figures[name].get<double>(), 6);
  };
  out << "Wang, Cao, Luan, Zhang (2008), Table 1: sigma 0.06, 0.055, 0.056 m; offsets 0.18, 0.155, "
         "0.165 m; epsilon 0.75\n\n";
  table.print(out, "  ");
  out << "\n  rows 1 to 9: largest difference from the paper "
      << figure("rows_1_to_9_max_abs_error_m")
      << " m (1/sigma^2: " << figure("rows_1_to_9_max_abs_error_ml_m")
      << " m, equation 13: " << figure("rows_1_to_9_max_abs_error_eq13_m") << " m)\n"
      << "  row 10: difference " << figure("row_10_error_m")
      << " m. The printed 5.52 does not follow from the method: no confidence distance in the row\n"
         "  exceeds "
      << figure("row_10_largest_confidence_distance")
      << " (epsilon is 0.75), so all three odometers support each other. Odometers 2 and 3 alone\n"
         "  would give "
      << figure("row_10_without_odometer_1_m")
      << " m; the paper gives no reason to reject odometer 1.\n";
  return result;
}

}  // namespace pipescout::reproduce
