// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace pipescout {

/// The program could not be run, or has said too much; what() says why, without the picture's name.
class ExiftoolError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// What exiftool says in JSON of these tags ("-FLIR:Emissivity") of the content of a file, numbers
/// as numbers and binary as base64. The content is its standard input: no name reaches it, and no
/// shell is run. Content that it can make nothing of is no error here: it then gives an "Error"
/// among the tags.
[[nodiscard]] std::string exiftool_json(const std::string& program,
                                        const std::vector<std::string>& tags,
                                        std::span<const std::uint8_t> content);

/// The same of several files in one run: an array with an object for each, in their order. A file
/// that cannot be opened has an object without these tags.
[[nodiscard]] std::string exiftool_json(const std::string& program,
                                        const std::vector<std::string>& tags,
                                        std::span<const std::filesystem::path> files);

}  // namespace pipescout
