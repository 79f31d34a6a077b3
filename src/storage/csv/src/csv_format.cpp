// SPDX-License-Identifier: Apache-2.0
#include "pipescout/csv/csv_format.hpp"

#include <algorithm>
#include <stdexcept>

#include "pipescout/csv/csv_words.hpp"

namespace pipescout {
namespace {

/// Nothing for an empty word.
template <class Value>
std::optional<Value> meaning(const std::string& key, const std::string& word,
                             std::optional<Value> (*meaning_of)(std::string_view),
                             const std::string& words) {
  const auto value = word.empty() ? std::nullopt : meaning_of(word);
  if (!word.empty() && !value) {
    throw std::invalid_argument(key + " must be " + words + ", not '" + word + "'");
  }
  return value;
}

}  // namespace

void CsvFormat::set(const std::string& key, const std::string& word) {
  if (key == "delimiter") {
    delimiter = meaning(key, word, list_delimiter, delimiter_words());
  } else if (key == "decimal_mark") {
    decimal_mark = meaning(key, word, pipescout::decimal_mark, "'.' or ','");
  } else if (key == "time_unit") {
    time_unit = meaning(key, word, pipescout::time_unit, "s, ms, us or ns");
  } else {
    throw std::invalid_argument("'" + key + "' says nothing about a table");
  }
}

std::string CsvFormat::advice(const std::string& key, const std::string& otherwise) const {
  if (settings.empty()) {
    return otherwise;
  }
  if (settings == "--") {
    std::string option = "--" + key;
    std::ranges::replace(option, '_', '-');
    return "give " + option;
  }
  return "set '" + key + "' in " + settings;
}

}  // namespace pipescout
