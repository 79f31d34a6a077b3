// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

/// Words that headers and mappings of tables use. Pure functions; thread-safe.
namespace pipescout {

/// With one blank for each run of white space, line ends and control characters, and none at the
/// ends: spreadsheets break lines in headers and fill up with blanks that do not break (U+00A0).
[[nodiscard]] std::string folded(std::string_view text);

/// "m" of "Log distance [m]" or "Log distance (m)"; empty without.
[[nodiscard]] std::string bracketed(std::string_view name);

/// Metres in a unit of length that lists have: "metres" or "m", "millimetres" (mm), "centimetres"
/// (cm), "kilometres" (km), "feet" (ft). Nothing for other names.
[[nodiscard]] std::optional<double> metres_per_list_unit(std::string_view unit);
/// "metres (m), millimetres (mm), ...", for messages.
[[nodiscard]] std::string list_unit_names();

/// Whether a cell below a header is a unit: "m", "[mm]", "m/s^2", "°C", "-".
[[nodiscard]] bool is_unit_word(std::string_view cell);

/// The delimiter that a word means: ",", ";", "|", a tab or "tab", and "blank" for runs of blanks.
/// Nothing for other words.
[[nodiscard]] std::optional<char> list_delimiter(std::string_view word);
/// The same the other way round.
[[nodiscard]] std::string delimiter_word(char delimiter);
/// "',', ';', '|', tab or blank", for messages.
[[nodiscard]] std::string delimiter_words();

/// The decimal mark that a word means: "." or ",". Nothing for other words.
[[nodiscard]] std::optional<char> decimal_mark(std::string_view word);

/// "'a', 'b', 'c'".
[[nodiscard]] std::string quoted_list(const std::vector<std::string>& names);

}  // namespace pipescout
