// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "csv_source.hpp"
#include "pipescout/estimator_sources/named_source.hpp"
#include "recording.hpp"

namespace pipescout::estimate {

/// The kinds of further sources that a CSV file may hold, for errors.
[[nodiscard]] std::string kinds_in_csv_files();

/// Rows of a further source, as the messages that a driver would send. `columns_node`: that of
/// `columns`. Throws YamlError for columns that are missing or unknown, and for a kind that no CSV
/// file holds.
void read_messages(NamedSourceKind kind, const CsvSource& source, const CsvColumns& columns,
                   const YAML::Node& columns_node, const std::string& mapping, Stream& stream);

}  // namespace pipescout::estimate
