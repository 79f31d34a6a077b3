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

/// Storage of findings beyond the run, and their report. Not thread-safe.
class FindingsArchive {
 public:
  /// `store`: file of the findings of all days; empty: they are not stored. `report_folder`: folder
  /// of the report; empty: none. Missing folders are created. Throws LeakStoreError and
  /// std::filesystem::filesystem_error naming the file.
  FindingsArchive(const std::filesystem::path& store, std::filesystem::path report_folder);

  /// Findings of other days, and of this one so far.
  [[nodiscard]] std::vector<leak_findings::Finding> known() const;

  /// Throws LeakStoreError.
  void log(const ConditionRecord& record);
  /// Whether an image of that time becomes the evidence of a finding in it: it shows it best, or
  /// the finding has none yet, because it is raised now and had a better view before.
  [[nodiscard]] bool wants(const leak_findings::Finding& finding, double time) const;
  /// Sets the best image of a finding; saved with it the next time.
  void keep(std::uint64_t finding, Evidence evidence);
  /// Nothing if none was set since the start.
  [[nodiscard]] const Evidence* evidence(std::uint64_t finding) const;
  /// Durable when it returns. Throws LeakStoreError.
  void save(const leak_findings::Finding& finding);

  /// leaks.geojson, leaks.kml, leaks.csv and report.html of these findings. Findings and conditions
  /// are added to `report`; its other fields are set by the caller. Throws LeakStoreError and
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
