// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

namespace pipescout {

/// The program could not be run, or has said too much; what() says why, without the picture's name.
class ExiftoolError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// What exiftool says in JSON of these tags ("-FLIR:Emissivity") of a file, numbers as numbers and
/// binary as base64. The file is its standard input: no name reaches it, and no shell is run. A
/// file that it can make nothing of is no error here: it then gives an "Error" among the tags.
[[nodiscard]] std::string exiftool_json(const std::string& program,
                                        const std::vector<std::string>& tags,
                                        const std::filesystem::path& file);

}  // namespace pipescout
