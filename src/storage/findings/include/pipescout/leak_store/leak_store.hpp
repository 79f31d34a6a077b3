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

/// The store cannot be opened, read or written; what() names its file and says why.
class LeakStoreError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// With what a leak was looked for: an entry of the log.
struct ConditionRecord {
  double time = 0;          ///< s, of the findings' clock, from which on it holds
  std::string source;       ///< folder, recording or topic
  std::string camera;       ///< model, serial number, lens
  std::string parameters;   ///< emissivity, distances, temperatures, humidity and their deviations
  std::string weather;      ///< as the operator typed it
  std::string calibration;  ///< of the camera: file, or constants
  std::string doubts;       ///< about any of these, one a line
  friend bool operator==(const ConditionRecord&, const ConditionRecord&) = default;
};

/// Findings of all days in one SQLite file. What a call has written is on the disk when it returns:
/// killing the process, or the machine, loses nothing of it. One process may write while others
/// read. Not thread-safe. All functions throw LeakStoreError.
///
/// Tables: `finding`, `pass` and `condition`, in columns named as the fields, NULL for what is not
/// known; `evidence` with the thumbnail as PNG. PRAGMA user_version is the version of the schema.
class LeakStore {
 public:
  static constexpr int kSchemaVersion = 1;

  /// Opens the file, or makes it. One that is no store, or of a later version, is not touched.
  explicit LeakStore(const std::filesystem::path& file);
  ~LeakStore();
  LeakStore(LeakStore&& other) noexcept;
  LeakStore& operator=(LeakStore&& other) noexcept;

  /// Writes a finding over the one of its id, with its passes; all or nothing. `evidence`, where
  /// there is some, takes the place of what there was.
  void save(const leak_findings::Finding& finding, const Evidence* evidence = nullptr);
  /// Adds an entry to the log, unless it is the last one but for its time.
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
