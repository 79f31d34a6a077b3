// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "pipescout/csv/csv_time.hpp"

namespace pipescout {

/// What a caller, or a user through `settings`, knows of a table. The rest is recognised.
struct CsvFormat {
  std::optional<char> delimiter{};     ///< ',', ';', '|', '\t'; ' ': runs of blanks
  std::optional<char> decimal_mark{};  ///< '.' or ','
  std::optional<TimeUnit> time_unit{};
  bool header = true;     ///< false: columns are named "1", "2", ...
  bool comments = false;  ///< lines that begin with '#' are passed over
  bool ragged = false;    ///< rows may have any number of cells
  /// A last row without a line end and with too few cells, as a recorder that was killed leaves it,
  /// is left out, with a note.
  bool cut_end = false;
  /// Where a user sets the keys 'delimiter', 'decimal_mark' and 'time_unit', for messages: a file
  /// or a component; "--": options of the command line. Empty: nowhere.
  std::string settings{};

  /// Sets what a user says of 'delimiter' (a word of `list_delimiter`), 'decimal_mark' or
  /// 'time_unit'; an empty word: recognised. Throws std::invalid_argument for other keys and words.
  void set(const std::string& key, const std::string& word);

  /// "set 'decimal_mark' in m.yaml", "give --decimal-mark"; `otherwise` where there is no setting.
  [[nodiscard]] std::string advice(const std::string& key, const std::string& otherwise) const;
};

}  // namespace pipescout
