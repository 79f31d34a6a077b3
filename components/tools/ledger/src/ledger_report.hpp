// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <ostream>
#include <string>
#include <string_view>
#include <vector>

#include "pipescout/odometry/weld_ledger.hpp"
#include "run_file.hpp"

/// What `pipescout ledger` says about ledgers and alignments, for people and for programs.
/// Distances in metres.
namespace pipescout::ledger {

/// Runs, welds, lengths and what is doubtful.
void print_ledger(std::ostream& out, const odometry::WeldLedger& ledger);

/// A run against a ledger as it was before. Refers to both and to the update: they must outlive it.
class AlignmentReport {
 public:
  /// `update`: of `merge_run` with the welds of `run`, accepted.
  AlignmentReport(const RunFile& run, const odometry::WeldLedger& ledger,
                  const odometry::LedgerUpdate& update);

  /// Summary, replaced sections, welds that are new or missing and, when asked for, features: of
  /// each not more than `most_rows`.
  void print(std::ostream& out, std::size_t most_rows, bool features) const;

  /// One row per matched weld: run_chainage, ledger_chainage, ledger_id, difference,
  /// standard_deviation (of the match), probability.
  [[nodiscard]] std::string matches_csv() const;

  /// One row per feature: line, kind, clock, run_chainage_m, weld, from_weld_m, from_weld_sd_m,
  /// given_from_weld_m, chainage_m, chainage_sd_m, between_welds, and the columns of the ledger's
  /// map if it has one.
  [[nodiscard]] std::string features_csv() const;

  /// The figures of the summary, and the new and missing welds.
  [[nodiscard]] nlohmann::json to_json() const;

 private:
  struct Weld {
    const char* what;     // "new", "ambiguous", "beyond", "missing"
    double run_chainage;  // of a missing one: where the run should have it
    double ledger_chainage;
    double standard_deviation;
    std::string weld;         // id, of a new one that of the weld before
    double best_probability;  // that it has a partner all the same
  };
  struct Place {
    const RunFeature* feature;
    odometry::LedgerPlace place;
    bool between_welds;
  };

  /// Joints between two welds that are there still, which differ from those of the ledger: a part
  /// of the pipe was cut out and replaced, or welds were not seen.
  struct ReplacedSection {
    std::size_t first_match;  // index of the match before
    std::size_t ledger_joints;
    std::size_t run_joints;
    double ledger_length;
    double run_length;  // in metres of the ledger
  };

  void find_replaced();
  [[nodiscard]] double difference(const odometry::WeldMatch& match) const;
  [[nodiscard]] std::size_t count(std::string_view what) const;
  void find_welds();
  void measure();
  void print_features(std::ostream& out, std::size_t most) const;

  const RunFile& run_;
  const odometry::WeldLedger& ledger_;
  const odometry::LedgerUpdate& update_;
  std::vector<Weld> welds_;  // by chainage
  std::vector<Place> places_;
  std::vector<ReplacedSection> replaced_;  // in the order of the matches
  std::size_t run_beyond_ = 0;             // welds before the first or behind the last that matched
  std::size_t ledger_beyond_ = 0;
  double scale_ = 1.0;            // ledger's length over the run's, first to last match
  std::size_t largest_slip_ = 0;  // index of a match
  std::size_t least_difference_ = 0;
  std::size_t largest_difference_ = 0;
};

}  // namespace pipescout::ledger
