// SPDX-License-Identifier: Apache-2.0
#include "pipescout/leak_store/findings_archive.hpp"

#include <utility>

#include "pipescout/files/whole_file.hpp"
#include "pipescout/leak_store/leak_exports.hpp"

namespace pipescout {

using leak_findings::Finding;

FindingsArchive::FindingsArchive(const std::filesystem::path& store,
                                 std::filesystem::path report_folder)
    : report_folder_(std::move(report_folder)) {
  if (!store.empty()) {
    if (store.has_parent_path()) {
      std::filesystem::create_directories(store.parent_path());
    }
    store_.emplace(store);
  }
  if (!report_folder_.empty()) {
    std::filesystem::create_directories(report_folder_);
  }
}

std::vector<Finding> FindingsArchive::known() const {
  return store_ ? store_->findings() : std::vector<Finding>{};
}

void FindingsArchive::log(const ConditionRecord& record) {
  if (store_) {
    store_->log(record);
  } else {
    conditions_.push_back(record);
  }
}

bool FindingsArchive::wants(const Finding& finding, double time) const {
  return finding.best.time == time ||
         (evidence(finding.id) == nullptr && !(store_ && store_->evidence(finding.id).has_value()));
}

void FindingsArchive::keep(std::uint64_t finding, Evidence evidence) {
  evidence_.insert_or_assign(finding, std::move(evidence));
  unsaved_.insert(finding);
}

const Evidence* FindingsArchive::evidence(std::uint64_t finding) const {
  const auto found = evidence_.find(finding);
  return found == evidence_.end() ? nullptr : &found->second;
}

void FindingsArchive::save(const Finding& finding) {
  if (!store_) {
    return;
  }
  store_->save(finding, unsaved_.contains(finding.id) ? evidence(finding.id) : nullptr);
  unsaved_.erase(finding.id);
}

void FindingsArchive::write_report(std::span<const Finding> findings, LeakReport report) const {
  if (report_folder_.empty()) {
    return;
  }
  report.conditions = store_ ? store_->conditions() : conditions_;
  for (const Finding& finding : findings) {
    const Evidence* const kept = evidence(finding.id);
    report.findings.push_back({.finding = finding,
                               .evidence = kept != nullptr ? std::optional(*kept)
                                           : store_        ? store_->evidence(finding.id)
                                                           : std::nullopt});
  }
  replace_file(report_folder_ / "leaks.geojson", leaks_geojson(findings, report.datum));
  replace_file(report_folder_ / "leaks.kml", leaks_kml(findings, report.datum));
  replace_file(report_folder_ / "leaks.csv", leaks_csv(findings, report.datum));
  replace_file(report_folder_ / "report.html", leak_report_html(report));
}

}  // namespace pipescout
