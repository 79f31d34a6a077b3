// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "pipescout/leak_findings/finding.hpp"
#include "pipescout/leak_store/evidence.hpp"

namespace pipescout {

/// The database cannot be opened, read or written; what() names its file and the reason.
class LeakStoreError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Conditions of an inspection: an entry of the log.
struct ConditionRecord {
  double time = 0;          ///< s, of the findings' clock, from which on it is valid
  std::string source;       ///< folder, recording or topic
  std::string camera;       ///< model, serial number, lens
  std::string parameters;   ///< emissivity, distances, temperatures, humidity and their deviations
  std::string weather;      ///< as the operator typed it
  std::string calibration;  ///< of the camera: file, or constants
  std::string doubts;       ///< about any of these, one per line
  friend bool operator==(const ConditionRecord&, const ConditionRecord&) = default;
};

/// Findings of all days in one SQLite file. Writes are durable when the call returns: they survive
/// a kill of the process and a power failure. One process may write while others read. Not
/// thread-safe. All functions throw LeakStoreError.
///
/// Tables: `finding`, `pass` and `condition`, in columns named as the fields, NULL for unknown
/// values; `evidence` with the thumbnail as PNG. PRAGMA user_version is the version of the schema.
class LeakStore {
 public:
  static constexpr int kSchemaVersion = 1;

  /// Opens or creates the file. A file of another kind, or of a later version, is not modified.
  explicit LeakStore(const std::filesystem::path& file);
  ~LeakStore();
  LeakStore(LeakStore&& other) noexcept;
  LeakStore& operator=(LeakStore&& other) noexcept;

  /// Replaces the finding with this id and its passes, atomically. `evidence`, if given, replaces
  /// the previous one.
  void save(const leak_findings::Finding& finding, const Evidence* evidence = nullptr);
  /// Adds an entry to the log, unless it equals the last one except for its time.
  void log(const ConditionRecord& record);

  /// By id.
  [[nodiscard]] std::vector<leak_findings::Finding> findings() const;
  [[nodiscard]] std::optional<Evidence> evidence(std::uint64_t finding) const;
  /// In the order in which they were added.
  [[nodiscard]] std::vector<ConditionRecord> conditions() const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace pipescout
