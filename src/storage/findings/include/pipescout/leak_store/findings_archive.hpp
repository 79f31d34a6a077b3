// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <vector>

#include "pipescout/leak_findings/finding.hpp"
#include "pipescout/leak_store/evidence.hpp"
#include "pipescout/leak_store/leak_report.hpp"
#include "pipescout/leak_store/leak_store.hpp"

namespace pipescout {

/// Where findings are kept beyond the run, and told to people. Not thread-safe.
class FindingsArchive {
 public:
  /// `store`: file of the findings of all days; empty: they are not kept. `report_folder`: gets the
  /// report; empty: there is none. Missing folders are made. Throws LeakStoreError and
  /// std::filesystem::filesystem_error naming the file.
  FindingsArchive(const std::filesystem::path& store, std::filesystem::path report_folder);

  /// Of other days, and of this one so far.
  [[nodiscard]] std::vector<leak_findings::Finding> known() const;

  /// Throws LeakStoreError.
  void log(const ConditionRecord& record);
  /// Whether a picture of that time is evidence of a finding that is in it: it shows it best, or
  /// there is none yet, as of one that is raised now and was seen better before.
  [[nodiscard]] bool wants(const leak_findings::Finding& finding, double time) const;
  /// The picture that shows a finding best; saved with it the next time.
  void keep(std::uint64_t finding, Evidence evidence);
  /// Nothing where none was kept since the start.
  [[nodiscard]] const Evidence* evidence(std::uint64_t finding) const;
  /// On the disk when it returns. Throws LeakStoreError.
  void save(const leak_findings::Finding& finding);

  /// leaks.geojson, leaks.kml, leaks.csv and report.html of these findings. Theirs and the
  /// conditions are put into `report`; all else of it is the caller's. Throws LeakStoreError and
  /// std::system_error naming the file.
  void write_report(std::span<const leak_findings::Finding> findings, LeakReport report) const;

 private:
  std::filesystem::path report_folder_;
  std::optional<LeakStore> store_;
  std::vector<ConditionRecord> conditions_;  // where there is no store
  std::map<std::uint64_t, Evidence> evidence_;
  std::set<std::uint64_t> unsaved_;  // whose evidence is not in the store
};

}  // namespace pipescout
